/* SPDX-License-Identifier: MIT */
#include "run.h"

#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "state_guard.h"
#include "trig.h"
#include "voltage_drive.h"

/* at rest the gain of the torque filter differs from 1 by 2^-10 at most */
#define TORQUE_ROUNDING_LOG2 (10U)
#define Q14_TO_Q16 (4)
/* Failed starts are forgotten after this many times startup.lost_periods in RUN. */
#define HELD_LOST_TIMES (100U)
/*
 * A rotor counts as following its speed reference while the difference is at most 1/4 of the
 * hand-over speed.
 */
#define NEAR_SHARE (4)

/*
 * Without a sensor the drive does not know how far the rotor has turned while it was not driven. So
 * it counts the turns anew and begins in speed control. With a sensor it knows the turns. So it
 * begins in position control if the last run ended in it.
 */
static void reset_position(drive_t *drive)
{
    position_loop_reset(&drive->motion.position_loop, 0, 0);
    if (!drive_has_sensor(drive)) {
        position_loop_set_zero(&drive->motion.position_loop, 0);
        drive->motion.mode = (uint8_t)DRIVE_MODE_SPEED;
    } else if (drive->motion.mode != (uint8_t)DRIVE_MODE_POSITION) {
        drive->motion.mode = (uint8_t)DRIVE_MODE_SPEED;
    } else {
        /* position control goes on */
    }
}

void run_reset(drive_t *drive)
{
    rotor_position_reset(&drive->rotor.position, 0U);
    estimate_start(drive, 0, (dq_t){0, 0});
    rotor_position_reset(&drive->vector.position, 0U);
    drive->vector.step = 0;
    drive->vector.current_mean = (dq_t){0, 0};
    drive->voltage_drive.active = false;
    drive->voltage_drive.calm_periods = 0U;
    current_loop_reset(&drive->control.current_loop);
    speed_loop_reset(&drive->motion.speed_loop, 0);
    reset_position(drive);
    drive->motion.speed_reference = 0;
    drive->control.ratio_next = (ab_t){0, 0};
    drive->control.ratio_acting = (ab_t){0, 0};
    drive->rotor.residual = 0;
    drive->start.lost_periods = 0U;
    drive->control.current_ref = (dq_t){0, 0};
    drive->motion.torque_range =
        (torque_range_t){-drive->derating.motoring, drive->derating.motoring};
    drive->derating.voltage = (dq_t){0, 0};
    weakening_reset(&drive->motion.weakening);
}

void run_reset_sensed(drive_t *drive)
{
    run_reset(drive);
    estimate_start_sensed(drive);
    speed_loop_reset(&drive->motion.speed_loop, drive->rotor.observer.speed);
    position_loop_reset(&drive->motion.position_loop, drive->rotor.position.turns_q32,
                        drive->rotor.observer.speed);
    drive->motion.speed_reference = drive->rotor.observer.speed;
}

/*
 * In position control the zero is set to the position of the profile, not to that of the rotor. The
 * two differ by the error of the position control, and a target of 0 must not move the rotor.
 */
void run_set_zero(drive_t *drive)
{
    const bool profiled =
        drive_is_controlled(drive->state) && (drive->motion.mode == (uint8_t)DRIVE_MODE_POSITION);

    position_loop_set_zero(&drive->motion.position_loop,
                           profiled ? drive->motion.position_loop.profile_q32
                                    : drive->rotor.position.turns_q32);
}

/*
 * Changes the mode without a jump: the position profile begins with this position and the present
 * speed reference, the torque with the torque that acts. The torque that the new mode demands may
 * be very different: a commanded torque differs from the torque of the speed loop, and the ramp of
 * a profile differs from the ramp of the speed. So the torque changes on a slope
 * (torque_loop_bridge()). Whole turns that the rotor made outside position control do not count.
 */
static void change_mode(drive_t *drive, uint8_t mode, const rotor_position_t *position)
{
    torque_loop_start(&drive->motion.torque_loop, drive_flux(drive),
                      drive_current_in_force(drive).q);
    torque_loop_bridge(&drive->motion.torque_loop);
    drive->motion.mode = mode;
    state_guard_forget(drive);
    if (mode == (uint8_t)DRIVE_MODE_POSITION) {
        position_loop_recount(&drive->motion.position_loop, &drive->cfg->position_loop,
                              position->turns_q32);
    }
    position_loop_reset(&drive->motion.position_loop, position->turns_q32,
                        drive->motion.speed_loop.reference);
}

/*
 * The integral of the speed loop is the load torque. While the speed changes, the integral also
 * contains the torque for the part of J above the file's J. When the drive brakes, that torque is
 * against the motion. So only a torque in the direction of the motion counts as a load.
 */
static bool is_loaded(const drive_t *drive)
{
    const int32_t load = pi_output(&drive->motion.speed_loop.pi);
    const int32_t onwards = (drive->motion.speed_loop.reference < 0) ? -load : load;

    return (drive->motion.mode != (uint8_t)DRIVE_MODE_POSITION) &&
           (onwards >= drive->cfg->startup.load_current);
}

/*
 * Returns the lowest speed of RUN. At low speed the voltage that a leg loses by its dead time while
 * its current crosses zero is larger than the EMF. With a torque current this voltage is at right
 * angles to the EMF and turns the estimated angle by some degrees. With i_d* alone it is parallel
 * to the EMF, and the observer takes it for speed. So the lowest speed is lower with a load.
 */
static step_t lowest_speed(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;

    return is_loaded(drive) ? cfg->loaded_speed : cfg->hold_speed;
}

/*
 * Returns the speed reference in speed mode. Below the lowest speed of RUN it changes no faster
 * than the ramp of an imposed vector, upwards and downwards. At the hand-back the acting torque
 * determines the load angle of the vector. With the torque of a steeper ramp the rotor would slip.
 * A position profile is soft near standstill by itself.
 */
static step_t gentle(const drive_t *drive, step_t wanted)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t present = drive->motion.speed_loop.reference;
    step_t next = wanted;

    if ((cfg->current_hold != 0) && (fx_abs(present) < lowest_speed(drive))) {
        next = fx_towards(present, wanted, cfg->ramp);
    }
    return next;
}

/*
 * Returns the lowest speed of torque control: the lowest speed of RUN, or 0 if the drive never
 * imposes a current.
 */
static step_t lowest_torque_speed(const drive_t *drive)
{
    return (drive->cfg->startup.current_hold != 0) ? lowest_speed(drive) : 0;
}

/*
 * In RUN, plans the torque and the speed to which it leads. Below RUN, plans the speed that the
 * imposed vector is to reach.
 */
NEVER_INLINED static void plan_torque(drive_t *drive, int32_t target_q28)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const bool was_bound = drive->motion.torque_loop.bound;
    step_t reference = torque_loop_aim(&cfg->torque_loop, target_q28);

    if (drive->state == DRIVE_STATE_RUN) {
        const torque_loop_in_t in = {
            .target_q28 = target_q28,
            .flux_q13 = drive_flux(drive),
            .current = drive_current_in_force(drive).q,
            .range = drive->motion.torque_range,
            .speed = drive->rotor.observer.speed,
            .reference = drive->motion.speed_loop.reference,
            .lowest = lowest_torque_speed(drive),
            .ramp = cfg->startup.ramp,
        };

        reference = torque_loop_plan(&drive->motion.torque_loop, &cfg->torque_loop, &in);
        if (drive->motion.torque_loop.bound && !was_bound) {
            /*
             * The slope of the speed begins at this reference. Set it at once: no acceleration may
             * be fed forward for the step from the rotor's speed to it.
             */
            drive->motion.speed_loop.reference = reference;
        }
    }
    drive->motion.speed_reference = reference;
}

/* While the command sets the zero, the target is the zero. */
static int64_t target_position(const drive_t *drive, const drive_command_t *command)
{
    const bool zero = (command->request & DRIVE_REQUEST_ZERO) != 0U;

    return position_loop_target(&drive->motion.position_loop, zero ? 0 : command->target);
}

void run_plan(drive_t *drive, const drive_command_t *command, const rotor_position_t *position)
{
    const drive_cfg_t *const cfg = drive->cfg;

    if (command->mode != drive->motion.mode) {
        change_mode(drive, command->mode, position);
    }
    if (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) {
        plan_torque(drive, command->target);
    } else if (drive->motion.mode == (uint8_t)DRIVE_MODE_POSITION) {
        drive->motion.speed_reference = position_loop_step(
            &drive->motion.position_loop, &cfg->position_loop, target_position(drive, command),
            position->turns_q32, cfg->slow_ticks);
    } else {
        drive->motion.speed_reference = gentle(
            drive, speed_loop_ramp(&drive->motion.speed_loop, &cfg->speed_loop, command->target));
    }
}

/* Whether commanded speed and rotor speed are both so low that a current has to be imposed. */
static bool is_slow(const drive_t *drive)
{
    return (fx_abs(drive->rotor.observer.speed) < drive->cfg->startup.handover_speed) &&
           (fx_abs(drive->motion.speed_reference) < lowest_speed(drive));
}

/*
 * Returns the inputs for the next i_d*. When the speed is low, i_d* rises to the current that will
 * be imposed. With a load below hold_speed it stays without a floor, for the reason given at
 * lowest_speed().
 */
static current_reference_in_t operating_point(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;

    return (current_reference_in_t){
        .present = drive->control.current_ref,
        .speed = drive->motion.speed_reference,
        .floor_speed = cfg->hold_speed,
        .imposed = is_slow(drive) ? cfg->current_hold : 0,
        .ticks = (int32_t)drive->cfg->slow_ticks,
    };
}

/*
 * Replaces `next` by the reference of field weakening. Called when the motor needs nearly all of
 * the bus voltage, or more.
 */
NEVER_INLINED static void weaken(drive_t *drive, dq_t current, current_reference_t *next)
{
    const weakening_in_t point = {
        .model = &drive->motor.model.run_loop,
        .speed_q15 = drive_speed_q15(drive, fx_abs(drive->rotor.observer.speed)),
        .reference = drive->control.current_ref,
        .current = {.d = fx_sat15(current.d), .q = fx_sat15(current.q)},
        .voltage = drive->derating.voltage,
        .current_max = drive->cfg->derating.current_max,
        .deepest = drive->cfg->current_reference.deepest,
    };

    *next = current_reference_weakened(&drive->motion.weakening, &point, next->d);
}

/*
 * i_d* takes a part of the allowed current, so it narrows the range of i_q*: with the whole current
 * as torque on top, the drive would trip at over-current. The allowed current is what the winding
 * can still bear (derating.thermal). So a motor that is too hot keeps the i_d that its speed needs,
 * and loses torque.
 */
INLINES_ALL static void limit_current(drive_t *drive, const instant_t *now)
{
    const current_reference_cfg_t *const cfg = &drive->cfg->current_reference;
    const current_reference_in_t point = operating_point(drive);
    const int32_t circle = modulator_limit(&drive->cfg->modulator, now->sample.bus);
    current_reference_t next = {.reach = CURRENT_REFERENCE_ALL};

    next.d = current_reference_d(cfg, &drive->motor.model.run_loop, &point);
    if (weakening_is_near(&drive->motion.weakening, drive->control.voltage, circle)) {
        weaken(drive, now->along_rotor, &next);
    }
    drive->control.current_ref.d = next.d;
    drive->motion.torque_range =
        current_reference_range(cfg, drive->motion.torque_range, &next, drive->derating.thermal);
}

void run_limit(drive_t *drive, const instant_t *now)
{
    if (!drive->voltage_drive.active) {
        limit_current(drive, now);
    }
}

/*
 * Changes back to an imposed current: the d axis of the vector's frame is set to the direction of
 * the present current reference.
 */
static void hand_back(drive_t *drive, dq_t current)
{
    const dq_t reference = drive->control.current_ref;
    const angle_t load_angle =
        trig_atan2((int16_t)fx_sat16(reference.q), (int16_t)fx_sat16(reference.d));
    dq_t turned;

    drive->vector.position = drive->rotor.position;
    rotor_position_step(&drive->vector.position, fx_signed(load_angle));
    drive->vector.step = drive->motion.speed_loop.reference;
    frame_turn(drive, load_angle);
    turned =
        transforms_park((ab_t){fx_sat15(current.d), fx_sat15(current.q)}, trig_sincos(load_angle));
    drive->vector.current_mean = (dq_t){fx_sat15(turned.d), fx_sat15(turned.q)};
    supervision_forget_imposed(&drive->watch.supervision);
}

/*
 * While derating or field weakening narrows the range of torque, and the torque is at its limit,
 * the ramp of the speed and the position profile wait. If they went on, the reference would
 * move further away from the rotor in each period. As soon as the limit ends, the drive would
 * accelerate or brake the rotor with the whole current. An i_d* that rises to an imposed current
 * narrows the range too. The ramp goes on then, down to standstill.
 */
static void wait_at_limit(drive_t *drive, step_t before)
{
    const bool faster = drive->motion.speed_loop.reference > before;
    const dq_t current = drive->control.current_ref;
    const int32_t end =
        faster ? drive->motion.torque_range.upper : -drive->motion.torque_range.lower;
    const int32_t towards = faster ? current.q : -current.q;
    const bool narrowed = (end < drive->cfg->derating.current_max) &&
                          (current.d <= drive->cfg->current_reference.floor);

    if ((towards >= end) && narrowed) {
        drive->motion.speed_loop.reference = before;
        position_loop_reset(&drive->motion.position_loop, drive->rotor.position.turns_q32, before);
    }
}

/* change: of the speed in this slow period, step_t, ±2^30 */
static void accelerate_estimate(drive_t *drive, step_t change)
{
    const int32_t share_q14 = drive->cfg->run.acceleration_q14;

    nn_observer_accelerate(&drive->rotor.observer, &drive->motor.model.observer,
                           fx_mul_32x16(change, share_q14) * Q14_TO_Q16);
}

/*
 * Feeds the change of the reference forward to the observer, but only if the estimated speed was
 * near the reference. A rotor that was caught turning, or that its torque cannot accelerate, is not
 * near it and does not follow the ramp.
 */
static void lead_along_ramp(drive_t *drive, step_t before)
{
    const step_t reference = drive->motion.speed_loop.reference;
    const step_t near = drive->cfg->startup.handover_speed / NEAR_SHARE;

    if (fx_abs(before - drive->rotor.observer.speed) <= near) {
        accelerate_estimate(drive, reference - before);
    }
}

/*
 * Feeds the acceleration by the torque current forward to the observer. In torque control the speed
 * reference does not show the acceleration: it is the estimate itself, or the slope near
 * standstill. The torque may accelerate the rotor many times faster than a ramp. An observer of a
 * motor with large R, below some 40 % of rated speed, is too slow to find this from its error:
 * without the feed-forward it lost the angle.
 */
NEVER_INLINED static void lead_by_torque(drive_t *drive)
{
    const int32_t torque = drive->control.current_ref.q;

    accelerate_estimate(
        drive, speed_loop_response(&drive->motion.speed_loop, &drive->cfg->speed_loop, torque));
}

/*
 * Moves the estimated speed with the expected acceleration, without waiting for an observer error.
 */
static void lead_estimate(drive_t *drive, step_t before)
{
    if (drive->cfg->run.acceleration_q14 == 0) {
        /* the published observer: no feed-forward */
    } else if (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) {
        lead_by_torque(drive);
    } else {
        lead_along_ramp(drive, before);
    }
}

/*
 * Whether to change back to an imposed current: i_d* has risen to it, and the speed reference is so
 * far below the lowest speed of RUN that voltage and torque have settled. The voltage that makes
 * i_d rise differs from the voltage that holds it. In speed and torque mode the reference follows
 * the ramp of the imposed vector below the lowest speed, so 3/4 of the lowest speed is low enough.
 * At lower speed the weak EMF may lose the rotor. A position profile still brakes at 3/4, so it has
 * to reach 1/2.
 */
static bool is_to_be_held(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool gentle_ramp = drive->motion.mode != (uint8_t)DRIVE_MODE_POSITION;
    const step_t half = lowest_speed(drive) / 2;
    const step_t settled_speed = gentle_ramp ? (half + (half / 2)) : half;
    const bool settled = fx_abs(drive->motion.speed_reference) <= settled_speed;

    return (drive->control.current_ref.d >= cfg->current_hold) && is_slow(drive) && settled;
}

/*
 * The speed loop applies its limits before the filter, so its integral stops at the same value as
 * without a filter. The filter may overshoot a limit that the speed loop has just reached; the
 * overshoot is cut off. At rest the output of the filter is a rounding short of the limit, and the
 * checks would not see that the torque is at its limit. So near the limit the output is set to the
 * limit.
 */
static void filter_torque(drive_t *drive)
{
    const torque_range_t range = drive->motion.torque_range;
    const int32_t asked = drive->control.current_ref.q;
    const int32_t near = fx_asr(range.upper - range.lower, TORQUE_ROUNDING_LOG2) + 1;
    int32_t torque =
        torque_filter_step(&drive->motion.torque_filter, &drive->cfg->torque_filter, asked);

    if ((asked >= range.upper) && (torque >= (range.upper - near))) {
        torque = range.upper;
    } else if ((asked <= range.lower) && (torque <= (range.lower + near))) {
        torque = range.lower;
    } else {
        /* between the limits, or still on its way to one */
    }
    drive->control.current_ref.q = fx_clamp(torque, range.lower, range.upper);
}

/*
 * Learns J from a ramp of the speed. In position control the change of the speed reference is not a
 * ramp, because it also corrects the position.
 */
static void learn_inertia(drive_t *drive, step_t before, int32_t integral_before)
{
    if (drive->motion.mode == (uint8_t)DRIVE_MODE_SPEED) {
        speed_loop_learn(&drive->motion.speed_loop, &drive->cfg->speed_loop,
                         drive->motion.speed_loop.reference - before, integral_before);
    }
}

/*
 * Sets i_q* while the torque is free within the window of speeds. No speed is commanded then, so no
 * ramp waits and J is not learned.
 */
NEVER_INLINED static void control_free_torque(drive_t *drive, torque_range_t range)
{
    const speed_window_t window = torque_loop_window(
        &drive->cfg->torque_loop, drive->motion.speed_loop.reference, lowest_torque_speed(drive));
    speed_end_t end = SPEED_END_NONE;

    drive->control.current_ref.q = speed_loop_within(
        &drive->motion.speed_loop, &drive->cfg->speed_loop, &window, drive->motion.speed_reference,
        drive->rotor.observer.speed, drive->motion.torque_loop.current, range, &end);
    drive->motion.torque_loop.end = (uint8_t)end;
}

static void control_rotor_speed(drive_t *drive, torque_range_t range)
{
    drive->control.current_ref.q =
        speed_loop_step(&drive->motion.speed_loop, &drive->cfg->speed_loop,
                        drive->motion.speed_reference, drive->rotor.observer.speed, range);
}

/* Sets i_q* with the torque loop or the speed loop. */
static void choose_current_q(drive_t *drive, torque_range_t range)
{
    if (run_torque_is_free(drive)) {
        control_free_torque(drive, range);
    } else {
        control_rotor_speed(drive, range);
    }
}

static void filter_current_q(drive_t *drive)
{
    if (torque_filter_acts(&drive->cfg->torque_filter)) {
        filter_torque(drive);
    }
}

/*
 * Learns J while the torque is between its limits. At a limit the torque is smaller than the ramp
 * needs, so J cannot be learned and the ramp may have to wait.
 */
static void follow_ramp(drive_t *drive, step_t before, int32_t integral_before)
{
    const torque_range_t range = drive->motion.torque_range;
    const int32_t torque = drive->control.current_ref.q;

    if ((torque > range.lower) && (torque < range.upper)) {
        learn_inertia(drive, before, integral_before);
    } else {
        wait_at_limit(drive, before);
    }
}

/*
 * Sets i_q* after a change of the mode, while the torque goes on a slope. Until the slope has
 * ended, the ramp of the speed does not wait and J is not learned. The function is separate from
 * control_current_q() to keep its code out of a tick without a bridge.
 */
RARE static void bridge_current_q(drive_t *drive)
{
    const step_t before = drive->motion.speed_loop.reference;
    const torque_range_t range =
        torque_loop_bridged(&drive->cfg->torque_loop, drive_flux(drive),
                            drive->control.current_ref.q, drive->motion.torque_range);

    choose_current_q(drive, range);
    torque_loop_arrive(&drive->motion.torque_loop, drive->control.current_ref.q, range);
    filter_current_q(drive);
    lead_estimate(drive, before);
}

static void control_current_q(drive_t *drive)
{
    const step_t before = drive->motion.speed_loop.reference;
    const int32_t integral_before = drive->motion.speed_loop.pi.integral_q26;

    choose_current_q(drive, drive->motion.torque_range);
    filter_current_q(drive);
    if (!run_torque_is_free(drive)) {
        follow_ramp(drive, before, integral_before);
    }
    lead_estimate(drive, before);
}

/*
 * Sets i_q*. Returns HELD when the drive changes back to an imposed current. The compiler inlines
 * all of the speed control here.
 */
INLINES_ALL static drive_event_t control_torque(drive_t *drive, dq_t current)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->motion.torque_loop.bridging) {
        bridge_current_q(drive);
    } else {
        control_current_q(drive);
    }
    if ((drive->cfg->startup.current_hold != 0) && is_to_be_held(drive)) {
        hand_back(drive, current);
        event = DRIVE_EVENT_HELD;
    }
    return event;
}

/*
 * Forgets failed starts when RUN has lasted long enough. So a rotor that is lost again and again,
 * each time soon after the start, leads to a fault.
 */
RARE static void forget_attempts(drive_t *drive)
{
    drive->start.held_periods++;
    if (drive->start.held_periods >= (HELD_LOST_TIMES * drive->cfg->startup.lost_periods)) {
        drive->start.attempts = 0U;
    }
}

drive_event_t run_control_speed(drive_t *drive, const drive_command_t *command,
                                const instant_t *now)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->start.attempts > 0U) {
        forget_attempts(drive);
    }
    if (drive->voltage_drive.active) {
        voltage_drive_motion(drive, command, now->sample.bus);
    } else {
        event = control_torque(drive, now->along_rotor);
        voltage_drive_offer(drive, command, now->along_rotor);
        frame_plan_rotor(drive);
    }
    return event;
}
