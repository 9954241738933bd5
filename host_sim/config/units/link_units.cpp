// SPDX-License-Identifier: MIT
#include "link_units.h"

#include <cmath>

namespace nf
{
namespace
{

// Rounded up: a time that is not 0 is not "never".
uint32_t timeout_ticks(double timeout_s, const Bases &b)
{
    return static_cast<uint32_t>(std::ceil(timeout_s / b.control_period_s));
}

} // namespace

link_cfg_t make_link(const TuningSettings &tuning, const Bases &b)
{
    return {timeout_ticks(tuning.command_timeout_s, b)};
}

console_cfg_t make_console(const TuningSettings &tuning, const Bases &b)
{
    return {timeout_ticks(tuning.console_timeout_s, b)};
}

} // namespace nf
