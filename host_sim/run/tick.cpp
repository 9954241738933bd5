// SPDX-License-Identifier: MIT
#include "tick.h"

#include "numbers.h"

#include <limits>

namespace nf
{

Tick believed_tick(const Simulation &sim, double time_s)
{
    Tick tick{};
    tick.sim = &sim;
    tick.speed_estimate = drive_speed(&sim.drive());
    tick.position_estimate_q32 = drive_position_q32(&sim.drive());
    tick.position_zero_q32 = sim.drive().motion.position_loop.zero_q32;
    tick.observer_speed = sim.drive().rotor.observer.speed;
    tick.ratio_acted = sim.drive().control.ratio_acting;
    tick.bus_before = sim.drive().bus;
    tick.time_s = time_s;
    return tick;
}

static DriveMode mode_of(const drive_command_t &command)
{
    switch (command.mode) {
    case DRIVE_MODE_POSITION:
        return DriveMode::position;
    case DRIVE_MODE_TORQUE:
        return DriveMode::torque;
    default:
        return DriveMode::speed;
    }
}

static double command_si(const drive_command_t &command, const Bases &bases)
{
    constexpr double TURN_EL = 65536.0; // Q16
    switch (mode_of(command)) {
    case DriveMode::position:
        return command.target / TURN_EL * TWO_PI / bases.pole_pairs;
    case DriveMode::torque:
        return command.target / Q28 * bases.torque_nm();
    default:
        return bases.rpm_from_step(command.target);
    }
}

Tick tick_of_frame(const Simulation &sim, const drive_in_t &in, double time_s)
{
    constexpr double UNKNOWN = std::numeric_limits<double>::quiet_NaN();
    Tick tick = believed_tick(sim, time_s);
    tick.truth = {time_s,  UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, {UNKNOWN, UNKNOWN, UNKNOWN},
                  UNKNOWN, UNKNOWN};
    tick.mode = mode_of(in.command);
    tick.command = command_si(in.command, sim.bases());
    tick.request = in.command.request;
    tick.load_nm = UNKNOWN;
    return tick;
}

} // namespace nf
