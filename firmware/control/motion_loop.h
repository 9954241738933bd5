/* SPDX-License-Identifier: MIT */
/*
 * Speed and position control, called at the slow rate (every N-th control tick).
 *
 * Speed: a ramp limits how fast the reference follows the target. A PI and an acceleration
 * feed-forward compute i_q*.
 *
 * J: on a ramp the feed-forward is J·dω/dt, first with the configured J. If J is wrong, the
 * integral supplies the difference of the torque, and after the ramp the speed overshoots. So on a
 * ramp this difference corrects J, and the integral stays. A load that changes on a ramp is
 * mistaken for J until the next ramp.
 *
 * Position: a profile with limited speed, acceleration and deceleration runs to the target. The
 * speed reference is the profile's speed plus a gain times the position lag. Targets count from a
 * zero. When position control begins, the rotor must not go back the turns that it has made in
 * another mode. So the zero is then moved by whole turns of the shaft.
 *
 * Speeds are step_t (2^32 = one electrical turn a control tick), positions Q32 electrical turns in
 * 64 bits, currents Q15 of I_b. Pure, total; call from the control interrupt.
 */
#ifndef MOTION_LOOP_H
#define MOTION_LOOP_H

#include "fx.h"
#include "pi.h"

#include <stdbool.h>
#include <stdint.h>

/* From this ratio of J on (1.5, in Q17) a rotor is heavy: its speed loop has half of K_i. */
#define SPEED_LOOP_HEAVY_Q17 (196608)

typedef struct {
    pi_cfg_t pi; /* from the speed error, Q15 of 2·Ω_b, to i_q*; paper B (28)–(30) */
    /*
     * these gains replace `pi` while |reference| is below soft_speed, where the estimate has more
     * ripple
     */
    pi_cfg_t soft;
    step_t soft_speed; /* 0…2^29; 0: `soft` is never used */
    step_t ramp;       /* largest change of the reference in a slow period, > 0 */
    step_t speed_max;  /* limit of |reference|, ≤ 2^29 */
    /*
     * feed-forward: i_q = change · inertia / 2^(16 + inertia_shift − inertia_lift), where `change`
     * is the change of the reference in a slow period
     */
    int32_t inertia;
    uint32_t inertia_shift; /* 0…30 */
    /* 0…14; above 0 where a change by one step needs more than half an LSB of current */
    uint32_t inertia_lift;
    int32_t inertia_least_q13; /* lower limit of J / configured J, 2048…8192 (1) */
    int32_t inertia_most_q13;  /* upper limit of J / configured J, 8192…32767 */
    /*
     * change of J / configured J (Q17) that changes i_q on the ramp by 1 LSB of Q26: inertia_rate /
     * 2^(16 + inertia_rate_shift)
     */
    int32_t inertia_rate;        /* 0: J is not corrected */
    uint32_t inertia_rate_shift; /* 0…30 */
    uint32_t error_shift;        /* Q15 of 2·Ω_b = speed as step_t >> error_shift, 1…17 */
} speed_loop_cfg_t;

typedef struct {
    pi_t pi;
    step_t reference;  /* speed reference of the last slow period, after all limits */
    uint32_t halvings; /* how many times the bandwidth is halved, 0…1 */
    /* J / configured J, 32768…524288 (¼…4); kept from run to run until a fault */
    int32_t inertia_q17;
} speed_loop_t;

typedef struct {
    step_t ramp;             /* acceleration: change of the profile speed in a slow period, > 0 */
    step_t speed_max;        /* profile speed limit, 1…2^29 */
    int32_t braking_inverse; /* 2^30 / B, B = braking distance from speed_max, 2^13…2^14 units */
    /* c of position_loop_step(): braking fades out under c·speed_max, 0…12288 */
    int32_t softness_q15;
    /* speed that a lag adds = lag in Q16 turns · gain / 2^gain_shift, 0…32767 */
    int32_t gain;
    uint32_t gain_shift;     /* 0…30 */
    uint32_t distance_shift; /* one distance unit = 2^distance_shift of Q32 turns, 8…48 */
    uint32_t pole_pairs;     /* electrical turns in a turn of the shaft, 1…50 */
} position_loop_cfg_t;

typedef struct {
    int64_t profile_q32;  /* position of the profile */
    int64_t zero_q32;     /* position from which targets count */
    step_t profile_speed; /* speed of the profile */
    uint32_t check;       /* check word of the fields above, see position_loop_holds() */
} position_loop_t;

/*
 * Allowed range of i_q*, lower ≤ upper, Q15 of I_b, ±16384. The range of a motor contains 0. A
 * range that a slope leaves may have both ends on one side of 0.
 */
typedef struct {
    int32_t lower;
    int32_t upper;
} torque_range_t;

/* Window of speeds in which the speed loop does not decide i_q*. */
typedef struct {
    step_t lower; /* lower end of the window, ±2^29, ≤ upper */
    step_t upper; /* upper end of the window, ±2^29 */
    /* in the window the integral follows the load as a mean over 2^load_shift slow periods, 0…14 */
    uint32_t load_shift;
} speed_window_t;

/* What has decided i_q* in a window of speeds. */
typedef enum {
    SPEED_END_NONE = 0, /* the wanted current, limited to its range */
    SPEED_END_LOWER,    /* the speed loop at the lower end */
    SPEED_END_UPPER     /* the speed loop at the upper end */
} speed_end_t;

/*
 * Halve the bandwidth, at most once, or restore it. Half of K_p and a quarter of K_i keep the
 * damping: in s² + (K_p/J)·s + K_i/J the coefficients are 2ζω and ω². The integral stays, so i_q*
 * changes by half of the proportional part.
 */
void speed_loop_lower(speed_loop_t *loop);
void speed_loop_restore(speed_loop_t *loop);

/*
 * Sets the configured J, the whole bandwidth and a speed reference of 0. Call it before the first
 * use and after a fault.
 */
void speed_loop_init(speed_loop_t *loop);

/* Take over another configuration: the learned ratio of J stays, within the new limits. */
void speed_loop_change(speed_loop_t *loop, const speed_loop_cfg_t *cfg);

/*
 * Starts at the present speed with i_q* = 0, so that the speed does not jump. Does not change the
 * bandwidth.
 */
void speed_loop_reset(speed_loop_t *loop, step_t speed);

/* Sets the reference of the last slow period; the torque stays. */
void speed_loop_refer(speed_loop_t *loop, step_t reference);

/*
 * Returns the reference of the next slow period on the ramp to `target`. Does not change the loop.
 */
step_t speed_loop_ramp(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t target);

/*
 * Returns i_q for the acceleration from the last reference to this one, saturated to `range`,
 * rounded down. The loop takes over this reference, limited to ±speed_max.
 */
int32_t speed_loop_accelerate(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                              torque_range_t range);

/*
 * The inverse of speed_loop_accelerate(): returns the change of the speed in a slow period that i_q
 * (Q15 of I_b, ±32768) causes, after the load that the integral holds is subtracted. Rounded down,
 * saturated to ±2^30. 0 if no inertia is known. One division.
 */
step_t speed_loop_response(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, int32_t current);

/* Start so that zero error and a constant reference give i_q* = `current` (Q15 of I_b, ±32767). */
void speed_loop_start(speed_loop_t *loop, step_t reference, int32_t current);

/*
 * One slow period: PI and feed-forward for `reference`, limited to ±speed_max, and the measured
 * speed. Returns i_q*, saturated to `range` and −16384…16383.
 */
int32_t speed_loop_step(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                        step_t measured, torque_range_t range);

/*
 * One slow period within a window: i_q* is `wanted` (±16384) as long as the PIs of both ends allow
 * it,
 *     i_q* = K_p·(lower − ω) + I  ≤  wanted  ≤  K_p·(upper − ω) + I
 * Otherwise i_q* is the output of the PI that does not allow it. Both outputs are continuous in ω,
 * so i_q* does not jump.
 *
 * Between the ends I follows the load, which is i_q* less the current for J·dω/dt. The ends are
 * limited to ±speed_max. The PI of an end decides when the rotor would reach that end within
 * 1/(2π·bandwidth); the speed settles at the end. dω/dt is the change from the stored reference to
 * `reference`, so pass the measured speed as `reference`. It is limited to ±speed_max and stored.
 * Returns i_q*, saturated to `range` and −16384…16383; *end says what has decided i_q*.
 */
int32_t speed_loop_within(speed_loop_t *loop, const speed_loop_cfg_t *cfg,
                          const speed_window_t *window, step_t reference, step_t measured,
                          int32_t wanted, torque_range_t range, speed_end_t *end);

/*
 * Call it after a step of speed control on a ramp. Moves the growth of the integral in this step to
 * J. If J would leave its limits, nothing changes. change: change of the reference in this step,
 * ±2^30; nothing is learned from less than half of `ramp`. integral_before_q26: the integral before
 * the step. Rounded down. A growth that rounds to zero stays in the integral.
 */
void speed_loop_learn(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t change,
                      int32_t integral_before_q26);

/*
 * Moves the zero by whole turns of the shaft, so that the position is at −½ turn to below +½ turn
 * from the zero. Exact while the position is less than 2^31 electrical turns from the zero.
 */
void position_loop_recount(position_loop_t *loop, const position_loop_cfg_t *cfg,
                           int64_t position_q32);

/*
 * Returns the position of a target, Q32 electrical turns. target_q16: electrical turns from the
 * zero.
 */
int64_t position_loop_target(const position_loop_t *loop, int32_t target_q16);

/*
 * Start the profile at the present position and speed, so that a rotor that turns brakes along the
 * profile. The zero stays.
 */
void position_loop_reset(position_loop_t *loop, int64_t position_q32, step_t speed);

/* Sets the zero that targets count from. */
void position_loop_set_zero(position_loop_t *loop, int64_t zero_q32);

/*
 * Returns true while profile and zero are as the functions here have written them. Returns false
 * when a bit has flipped by itself in one of them or in the check word, and stays false. A loop
 * whose words are all zero holds.
 */
bool position_loop_holds(const position_loop_t *loop);

/*
 * One slow period of `ticks` control ticks, 6…100. The profile brakes along
 *     v(d) = speed_max·(√(d/B + c²) − c)
 * with the remaining distance d. The deceleration stays below speed_max²/(2B) and fades out
 * linearly at the end. Positions wrap. A distance is the shorter way, so it is exact for less than
 * 2^31 turns. Returns the speed reference: the speed of the profile plus gain · lag, where gain ·
 * lag is limited to ±speed_max.
 */
step_t position_loop_step(position_loop_t *loop, const position_loop_cfg_t *cfg, int64_t target_q32,
                          int64_t measured_q32, uint32_t ticks);

#endif
