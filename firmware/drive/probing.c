/* SPDX-License-Identifier: MIT */
#include "probing.h"

#include "derating.h"
#include "estimate.h"
#include "frame.h"
#include "vector.h"

static void note_sample(probe_t *probe, const drive_t *drive, sample_t measured, dq_t current,
                        dq_t e)
{
    const probe_sample_t sample = {
        .phase_a = measured.phase_a,
        .phase_b = measured.phase_b,
        .current = current,
        .voltage = drive->control.voltage,
        .bus = measured.bus,
        .turns_q16 = rotor_position_turns_q16(&drive->vector.position),
        .emf = e,
        .speed_q15 = drive_speed_q15(drive, drive->vector.step),
    };

    probe_note(probe, &sample);
}

/* Returns the EMF: the demanded voltage minus the voltage that R and L need. */
static dq_t emf_of(const drive_t *drive, dq_t current)
{
    const dq_t model = current_loop_model(&drive->control.current_loop, current);

    return (dq_t){drive->control.voltage.d - model.d, drive->control.voltage.q - model.q};
}

static dq_t voltage_for(control_t *control, const drive_t *drive, dq_t current, int32_t bus)
{
    const probe_t *const probe = &drive->probe;
    const bool pulses = probe_pulses(probe);
    const dq_t seen =
        pulses ? probe_controlled(probe, drive->control.current_ref, current) : current;
    dq_t voltage;

    frame_plan_with(control, drive, &probe->loop, drive->vector.step);
    voltage = frame_control_current(control, drive, &probe->loop, seen, bus);
    return pulses ? probe_voltage(probe, voltage) : voltage;
}

static bool may_brake(const drive_cfg_t *cfg, int32_t bus)
{
    return derating_share(&cfg->derating.bus_high, bus) == FX_Q15_MAX;
}

bool probing_may_brake(const drive_t *drive)
{
    return may_brake(drive->cfg, drive->bus);
}

dq_t probing_current(const drive_t *drive)
{
    return drive->probe.current_before;
}

dq_t probing_step(drive_t *drive, const drive_command_t *command, sample_t sample, compare_t *out)
{
    probe_t *const probe = &drive->probe;
    const dq_t current = vector_measure(&drive->vector, sample);
    const dq_t e = emf_of(drive, current);

    probe_set(probe, command->mode, command->target);
    note_sample(probe, drive, sample, current, e);
    vector_move(&drive->vector, probe_turn(probe, rotor_position_angle(&drive->vector.position), e,
                                           may_brake(drive->cfg, sample.bus)));
    frame_ask(&drive->control, (dq_t){.d = probe->current, .q = 0});
    frame_modulate_plain(&drive->control, drive,
                         voltage_for(&drive->control, drive, current, sample.bus), out);
    vector_advance(&drive->vector);
    estimate_place(&drive->rotor, drive->vector.position);
    return current;
}
