/* SPDX-License-Identifier: MIT */
#include "entry.h"

#include "calibration.h"
#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "monitor.h"
#include "motor.h"
#include "open_loop.h"
#include "run.h"
#include "state_guard.h"
#include "trig.h"
#include "vector.h"
#include "voltage_drive.h"

/* A vector within ± 1/128 of a turn counts as lying along phase a. */
#define NEAR_ZERO (0x02000000U)

/* Starts the estimate at θ̂ with this speed and this current, in the frame of θ̂. */
static void start_estimate(rotor_t *rotor, motor_t *motor, const drive_cfg_t *cfg, step_t speed,
                           dq_t current)
{
    motor_pace(motor, cfg, speed);
    estimate_start(rotor, &motor->model.observer, speed, current);
}

/*
 * A start begins: all that the last run has left is forgotten. The model of the motor stays. What
 * the estimate begins with follows.
 */
NEVER_INLINED static void begin_start(drive_t *drive)
{
    vector_reset(&drive->vector);
    voltage_drive_reset(&drive->voltage_drive);
    frame_reset(&drive->control);
    derating_start(&drive->derating);
    estimate_reset(&drive->rotor);
    run_reset(&drive->motion, drive);
}

/*
 * RUN begins where a sensor says that the rotor is. Without a sensor and without a start-up the
 * rotor counts as at rest at angle 0.
 */
static void begin_known(drive_t *drive)
{
    if (drive_is_sensed(drive)) {
        motor_pace(&drive->motor, drive->cfg, drive->rotor.angle_sensor.speed);
        estimate_start_sensed(&drive->rotor, &drive->motor.model.observer);
        run_catch_sensed(&drive->motion, drive);
    } else {
        start_estimate(&drive->rotor, &drive->motor, drive->cfg, 0, (dq_t){0, 0});
    }
}

/* FLYING_START begins, the first time or once more. */
static void begin_search(drive_t *drive)
{
    open_loop_reset(&drive->start);
    begin_start(drive);
    start_estimate(&drive->rotor, &drive->motor, drive->cfg, 0, (dq_t){0, 0});
}

/* Begins with no current, and with no word in force. */
static void begin_probe(drive_t *drive)
{
    probe_reset(&drive->probe);
    frame_reset(&drive->control);
    vector_reset(&drive->vector);
    voltage_drive_reset(&drive->voltage_drive);
}

/* The vector begins one sweep away from angle 0. */
NEVER_INLINED static void begin_sweep(drive_t *drive)
{
    const align_cfg_t *const cfg = &drive->cfg->startup.align;
    const angle_t sweep = (angle_t)cfg->sweep_speed * cfg->sweep_ticks;

    vector_draw_back(&drive->vector, sweep, drive->start.align.backwards);
    estimate_place(&drive->rotor, drive->vector.position);
    start_estimate(&drive->rotor, &drive->motor, drive->cfg, 0, (dq_t){0, 0});
}

/*
 * Sets L from the pulses of the flying start, until R and L are measured at standstill: with a
 * wrong L the estimate swings. The pulses give φ/L_q; φ and L_q/L_d are taken from the file. If the
 * pulses give no L, the bandwidth of the speed loop is lowered, so that it tolerates a wrong L.
 */
NEVER_INLINED static void use_pulses(motor_t *motor, motion_t *motion, const drive_t *drive)
{
    const model_measured_t found = {
        .resistance_q13 = MODEL_UNKNOWN,
        .inductance_q14 = drive->start.flying_start.inductance_q14,
        .saliency_q13 = MODEL_UNKNOWN,
    };
    const bool usable = found.inductance_q14 > 0;

    if (usable) {
        motor_set(motor, drive->cfg, &found);
    }
    run_set_bandwidth(motion, !usable);
}

/*
 * Starts the estimate with the angle and the speed that the flying start has found. The windings
 * stay shorted until the first demand acts, so the applied voltage is zero until then.
 */
NEVER_INLINED static void start_turning(drive_t *drive, sample_t sample)
{
    const flying_start_t *const found = &drive->start.flying_start;
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    rotor_position_t position;

    rotor_position_reset(&position, found->angle);
    estimate_place(&drive->rotor, position);
    start_estimate(&drive->rotor, &drive->motor, drive->cfg, found->speed,
                   transforms_park(current_ab, trig_sincos(found->angle)));
    rotor_position_step(&position, drive->rotor.observer.speed_out);
    estimate_place(&drive->rotor, position);
    run_catch(&drive->motion, drive->rotor.observer.speed);
    vector_place(&drive->vector, position, drive->rotor.observer.speed, (dq_t){0, 0});
}

/* A flying start has ended: the rotor turns. */
static void begin_turning(drive_t *drive, sample_t sample)
{
    if (!drive->motor.identified) {
        use_pulses(&drive->motor, &drive->motion, drive);
    }
    start_turning(drive, sample);
}

/*
 * True after a sweep, except for rounding errors of the angle. After a hand-back the vector may lie
 * at any angle.
 */
static bool lies_along_phase_a(const drive_t *drive)
{
    return (rotor_position_angle(&drive->vector.position) + NEAR_ZERO) < (2U * NEAR_ZERO);
}

/*
 * Corrects the dead time. Returns the voltage that the compensation adds along the vector from now
 * on, Q15 of the bus.
 */
static int32_t correct_dead_time(modulator_t *modulator, const drive_t *drive, int32_t lost_voltage)
{
    int32_t change = 0;

    if (lies_along_phase_a(drive)) {
        change = modulator_correct(modulator, &drive->cfg->modulator, lost_voltage);
    }
    return (4 * change) / 3;
}

/*
 * From now on the model (R·i) and the dead-time compensation supply a part of the voltage. This
 * function takes that part out of the integral. The integral is slow, so the part would otherwise
 * be there twice for some swings of the rotor. compensated: voltage that the compensation adds from
 * now on, Q15 of the bus.
 */
static void leave_rest_to_integral(control_t *control, const drive_t *drive, int32_t bus,
                                   int32_t compensated)
{
    const int32_t resistance = drive->motor.model.hold_loop.resistance_q13;
    const int32_t model = fx_asr(resistance * fx_sat15(drive->vector.current_mean.d), 13U);
    const int32_t added = fx_asr(compensated * bus, 15U);

    frame_rest_to_integral_d(control, model + added);
}

/* ALIGN has ended: R and L are used from now on, if they were found. */
NEVER_INLINED static void use_alignment(drive_t *drive, const instant_t *now)
{
    const align_found_t *const found = &drive->start.align.found;

    if (found->inductance.ratio_q14 > 0) {
        const model_measured_t measured = {
            found->resistance_q13,
            found->inductance.ratio_q14,
            found->inductance.saliency_q13,
        };

        motor_set(&drive->motor, drive->cfg, &measured);
        leave_rest_to_integral(&drive->control, drive, now->sample.bus,
                               correct_dead_time(&drive->modulator, drive, found->lost_voltage));
        start_estimate(&drive->rotor, &drive->motor, drive->cfg, 0, now->along_rotor);
    }
    motor_identify(&drive->motor);
    state_guard_keep_measured(&drive->state_guard, drive);
    run_set_bandwidth(&drive->motion, false);
    vector_move(&drive->vector, 0);
    run_stand(&drive->motion);
    estimate_align_sensor(&drive->rotor, drive);
}

/*
 * Changes back to an imposed current: the d axis of the vector's frame is set to the direction of
 * the present current reference.
 */
NEVER_INLINED static void hand_back(drive_t *drive, dq_t current)
{
    const dq_t reference = drive->control.current_ref;
    const angle_t load_angle =
        trig_atan2((int16_t)fx_sat16(reference.q), (int16_t)fx_sat16(reference.d));
    const dq_t turned =
        transforms_park((ab_t){fx_sat15(current.d), fx_sat15(current.q)}, trig_sincos(load_angle));
    rotor_position_t position = drive->rotor.position;

    rotor_position_step(&position, fx_signed(load_angle));
    vector_place(&drive->vector, position, drive->motion.speed_loop.reference,
                 (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)});
    frame_turn(&drive->control, load_angle);
    monitor_forget_imposed(&drive->watch);
}

/*
 * Changes from the frame of the vector to the frame of the rotor. i_q* in the vector's frame is the
 * torque of the ramp. The speed loop feeds that torque forward, so its integral begins with i_q* in
 * the rotor's frame minus that torque: the torque of the load.
 */
static void hand_over(control_t *control, motion_t *motion, const drive_t *drive)
{
    const int32_t of_ramp = control->current_ref.q;

    frame_turn(control, 0U - open_loop_load_angle(drive));
    run_take_load(motion, control->current_ref.q - of_ramp);
}

/* RUN begins with a plan of its current control and with the torque that acts. */
NEVER_INLINED static void begin_run(drive_t *drive, drive_state_t from, const instant_t *now)
{
    if (from == DRIVE_STATE_READY) {
        begin_start(drive);
        begin_known(drive);
    } else if (from == DRIVE_STATE_FLYING_START) {
        begin_turning(drive, now->sample);
    } else { /* HANDOVER, or HOLD with a sensor that knows the rotor now */
        if (from == DRIVE_STATE_HOLD) {
            estimate_take_sensor(&drive->rotor);
        }
        hand_over(&drive->control, &drive->motion, drive);
    }
    run_start(&drive->motion, drive);
    frame_plan_rotor(&drive->control, drive);
}

NEVER_INLINED static void begin_hold(drive_t *drive, drive_state_t from, const instant_t *now)
{
    if (from == DRIVE_STATE_ALIGN) {
        use_alignment(drive, now);
    } else if (from == DRIVE_STATE_RUN) {
        hand_back(drive, now->along_rotor);
    } else {
        /* the vector has come to rest */
    }
}

/* The user asks to run or to measure: failed starts are forgotten, and the checks begin anew. */
static void begin_request(start_t *start, watch_t *watch, motion_t *motion)
{
    open_loop_forget(start);
    monitor_reset(watch);
    run_set_bandwidth(motion, false);
}

/*
 * A calibration begins; it ends a safe state. R, L and φ stay: they were measured, or lie within a
 * range around the values of the files.
 */
static void begin_calibration(sensors_t *sensors, safe_state_t *safe_state, motion_t *motion)
{
    calibration_begin(sensors);
    safe_state_reset(safe_state);
    run_forget_inertia(motion);
}

NEVER_INLINED void entry_begin(drive_t *drive, drive_state_t from, const instant_t *now)
{
    if (from == DRIVE_STATE_READY) {
        begin_request(&drive->start, &drive->watch, &drive->motion);
    }
    switch (drive->state) {
    case DRIVE_STATE_OFFSET_CAL:
        begin_calibration(&drive->sensors, &drive->safe_state, &drive->motion);
        break;
    case DRIVE_STATE_FLYING_START:
        begin_search(drive);
        break;
    case DRIVE_STATE_PROBE:
        begin_probe(drive);
        break;
    case DRIVE_STATE_ALIGN:
        if (from == DRIVE_STATE_FLYING_START) {
            begin_sweep(drive);
        }
        break;
    case DRIVE_STATE_HOLD:
        begin_hold(drive, from, now);
        break;
    case DRIVE_STATE_IF_RAMP:
        if (from == DRIVE_STATE_FLYING_START) {
            begin_turning(drive, now->sample);
        }
        break;
    case DRIVE_STATE_RUN:
        begin_run(drive, from, now);
        break;
    default:
        /* INIT, READY, HANDOVER, FAULT: nothing begins */
        break;
    }
}
