/* SPDX-License-Identifier: MIT */
#include "open_loop.h"

#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "run.h"
#include "state_guard.h"
#include "trig.h"

#define SIXTH_TURN (0x2AAAAAAAU)
/* At a hand-over the speeds of rotor and vector differ by less than 1/2 of the hand-over speed. */
#define SLIP_SHARE (2)
/* A vector within ± 1/128 of a turn counts as lying along phase a. */
#define NEAR_ZERO (0x02000000U)
#define INVERSE_ROOT_3_Q15 (18918)
#define Q13_ONE (8192)

drive_event_t open_loop_start(drive_t *drive)
{
    run_reset(drive);
    flying_start_reset(&drive->start.flying_start);
    return DRIVE_EVENT_SEARCH;
}

static bool runs_backwards(const drive_command_t *command)
{
    return (command->mode != (uint8_t)DRIVE_MODE_POSITION) && (command->target < 0);
}

/*
 * Starts the alignment. The vector begins one sweep away from angle 0, so that the sweep ends at
 * angle 0. Every other attempt sweeps in the other direction: a load that turned the rotor against
 * the vector then turns it with the vector.
 */
static drive_event_t start_alignment(drive_t *drive, const drive_command_t *command)
{
    const align_cfg_t *const cfg = &drive->cfg->startup.align;
    const bool reversed = (drive->start.attempts & 1U) != 0U;
    const bool backwards = runs_backwards(command) != reversed;
    const angle_t sweep = (angle_t)cfg->sweep_speed * cfg->sweep_ticks;

    align_reset(&drive->start.align, backwards);
    rotor_position_reset(&drive->vector.position, 0U);
    drive->vector.position.turns_q32 -= (int64_t)sweep * (backwards ? -1 : 1);
    drive->rotor.position = drive->vector.position;
    estimate_start(drive, 0, (dq_t){0, 0});
    return DRIVE_EVENT_STANDS;
}

/*
 * Whether the rotor has to be brought to rest before another hand-over: a start has failed before R
 * was measured. The rotor has slipped, its load drives it, and an observer with a wrong R would
 * lose it.
 */
static bool has_to_stand(const drive_t *drive)
{
    return (drive->start.attempts > 0U) && !drive->motor.identified;
}

/*
 * Sets L from the pulses of the flying start, until R and L are measured at standstill: with a
 * wrong L the estimate swings. The pulses give φ/L_q; φ and L_q/L_d are taken from the file. If the
 * pulses give no L, the bandwidth of the speed loop is lowered, so that it tolerates a wrong L.
 */
static void use_pulses(drive_t *drive)
{
    const model_nominal_t nominal = drive_nominal(drive);
    const model_measured_t found = {
        .resistance_q13 = MODEL_UNKNOWN,
        .inductance_q14 = drive->start.flying_start.inductance_q14,
        .saliency_q13 = MODEL_UNKNOWN,
    };

    if (found.inductance_q14 > 0) {
        model_set(&drive->motor.model, &drive->cfg->model, &nominal, &found);
        speed_loop_restore(&drive->motion.speed_loop);
    } else {
        speed_loop_lower(&drive->motion.speed_loop);
    }
}

/*
 * Starts the estimate with the angle and the speed that the flying start has found. The windings
 * stay shorted until the first demand acts, so the applied voltage is zero until then.
 */
NEVER_INLINED static drive_event_t start_turning(drive_t *drive, ab_t current_ab)
{
    const flying_start_t *const found = &drive->start.flying_start;
    const bool fast = fx_abs(found->speed) >= drive->cfg->startup.handover_speed;

    if (!drive->motor.identified) {
        use_pulses(drive);
    }
    rotor_position_reset(&drive->rotor.position, found->angle);
    estimate_start(drive, found->speed, transforms_park(current_ab, trig_sincos(found->angle)));
    rotor_position_step(&drive->rotor.position, drive->rotor.observer.speed_out);
    speed_loop_reset(&drive->motion.speed_loop, drive->rotor.observer.speed);
    drive->motion.speed_reference = drive->rotor.observer.speed;
    drive->vector.position = drive->rotor.position;
    drive->vector.step = drive->rotor.observer.speed;
    return (fast && !has_to_stand(drive)) ? DRIVE_EVENT_TRACKED : DRIVE_EVENT_DRAGGED;
}

/* Returns the speed above which the EMF between two phases is larger than the bus voltage. */
static step_t rectifying_speed(const drive_t *drive, int32_t bus)
{
    const int32_t phase = fx_asr(bus * INVERSE_ROOT_3_Q15, 15U);
    const int32_t speed_q15 = (phase * Q13_ONE) / fx_max(drive->motor.model.run_loop.emf_q13, 1);
    const uint32_t lift = (uint32_t)1U << drive->cfg->speed_shift;

    return fx_min(speed_q15, FX_Q15_MAX) * (int32_t)lift;
}

/*
 * Returns the fault that explains a current with open gates. There are two causes. The EMF of a
 * fast rotor is above the bus; then the current vector turns as fast as the rotor. Or a current
 * channel is stuck; then the vector stands still. A vector that turns faster than half of the limit
 * means a fast rotor.
 */
static fault_t live_fault(const drive_t *drive, sample_t sample)
{
    const step_t speed = fx_abs(drive->start.flying_start.speed);
    const step_t limit =
        fx_min(drive->cfg->speed_loop.speed_max, rectifying_speed(drive, sample.bus));
    fault_t fault = {.id = FAULT_OVERSPEED, .value = speed, .limit = limit};

    if (speed <= (limit / 2)) {
        fault = (fault_t){
            .id = FAULT_ADC_STUCK,
            .value = fx_max(fx_abs(sample.phase_a), fx_abs(sample.phase_b)),
            .limit = fx_asr(drive->cfg->startup.flying_start.current, FLYING_START_QUIET_LOG2),
        };
    }
    return fault;
}

drive_event_t open_loop_flying_start(drive_t *drive, const drive_in_t *in, sample_t sample,
                                     drive_out_t *out, fault_t *fault)
{
    const flying_start_cfg_t *const cfg = &drive->cfg->startup.flying_start;
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    drive_event_t event = DRIVE_EVENT_NONE;
    flying_start_result_t result;

    result = flying_start_step(&drive->start.flying_start, cfg, current_ab);
    *out = (drive_out_t){.compare = {.phase = {0U, 0U, 0U}},
                         .gate_enable = drive->start.flying_start.gates};
    if (result == FLYING_START_TURNING) {
        event = start_turning(drive, current_ab);
    } else if (result == FLYING_START_LIVE) {
        event = DRIVE_EVENT_FAULT;
        *fault = live_fault(drive, sample);
    } else if (result != FLYING_START_BUSY) {
        out->gate_enable = false;
        event = start_alignment(drive, &in->command);
    } else {
        /* busy */
    }
    return event;
}

/*
 * Begins the start again, or returns FAULT after the last attempt. value: the current that has
 * exceeded its limit, Q15 of I_b.
 */
static drive_event_t repeat_start(drive_t *drive, int32_t value, int32_t limit, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_FAULT;

    drive->start.attempts++;
    drive->start.held_periods = 0U;
    if (drive->start.attempts < drive->cfg->startup.attempts) {
        event = open_loop_start(drive);
    } else {
        *fault = (fault_t){.id = FAULT_STARTUP, .value = value, .limit = limit};
    }
    return event;
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
 * From now on the model (R·i) and the dead-time compensation supply a part of the voltage. This
 * function takes that part out of the integral. The integral is slow, so the part would otherwise
 * be there twice for some swings of the rotor. compensated: voltage that the compensation adds from
 * now on, Q15 of the bus.
 */
static void leave_rest_to_integral(drive_t *drive, int32_t bus, int32_t compensated)
{
    const int32_t resistance = drive->motor.model.hold_loop.resistance_q13;
    const int32_t model = fx_asr(resistance * fx_sat15(drive->vector.current_mean.d), 13U);
    const int32_t added = fx_asr(compensated * bus, 15U);

    pi_reset(&drive->control.current_loop.pi_d, fx_sat16(drive->control.voltage.d - model - added));
}

/*
 * Corrects the dead time. Returns the voltage that the compensation adds along the vector from now
 * on, Q15 of the bus.
 */
static int32_t correct_dead_time(drive_t *drive, int32_t lost_voltage)
{
    int32_t change = 0;

    if (lies_along_phase_a(drive)) {
        change = modulator_correct(&drive->modulator, &drive->cfg->modulator, lost_voltage);
    }
    return (4 * change) / 3;
}

static drive_event_t finish_alignment(drive_t *drive, const instant_t *now)
{
    const align_found_t *const found = &drive->start.align.found;
    const model_nominal_t nominal = drive_nominal(drive);

    if (found->inductance.ratio_q14 > 0) {
        const model_measured_t measured = {
            found->resistance_q13,
            found->inductance.ratio_q14,
            found->inductance.saliency_q13,
        };

        model_set(&drive->motor.model, &drive->cfg->model, &nominal, &measured);
        leave_rest_to_integral(drive, now->sample.bus,
                               correct_dead_time(drive, found->lost_voltage));
        estimate_start(drive, 0, now->along_rotor);
    }
    speed_loop_restore(&drive->motion.speed_loop);
    drive->motor.identified = true; /* a measurement that fails is not repeated */
    state_guard_keep_measured(drive);
    drive->vector.step = 0;
    speed_loop_reset(&drive->motion.speed_loop, 0);
    return DRIVE_EVENT_HELD;
}

/*
 * If the rotor is not at rest, begins the start again at once, because the load accelerates a
 * slipping rotor. A rotor that only swings costs an attempt too.
 */
static drive_event_t judge_rest(drive_t *drive, fault_t *fault)
{
    const align_cfg_t *const cfg = &drive->cfg->startup.align;
    const align_t *const align = &drive->start.align;
    drive_event_t event = DRIVE_EVENT_NONE;

    if (!align_is_at_rest(align, cfg)) {
        event = repeat_start(drive, align->swing, cfg->swing_max, fault);
    }
    return event;
}

/*
 * One tick of ALIGN. The measurement is evaluated in one tick, and its result is used in the next
 * one.
 */
static drive_event_t align(drive_t *drive, const instant_t *now, fault_t *fault)
{
    const bool done = drive->start.align.phase == ALIGN_DONE;
    drive_event_t event = DRIVE_EVENT_NONE;

    align_step(&drive->start.align, &drive->cfg->startup.align, now->along_vector,
               drive->control.voltage.d);
    drive->control.current_ref = (dq_t){.d = drive->start.align.current_ref, .q = 0};
    drive->vector.step = drive->start.align.frame_speed;
    if (done) {
        event = finish_alignment(drive, now);
    } else if (align_has_measured(&drive->start.align)) {
        event = judge_rest(drive, fault);
    } else {
        /* the alignment goes on */
    }
    return event;
}

/*
 * Returns the next imposed current. It is larger while the vector moves, because it has to
 * accelerate the rotor too.
 */
static int32_t next_imposed_current(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const int32_t present = drive->control.current_ref.d;
    const int32_t whole =
        (drive->motion.speed_reference == 0) ? cfg->current_hold : cfg->current_move;
    const int32_t wanted = fx_min(whole, drive->derating.thermal);

    return fx_towards(present, wanted, cfg->current_slope);
}

/* Returns the angle by which the vector is ahead of the rotor. */
static angle_t load_angle(const drive_t *drive)
{
    return rotor_position_angle(&drive->vector.position) -
           rotor_position_angle(&drive->rotor.position);
}

/*
 * Whether the observer has found the rotor: its angle and speed are near those of the vector, and
 * its model explains the current.
 */
static bool has_found_rotor(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t slip = fx_abs(drive->vector.step - drive->rotor.observer.speed);
    const bool near = (load_angle(drive) + SIXTH_TURN) < (2U * SIXTH_TURN);

    return near && (slip < (cfg->handover_speed / SLIP_SHARE)) &&
           (drive->rotor.residual < cfg->residual_max);
}

/*
 * Changes from the frame of the vector to the frame of the rotor. i_q* in the vector's frame is the
 * torque of the ramp. The speed loop feeds that torque forward, so its integral begins with i_q* in
 * the rotor's frame minus that torque: the torque of the load.
 */
static drive_event_t hand_over(drive_t *drive)
{
    const int32_t of_ramp = drive->control.current_ref.q;

    frame_turn(drive, 0U - load_angle(drive));
    speed_loop_start(&drive->motion.speed_loop, drive->motion.speed_loop.reference,
                     drive->control.current_ref.q - of_ramp);
    return DRIVE_EVENT_TRACKED;
}

/*
 * Returns TRACKED when the observer takes over. While the vector turned slowly, the observer may
 * have learned a load angle. It has settle_periods to correct that.
 */
static drive_event_t judge_handover(drive_t *drive, fault_t *fault)
{
    const bool settled = drive->start.handover_periods >= drive->cfg->startup.settle_periods;
    drive_event_t event = DRIVE_EVENT_NONE;

    drive->start.handover_periods++;
    if (settled && has_found_rotor(drive)) {
        event = hand_over(drive);
    } else if (drive->start.handover_periods >= drive->cfg->startup.handover_periods) {
        event = repeat_start(drive, drive->rotor.residual, drive->cfg->startup.residual_max, fault);
    } else {
        /* wait */
    }
    return event;
}

/*
 * Whether the rotor has slipped for so long that it counts as lost. The EMF of a slipping rotor
 * fits neither a model at standstill nor a model that is trained, so the residual stays large. In
 * each turn of the slip the EMF passes through zero twice, so a period with a small residual only
 * counts down by one. While the network follows the vector untrained, a load angle looks like an
 * error, so nothing is checked then.
 */
static bool has_lost_rotor(drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool judges = (drive->vector.step == 0) || estimate_is_trained(drive);
    const bool wrong = judges && (drive->rotor.residual > cfg->residual_lost);

    if (wrong) {
        drive->start.lost_periods++;
    } else if (drive->start.lost_periods > 0U) {
        drive->start.lost_periods--;
    } else {
        /* nothing to count */
    }
    return drive->start.lost_periods >= cfg->lost_periods;
}

/*
 * Returns the event of a vector at rest. After a flying start R and L have not been measured yet:
 * the first standstill is used for it.
 */
static drive_event_t hold(drive_t *drive)
{
    const bool at_rest = drive->state == DRIVE_STATE_HOLD;
    drive_event_t event = DRIVE_EVENT_HELD;

    if (at_rest && !drive->motor.identified) {
        align_reset_held(&drive->start.align, &drive->cfg->startup.align,
                         drive->control.current_ref.d);
        event = DRIVE_EVENT_STANDS;
    }
    return event;
}

/* Returns the event that follows from the speed of the vector in HOLD, IF_RAMP and HANDOVER. */
static drive_event_t judge_speed(drive_t *drive, fault_t *fault)
{
    const step_t handover_speed = drive->cfg->startup.handover_speed;
    const step_t speed = fx_abs(drive->vector.step);
    drive_event_t event;

    if (has_lost_rotor(drive)) {
        event =
            repeat_start(drive, drive->rotor.residual, drive->cfg->startup.residual_lost, fault);
    } else if (speed == 0) {
        event = hold(drive);
    } else if ((speed < handover_speed) || has_to_stand(drive)) {
        event = DRIVE_EVENT_DRAGGED;
    } else if (drive->state != DRIVE_STATE_HANDOVER) {
        drive->start.handover_periods = 0U;
        event = DRIVE_EVENT_FAST;
    } else {
        event = judge_handover(drive, fault);
    }
    return event;
}

/*
 * The vector does not wait for the rotor. So its ramp is slow enough to leave torque for load and
 * inertia.
 */
void open_loop_plan(drive_t *drive, const drive_command_t *command)
{
    const step_t ramp = drive->cfg->startup.ramp;

    run_plan(drive, command, &drive->vector.position);
    if (has_to_stand(drive)) {
        drive->motion.speed_reference = fx_towards(drive->vector.step, 0, ramp);
        position_loop_reset(&drive->motion.position_loop, drive->vector.position.turns_q32,
                            drive->vector.step);
    } else if (drive->motion.mode != (uint8_t)DRIVE_MODE_POSITION) {
        drive->motion.speed_reference =
            fx_towards(drive->vector.step, drive->motion.speed_reference, ramp);
    } else {
        /* a position profile is soft near standstill by itself */
    }
}

drive_event_t open_loop_step(drive_t *drive, const instant_t *now, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->state == DRIVE_STATE_ALIGN) {
        event = align(drive, now, fault);
    } else {
        drive->control.current_ref.d = next_imposed_current(drive);
    }
    return event;
}

static drive_event_t drag(drive_t *drive, fault_t *fault)
{
    drive->control.current_ref.q =
        speed_loop_accelerate(&drive->motion.speed_loop, &drive->cfg->speed_loop,
                              drive->motion.speed_reference, drive->motion.torque_range);
    drive->vector.step = drive->motion.speed_loop.reference;
    return judge_speed(drive, fault);
}

drive_event_t open_loop_drag(drive_t *drive, fault_t *fault)
{
    const bool sound = state_guard_check_vector(drive, fault) == FAULT_NONE;

    return sound ? drag(drive, fault) : DRIVE_EVENT_FAULT;
}
