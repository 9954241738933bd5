/* SPDX-License-Identifier: MIT */
#include "frame.h"

#include "trig.h"

#define LACKING_SHIFT (2U) /* expected current = reference + (measured − reference) / 4 */
#define MEAN_SHIFT (5U)    /* the mean of the imposed current has a time constant of 2^5 ticks */

/*
 * The dead-time compensation must not use the measured current of a leg that the dead time itself
 * holds at zero. So the sign comes from the filtered current vector.
 */
dq_t frame_measure(drive_t *drive, sample_t sample)
{
    const angle_t frame = rotor_position_angle(&drive->vector.position);
    /*@ assert SECTORS(frame); */
    dq_t *const mean = &drive->vector.current_mean;
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    const dq_t current = transforms_park(current_ab, trig_sincos(frame));

    mean->d = fx_approach(mean->d, fx_sat15(current.d), MEAN_SHIFT);
    mean->q = fx_approach(mean->q, fx_sat15(current.q), MEAN_SHIFT);
    return current;
}

static void plan_current(drive_t *drive, const current_loop_cfg_t *loop, step_t speed)
{
    current_loop_plan(&drive->control.current_loop, loop, drive->control.current_ref,
                      drive_speed_q15(drive, speed));
}

void frame_plan_rotor(drive_t *drive)
{
    plan_current(drive, &drive->motor.model.run_loop, drive->rotor.observer.speed);
}

dq_t frame_model_voltage(drive_t *drive)
{
    if (drive->state == DRIVE_STATE_RUN) {
        frame_plan_rotor(drive);
    } else {
        plan_current(drive, &drive->motor.model.hold_loop, drive->vector.step);
    }
    return current_loop_model(&drive->control.current_loop, drive->control.current_ref);
}

/*
 * Returns the voltage that RUN at full speed would apply against the part of `current` beyond
 * ±limit: that part times the proportional gain. ratio_q14: L in force divided by the file's L.
 */
static int32_t held_back(const pi_cfg_t *cfg, int32_t current, int32_t limit, int32_t ratio_q14)
{
    const int32_t beyond = current - fx_clamp(current, -limit, limit);
    const int32_t nominal = fx_sat16(fx_asr(beyond * cfg->kp, cfg->kp_shift));

    return fx_sat16(fx_asr(nominal * ratio_q14, 14U));
}

/*
 * An imposed current is controlled softly, so that the current that the EMF of a swinging rotor
 * drives damps the swing. Beyond along_max and across_max the control is firm. Otherwise a rotor
 * that turns while it is pulled in would trip the drive at over-current. The firm gain is the full
 * one for the measured L, not reduced at low speed as model_pace() does.
 */
static void limit_imposed_current(drive_t *drive, dq_t current)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const current_loop_cfg_t *const firm = &drive->cfg->current_loop;
    dq_t *const voltage = &drive->control.current_loop.constant;

    voltage->d -=
        held_back(&firm->pi_d, current.d, cfg->along_max, drive->motor.model.inductance_q14);
    voltage->q -=
        held_back(&firm->pi_q, current.q, cfg->across_max, model_ratio_q_q14(&drive->motor.model));
}

/*
 * The integrals round down, on average by half an LSB per tick. The integrals of an imposed current
 * are so slow that this would shift the current by some percent and the vector by degrees. So every
 * other tick adds one LSB.
 */
static void give_rounding_back(drive_t *drive)
{
    const int32_t due = ((drive->tick & 1U) != 0U) ? 1 : 0;
    pi_t *const d = &drive->control.current_loop.pi_d;
    pi_t *const q = &drive->control.current_loop.pi_q;

    d->integral_q26 = fx_sat27(d->integral_q26 + due);
    q->integral_q26 = fx_sat27(q->integral_q26 + due);
}

dq_t frame_control_current(drive_t *drive, const current_loop_cfg_t *loop, dq_t current,
                           int32_t bus)
{
    return current_loop_step(&drive->control.current_loop, loop, drive->control.current_ref,
                             current, modulator_limit(&drive->cfg->modulator, bus));
}

dq_t frame_impose_current(drive_t *drive, const frame_t *frame, int32_t bus)
{
    plan_current(drive, frame->loop, frame->step);
    limit_imposed_current(drive, frame->current);
    give_rounding_back(drive);
    return frame_control_current(drive, frame->loop, frame->current, bus);
}

/*
 * Returns the current expected in the next period. In RUN it is the reference plus a quarter of the
 * difference to the measurement. The reference alone has the wrong sign for a leg whose current has
 * not changed yet; the measurement alone has noise and ripple.
 *
 * An imposed current is controlled softly, and a swinging rotor adds a current of its own. So half
 * of the expected current is the mean of the measured one. The other half is the reference: with a
 * measured current of zero the compensation would be zero, and the dead time would keep the current
 * at zero. The integral would rise until it overcomes the dead time. Then the compensation would
 * come on top of it, and far too much current would flow.
 *
 * In the voltage drive it is the measured current alone: a mean would follow the natural
 * oscillation of the currents too late (voltage_drive.h).
 */
static dq_t expected_current(const drive_t *drive, const frame_t *frame)
{
    dq_t expected;

    if (frame->imposed) {
        const dq_t wanted = drive->control.current_ref;

        expected.d = fx_asr(wanted.d + drive->vector.current_mean.d, 1U);
        expected.q = fx_asr(wanted.q + drive->vector.current_mean.q, 1U);
    } else if (drive->voltage_drive.active) {
        expected = (dq_t){fx_sat15(frame->current.d), fx_sat15(frame->current.q)};
    } else {
        const dq_t wanted = drive->control.current_ref;

        expected.d = fx_approach(wanted.d, frame->current.d, LACKING_SHIFT);
        expected.q = fx_approach(wanted.q, frame->current.q, LACKING_SHIFT);
    }
    return expected;
}

/*
 * Returns the angle that a frame will have in the middle of the period in which the voltage of this
 * tick acts.
 */
static inline angle_t acting_angle(angle_t angle, step_t step)
{
    return angle + fx_unsigned(step) + fx_unsigned(fx_asr(step, 1U));
}

void frame_modulate(drive_t *drive, const frame_t *frame, dq_t voltage, compare_t *out)
{
    const angle_t acting = acting_angle(frame->angle, frame->step);
    /*@ assert SECTORS(acting); */
    const modulator_t *const mod = &drive->modulator;
    const modulator_cfg_t *const cfg = &drive->cfg->modulator;
    const sincos_t angle = trig_sincos(acting);
    const dq_t ratio = modulator_ratio(mod, voltage);
    const ab_t ratio_ab = transforms_park_inverse(ratio, angle);

    drive->control.ratio_acting.alpha = drive->control.ratio_next.alpha;
    drive->control.ratio_acting.beta = drive->control.ratio_next.beta;
    drive->control.ratio_next = ratio_ab;
    if (modulator_compensates(cfg)) {
        const ab_t current = transforms_park_inverse(expected_current(drive, frame), angle);

        modulator_compare_compensated(mod, cfg, ratio_ab, current, out);
    } else {
        modulator_compare(cfg, ratio_ab, out);
    }
}

void frame_modulate_plain(drive_t *drive, dq_t voltage, compare_t *out)
{
    const angle_t acting =
        acting_angle(rotor_position_angle(&drive->vector.position), drive->vector.step);
    /*@ assert SECTORS(acting); */
    const dq_t ratio = modulator_ratio(&drive->modulator, voltage);

    drive->control.ratio_acting = drive->control.ratio_next;
    drive->control.ratio_next = transforms_park_inverse(ratio, trig_sincos(acting));
    modulator_compare(&drive->cfg->modulator, drive->control.ratio_next, out);
}

void frame_turn(drive_t *drive, angle_t angle)
{
    const sincos_t turn = trig_sincos(angle);
    const dq_t reference = drive->control.current_ref;
    const dq_t turned = transforms_park((ab_t){reference.d, reference.q}, turn);

    drive->control.current_ref = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    current_loop_turn(&drive->control.current_loop, turn);
}
