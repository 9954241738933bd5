/* SPDX-License-Identifier: MIT */
#include "frame.h"

#include "trig.h"

#define LACKING_SHIFT (2U) /* expected current = reference + (measured − reference) / 4 */

void frame_reset(control_t *control)
{
    *control = (control_t){.current_ref = {0, 0}};
}

void frame_plan_with(control_t *control, const drive_t *drive, const current_loop_cfg_t *loop,
                     step_t speed)
{
    current_loop_plan(&control->current_loop, loop, control->current_ref,
                      drive_speed_q15(drive, speed));
}

void frame_plan_rotor(control_t *control, const drive_t *drive)
{
    frame_plan_with(control, drive, &drive->motor.model.run_loop, drive->rotor.observer.speed);
}

void frame_plan(control_t *control, const drive_t *drive)
{
    if (drive->state == DRIVE_STATE_RUN) {
        frame_plan_rotor(control, drive);
    } else {
        frame_plan_with(control, drive, &drive->motor.model.hold_loop, drive->vector.step);
    }
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
static void limit_imposed_current(control_t *control, const drive_t *drive, dq_t current)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const current_loop_cfg_t *const firm = &drive->cfg->current_loop;
    dq_t *const voltage = &control->current_loop.constant;

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
static void give_rounding_back(control_t *control, uint32_t tick)
{
    const int32_t due = ((tick & 1U) != 0U) ? 1 : 0;
    pi_t *const d = &control->current_loop.pi_d;
    pi_t *const q = &control->current_loop.pi_q;

    d->integral_q26 = fx_sat27(d->integral_q26 + due);
    q->integral_q26 = fx_sat27(q->integral_q26 + due);
}

dq_t frame_control_current(control_t *control, const drive_t *drive, const current_loop_cfg_t *loop,
                           dq_t current, int32_t bus)
{
    return current_loop_step(&control->current_loop, loop, control->current_ref, current,
                             modulator_limit(&drive->cfg->modulator, bus));
}

dq_t frame_impose_current(control_t *control, const drive_t *drive, const frame_t *frame,
                          int32_t bus)
{
    frame_plan_with(control, drive, frame->loop, frame->step);
    limit_imposed_current(control, drive, frame->current);
    give_rounding_back(control, drive->tick);
    return frame_control_current(control, drive, frame->loop, frame->current, bus);
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

/* Keeps the demand of this tick: its ratio acts from the next instant on. */
static void keep_demand(control_t *control, dq_t voltage, ab_t ratio)
{
    control->voltage = voltage;
    control->ratio_acting.alpha = control->ratio_next.alpha;
    control->ratio_acting.beta = control->ratio_next.beta;
    control->ratio_next = ratio;
}

void frame_modulate(control_t *control, const drive_t *drive, const frame_t *frame, dq_t voltage,
                    compare_t *out)
{
    const angle_t acting = acting_angle(frame->angle, frame->step);
    /*@ assert SECTORS(acting); */
    const modulator_t *const mod = &drive->modulator;
    const modulator_cfg_t *const cfg = &drive->cfg->modulator;
    const sincos_t angle = trig_sincos(acting);
    const dq_t ratio = modulator_ratio(mod, voltage);
    const ab_t ratio_ab = transforms_park_inverse(ratio, angle);

    keep_demand(control, voltage, ratio_ab);
    if (modulator_compensates(cfg)) {
        const ab_t current = transforms_park_inverse(expected_current(drive, frame), angle);

        modulator_compare_compensated(mod, cfg, ratio_ab, current, out);
    } else {
        modulator_compare(cfg, ratio_ab, out);
    }
}

void frame_modulate_plain(control_t *control, const drive_t *drive, dq_t voltage, compare_t *out)
{
    const angle_t acting =
        acting_angle(rotor_position_angle(&drive->vector.position), drive->vector.step);
    /*@ assert SECTORS(acting); */
    const dq_t ratio = modulator_ratio(&drive->modulator, voltage);

    keep_demand(control, voltage, transforms_park_inverse(ratio, trig_sincos(acting)));
    modulator_compare(&drive->cfg->modulator, control->ratio_next, out);
}

void frame_lose_demand(control_t *control)
{
    control->ratio_next = (ab_t){0, 0};
}

void frame_turn(control_t *control, angle_t angle)
{
    const sincos_t turn = trig_sincos(angle);
    const dq_t reference = control->current_ref;
    const dq_t turned = transforms_park((ab_t){reference.d, reference.q}, turn);

    control->current_ref = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    current_loop_turn(&control->current_loop, turn);
}

/* The integral takes the part of this voltage that the model does not supply. */
static void rest_to_integral(pi_t *pi, int32_t voltage, int32_t modelled)
{
    pi_reset(pi, fx_sat16(voltage - modelled));
}

void frame_rest_to_integral_d(control_t *control, int32_t modelled)
{
    rest_to_integral(&control->current_loop.pi_d, control->voltage.d, modelled);
}

void frame_resume(control_t *control, const drive_t *drive, dq_t mean)
{
    dq_t modelled;

    control->current_ref = (dq_t){.d = 0, .q = mean.q};
    frame_plan_rotor(control, drive);
    modelled = current_loop_model(&control->current_loop, mean);
    rest_to_integral(&control->current_loop.pi_d, control->voltage.d, modelled.d);
    rest_to_integral(&control->current_loop.pi_q, control->voltage.q, modelled.q);
}

void frame_take_over(control_t *control, dq_t voltage)
{
    current_loop_take_over(&control->current_loop, voltage);
}
