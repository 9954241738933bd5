/* SPDX-License-Identifier: MIT */
#include "identify_turn.h"

#include "identify_aim.h"
#include "trig.h"

#include <stddef.h>

#define ONE_Q14 (16384)
#define ONE_Q16 (65536)
#define ONE_Q20 (1048576)
#define TWO_PI_Q16 (411775)
#define STEPS_PER_RADIAN (683565276) /* 2^32/(2π) */
#define STEPS_PER_Q16 (65536)        /* steps of an angle_t in 2^-16 of a turn */
#define SWING_TICKS_LEAST (8)
#define SPEED_SHARE (2) /* the vector turns with at most 1/2 of the name plate's highest speed */

/* ---- ramps ---- */

/* time of the first ramp, from half of the highest speed to all of it */
#define RAMP_MS_FIRST (1000)
#define RAMP_MS_ALL (2500) /* time for all pairs of the steepest ramps */
#define RAMP_TICKS_LEAST (64)
#define RAMP_MS_MOST (400) /* longest ramp; a ramp that needs more time goes less far down */
#define RAMP_TICKS_MOST (PROBE_WINDOW_MAX / 2) /* a ramp and its two edges fit into a window */
#define EDGE_TICKS (1024) /* shortest edge: time before and after a ramp in its window */
#define EDGE_MS_MOST (450)
#define EDGE_TICKS_MOST (PROBE_WINDOW_MAX / 4)
/* an edge lasts 8/ω_n: by then a swing that the ramp has started is damped */
#define EDGE_SWINGS (8)
/*
 * largest 2·K in steps per tick: K = 0.03 per tick, a quarter of the bandwidth of the current
 * control
 */
#define DAMPING_MOST (41000000)
#define TORQUE_MOST (65536) /* 4, Q14 */
/* 0.3 of the torque that the current can pull, Q14: with it the rotor lags by 17 degrees */
#define TORQUE_ENOUGH (4915)

int32_t identify_turn_current(const identify_t *identify)
{
    return (identify_aim_continuous(identify) * 3) / 4;
}

step_t identify_turn_speed(const identify_t *identify)
{
    return identify->app->drive.cfg->speed_loop.speed_max / SPEED_SHARE;
}

static void aim_speed(identify_t *identify, step_t speed, step_t ramp)
{
    identify_aim_set(identify, PROBE_SPEED, speed);
    identify_aim_set(identify, PROBE_RAMP, fx_max(ramp, 1));
}

/*
 * Returns the ticks of the edges before and after a ramp. Before the first ramp swing_ticks is not
 * known: then an edge is a quarter of the ramp's ticks.
 */
static int32_t edge_ticks(const identify_t *identify)
{
    const int32_t most = fx_clamp(EDGE_MS_MOST * identify->ms_ticks, EDGE_TICKS, EDGE_TICKS_MOST);
    const int32_t swings = EDGE_SWINGS * identify->turn.swing_ticks;
    const int32_t unknown = (identify->turn.swing_ticks > 0) ? 0 : (identify->turn.ramp_ticks / 4);

    return fx_clamp(unknown + swings, EDGE_TICKS, most);
}

/*
 * Sets up a ramp. The window begins before the ramp and ends after it; there the speed is constant.
 */
static void aim_ramp(identify_t *identify, bool down)
{
    const step_t low = identify->turn.low;
    const step_t top = identify->turn.top;
    const int32_t ramp = identify->turn.ramp_ticks;
    const int32_t edge = edge_ticks(identify);

    aim_speed(identify, down ? low : top, (top - low) / ramp);
    identify_aim_window(identify, "ramp", edge, ramp + (2 * edge));
    identify->aim.leads = true;
}

static void aim_hold(identify_t *identify)
{
    identify_aim_window(identify, "hold", 0, 2 * IDENTIFY_AIM_WINDOW_MS * identify->ms_ticks);
    identify->aim.leads = false;
}

/* Returns the steps per tick in 1 LSB of a speed in Q15 of Ω_b. */
static int64_t one_of_q15(const identify_t *identify)
{
    const uint32_t one = (uint32_t)1U << identify->app->drive.cfg->speed_shift;

    return (int64_t)one;
}

/*
 * Returns the voltage across the current divided by ω, for the window that has ended, Q14 of
 * U_b/Ω_b, at least 1. This voltage is the sum of the part of |e| that lies across the current, and
 * ωL·i.
 */
static int32_t flux_q14(const identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int64_t one_step = one_of_q15(identify);
    const int64_t speed_q15 = ((int64_t)fx_max(sums->turn_q16, 1) * STEPS_PER_Q16) / one_step;
    const int64_t flux = ((int64_t)sums->voltage.q * ONE_Q14) / ((speed_q15 > 0) ? speed_q15 : 1);

    return identify_aim_bounded(flux, 1, INT32_MAX);
}

/*
 * Returns the mean torque of a ramp over the torque that the current can pull, Q14. The mean is the
 * sum over the window divided by the ticks of the ramp. The result is limited to ±4: no motor gives
 * more, and later computations would overflow.
 */
static int32_t mean_torque(const identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int64_t current = fx_max(sums->current.d / identify->aim.ticks, 1);
    const int64_t each = (((int64_t)sums->torque * ONE_Q14) / current) / identify->turn.ramp_ticks;
    const int64_t share = (each * ONE_Q14) / flux_q14(identify);

    return identify_aim_bounded(share, -TORQUE_MOST, TORQUE_MOST);
}

/*
 * Returns the ticks of the shortest ramp that is allowed. In a ramp the EMF drives a current across
 * the imposed one, and the current control acts against it in proportion. So the sum of this
 * current is the same in every ramp, and a short ramp has a large mean. The mean has to stay below
 * 1/8 of the imposed current. A ramp also has to end within its window.
 */
static int32_t shortest_ramp(const identify_t *identify)
{
    const int32_t each = fx_max(identify_aim_asked_current(identify) / 8, 1);
    const int32_t least = fx_max(identify->turn.ramp_least, RAMP_TICKS_LEAST);

    return fx_max(fx_abs(identify_aim_sums(identify)->current.q) / each, least);
}

/*
 * Sets the next ramps: between the speed `low` and the highest speed, in `ramp` ticks. If `ramp` is
 * more than `longest`, they take `longest` ticks and go less far down.
 */
static void take_ramp(identify_t *identify, step_t low, int32_t ramp, int32_t longest)
{
    identify_turn_t *const turn = &identify->turn;

    turn->low = low;
    turn->ramp_ticks = ramp;
    if (ramp > longest) {
        turn->low = turn->top - (((turn->top - low) / ramp) * longest);
        turn->ramp_ticks = longest;
    }
}

/* Returns √square, where `square` is limited to 32 bits. square: 0 and above. */
static int32_t root_of(int64_t square)
{
    const int64_t bounded = (square < (int64_t)UINT32_MAX) ? square : (int64_t)UINT32_MAX;

    return (int32_t)trig_sqrt((uint32_t)bounded);
}

/* Damps the rotor's swing with K = ω_n. swing_ticks is known. */
static void aim_damping(identify_t *identify)
{
    identify_aim_set(identify, PROBE_DAMPING,
                     fx_min((2 * STEPS_PER_RADIAN) / identify->turn.swing_ticks, DAMPING_MOST));
}

/*
 * Makes the next ramps so steep that they take the torque TORQUE_ENOUGH. With the lag δ at the
 * acceleration α, the rotor's swing has ω_n² = α/sin δ. The frame damps the swing with K = ω_n.
 * With a larger K, the lag would hold back the speed of the frame.
 */
static void steepen(identify_t *identify, int32_t torque)
{
    identify_turn_t *const turn = &identify->turn;
    const int32_t shown = fx_max(torque, TORQUE_ENOUGH / 4);
    const int64_t lagging = ((int64_t)turn->ramp_ticks * shown) / ONE_Q14;
    const int64_t square = (lagging * STEPS_PER_RADIAN) / fx_max(turn->top - turn->low, 1);
    const int32_t longest = fx_min(RAMP_MS_MOST * identify->ms_ticks, RAMP_TICKS_MOST);
    const int32_t ramp = (turn->ramp_ticks * (shown / 16)) / (TORQUE_ENOUGH / 16);

    turn->swing_ticks = fx_max(root_of(square), SWING_TICKS_LEAST);
    aim_damping(identify);
    take_ramp(identify, turn->low, fx_max(ramp, shortest_ramp(identify)), longest);
}

/* ---- SPIN ---- */

/*
 * The experiments of SPIN. While an experiment is under way, and when its result is noted, `step`
 * is this number plus one.
 */
#define SPIN_QUARTER (0U)
#define SPIN_LOW (1U)
#define SPIN_RAMP (2U)
#define SPIN_WHOLE (3U)
#define SPIN_OTHER_CURRENT (4U)

#define ATTEMPTS (2U)  /* further attempts after the rotor was lost */
#define SPIN_MS (2000) /* time from rest to the highest speed */
#define SPIN_SETTLE_MS (150)
#define VOLTAGE_SHARE (12) /* the highest speed uses at most 12/16 of the voltage */
#define VOLTAGE_LEFT (32)  /* all of the voltage counts as used when less than 1/32 is left */
#define SPEED_SHARE_LEAST (16)
/*
 * 1/cos of a lag of 20 degrees, Q10. A rotor with a larger lag is loaded: with half of the current
 * it would lag by more than 43 degrees.
 */
#define LAG_OF_LOAD (1093)
/* the rotor stands still if its EMF at the highest speed would be below 1/20 of the voltage */
#define FLUX_SHARE_LEAST (20)

/*
 * Returns Ω_b·L, Q13 of U_b/I_b: L in volt-ticks times Ω_b. Ω_b is 2^(15 + speed_shift) steps per
 * tick, and a step is 2π/2^32 rad.
 */
static int32_t reactance_q13(const identify_t *identify)
{
    const int64_t one_step = one_of_q15(identify);
    const int64_t per_radian = ((int64_t)identify->rest.inductance_q16 * TWO_PI_Q16) / ONE_Q16;
    const int64_t reactance = (per_radian * one_step) / ONE_Q20;

    return identify_aim_bounded(reactance, 0, FX_Q15_MAX);
}

static void begin_spin(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const int32_t current = identify_turn_current(identify);
    const int32_t resistive = (rest->resistance_q13[2] * current) / 8192;

    identify->turn.top = identify_turn_speed(identify);
    identify_aim_set(identify, PROBE_RESISTANCE, rest->resistance_q13[2]);
    identify_aim_set(identify, PROBE_REACTANCE, reactance_q13(identify));
    identify_aim_set(identify, PROBE_LOSS, rest->loss);
    identify_aim_set(identify, PROBE_EMF, fx_max(2 * rest->loss, resistive / 2));
    identify_aim_set(identify, PROBE_DAMPING, DAMPING_MOST);
    identify_aim_gains(identify, IDENTIFY_GAINS_FIRM);
    identify_aim_current(identify, current);
}

/*
 * Returns 1, 2 or 4, the factor by which ramps take longer: it doubles each time that the rotor was
 * lost.
 */
static int32_t slowness(const identify_t *identify)
{
    const uint32_t factor = (uint32_t)1U << identify->turn.slower;

    return fx_signed(factor);
}

static step_t spin_ramp(const identify_t *identify)
{
    return identify->turn.top / (SPIN_MS * identify->ms_ticks * slowness(identify));
}

/* Returns the largest voltage that the bus allows, Q15 of U_b. */
static int32_t largest_voltage(const identify_t *identify)
{
    const drive_t *const drive = &identify->app->drive;

    return modulator_limit(&drive->cfg->modulator, drive->bus);
}

/*
 * Whether the rotor turns with the vector. A standing rotor has no EMF: the voltage is only ωL·i.
 * With unlike L_d and L_q, L is up to twice the L that the pulses have shown, so a standing rotor
 * may seem to turn: has_stood() finds it at half of the current.
 */
static bool turns_along(const identify_t *identify)
{
    const int32_t limit = largest_voltage(identify);
    const int32_t max_q15 = fx_max(fx_asr(identify->app->drive.cfg->speed_loop.speed_max,
                                          identify->app->drive.cfg->speed_shift),
                                   1);
    const int32_t least_q14 = (limit * ONE_Q14) / (FLUX_SHARE_LEAST * max_q15);
    const int32_t inductive_q14 =
        (reactance_q13(identify) * (identify_aim_asked_current(identify) / 64)) / 256;

    return (flux_q14(identify) - inductive_q14) >= fx_max(least_q14, inductive_q14 / 4);
}

/*
 * Returns |e| over the voltage across the current, for the window that has ended, Q10, at least
 * 1.0. It is larger for a rotor that lags, because its EMF has a part along the current too.
 */
static int32_t lag_q10(const identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const int32_t resistive =
        (rest->resistance_q13[2] * identify_aim_asked_current(identify)) / 8192;
    const int32_t along =
        (identify_aim_sums(identify)->voltage.d / identify->aim.ticks) - resistive - rest->loss;
    const int32_t across = identify_aim_sums(identify)->voltage.q / identify->aim.ticks;
    const dq_t e = {fx_sat16(along), fx_sat16(across)};
    const int64_t size = (int64_t)trig_sqrt(transforms_square(e)) * 1024;
    const int64_t share = size / fx_max(fx_abs(across), 1);

    return identify_aim_bounded(share, 0, INT16_MAX);
}

/*
 * Whether the rotor has stood still. The EMF of a turning rotor does not depend on the current, but
 * with half of the current ωL·i is halved. A loaded rotor lags, so it has an EMF along the current
 * and turns.
 */
static bool has_stood(const identify_t *identify)
{
    const int64_t whole = identify->turn.flux_q14;
    const int64_t half = ((int64_t)flux_q14(identify) * lag_q10(identify)) / 1024;

    return !identify->turn.loaded && (((2 * half) - whole) < (whole / 4));
}

bool identify_turn_seeks_speed(const identify_t *identify)
{
    return (identify->phase == IDENTIFY_SPIN) && (identify->step == (SPIN_QUARTER + 1U));
}

bool identify_turn_lacks_voltage(const identify_t *identify)
{
    const int32_t limit = largest_voltage(identify);
    const int32_t used =
        (int32_t)trig_sqrt(transforms_square(identify->app->drive.control.voltage));

    return identify_turn_seeks_speed(identify) && (used > (limit - (limit / VOLTAGE_LEFT)));
}

void identify_turn_refuse_voltage(identify_t *identify)
{
    identify_aim_refusal(
        identify, "the bus voltage is too low to turn the motor at 1/8 of its highest speed");
}

/*
 * Begins a slower attempt with a rotor that has stood still, or ends the identification. A heavy
 * rotor that has not followed the ramp to this speed may follow a slower one.
 */
static void retry_standing(identify_t *identify)
{
    if (identify->turn.slower < ATTEMPTS) {
        identify_turn_catch_again(identify);
    } else {
        identify_aim_refusal(
            identify,
            "the rotor does not turn with the current: is it blocked, braked, or loaded?");
    }
}

/*
 * Limits the highest speed to the speed that the voltage allows, computed from the voltage at a
 * quarter of the highest speed.
 */
static void bound_speed(identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int32_t ticks = identify->aim.ticks;
    const int32_t limit = (largest_voltage(identify) * VOLTAGE_SHARE) / 16;
    const int32_t along = fx_abs(sums->voltage.d / ticks);
    const int32_t across = fx_max(fx_abs(sums->voltage.q / ticks), 1);
    const int32_t room = fx_max((limit * limit) - (along * along), 0);
    const int64_t quarter = identify->turn.top / 4;
    const int64_t reached = (quarter * root_of(room)) / across;
    const step_t least = identify->app->drive.cfg->speed_loop.speed_max / SPEED_SHARE_LEAST;

    const bool turns = turns_along(identify);

    if (identify_turn_lacks_voltage(identify) || (turns && (reached < least))) {
        identify_turn_refuse_voltage(identify);
    } else if (!turns) {
        retry_standing(identify);
    } else {
        identify->turn.top = (reached < identify->turn.top) ? (step_t)reached : identify->turn.top;
    }
}

/* Whether the rotor is out of step: then the voltage across the current is ωL·i alone. */
static bool is_lost(const identify_t *identify)
{
    return flux_q14(identify) < (identify->turn.flux_q14 / 2);
}

void identify_turn_refuse_lost(identify_t *identify)
{
    identify_aim_refusal(identify,
                         "the rotor falls out of step: is the load too large, or does it change?");
}

void identify_turn_catch_again(identify_t *identify)
{
    if (identify->turn.slower < ATTEMPTS) {
        identify->turn.slower++;
        identify->turn.steep = false;
        identify->aim.leads = false;
        identify_aim_phase(identify, IDENTIFY_CATCH);
    } else {
        identify_turn_refuse_lost(identify);
    }
}

/*
 * Plans the first ramp. It begins at half of the highest speed, or at a higher speed if the ramp
 * would not fit into its window.
 */
static void plan_first_ramp(identify_t *identify)
{
    const int32_t ramp = RAMP_MS_FIRST * identify->ms_ticks * slowness(identify);

    identify->turn.swing_ticks = 0;
    take_ramp(identify, identify->turn.top / 2, ramp, RAMP_TICKS_MOST);
}

/*
 * Returns the ticks to settle. They include the time of the rotor's swing, because a change of the
 * current also starts a swing.
 */
static int32_t spin_settle(const identify_t *identify)
{
    return (SPIN_SETTLE_MS * identify->ms_ticks) + (EDGE_SWINGS * identify->turn.swing_ticks);
}

/*
 * Sets another current, with which L·i takes another part of the voltage. Usually the other current
 * is half of the present one. A rotor that lags by more than 20 degrees because of friction would
 * be lost at half of the current: then the other current is the continuous current, and the ramps
 * have the continuous current too.
 */
static void aim_other_current(identify_t *identify)
{
    const int32_t current = identify_turn_current(identify);

    identify->turn.loaded = lag_q10(identify) > LAG_OF_LOAD;
    identify_aim_current(identify,
                         identify->turn.loaded ? identify_aim_continuous(identify) : (current / 2));
}

/*
 * Sets up the next experiment of SPIN. The first ramp leads from half of the highest speed to all
 * of it: its torque, friction included, shows how steep the next ramps may be.
 */
static void aim_spin(identify_t *identify)
{
    const int32_t torque = (identify->step == SPIN_WHOLE) ? mean_torque(identify) : 0;

    identify->aim.leads = false;
    identify_aim_window(identify, "spin", spin_settle(identify),
                        2 * IDENTIFY_AIM_WINDOW_MS * identify->ms_ticks);
    switch (identify->step) {
    case SPIN_QUARTER:
        begin_spin(identify);
        aim_speed(identify, identify->turn.top / 4, spin_ramp(identify));
        break;
    case SPIN_LOW:
        plan_first_ramp(identify);
        aim_speed(identify, identify->turn.low, spin_ramp(identify));
        break;
    case SPIN_RAMP:
        aim_ramp(identify, false);
        break;
    case SPIN_WHOLE:
        steepen(identify, torque);
        identify->aim.settle = spin_settle(identify);
        break;
    default:
        aim_other_current(identify);
        break;
    }
}

/*
 * Notes the result of an experiment of SPIN. The experiment at half of the highest speed gives φ +
 * L·i.
 */
static void note_spin(identify_t *identify)
{
    if (identify->step == (SPIN_QUARTER + 1U)) {
        bound_speed(identify);
    } else if (identify->step == (SPIN_LOW + 1U)) {
        identify->turn.flux_q14 = flux_q14(identify);
    } else if ((identify->step == (SPIN_WHOLE + 1U)) && is_lost(identify)) {
        identify_turn_catch_again(identify);
    } else if ((identify->step == (SPIN_OTHER_CURRENT + 1U)) && has_stood(identify)) {
        retry_standing(identify);
    } else {
        /* for the record only */
    }
}

bool identify_turn_plan_spin(identify_t *identify)
{
    note_spin(identify);
    if (identify->phase != IDENTIFY_SPIN) {
        /* refused, or lost */
    } else if (identify->step <= SPIN_OTHER_CURRENT) {
        aim_spin(identify);
        identify->step++;
    } else {
        if (!identify->turn.loaded) {
            identify_aim_current(identify, identify_turn_current(identify));
        }
        identify_aim_phase(identify, IDENTIFY_RAMP);
    }
    return identify->phase == IDENTIFY_SPIN;
}

/* ---- RAMP ---- */

#define RAMP_PARTS (4U) /* parts of a pair of ramps: down, hold, up, hold */
#define PAIRS_MOST (9)  /* largest number of pairs of the steepest ramps */

/* Whether the torque is large enough, or the ramps cannot be shorter. */
static bool is_steep(const identify_t *identify, int32_t torque)
{
    const bool shortest = identify->turn.ramp_ticks <= ((shortest_ramp(identify) * 5) / 4);

    return (torque >= ((TORQUE_ENOUGH * 2) / 3)) || shortest;
}

/*
 * Notes whether a ramp down has waited. It waits while the bus cannot take the energy of more
 * braking (probe.h). Then the next ramps take at least twice as long.
 */
static void note_wait(identify_t *identify)
{
    identify_turn_t *const turn = &identify->turn;

    turn->waited = identify->app->drive.probe.own_speed != turn->low;
    if (turn->waited) {
        turn->ramp_least = 2 * turn->ramp_ticks;
        turn->steep = false;
    }
}

/*
 * Judges a pair of ramps by half of the difference between their torques. The effect of friction
 * and R is the same up and down, so it cancels.
 */
static void judge_pair(identify_t *identify)
{
    identify_turn_t *const turn = &identify->turn;
    const int32_t torque = (turn->torque_up - turn->torque_down) / 2;

    if (turn->steep) {
        turn->pairs_left--;
    } else if (!turn->waited && is_steep(identify, torque)) {
        const int32_t hold = 2 * IDENTIFY_AIM_WINDOW_MS * identify->ms_ticks;
        const int32_t pair = 2 * ((2 * (turn->ramp_ticks + edge_ticks(identify))) + hold);

        turn->steep = true;
        turn->pairs_left = fx_clamp((RAMP_MS_ALL * identify->ms_ticks) / pair, 2, PAIRS_MOST) - 1;
    } else {
        steepen(identify, torque);
    }
}

static void note_ramp(identify_t *identify, uint32_t part)
{
    if (part == 1U) {
        identify->turn.torque_down = mean_torque(identify);
        note_wait(identify);
    } else if (part == 3U) {
        identify->turn.torque_up = mean_torque(identify);
        judge_pair(identify);
    } else if ((identify->step > 0U) && is_lost(identify)) {
        identify_turn_catch_again(identify);
    } else {
        /* nothing is measured yet */
    }
}

bool identify_turn_plan_ramp(identify_t *identify)
{
    const uint32_t part = identify->step % RAMP_PARTS;

    note_ramp(identify, part);
    if (identify->phase != IDENTIFY_RAMP) {
        /* refused */
    } else if ((part == 0U) && identify->turn.steep && (identify->turn.pairs_left == 0)) {
        identify->aim.leads = false;
        identify_aim_phase(identify, IDENTIFY_COAST);
    } else if ((part % 2U) == 0U) {
        aim_ramp(identify, part == 0U);
        identify->step++;
    } else {
        aim_hold(identify);
        identify->step++;
    }
    return identify->phase == IDENTIFY_RAMP;
}

/* ---- COAST ---- */

#define COAST_WINDOWS (18U)
#define COAST_SETTLE_TICKS (60) /* the current falls with a time constant of 8 ticks */
#define COAST_MS_FIRST (5)
#define COAST_MS_MOST (60)
/* 2·k in steps per tick; with k = K²/4 the frame that follows the rotor has a double pole */
#define COAST_TRACKING (300000)

/* Returns the mean speed in the window that has ended, 2^-20 turns per tick. */
static int32_t mean_speed(const identify_t *identify)
{
    const int64_t speed =
        ((int64_t)identify_aim_sums(identify)->turn_q16 * 16) / identify->aim.ticks;

    return (int32_t)speed;
}

/*
 * Sets the length of the next window. The windows grow while the speed hardly falls: the third
 * window is the first whose speed can be compared with an earlier one. The first window is one
 * electrical turn long, and at least 5 ms.
 */
static void size_coast(identify_t *identify)
{
    identify_turn_t *const turn = &identify->turn;
    const int32_t turn_ticks = INT32_MAX / fx_max(turn->top / 2, 1);
    const int32_t most = COAST_MS_MOST * identify->ms_ticks;

    if (identify->step == 0U) {
        turn->coast_ticks = fx_clamp(turn_ticks, COAST_MS_FIRST * identify->ms_ticks, most);
    } else if (identify->step == 2U) {
        turn->coast_speed = mean_speed(identify);
    } else if ((identify->step > 2U) && (turn->coast_ticks < most) &&
               (mean_speed(identify) > (turn->coast_speed - (turn->coast_speed / 64)))) {
        turn->coast_ticks *= 2;
    } else {
        /* the next window is as long as the last one */
    }
}

/* Whether COAST ends: the speed has fallen to half, or all windows are done. */
static bool has_coasted(const identify_t *identify)
{
    const bool slow = mean_speed(identify) < (identify->turn.coast_speed / 2);

    return (identify->step > COAST_WINDOWS) || ((identify->step > 2U) && slow);
}

static bool has_halls(const identify_t *identify)
{
    return (identify->app->shaft != NULL) &&
           (identify->app->drive.cfg->sensor.kind == (uint32_t)SENSOR_KIND_HALL);
}

bool identify_turn_plan_coast(identify_t *identify)
{
    size_coast(identify);
    if (has_coasted(identify)) {
        identify_aim_phase(identify, has_halls(identify) ? IDENTIFY_HALL : IDENTIFY_ENDS);
    } else {
        identify_aim_current(identify, 0);
        identify_aim_gains(identify, IDENTIFY_GAINS_QUICK);
        identify_aim_set(identify, PROBE_DAMPING, DAMPING_MOST);
        identify_aim_set(identify, PROBE_TRACKING, COAST_TRACKING);
        identify_aim_window(identify, "coast", (identify->step == 0U) ? COAST_SETTLE_TICKS : 0,
                            identify->turn.coast_ticks);
        identify->aim.rushes = true;
        identify->step++;
    }
    return identify->phase == IDENTIFY_COAST;
}

/* ---- HALL ---- */

#define HALL_WINDOWS (4U) /* two backwards, then two forwards */
#define HALL_MS (200U)    /* shortest window */
#define HALL_SPEED_SHARE (2)
/* slowest speed, in steps per tick: its turn fits into a window */
#define HALL_STEPS_LEAST (65536)
#define GOLDEN_EIGHTHS (5U) /* golden section of a tick, in eighths of it */

/* Returns the whole ticks of an electrical turn at about half of the highest speed. */
static uint32_t hall_turn_ticks(const identify_t *identify)
{
    return UINT32_MAX /
           fx_unsigned(fx_max(identify->turn.top / HALL_SPEED_SHARE, HALL_STEPS_LEAST));
}

/*
 * Returns the speed at which a turn takes so many ticks and the golden section of a tick more. So
 * the edges of the turns fall evenly on a tick.
 */
static step_t hall_speed(uint32_t turn_ticks)
{
    return fx_signed((UINT32_MAX / ((8U * turn_ticks) + GOLDEN_EIGHTHS)) * 8U);
}

/* Returns the ticks of as many turns of the shaft as HALL_MS takes, about. */
static int32_t hall_ticks(const identify_t *identify, uint32_t turn_ticks)
{
    const uint32_t shaft =
        (identify->about->rotation.pole_pairs * ((8U * turn_ticks) + GOLDEN_EIGHTHS)) / 8U;
    const uint32_t least = HALL_MS * fx_unsigned(identify->ms_ticks);
    const uint32_t ticks = ((least + shaft - 1U) / shaft) * shaft;

    return fx_min(fx_signed(ticks), HALL_SURVEY_TICKS_MAX);
}

/* Returns the slope of the last ramps: with it the rotor lags by about 17 degrees. */
static step_t hall_ramp(const identify_t *identify)
{
    const identify_turn_t *const turn = &identify->turn;

    return (turn->top - turn->low) / fx_max(turn->ramp_ticks, 1);
}

/*
 * The rotor coasts, and the frame follows it. A current along the rotor makes no torque, so it may
 * flow at once.
 */
bool identify_turn_plan_hall(identify_t *identify)
{
    const uint32_t turn_ticks = hall_turn_ticks(identify);
    const step_t speed = hall_speed(turn_ticks);

    if (identify->step == HALL_WINDOWS) {
        identify_aim_phase(identify, IDENTIFY_ENDS);
    } else {
        identify_aim_current(identify, identify->turn.loaded ? identify_aim_continuous(identify)
                                                             : identify_turn_current(identify));
        identify_aim_gains(identify, IDENTIFY_GAINS_FIRM);
        aim_damping(identify);
        identify_aim_set(identify, PROBE_TRACKING, 0);
        aim_speed(identify, (identify->step < (HALL_WINDOWS / 2U)) ? -speed : speed,
                  fx_min(spin_ramp(identify), hall_ramp(identify)));
        identify_aim_window(identify, "hall", spin_settle(identify),
                            hall_ticks(identify, turn_ticks));
        identify->aim.rushes = false;
        identify->step++;
    }
    return identify->phase == IDENTIFY_HALL;
}
