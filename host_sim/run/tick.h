/* SPDX-License-Identifier: MIT */
// One control tick of a run: what is true at t_k, and what the drive believed about it.
#pragma once

#include "sim.h"

#include <cmath>

namespace nf
{

struct Tick {
    const Simulation *sim;         // after control()
    plant_view_t truth;            // at t_k
    step_t speed_estimate;         // ω̂(k), from before control()
    int64_t position_estimate_q32; // θ̂(k), likewise
    int64_t position_zero_q32;     // where position targets count from, likewise
    step_t observer_speed;         // the weight's speed, likewise
    ab_t ratio_acted;              // since t_k-1, Q15 of the bus, likewise
    int32_t bus_before;            // at t_k-1, Q15 of U_b, likewise
    double time_s;                 // t_k, counted from the end of the prelude
    DriveMode mode;
    double command;  // rpm; in position mode mechanical rad, in torque mode N·m
    uint8_t request; // with it, as drive_command_t has it
    double load_nm;
    const drive_out_t *recorded; // what a recording has of this tick; NULL: the run is of none
};

// What the drive believes about the present instant, before control(); nothing of what is true or
// wanted.
Tick believed_tick(const Simulation &sim, double time_s);

// Where only the frames are known: what they command, and NaN for what is true.
Tick tick_of_frame(const Simulation &sim, const drive_in_t &in, double time_s);

// θ − θ̂, electrical, within ±180°; NaN where θ is not known.
inline double angle_error_deg(const Tick &tick)
{
    constexpr double STEPS_PER_RAD = 4294967296.0 / 6.28318530717958647693;
    constexpr double DEG_PER_STEP = 360.0 / 4294967296.0;
    if (std::isnan(tick.truth.theta_el_rad)) {
        return tick.truth.theta_el_rad;
    }
    const auto truth = static_cast<int64_t>(tick.truth.theta_el_rad * STEPS_PER_RAD);
    const auto error = static_cast<uint64_t>(truth - tick.position_estimate_q32);
    return DEG_PER_STEP * static_cast<int32_t>(static_cast<uint32_t>(error & 0xFFFFFFFFU));
}

// Something that looks at every tick of a run.
class TickSink
{
public:
    virtual ~TickSink() = default;
    virtual void add(const Tick &tick) = 0;
};

} // namespace nf
