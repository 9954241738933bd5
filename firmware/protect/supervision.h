/* SPDX-License-Identifier: MIT */
/*
 * Supervision: faults that only several samples can show, checked in small steps between the motion
 * loops.
 *
 * A fault of a single sample belongs to protection.h; here a measurement has to be wrong for a
 * while. A check either counts up while its symptom is present and down while it is not, or it
 * takes a mean. So neither a transient nor noise causes a fault. The phases are checked once per
 * slow period. Of the other checks one runs per slow period, in turn. One round of them is the
 * supervision period. All periods below are supervision periods unless they are called slow.
 *
 * Currents Q15 of I_b, speeds step_t. Pure, total within the ranges; control interrupt only. Checks
 * return faults as fault.h says.
 */
#ifndef SUPERVISION_H
#define SUPERVISION_H

#include "fault.h"
#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

#define SUPERVISION_STEPS (4U)
#define SUPERVISION_PHASES (3U)

typedef struct {
    /*
     * phases are compared when the largest range of a phase is above this; with an imposed current
     * a phase is judged when its reference is above this; 1…65535
     */
    int32_t phase_range_min;
    int32_t phase_zero_max; /* a phase that stays within ± this is an open wire, 0…16384 */
    step_t phase_speed_max; /* above this speed an arc has too few samples to compare, 1…2^30 */
    /*
     * slow periods for which a swinging rotor may cause a symptom on an imposed current; a symptom
     * that lasts longer has another cause
     */
    uint32_t swing_periods;
    /*
     * CURRENT_IMPLAUSIBLE: limit of the voltage of an imposed current minus the voltage of the
     * model, Q15 of U_b, 1…32767
     */
    int32_t voltage_max;
    /* LOST_PHASE: limit of the mean error of the current control, 1…65535 */
    int32_t follow_error_max;
    /* OBSERVER_LOST: limit of the mean of the larger current error, 1…8191 */
    int32_t residual_max;
    uint32_t mean_shift; /* both means are over 2^mean_shift periods, 0…14 */
    /* SPEED_IMPLAUSIBLE: limit of |ω̂ − reference| while the torque is not at its limit, 1…2^30 */
    step_t speed_error_max;
    /* SPEED_IMPLAUSIBLE when ω̂ is beyond speed_error_max for more periods than this */
    uint32_t speed_error_periods;
    /* SPEED_IMPLAUSIBLE when ω̂ is at the observer's limit for more periods than this */
    uint32_t runaway_periods;
    step_t overspeed;           /* OVERSPEED: limit of |ω̂|, 1…2^30 */
    uint32_t overspeed_periods; /* OVERSPEED when |ω̂| is above it for more periods than this */
    int32_t stall_current;      /* STALL: |i_q*| is at its limit and at least this, 1…16384 */
    step_t stall_speed;         /* STALL: ω̂ in the torque's direction is below this, 1…2^29 */
    uint32_t stall_periods;     /* STALL when both hold for more periods than this */
    /* CURRENT_SUM: constant part of the limit of the mean of |i_a + i_b + i_c|, 1…65535 */
    int32_t sum_max;
    /*
     * CURRENT_SUM: share of the mean of |i_a| + |i_b| + |i_c| that is added to the limit, 0…32767
     */
    int32_t sum_share_q15;
    uint32_t late_max;    /* LATE when there are more late ticks than this in a window */
    uint32_t late_window; /* length of the window of late_max in periods, ≥ 1 */
} supervision_cfg_t;

typedef struct {
    /* next of the checks that take turns, 0…SUPERVISION_STEPS − 1 */
    uint32_t step;
    uint32_t late;                      /* late ticks in this window */
    uint32_t late_periods;              /* periods of this window so far */
    int32_t start_q16;                  /* angle at the start of this arc, Q16 electrical turns */
    uint32_t samples;                   /* samples of this arc; 0: a new arc begins */
    int32_t lowest[SUPERVISION_PHASES]; /* lowest and highest current of each phase in this arc */
    int32_t highest[SUPERVISION_PHASES];
    uint32_t weak;      /* the phase that was weak in the last arcs */
    uint32_t weak_arcs; /* number of arcs in a row in which this phase was weak */
    fault_t suspect;    /* the fault that the last weak arc indicates; none after a healthy arc */
    /* the phase that lacks its imposed current; SUPERVISION_PHASES: there is none */
    uint32_t absent;
    uint32_t absent_periods; /* slow periods for which `absent` has not changed */
    uint32_t unexplained;    /* slow periods with too much voltage, counted up and down */
    dq_t off_current;        /* mean error of the current, Q15 times 2^mean_shift */
    /*
     * periods with ω̂ off its reference. This count, unmodelled, flux_off, runaway, too_fast and
     * stalled go up by one in a period with the symptom and down by one in a period without it
     */
    uint32_t off_reference;
    uint32_t unmodelled; /* periods of RUN with too much voltage */
    int32_t flux_q30;    /* φ̂ low-pass filtered over about a second, Q30 of the file's flux */
    /*
     * periods with a corrected φ̂ since the start or since the flux of the file has changed; stops
     * when φ̂ has settled
     */
    uint32_t flux_periods;
    uint32_t flux_off; /* periods in which φ̂ has changed too much */
    uint32_t runaway;
    uint32_t too_fast;
    uint32_t stalled;
    /*
     * ω̂ in the direction of the torque, at the start of the stall or when the torque had last
     * slowed the rotor by stall_speed
     */
    step_t onwards;
    int32_t residual; /* mean of the larger error of the observer, Q15 times 2^mean_shift */
} supervision_t;

/* Clear all counts and means. Call at a start. */
void supervision_reset(supervision_t *state);

typedef struct {
    int32_t a; /* phase currents, −16384…16383 */
    int32_t b;
    int32_t turns_q16; /* angle of the frame, Q16 electrical turns; wraps */
    step_t speed;
} supervision_phases_t;

/*
 * LOST_PHASE, ADC_STUCK: over an arc of half an electrical turn, the range of a phase was less than
 * an eighth of the largest range, in three arcs in a row. An arc has at least 8 samples. At
 * standstill there is no arc, because the currents are constant.
 */
fault_id_t supervision_check_phases(supervision_t *state, const supervision_cfg_t *cfg,
                                    const supervision_phases_t *in, fault_t *fault);

typedef struct {
    int32_t a; /* phase currents, −16384…16383 */
    int32_t b;
    ab_t expected; /* current reference, ±32767 */
    dq_t voltage;  /* voltage of the current control minus the voltage of the model, Q15 of U_b */
    int32_t emf;   /* EMF of a rotor at the speed of the frame, Q15 of U_b, 0…97500 */
} supervision_imposed_t;

/*
 * Call when the drive begins to impose a current: clears the counts of supervision_check_imposed.
 */
void supervision_forget_imposed(supervision_t *state);

/*
 * For an imposed current, once per slow period. LOST_PHASE: a phase that should carry a current
 * stays at zero; a swinging rotor can cause that only for a part of a swing. CURRENT_IMPLAUSIBLE:
 * the voltage is larger than the measured current can need, so a sensor does not measure the
 * current that flows.
 */
fault_id_t supervision_check_imposed(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_imposed_t *in, fault_t *fault);

typedef struct {
    /* integrals of the current control: the voltage that its model does not explain, Q15 of U_b */
    dq_t voltage;
    int32_t emf; /* EMF of the rotor, Q15 of U_b, 0…97500 */
    /*
     * |ω̂ − reference|, 0…2^30. From speed_error_max/2 on the voltage counts as right, because a
     * swinging rotor causes such a voltage too
     */
    step_t off_reference;
    /*
     * do not judge, for example when the voltage is at its limit, where an integral means nothing
     */
    bool excused;
} supervision_voltage_t;

/*
 * Whether the voltage is large enough for emf, off_reference and excused to matter. If not, the
 * voltage is right whatever their values are.
 */
bool supervision_is_large(const supervision_cfg_t *cfg, dq_t voltage);

/*
 * CURRENT_IMPLAUSIBLE in RUN: an integral is above 2·voltage_max + EMF/4 for more than half of
 * 2^mean_shift periods, counted up and down. The EMF counts because a rotor that swings changes it.
 * The cause is a sensor that has lost its gain, or a leg that does not follow its command.
 */
fault_id_t supervision_check_voltage(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_voltage_t *in, fault_t *fault);

/* Call when the flux of the file changes: φ̂ has to settle again before it is judged. */
void supervision_forget_flux(supervision_t *state);

/*
 * FLUX_IMPLAUSIBLE: φ̂ differs from its own mean, low-pass filtered over about a second, and the
 * EMF of this difference is above 5/64 of the EMF plus voltage_max/4 for some periods. φ̂ is not
 * judged in its first second. A magnet cannot change so fast; the cause is a bus sensor that has
 * lost its gain, or a wrong clock. Call only while φ̂ is corrected.
 *
 * flux_q30: φ̂, Q30 of the flux of the file, 2^29…1.5·2^30. emf: EMF of the rotor, Q15 of U_b,
 * 0…97500.
 */
fault_id_t supervision_check_flux(supervision_t *state, const supervision_cfg_t *cfg,
                                  int32_t flux_q30, int32_t emf, fault_t *fault);

typedef struct {
    dq_t current;
    dq_t reference;
    bool excused; /* do not judge: the rotor turns, and its EMF may use up the voltage */
} supervision_current_t;

/*
 * LOST_PHASE at standstill or with an imposed current: the mean current does not follow its
 * reference. There the whole voltage is available for the current, so a voltage at its limit does
 * not excuse an error. The mean has a sign, so the error of a reference that jitters cancels.
 */
fault_id_t supervision_check_current(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_current_t *in, fault_t *fault);

/*
 * OBSERVER_LOST. error: measured minus modelled current, −8192…8191. When the last arc had a weak
 * phase, the fault of that phase is returned instead, because it is the cause.
 * supervision_check_voltage() and supervision_check_flux() do the same.
 */
fault_id_t supervision_check_observer(supervision_t *state, const supervision_cfg_t *cfg,
                                      dq_t error, fault_t *fault);

typedef struct {
    step_t speed; /* ω̂ */
    step_t reference;
    step_t speed_limit;   /* largest ω̂ that the observer allows */
    int32_t current_ref;  /* i_q* */
    bool torque_at_limit; /* i_q* is at its limit */
} supervision_speed_t;

/*
 * SPEED_IMPLAUSIBLE, OVERSPEED, STALL. For closed loop only. STALL: with full torque the rotor
 * stands, or turns against the torque and does not slow down. Then the load is too large, or the
 * angle is wrong and the current makes no torque.
 */
fault_id_t supervision_check_speed(supervision_t *state, const supervision_cfg_t *cfg,
                                   const supervision_speed_t *in, fault_t *fault);

/* Finds LATE. Call in each tick that follows a late one, in any state. */
fault_id_t supervision_count_late(supervision_t *state, const supervision_cfg_t *cfg,
                                  fault_t *fault);

/* Once per supervision period: advances the window in which late ticks are counted. */
void supervision_forget_late(supervision_t *state, const supervision_cfg_t *cfg);

#endif
