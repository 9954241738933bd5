// SPDX-License-Identifier: MIT
#include "drive_gains.h"

#include "schema.h"

#include <fmt/format.h>

namespace nf::design
{
namespace
{

double checked(const char *key, double gain)
{
    Node value;
    value.kind = Node::Kind::real;
    value.real = gain;
    value.origin = {"gains for the drive", 0};
    check_value(*find_field(key), value);
    return gain;
}

} // namespace

VoltageLoopGains voltage_loop_gains(const Gains &gains, double voltage_per_speed_v_s_per_rad)
{
    return {checked("voltage_loop.kp_v_s_per_rad", voltage_per_speed_v_s_per_rad * gains.kp),
            checked("voltage_loop.ki_v_per_rad", voltage_per_speed_v_s_per_rad * gains.ki_per_s)};
}

std::string voltage_loop_toml(const VoltageLoopGains &gains, double sample_time_s,
                              const std::string &origin)
{
    return fmt::format("# {}, for a speed loop that runs every {:g} s\n"
                       "[voltage_loop]\n"
                       "kp_v_s_per_rad = {:.6g}\n"
                       "ki_v_per_rad = {:.6g}\n",
                       origin, sample_time_s, gains.kp_v_s_per_rad, gains.ki_v_per_rad);
}

} // namespace nf::design
