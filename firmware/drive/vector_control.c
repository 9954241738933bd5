/* SPDX-License-Identifier: MIT */
#include "vector_control.h"

#include "drive_state.h"
#include "trig.h"
#include "voltage_drive.h"

#include <stddef.h>

#define Q16_TO_Q32 (65536)
#define PULL_SHIFT (6U) /* while it follows, θ̂ closes 1/64 of its distance to the frame in a tick */
#define LACKING_SHIFT (2U)  /* of the distance to the reference, in the current expected */
#define MEAN_SHIFT (5U)     /* of the imposed current's filter, in ticks */
#define RESIDUAL_SHIFT (3U) /* of the residual's filter, in slow periods */

void vector_control_reset(drive_t *drive)
{
    nn_observer_start(&drive->observer, &drive->model.observer, 0, (dq_t){0, 0}, trig_sincos(0U));
    rotor_position_reset(&drive->position, 0U);
    rotor_position_reset(&drive->frame, 0U);
    drive->voltage_driven = false;
    drive->voltage_periods = 0U;
    current_loop_reset(&drive->current_loop);
    speed_loop_reset(&drive->speed_loop, 0);
    position_loop_reset(&drive->position_loop, 0, 0);
    drive->frame_speed = 0;
    drive->speed_reference = 0;
    drive->signals.ratio_ab = (ab_t){0, 0};
    drive->ratio_acting = (ab_t){0, 0};
    drive->residual = 0;
    drive->lost_periods = 0U;
    drive->signals.current_ref = (dq_t){0, 0};
    drive->signals.current_mean = (dq_t){0, 0};
    drive->torque_range = (torque_range_t){-drive->derating.motoring, drive->derating.motoring};
    drive->derating.voltage = (dq_t){0, 0};
    drive->mode = (uint8_t)DRIVE_MODE_SPEED;
}

/* The voltage that acted since the last instant: duty ratio times the mean bus voltage of that period. */
static ab_t applied_voltage(const drive_t *drive)
{
    const int32_t bus = fx_asr(drive->bus_before + drive->signals.bus, 1U);

    return (ab_t){
        .alpha = fx_sat16(fx_asr(drive->ratio_acting.alpha * bus, 15U)),
        .beta = fx_sat16(fx_asr(drive->ratio_acting.beta * bus, 15U)),
    };
}

/*
 * The dead-time compensation must not use the measured current of a leg that the dead time itself holds at zero. So the
 * sign comes from the filtered current vector.
 */
static void measure_frame(drive_t *drive)
{
    const angle_t frame = rotor_position_angle(&drive->frame);
    /*@ assert SECTORS(frame); */
    drive_signals_t *const s = &drive->signals;
    const dq_t current = transforms_park(s->current_ab, trig_sincos(frame));

    s->current_frame = current;
    s->current_mean.d = fx_approach(s->current_mean.d, fx_sat15(current.d), MEAN_SHIFT);
    s->current_mean.q = fx_approach(s->current_mean.q, fx_sat15(current.q), MEAN_SHIFT);
}

void vector_control_estimate(drive_t *drive, bool track)
{
    const angle_t rotor = rotor_position_angle(&drive->position);
    /*@ assert BLOCKS(rotor); */
    drive_signals_t *const s = &drive->signals;
    const nn_observer_cfg_t *const cfg = &drive->model.observer;
    const sincos_t angle = trig_sincos(rotor);

    s->current_ab = transforms_clarke(s->phase_a, s->phase_b);
    s->current = transforms_park(s->current_ab, angle);
    s->voltage_applied = applied_voltage(drive);
    nn_observer_predict(&drive->observer, cfg, s->current, s->voltage_applied, angle);
    if (track) {
        nn_observer_train(&drive->observer, cfg);
    } else {
        nn_observer_follow(&drive->observer, drive->frame_speed);
    }
    s->speed = fx_sat16(fx_asr(drive->observer.speed, drive->cfg->speed_shift));
    if (drive->state != DRIVE_STATE_RUN) {
        measure_frame(drive);
    }
}

static int64_t measured_position(const drive_t *drive)
{
    return (drive->state == DRIVE_STATE_RUN) ? drive->position.turns_q32 : drive->frame.turns_q32;
}

static void change_mode(drive_t *drive, uint8_t mode)
{
    drive->mode = mode;
    position_loop_reset(&drive->position_loop, measured_position(drive),
                        drive->speed_loop.reference);
}

void vector_control_plan(drive_t *drive, const drive_command_t *command)
{
    const drive_cfg_t *const cfg = drive->cfg;

    if (command->mode != drive->mode) {
        change_mode(drive, command->mode);
    }
    if (drive->mode == (uint8_t)DRIVE_MODE_POSITION) {
        drive->speed_reference = position_loop_step(&drive->position_loop, &cfg->position_loop,
                                                    (int64_t)command->target * Q16_TO_Q32,
                                                    measured_position(drive), cfg->slow_ticks);
    } else {
        drive->speed_reference =
            speed_loop_ramp(&drive->speed_loop, &cfg->speed_loop, command->target);
    }
}

/* Commanded speed and rotor speed are both so low that a current has to be imposed. */
static bool is_slow(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool asked = fx_abs(drive->speed_reference) < cfg->hold_speed;

    return asked && (fx_abs(drive->observer.speed) < cfg->handover_speed);
}

/*
 * i_d* in RUN. Below the speed at which the observer hands back, it rises to the current that will be imposed. Above, it
 * keeps the current vector large enough that not all legs switch near their zero crossing.
 */
static int32_t next_current_d(const drive_t *drive)
{
    const run_cfg_t *const cfg = &drive->cfg->run;
    const int32_t slope = cfg->current_slope * (int32_t)drive->cfg->slow_ticks;
    const dq_t present = drive->signals.current_ref;
    const bool slow = is_slow(drive);
    const int32_t lacking = fx_max(cfg->current_floor - fx_abs(present.q), 0);
    const int32_t wanted = slow ? drive->cfg->startup.current_hold : lacking;

    return fx_towards(present.d, wanted, slope);
}

/*
 * The speed for ρ of the observer: its estimate when that is far from zero, else the commanded speed. A swing of the
 * estimate through zero would change the sign of ρ and sustain itself.
 */
static step_t calm_speed(const drive_t *drive)
{
    const step_t fast = 2 * drive->cfg->startup.handover_speed;
    const step_t own = drive->observer.speed;

    return (fx_abs(own) >= fast) ? own : drive->speed_loop.reference;
}

void vector_control_refine(drive_t *drive)
{
    const nn_observer_t *const observer = &drive->observer;
    const model_nominal_t nominal = drive_nominal(drive);

    drive->residual = fx_approach(drive->residual, fx_abs(observer->turned.q), RESIDUAL_SHIFT);
    model_track_flux(&drive->model, &drive->cfg->model, &nominal, observer->turned.d,
                     observer->speed);
    nn_observer_update_rho(&drive->observer, &drive->model.observer, calm_speed(drive));
}

/* The frame turns forwards by `angle`. A vector that is constant in space turns backwards in it. */
static void turn_frame(drive_t *drive, angle_t angle)
{
    const sincos_t turn = trig_sincos(angle);
    const dq_t reference = drive->signals.current_ref;
    const dq_t turned = transforms_park((ab_t){reference.d, reference.q}, turn);

    drive->signals.current_ref = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    current_loop_turn(&drive->current_loop, turn);
}

/* Change back to an imposed current: the d axis of the frame is set to the direction of the present reference. */
static void hand_back(drive_t *drive)
{
    const dq_t reference = drive->signals.current_ref;
    const angle_t load_angle =
        trig_atan2((int16_t)fx_sat16(reference.q), (int16_t)fx_sat16(reference.d));
    dq_t turned;

    drive->frame.turns_q32 = drive->position.turns_q32;
    rotor_position_step(&drive->frame, fx_signed(load_angle));
    drive->frame_speed = drive->speed_loop.reference;
    turn_frame(drive, load_angle);
    turned = transforms_park(
        (ab_t){fx_sat15(drive->signals.current.d), fx_sat15(drive->signals.current.q)},
        trig_sincos(load_angle));
    drive->signals.current_frame = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    drive->signals.current_mean = drive->signals.current_frame;
    supervision_forget_imposed(&drive->supervision);
}

/* RUN changes to HOLD when the imposed current has risen to its level. */
static void watch_speed(drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;

    if ((cfg->current_hold != 0) && (drive->signals.current_ref.d >= cfg->current_hold) &&
        is_slow(drive)) {
        hand_back(drive);
        drive_enter(drive, DRIVE_STATE_HOLD);
    }
}

/*
 * While derating narrows the torque, ramp and profile wait at the narrowed limit. If they went on, the rotor would fall
 * further behind in each period. It would then be braked with the whole current as soon as the limit ends.
 */
static void wait_at_limit(drive_t *drive, step_t before)
{
    const bool faster = drive->speed_loop.reference > before;
    const int32_t torque = drive->signals.current_ref.q;
    const int32_t end = faster ? drive->torque_range.upper : -drive->torque_range.lower;
    const int32_t towards = faster ? torque : -torque;

    if ((towards >= end) && (end < drive->cfg->derating.current_max)) {
        drive->speed_loop.reference = before;
        position_loop_reset(&drive->position_loop, measured_position(drive), before);
    }
}

/* The torque current, and i_d*. */
static void control_motion(drive_t *drive)
{
    const step_t before = drive->speed_loop.reference;

    drive->signals.current_ref.d = next_current_d(drive);
    drive->signals.current_ref.q =
        speed_loop_step(&drive->speed_loop, &drive->cfg->speed_loop, drive->speed_reference,
                        drive->observer.speed, drive->torque_range);
    wait_at_limit(drive, before);
    watch_speed(drive);
}

static void control_speed(drive_t *drive, const drive_command_t *command)
{
    if (drive->voltage_driven) {
        voltage_drive_motion(drive, command);
    } else {
        control_motion(drive);
        voltage_drive_offer(drive, command);
    }
}

void vector_control_motion(drive_t *drive, const drive_command_t *command, uint32_t left)
{
    if (left == (uint32_t)SLOW_PART_REFINE) {
        vector_control_refine(drive);
    } else if (left == (uint32_t)SLOW_PART_PLAN) {
        vector_control_plan(drive, command);
    } else if (left == (uint32_t)SLOW_PART_SPEED) {
        control_speed(drive, command);
    } else {
        /* the monitor's */
    }
}

/* The voltage step of the alignment: v_d drops once and stays; the integrals of the loop do not change. */
static void step_voltage(drive_t *drive)
{
    if (drive->align.tick == 1U) {
        drive->signals.voltage.d =
            fx_max(drive->signals.voltage.d - drive->cfg->startup.align.step_voltage, -FX_Q15_MAX);
    }
}

/* Currents to voltage. */
static void control_currents(drive_t *drive, bool running)
{
    drive_signals_t *const s = &drive->signals;
    const int32_t imposed = fx_sat16(fx_asr(drive->frame_speed, drive->cfg->speed_shift));

    s->voltage_limit = modulator_limit(&drive->cfg->modulator, s->bus);
    s->voltage = current_loop_step(&drive->current_loop,
                                   running ? &drive->model.run_loop : &drive->model.hold_loop,
                                   s->current_ref, running ? s->current : s->current_frame,
                                   running ? s->speed : imposed, s->voltage_limit);
}

/*
 * The current in the period to come, for the dead-time compensation. In RUN it is the reference plus a quarter of the
 * difference to the measurement. The reference alone has the wrong sign for a leg whose current has not changed yet; the
 * measurement alone has noise and ripple. An imposed current is controlled softly, so its mean is used.
 */
static dq_t expected_current(const drive_signals_t *s, bool running)
{
    dq_t expected = s->current_mean;

    if (running) {
        expected.d = fx_approach(s->current_ref.d, s->current.d, LACKING_SHIFT);
        expected.q = fx_approach(s->current_ref.q, s->current.q, LACKING_SHIFT);
    }
    return expected;
}

/* The voltage to compare values. It is turned for the middle of the period in which it acts. */
static void modulate(drive_t *drive, bool running, compare_t *out)
{
    const rotor_position_t *const frame = running ? &drive->position : &drive->frame;
    const step_t step = running ? drive->observer.speed_out : drive->frame_speed;
    const angle_t ahead = fx_unsigned(step) + fx_unsigned(fx_asr(step, 1U));
    const angle_t acting = rotor_position_angle(frame) + ahead;
    /*@ assert SECTORS(acting); */
    drive_signals_t *const s = &drive->signals;
    const sincos_t angle = trig_sincos(acting);
    const dq_t ratio = modulator_ratio(&drive->modulator, s->voltage);
    const ab_t *given_back = NULL;
    ab_t current;

    if (modulator_compensates(&drive->cfg->modulator)) {
        current = transforms_park_inverse(expected_current(s, running), angle);
        given_back = &current;
    }
    drive->ratio_acting.alpha = s->ratio_ab.alpha;
    drive->ratio_acting.beta = s->ratio_ab.beta;
    s->ratio_ab = transforms_park_inverse(ratio, angle);
    modulator_compare(&drive->modulator, &drive->cfg->modulator, s->ratio_ab, given_back, out);
}

/* While the observer does not run free, θ̂ advances with the frame and approaches it. */
static step_t closing_step(const drive_t *drive)
{
    const angle_t distance =
        rotor_position_angle(&drive->frame) - rotor_position_angle(&drive->position);

    return fx_asr(fx_signed(distance), PULL_SHIFT);
}

void vector_control_close(drive_t *drive, bool track, drive_out_t *out)
{
    const bool running = drive->state == DRIVE_STATE_RUN;
    step_t step = drive->observer.speed_out;

    if ((drive->state == DRIVE_STATE_ALIGN) &&
        align_steps_voltage(&drive->align, &drive->cfg->startup.align)) {
        step_voltage(drive);
    } else if (drive->voltage_driven) {
        voltage_drive_step(drive);
    } else {
        control_currents(drive, running);
    }
    modulate(drive, running, &out->compare);
    out->gate_enable = true;
    if (!running) {
        rotor_position_step(&drive->frame, drive->frame_speed);
        step += track ? 0 : closing_step(drive);
    }
    rotor_position_step(&drive->position, step); /* (23) */
}

void vector_control_take_over(drive_t *drive)
{
    turn_frame(drive, rotor_position_angle(&drive->position) - rotor_position_angle(&drive->frame));
    speed_loop_start(&drive->speed_loop, drive->speed_loop.reference, drive->signals.current_ref.q);
}
