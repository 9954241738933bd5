/* SPDX-License-Identifier: MIT */
#include "probing.h"

#include "derating.h"
#include "frame.h"

drive_event_t probing_start(drive_t *drive)
{
    probe_reset(&drive->probe);
    current_loop_reset(&drive->current_loop);
    rotor_position_reset(&drive->vector.position, 0U);
    drive->vector.step = 0;
    drive->vector.current_mean = (dq_t){0, 0};
    drive->voltage_drive.active = false;
    drive->signals.current_ref = (dq_t){0, 0};
    drive->signals.voltage = (dq_t){0, 0};
    drive->signals.ratio_ab = (ab_t){0, 0};
    return DRIVE_EVENT_PROBE;
}

static int32_t turns_q16(const drive_t *drive)
{
    const uint64_t turns = fx_unsigned64(drive->vector.position.turns_q32) >> 16U;

    return fx_signed((uint32_t)(turns & 0xFFFFFFFFU));
}

static void note_sample(drive_t *drive, dq_t e)
{
    const drive_signals_t *const s = &drive->signals;
    const probe_sample_t sample = {
        .phase_a = s->phase_a,
        .phase_b = s->phase_b,
        .current = s->current_frame,
        .voltage = s->voltage,
        .bus = s->bus,
        .turns_q16 = turns_q16(drive),
        .emf = e,
        .speed_q15 = drive_speed_q15(drive, drive->vector.step),
    };

    probe_note(&drive->probe, &sample);
}

/* What the current control has demanded, less what R and L need of it. */
static dq_t emf_of(const drive_t *drive)
{
    const drive_signals_t *const s = &drive->signals;
    const dq_t model = current_loop_model(&drive->current_loop, s->current_frame);

    return (dq_t){s->voltage.d - model.d, s->voltage.q - model.q};
}

static void demand(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;
    const probe_t *const probe = &drive->probe;
    const bool pulses = probe_pulses(probe);
    const frame_t frame = {
        .angle = rotor_position_angle(&drive->vector.position),
        .step = drive->vector.step,
        .current =
            pulses ? probe_controlled(probe, s->current_ref, s->current_frame) : s->current_frame,
        .loop = &probe->loop,
        .imposed = false, /* planned here: no gains of an imposed current */
    };

    current_loop_plan(&drive->current_loop, &probe->loop, s->current_ref,
                      drive_speed_q15(drive, drive->vector.step));
    frame_control_current(drive, &frame);
    if (pulses) {
        s->voltage = probe_voltage(probe, s->voltage);
    }
}

bool probing_may_brake(const drive_t *drive)
{
    return derating_share(&drive->cfg->derating.bus_high, drive->signals.bus) == FX_Q15_MAX;
}

void probing_step(drive_t *drive, const drive_command_t *command, compare_t *out)
{
    drive_signals_t *const s = &drive->signals;
    probe_t *const probe = &drive->probe;

    dq_t e;

    frame_measure(drive);
    s->current = s->current_frame;
    e = emf_of(drive);
    probe_set(probe, command->mode, command->target);
    note_sample(drive, e);
    drive->vector.step = probe_turn(probe, rotor_position_angle(&drive->vector.position), e,
                                    probing_may_brake(drive));
    s->current_ref = (dq_t){.d = probe->current, .q = 0};
    demand(drive);
    frame_modulate_plain(drive, out);
    rotor_position_step(&drive->vector.position, drive->vector.step);
    drive->position = drive->vector.position;
}
