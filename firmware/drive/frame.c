/* SPDX-License-Identifier: MIT */
#include "frame.h"

#include "trig.h"

#include <stddef.h>

#define LACKING_SHIFT (2U) /* current expected = reference + (measured − reference) / 4 */
#define MEAN_SHIFT (5U)    /* of the imposed current's filter, in ticks */

/*
 * The dead-time compensation must not use the measured current of a leg that the dead time itself holds at zero. So the
 * sign comes from the filtered current vector.
 */
void frame_measure(drive_t *drive)
{
    const angle_t frame = rotor_position_angle(&drive->vector.position);
    /*@ assert SECTORS(frame); */
    dq_t *const mean = &drive->vector.current_mean;
    const dq_t current = transforms_park(drive->signals.current_ab, trig_sincos(frame));

    drive->signals.current_frame = current;
    mean->d = fx_approach(mean->d, fx_sat15(current.d), MEAN_SHIFT);
    mean->q = fx_approach(mean->q, fx_sat15(current.q), MEAN_SHIFT);
}

void frame_control_current(drive_t *drive, const frame_t *frame)
{
    drive_signals_t *const s = &drive->signals;

    s->voltage_limit = modulator_limit(&drive->cfg->modulator, s->bus);
    s->voltage = current_loop_step(&drive->current_loop, frame->loop, s->current_ref,
                                   frame->current, frame->speed_q15, s->voltage_limit);
}

/*
 * The current in the period to come. In RUN it is the reference plus a quarter of the difference to the measurement. The
 * reference alone has the wrong sign for a leg whose current has not changed yet; the measurement alone has noise and
 * ripple. An imposed current is controlled softly, so its mean is expected.
 */
static dq_t expected_current(const drive_t *drive)
{
    dq_t expected = drive->vector.current_mean;

    if (drive->state == DRIVE_STATE_RUN) {
        const dq_t wanted = drive_current_in_force(drive);

        expected.d = fx_approach(wanted.d, drive->signals.current.d, LACKING_SHIFT);
        expected.q = fx_approach(wanted.q, drive->signals.current.q, LACKING_SHIFT);
    }
    return expected;
}

void frame_modulate(drive_t *drive, const frame_t *frame, compare_t *out)
{
    const angle_t ahead = fx_unsigned(frame->step) + fx_unsigned(fx_asr(frame->step, 1U));
    const angle_t acting = frame->angle + ahead;
    /*@ assert SECTORS(acting); */
    drive_signals_t *const s = &drive->signals;
    const sincos_t angle = trig_sincos(acting);
    const dq_t ratio = modulator_ratio(&drive->modulator, s->voltage);
    const ab_t *compensated = NULL;
    ab_t current;

    if (modulator_compensates(&drive->cfg->modulator)) {
        current = transforms_park_inverse(expected_current(drive), angle);
        compensated = &current;
    }
    drive->ratio_acting.alpha = s->ratio_ab.alpha;
    drive->ratio_acting.beta = s->ratio_ab.beta;
    s->ratio_ab = transforms_park_inverse(ratio, angle);
    modulator_compare(&drive->modulator, &drive->cfg->modulator, s->ratio_ab, compensated, out);
}

void frame_turn(drive_t *drive, angle_t angle)
{
    const sincos_t turn = trig_sincos(angle);
    const dq_t reference = drive->signals.current_ref;
    const dq_t turned = transforms_park((ab_t){reference.d, reference.q}, turn);

    drive->signals.current_ref = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    current_loop_turn(&drive->current_loop, turn);
}
