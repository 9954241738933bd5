// SPDX-License-Identifier: MIT
#include "measured.h"

extern "C" {
#include "trig.h"
}

namespace nf
{
namespace
{

dq_t turned(const sample_t &sample, angle_t angle)
{
    return transforms_park(transforms_clarke(sample.phase_a, sample.phase_b), trig_sincos(angle));
}

// With a sensor the tick begins with its angle.
angle_t rotor_angle(const Tick &tick)
{
    const drive_t &drive = tick.sim->drive();
    return drive_has_sensor(&drive)
               ? rotor_position_angle(&drive.angle_sensor.position)
               : static_cast<angle_t>(static_cast<uint64_t>(tick.position_estimate_q32));
}

} // namespace

Measured measured(const Tick &tick)
{
    const sample_t sample = instant_sample(&tick.sim->drive(), &tick.sim->in());
    return {sample, turned(sample, rotor_angle(tick)), turned(sample, tick.vector_angle)};
}

dq_t measured_current(const Simulation &sim)
{
    const drive_t &drive = sim.drive();
    const angle_t since = fx_unsigned(drive.observer.speed_out);
    return turned(instant_sample(&drive, &sim.in()), rotor_position_angle(&drive.position) - since);
}

} // namespace nf
