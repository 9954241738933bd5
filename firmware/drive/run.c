/* SPDX-License-Identifier: MIT */
#include "run.h"

#include "inlining.h"

/* at rest the gain of the torque filter differs from 1 by 2^-10 at most */
#define TORQUE_ROUNDING_LOG2 (10U)
/*
 * A rotor counts as following its speed reference while the difference is at most 1/4 of the
 * hand-over speed.
 */
#define NEAR_SHARE (4)

static bool is_other_filter(const torque_filter_cfg_t *one, const torque_filter_cfg_t *other)
{
    return (one->smooth_rate_q15 != other->smooth_rate_q15) ||
           (one->notch_share_q15 != other->notch_share_q15) ||
           (one->notch_turn.sin != other->notch_turn.sin) ||
           (one->notch_turn.cos != other->notch_turn.cos);
}

/*
 * Returns the mode in which the motion loops begin. Without a sensor the drive does not know how
 * far the rotor has turned while it was not driven, so it begins in speed control. With a sensor it
 * knows the turns, so it begins in position control if the last run ended in it.
 */
static uint8_t first_mode(const drive_t *drive)
{
    const bool goes_on =
        drive_is_sensed(drive) && (drive->motion.mode == (uint8_t)DRIVE_MODE_POSITION);

    return (uint8_t)(goes_on ? DRIVE_MODE_POSITION : DRIVE_MODE_SPEED);
}

void run_reset(motion_t *motion, const drive_t *drive)
{
    const int32_t motoring = drive->derating.motoring;

    *motion = (motion_t){
        .position_loop = motion->position_loop,
        .speed_loop = {.halvings = motion->speed_loop.halvings,
                       .inertia_q17 = motion->speed_loop.inertia_q17},
        .mode = first_mode(drive),
        .torque_range = {-motoring, motoring},
    };
    position_loop_reset(&motion->position_loop, 0, 0);
    if (!drive_is_sensed(drive)) {
        /* the turns are counted anew */
        position_loop_set_zero(&motion->position_loop, 0);
    }
    weakening_reset(&motion->weakening);
}

void run_forget_inertia(motion_t *motion)
{
    speed_loop_init(&motion->speed_loop);
}

void run_change(motion_t *motion, const drive_t *drive, const drive_cfg_t *before)
{
    const drive_cfg_t *const cfg = drive->cfg;

    speed_loop_change(&motion->speed_loop, &cfg->speed_loop);
    if (is_other_filter(&before->torque_filter, &cfg->torque_filter)) {
        torque_filter_start(&motion->torque_filter, drive->control.current_ref.q);
    }
    if (drive_torque_is_free(drive)) {
        torque_loop_bridge(&motion->torque_loop); /* the window of speeds may have new ends */
    }
}

void run_start(motion_t *motion, const drive_t *drive)
{
    const int32_t torque = drive->control.current_ref.q;

    motion->torque_loop.bridging = false;
    if (motion->mode == (uint8_t)DRIVE_MODE_TORQUE) {
        torque_loop_start(&motion->torque_loop, drive_flux(drive), torque);
    }
    torque_filter_start(&motion->torque_filter, torque);
}

void run_resume(motion_t *motion, const drive_t *drive)
{
    const int32_t torque = drive->control.current_ref.q;

    speed_loop_start(&motion->speed_loop, motion->speed_loop.reference, torque);
    torque_filter_start(&motion->torque_filter, torque);
    weakening_reset(&motion->weakening); /* it was not updated during the voltage drive */
}

void run_catch(motion_t *motion, step_t speed)
{
    speed_loop_reset(&motion->speed_loop, speed);
    motion->speed_reference = speed;
}

void run_catch_sensed(motion_t *motion, const drive_t *drive)
{
    const step_t speed = drive->rotor.observer.speed;

    run_catch(motion, speed);
    position_loop_reset(&motion->position_loop, drive->rotor.position.turns_q32, speed);
}

void run_stand(motion_t *motion)
{
    speed_loop_reset(&motion->speed_loop, 0);
}

void run_set_bandwidth(motion_t *motion, bool low)
{
    if (low) {
        speed_loop_lower(&motion->speed_loop);
    } else {
        speed_loop_restore(&motion->speed_loop);
    }
}

void run_take_load(motion_t *motion, int32_t load)
{
    speed_loop_start(&motion->speed_loop, motion->speed_loop.reference, load);
}

/*
 * In position control the zero is set to the position of the profile, not to that of the rotor. The
 * two differ by the error of the position control, and a target of 0 must not move the rotor.
 */
void run_set_zero(motion_t *motion, const drive_t *drive)
{
    const bool profiled =
        drive_is_controlled(drive->state) && (motion->mode == (uint8_t)DRIVE_MODE_POSITION);

    position_loop_set_zero(&motion->position_loop, profiled ? motion->position_loop.profile_q32
                                                            : drive->rotor.position.turns_q32);
}

void run_change_mode(motion_t *motion, const drive_t *drive, uint8_t mode,
                     const rotor_position_t *position)
{
    torque_loop_start(&motion->torque_loop, drive_flux(drive), drive_current_in_force(drive).q);
    torque_loop_bridge(&motion->torque_loop);
    motion->mode = mode;
    if (mode == (uint8_t)DRIVE_MODE_POSITION) {
        position_loop_recount(&motion->position_loop, &drive->cfg->position_loop,
                              position->turns_q32);
    }
    position_loop_reset(&motion->position_loop, position->turns_q32, motion->speed_loop.reference);
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

    if (drive_may_impose(drive) && (fx_abs(present) < lowest_speed(drive))) {
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
    return drive_may_impose(drive) ? lowest_speed(drive) : 0;
}

/*
 * In RUN, plans the torque and the speed to which it leads. Below RUN, plans the speed that the
 * imposed vector is to reach.
 */
NEVER_INLINED static void plan_torque(motion_t *motion, const drive_t *drive, int32_t target_q28)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const bool was_bound = motion->torque_loop.bound;
    step_t reference = torque_loop_aim(&cfg->torque_loop, target_q28);

    if (drive->state == DRIVE_STATE_RUN) {
        const torque_loop_in_t in = {
            .target_q28 = target_q28,
            .flux_q13 = drive_flux(drive),
            .current = drive_current_in_force(drive).q,
            .range = motion->torque_range,
            .speed = drive->rotor.observer.speed,
            .reference = motion->speed_loop.reference,
            .lowest = lowest_torque_speed(drive),
            .ramp = cfg->startup.ramp,
        };

        reference = torque_loop_plan(&motion->torque_loop, &cfg->torque_loop, &in);
        if (motion->torque_loop.bound && !was_bound) {
            /*
             * The slope of the speed begins at this reference. Set it at once: no acceleration may
             * be fed forward for the step from the rotor's speed to it.
             */
            speed_loop_refer(&motion->speed_loop, reference);
        }
    }
    motion->speed_reference = reference;
}

/* While the command sets the zero, the target is the zero. */
static int64_t target_position(const drive_t *drive, const drive_command_t *command)
{
    const bool zero = (command->request & DRIVE_REQUEST_ZERO) != 0U;

    return position_loop_target(&drive->motion.position_loop, zero ? 0 : command->target);
}

void run_plan(motion_t *motion, const drive_t *drive, const drive_command_t *command,
              const rotor_position_t *position)
{
    const drive_cfg_t *const cfg = drive->cfg;

    if (motion->mode == (uint8_t)DRIVE_MODE_TORQUE) {
        plan_torque(motion, drive, command->target);
    } else if (motion->mode == (uint8_t)DRIVE_MODE_POSITION) {
        motion->speed_reference = position_loop_step(&motion->position_loop, &cfg->position_loop,
                                                     target_position(drive, command),
                                                     position->turns_q32, cfg->slow_ticks);
    } else {
        motion->speed_reference =
            gentle(drive, speed_loop_ramp(&motion->speed_loop, &cfg->speed_loop, command->target));
    }
}

void run_plan_vector(motion_t *motion, const drive_t *drive, bool has_to_stand)
{
    const current_vector_t *const vector = &drive->vector;
    const step_t ramp = drive->cfg->startup.ramp;

    if (has_to_stand) {
        motion->speed_reference = fx_towards(vector->step, 0, ramp);
        position_loop_reset(&motion->position_loop, vector->position.turns_q32, vector->step);
    } else if (motion->mode != (uint8_t)DRIVE_MODE_POSITION) {
        motion->speed_reference = fx_towards(vector->step, motion->speed_reference, ramp);
    } else {
        /* a position profile is soft near standstill by itself */
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
        .imposed = (drive_may_impose(drive) && is_slow(drive)) ? cfg->current_hold : 0,
        .ticks = (int32_t)drive->cfg->slow_ticks,
    };
}

/*
 * Replaces `next` by the reference of field weakening. Called when the motor needs nearly all of
 * the bus voltage, or more.
 */
NEVER_INLINED static void weaken(weakening_t *weakening, const drive_t *drive, dq_t current,
                                 current_reference_t *next)
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

    *next = current_reference_weakened(weakening, &point, next->d);
}

void run_allow(motion_t *motion, torque_range_t range)
{
    motion->torque_range = range;
}

/*
 * i_d* takes a part of the allowed current, so it narrows the range of i_q*: with the whole current
 * as torque on top, the drive would trip at over-current. The allowed current is what the winding
 * can still bear (derating.thermal). So a motor that is too hot keeps the i_d that its speed needs,
 * and loses torque.
 */
int32_t run_plan_current_d(motion_t *motion, const drive_t *drive, const instant_t *now)
{
    const current_reference_cfg_t *const cfg = &drive->cfg->current_reference;
    const current_reference_in_t point = operating_point(drive);
    const int32_t circle = modulator_limit(&drive->cfg->modulator, now->sample.bus);
    current_reference_t next = {.reach = CURRENT_REFERENCE_ALL};

    next.d = current_reference_d(cfg, &drive->motor.model.run_loop, &point);
    if (weakening_follow_bus(&motion->weakening, drive->control.voltage, circle)) {
        weaken(&motion->weakening, drive, now->along_rotor, &next);
    }
    motion->torque_range =
        current_reference_range(cfg, motion->torque_range, &next, drive->derating.thermal);
    return next.d;
}

/*
 * While derating or field weakening narrows the range of torque, and the torque is at its limit,
 * the ramp of the speed and the position profile wait. If they went on, the reference would
 * move further away from the rotor in each period. As soon as the limit ends, the drive would
 * accelerate or brake the rotor with the whole current. An i_d* that rises to an imposed current
 * narrows the range too. The ramp goes on then, down to standstill.
 */
static void wait_at_limit(motion_t *motion, const drive_t *drive, int32_t torque, step_t before)
{
    const bool faster = motion->speed_loop.reference > before;
    const int32_t end = faster ? motion->torque_range.upper : -motion->torque_range.lower;
    const int32_t towards = faster ? torque : -torque;
    const bool narrowed = (end < drive->cfg->derating.current_max) &&
                          (drive->control.current_ref.d <= drive->cfg->current_reference.floor);

    if ((towards >= end) && narrowed) {
        speed_loop_refer(&motion->speed_loop, before);
        position_loop_reset(&motion->position_loop, drive->rotor.position.turns_q32, before);
    }
}

/*
 * Returns the change of the reference, but only if the estimated speed was near the reference. A
 * rotor that was caught turning, or that its torque cannot accelerate, is not near it and does not
 * follow the ramp.
 */
static step_t change_along_ramp(const drive_t *drive, step_t before)
{
    const step_t reference = drive->motion.speed_loop.reference;
    const step_t near = drive->cfg->startup.handover_speed / NEAR_SHARE;

    return (fx_abs(before - drive->rotor.observer.speed) <= near) ? (reference - before) : 0;
}

/*
 * Returns the acceleration by the torque current. In torque control the speed reference does not
 * show the acceleration: it is the estimate itself, or the slope near standstill. The torque may
 * accelerate the rotor many times faster than a ramp. An observer of a motor with large R, below
 * some 40 % of rated speed, is too slow to find this from its error: without the feed-forward it
 * lost the angle.
 */
NEVER_INLINED static step_t change_by_torque(const drive_t *drive)
{
    return speed_loop_response(&drive->motion.speed_loop, &drive->cfg->speed_loop,
                               drive->control.current_ref.q);
}

step_t run_expected_change(const drive_t *drive, step_t before)
{
    return (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) ? change_by_torque(drive)
                                                              : change_along_ramp(drive, before);
}

bool run_is_to_be_held(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool gentle_ramp = drive->motion.mode != (uint8_t)DRIVE_MODE_POSITION;
    const step_t half = lowest_speed(drive) / 2;
    const step_t settled_speed = gentle_ramp ? (half + (half / 2)) : half;
    const bool settled = fx_abs(drive->motion.speed_reference) <= settled_speed;

    return drive_may_impose(drive) && (drive->control.current_ref.d >= cfg->current_hold) &&
           is_slow(drive) && settled;
}

/*
 * The speed loop applies its limits before the filter, so its integral stops at the same value as
 * without a filter. The filter may overshoot a limit that the speed loop has just reached; the
 * overshoot is cut off. At rest the output of the filter is a rounding short of the limit, and the
 * checks would not see that the torque is at its limit. So near the limit the output is set to the
 * limit.
 */
static int32_t filter_torque(motion_t *motion, const drive_t *drive, int32_t asked)
{
    const torque_range_t range = motion->torque_range;
    const int32_t near = fx_asr(range.upper - range.lower, TORQUE_ROUNDING_LOG2) + 1;
    int32_t torque = torque_filter_step(&motion->torque_filter, &drive->cfg->torque_filter, asked);

    if ((asked >= range.upper) && (torque >= (range.upper - near))) {
        torque = range.upper;
    } else if ((asked <= range.lower) && (torque <= (range.lower + near))) {
        torque = range.lower;
    } else {
        /* between the limits, or still on its way to one */
    }
    return fx_clamp(torque, range.lower, range.upper);
}

/* Returns i_q* after the torque filter, if there is one. */
static int32_t filter_reference(motion_t *motion, const drive_t *drive, int32_t asked)
{
    return torque_filter_acts(&drive->cfg->torque_filter) ? filter_torque(motion, drive, asked)
                                                          : asked;
}

/*
 * Learns J from a ramp of the speed. In position control the change of the speed reference is not a
 * ramp, because it also corrects the position.
 */
static void learn_inertia(motion_t *motion, const drive_t *drive, step_t before,
                          int32_t integral_before)
{
    if (motion->mode == (uint8_t)DRIVE_MODE_SPEED) {
        speed_loop_learn(&motion->speed_loop, &drive->cfg->speed_loop,
                         motion->speed_loop.reference - before, integral_before);
    }
}

/*
 * Returns i_q* while the torque is free within the window of speeds. No speed is commanded then, so
 * no ramp waits and J is not learned.
 */
NEVER_INLINED static int32_t control_free_torque(motion_t *motion, const drive_t *drive,
                                                 torque_range_t range)
{
    const speed_window_t window = torque_loop_window(
        &drive->cfg->torque_loop, motion->speed_loop.reference, lowest_torque_speed(drive));
    speed_end_t end = SPEED_END_NONE;
    const int32_t torque = speed_loop_within(&motion->speed_loop, &drive->cfg->speed_loop, &window,
                                             motion->speed_reference, drive->rotor.observer.speed,
                                             motion->torque_loop.current, range, &end);

    motion->torque_loop.end = (uint8_t)end;
    return torque;
}

static int32_t control_rotor_speed(motion_t *motion, const drive_t *drive, torque_range_t range)
{
    return speed_loop_step(&motion->speed_loop, &drive->cfg->speed_loop, motion->speed_reference,
                           drive->rotor.observer.speed, range);
}

/* Returns i_q* of the torque loop or the speed loop. */
static int32_t choose_torque(motion_t *motion, const drive_t *drive, torque_range_t range)
{
    return drive_torque_is_free(drive) ? control_free_torque(motion, drive, range)
                                       : control_rotor_speed(motion, drive, range);
}

/*
 * Learns J while the torque is between its limits. At a limit the torque is smaller than the ramp
 * needs, so J cannot be learned and the ramp may have to wait.
 */
static void follow_ramp(motion_t *motion, const drive_t *drive, int32_t torque, step_t before,
                        int32_t integral_before)
{
    const torque_range_t range = motion->torque_range;

    if ((torque > range.lower) && (torque < range.upper)) {
        learn_inertia(motion, drive, before, integral_before);
    } else {
        wait_at_limit(motion, drive, torque, before);
    }
}

/*
 * Returns i_q* after a change of the mode, while the torque goes on a slope. Until the slope has
 * ended, the ramp of the speed does not wait and J is not learned. The function is separate from
 * run_step_torque() to keep its code out of a tick without a bridge.
 */
RARE static int32_t step_bridged_torque(motion_t *motion, const drive_t *drive)
{
    const torque_range_t range =
        torque_loop_bridged(&drive->cfg->torque_loop, drive_flux(drive),
                            drive->control.current_ref.q, motion->torque_range);
    const int32_t torque = choose_torque(motion, drive, range);

    torque_loop_arrive(&motion->torque_loop, torque, range);
    return filter_reference(motion, drive, torque);
}

static int32_t step_plain_torque(motion_t *motion, const drive_t *drive)
{
    const step_t before = motion->speed_loop.reference;
    const int32_t integral_before = motion->speed_loop.pi.integral_q26;
    const int32_t asked = choose_torque(motion, drive, motion->torque_range);
    const int32_t torque = filter_reference(motion, drive, asked);

    if (!drive_torque_is_free(drive)) {
        follow_ramp(motion, drive, torque, before, integral_before);
    }
    return torque;
}

int32_t run_step_torque(motion_t *motion, const drive_t *drive)
{
    return motion->torque_loop.bridging ? step_bridged_torque(motion, drive)
                                        : step_plain_torque(motion, drive);
}

int32_t run_accelerate(motion_t *motion, const drive_t *drive)
{
    return speed_loop_accelerate(&motion->speed_loop, &drive->cfg->speed_loop,
                                 motion->speed_reference, motion->torque_range);
}

void run_follow_command(motion_t *motion, const drive_t *drive)
{
    const step_t speed_max = drive->cfg->speed_loop.speed_max;

    speed_loop_refer(&motion->speed_loop, fx_clamp(motion->speed_reference, -speed_max, speed_max));
}
