/* SPDX-License-Identifier: MIT */
/*
 * Supervision: faults that show in the course of time, looked at in small steps between the motion loops.
 *
 * What a single sample proves is protection's; here a measurement has to be wrong for a while. Each check
 * counts up while its sign of trouble is there and down while it is not, or takes a mean, so that neither
 * a transient nor noise makes a fault. The phases are looked at once a slow period; of the other checks
 * there is one a slow period, in turn. Once round is the supervision period, in which all counts below
 * are meant.
 *
 * Currents Q15 of I_b, speeds step_t. Pure, total within the ranges; control interrupt only. A check
 * returns what it found with value and limit in `fault`, else FAULT_NONE and leaves `fault` alone.
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
    int32_t
        phase_range_min; /* phases are compared when one moved more than this, or has to carry it, 1…65535 */
    int32_t phase_zero_max; /* one that stays within this of zero is an open wire, 0…16384 */
    step_t phase_speed_max; /* above it an arc has too few samples to compare, 1…2^30 */
    uint32_t
        swing_periods; /* what a swing on an imposed current cannot explain lasts for more slow periods */
    int32_t
        voltage_max; /* CURRENT_IMPLAUSIBLE: an imposed current needs more than the model says and this, Q15 of U_b,
                                  1…32767 */
    int32_t follow_error_max; /* LOST_PHASE: mean error of the current control, 1…65535 */
    int32_t residual_max;     /* OBSERVER_LOST: mean of the larger model error, 1…8191 */
    uint32_t mean_shift;      /* both means are over 2^mean_shift periods, 0…14 */
    step_t speed_error_max; /* SPEED_IMPLAUSIBLE: |ω̂ − reference| with torque to spare, 1…2^30 … */
    uint32_t speed_error_periods; /* … for longer */
    uint32_t runaway_periods;     /* SPEED_IMPLAUSIBLE: ω̂ at the observer's limit for longer */
    step_t overspeed;             /* OVERSPEED: |ω̂| above it, 1…2^30 … */
    uint32_t overspeed_periods;   /* … for longer */
    int32_t stall_current;        /* STALL: |i_q*| at its limit and at least this, 1…16384, … */
    step_t stall_speed;           /* … with |ω̂| below this, 1…2^29 … */
    uint32_t stall_periods;       /* … for longer */
    uint32_t late_max;            /* LATE: more late ticks than these … */
    uint32_t late_window;         /* … in this many periods, ≥ 1 */
} supervision_cfg_t;

typedef struct {
    uint32_t step;         /* of the other checks, the next one, 0…SUPERVISION_STEPS − 1 */
    uint32_t late;         /* late ticks in this window */
    uint32_t late_periods; /* of this window */
    int32_t start_q16;     /* where this arc began, Q16 electrical turns */
    uint32_t samples;      /* of this arc; 0: begin anew */
    int32_t lowest[SUPERVISION_PHASES]; /* of each phase in this arc */
    int32_t highest[SUPERVISION_PHASES];
    uint32_t weak;      /* the phase that did not move in the last arcs … */
    uint32_t weak_arcs; /* … and in how many in a row */
    fault_t suspect;    /* what the last weak arc would be; none after a healthy one */
    uint32_t absent;    /* the phase without the current imposed on it, or SUPERVISION_PHASES … */
    uint32_t absent_periods; /* … and for how many slow periods */
    uint32_t unexplained;    /* slow periods with too much voltage, up and down */
    dq_t off_current;        /* mean error of the current, Q15 times 2^mean_shift */
    uint32_t off_reference;  /* counts of periods, up and down */
    uint32_t runaway;
    uint32_t too_fast;
    uint32_t stalled;
    int32_t residual; /* Q15 times 2^mean_shift */
} supervision_t;

/* Forget everything: at a start. */
void supervision_reset(supervision_t *state);

typedef struct {
    int32_t a; /* phase currents, −16384…16383 */
    int32_t b;
    int32_t turns_q16; /* of the angle that currents are turned with; wraps */
    step_t speed;
} supervision_phases_t;

/*
 * LOST_PHASE, ADC_STUCK: over an arc of half an electrical turn a phase moved less than an eighth of the
 * strongest, three arcs in a row. Never at standstill, where currents are constant. An arc has at least 8 samples.
 */
fault_id_t supervision_check_phases(supervision_t *state, const supervision_cfg_t *cfg,
                                    const supervision_phases_t *in, fault_t *fault);

typedef struct {
    int32_t a; /* phase currents, −16384…16383 */
    int32_t b;
    ab_t expected; /* the reference, ±32767 */
    dq_t voltage;  /* of the current control beyond what the model explains, Q15 of U_b */
    int32_t emf;   /* of a rotor that goes with the frame, Q15 of U_b, 0…97500 */
} supervision_imposed_t;

/* A current is imposed from here on: what supervision_check_imposed has counted begins anew. */
void supervision_forget_imposed(supervision_t *state);

/*
 * Where a current is imposed. LOST_PHASE: a phase stays at zero that has to carry a current; a swinging rotor can hold
 * it there for a part of a swing only. CURRENT_IMPLAUSIBLE: voltage that the current as measured cannot need; a sensor
 * does not tell what flows. Once a slow period.
 */
fault_id_t supervision_check_imposed(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_imposed_t *in, fault_t *fault);

typedef struct {
    dq_t current;
    dq_t reference;
    bool excused; /* the rotor turns: EMF may take the voltage, and the phases tell more */
} supervision_current_t;

/*
 * LOST_PHASE at standstill or where currents are imposed: in the mean the current does not follow its
 * reference. There all of the voltage is for it, so not even a voltage at its limit is an excuse. The mean
 * has a sign, so that a reference that jitters is none.
 */
fault_id_t supervision_check_current(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_current_t *in, fault_t *fault);

/*
 * OBSERVER_LOST: error is measured less modelled current, −8192…8191. When the last turn had a weak phase
 * the fault is that one's: it is what lost the observer.
 */
fault_id_t supervision_check_observer(supervision_t *state, const supervision_cfg_t *cfg,
                                      dq_t error, fault_t *fault);

typedef struct {
    step_t speed; /* ω̂ */
    step_t reference;
    step_t speed_limit;   /* the observer's */
    int32_t current_ref;  /* i_q* */
    bool torque_at_limit; /* i_q* is */
} supervision_speed_t;

/* SPEED_IMPLAUSIBLE, OVERSPEED, STALL: in closed loop. */
fault_id_t supervision_check_speed(supervision_t *state, const supervision_cfg_t *cfg,
                                   const supervision_speed_t *in, fault_t *fault);

/* LATE: in any state, in each tick that follows a late one. */
fault_id_t supervision_count_late(supervision_t *state, const supervision_cfg_t *cfg,
                                  fault_t *fault);

/* Once a period: the window in which they are counted goes on, and ends. */
void supervision_forget_late(supervision_t *state, const supervision_cfg_t *cfg);

#endif
