/* SPDX-License-Identifier: MIT */
// Gains in the drive's units.
#pragma once

#include "matrices.h"

#include <string>

namespace nf::design
{

// Of a speed controller whose output is the magnitude of the voltage.
struct VoltageLoopGains {
    double kp_v_s_per_rad; // volts per rad/s of electrical speed error
    double ki_v_per_rad;   // volts per second and rad/s; a sample adds this times T times the error
};

// The paper's controller gives a supply frequency Δω_s, which K_b turns into the voltage (23);
// together U = K_b·K_p·e + K_b·K_i·∫e. Assumed: K_b is in volts per rad/s of the same electrical
// speed as ω_s and ω_r, as (24) uses it. The paper's unit is V/rps; if that means electrical turns
// per second, K_b in (24) and here is the printed 3 divided by 2π, and both change together
// (nominal.voltage_per_speed_v_s_per_rad). Throws ConfigError for a gain that the drive's tuning
// does not allow.
VoltageLoopGains voltage_loop_gains(const Gains &gains, double voltage_per_speed_v_s_per_rad);

// The table [voltage_loop] of a drive's tuning.
std::string voltage_loop_toml(const VoltageLoopGains &gains, double sample_time_s,
                              const std::string &origin);

} // namespace nf::design
