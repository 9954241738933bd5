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

// A tick ends with the step of the vector.
angle_t vector_angle(const drive_t &drive)
{
    return rotor_position_angle(&drive.vector.position) - fx_unsigned(drive.vector.step);
}

angle_t sensed_angle(const drive_t &drive)
{
    const rotor_position_t position = angle_sensor_position(&drive.rotor.angle_sensor);
    return rotor_position_angle(&position);
}

// A tick with a sensor begins with its angle; PROBE takes the vector's.
angle_t rotor_angle(const Tick &tick)
{
    const drive_t &drive = tick.sim->drive();
    if (drive.state == DRIVE_STATE_PROBE) {
        return vector_angle(drive);
    }
    return drive_is_sensed(&drive)
               ? sensed_angle(drive)
               : static_cast<angle_t>(static_cast<uint64_t>(tick.position_estimate_q32));
}

// In RUN a tick ends with the step of θ̂, which a sensor's angle replaces in the next one.
angle_t control_angle(const drive_t &drive)
{
    if (drive.state != DRIVE_STATE_RUN) {
        return vector_angle(drive);
    }
    return drive_is_sensed(&drive) ? sensed_angle(drive)
                                   : rotor_position_angle(&drive.rotor.position) -
                                         fx_unsigned(drive.rotor.observer.speed_out);
}

} // namespace

instant_t measured(const Tick &tick)
{
    const sample_t sample = measured_sample(*tick.sim);
    return {sample, turned(sample, rotor_angle(tick)),
            turned(sample, vector_angle(tick.sim->drive()))};
}

sample_t measured_sample(const Simulation &sim)
{
    return instant_sample(&sim.drive(), &sim.in());
}

dq_t measured_current(const Simulation &sim)
{
    return turned(measured_sample(sim), control_angle(sim.drive()));
}

} // namespace nf
