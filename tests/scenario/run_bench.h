/* SPDX-License-Identifier: MIT */
// A drive and its motor under a test's hand: it asks for a motion, loads the motor, and lets time
// pass.
#pragma once

#include "config.h"
#include "numbers.h"
#include "tick.h"

#include <cmath>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h> // before Unity, whose macros it does not bear

namespace nf
{

using Words = std::vector<std::string>;

struct Machine {
    const char *motor;
    const char *board;
    const char *tuning;
};

class RunBench
{
public:
    RunBench(const Machine &machine, const Words &sets, const Words &set)
        : config(load_parts(machine.motor, machine.board, machine.tuning, sets, set)), sim(config)
    {
    }

    explicit RunBench(const Config &whole) : config(whole), sim(config)
    {
    }

    void tick()
    {
        now = believed_tick(sim, 0);
        plant_view(&sim.plant(), &now.truth);
        sim.control();
        sim.advance();
    }
    void slow_period()
    {
        for (uint32_t k = 0; k < sim.cfg().slow_ticks; k++) {
            tick();
        }
    }
    void seconds(double time_s)
    {
        const long ticks = std::lround(time_s / sim.bases().control_period_s);
        for (long k = 0; k < ticks; k++) {
            tick();
        }
    }
    // Asks to run until the drive is in this state.
    void until(drive_state_t state, double patience_s)
    {
        const long ticks = std::lround(patience_s / sim.bases().control_period_s);
        for (long k = 0; k < ticks && sim.drive().state != state; k++) {
            if (sim.drive().state == DRIVE_STATE_READY) {
                sim.request(DRIVE_REQUEST_RUN);
            }
            tick();
        }
        TEST_ASSERT_EQUAL_INT(state, sim.drive().state);
    }
    void ask_torque(double share)
    {
        sim.command_torque_nm(share * config.motor.rated_torque_nm);
    }
    void ask_speed(double share)
    {
        sim.command_speed_rpm(share * config.motor.rated_speed_rpm);
    }
    void load(double share)
    {
        sim.set_load_nm(share * config.motor.rated_torque_nm);
    }
    // Of rated ones.
    double speed() const
    {
        return now.truth.omega_mech_rad_s / rad_s_from_rpm(config.motor.rated_speed_rpm);
    }
    double mean_torque(double time_s)
    {
        const long ticks = std::lround(time_s / sim.bases().control_period_s);
        double sum = 0;
        for (long k = 0; k < ticks; k++) {
            tick();
            sum += now.truth.torque_nm;
        }
        return sum / static_cast<double>(ticks) / config.motor.rated_torque_nm;
    }
    double mean_speed(double time_s)
    {
        const long ticks = std::lround(time_s / sim.bases().control_period_s);
        double sum = 0;
        for (long k = 0; k < ticks; k++) {
            tick();
            sum += speed();
        }
        return sum / static_cast<double>(ticks);
    }
    bool torque_is_free() const
    {
        const drive_t &drive = sim.drive();
        return drive.state == DRIVE_STATE_RUN && drive.motion.mode == DRIVE_MODE_TORQUE &&
               !drive.motion.torque_loop.bound && drive.motion.torque_loop.end == SPEED_END_NONE;
    }

    Config config;
    Simulation sim;
    Tick now{};
};

} // namespace nf
