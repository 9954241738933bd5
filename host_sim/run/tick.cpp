// SPDX-License-Identifier: MIT
#include "tick.h"

#include <limits>

namespace nf
{

Tick believed_tick(const Simulation &sim, double time_s)
{
    Tick tick{};
    tick.sim = &sim;
    tick.speed_estimate = drive_speed(&sim.drive());
    tick.position_estimate_q32 = drive_position_q32(&sim.drive());
    tick.observer_speed = sim.drive().observer.speed;
    tick.ratio_acted = sim.drive().ratio_acting;
    tick.bus_before = sim.drive().bus_before;
    tick.time_s = time_s;
    return tick;
}

Tick tick_of_frame(const Simulation &sim, const drive_in_t &in, double time_s)
{
    constexpr double UNKNOWN = std::numeric_limits<double>::quiet_NaN();
    constexpr double Q16 = 65536.0;
    constexpr double TWO_PI = 6.28318530717958647693;
    Tick tick = believed_tick(sim, time_s);
    tick.truth = {time_s,  UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, {UNKNOWN, UNKNOWN, UNKNOWN},
                  UNKNOWN, UNKNOWN};
    tick.mode = in.command.mode == DRIVE_MODE_POSITION ? DriveMode::position : DriveMode::speed;
    tick.command = tick.mode == DriveMode::position
                       ? in.command.target / Q16 * TWO_PI / sim.bases().pole_pairs
                       : sim.bases().rpm_from_step(in.command.target);
    tick.load_nm = UNKNOWN;
    return tick;
}

} // namespace nf
