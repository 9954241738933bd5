/* SPDX-License-Identifier: MIT */
/*
 * The state of an identification (identify.h): the experiment under way, and the results of the
 * experiments before it.
 */
#ifndef IDENTIFY_STATE_H
#define IDENTIFY_STATE_H

#include "about.h"
#include "app.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    IDENTIFY_IDLE = 0,
    /* once the winding is cool it says the scales of its records, and asks the drive to PROBE */
    IDENTIFY_BEGINS,
    IDENTIFY_PULSE,
    IDENTIFY_CATCH,
    IDENTIFY_STILL,
    IDENTIFY_SPIN,
    IDENTIFY_RAMP,
    IDENTIFY_COAST,
    IDENTIFY_ENDS /* it says how it has ended, and opens the gates */
} identify_phase_t;

#define IDENTIFY_WORDS ((uint32_t)PROBE_WORDS - (uint32_t)PROBE_CURRENT)
#define IDENTIFY_AXES (3U)
#define IDENTIFY_TWICE (3U)

/* One experiment. */
typedef struct {
    int32_t words[IDENTIFY_WORDS]; /* of probe.h, from PROBE_CURRENT on */
    const char *kind;              /* first word of its record */
    /* ticks from the vector's arrival to the window; with `leads` from the window to the words */
    int32_t settle;
    int32_t ticks; /* of the window */
    bool leads;    /* the window begins before the words are asked for */
    bool rushes;   /* the window does not wait for the vector's arrival */
} identify_aim_t;

typedef enum {
    IDENTIFY_LEADING = 0, /* the window is open, its words are not asked for yet */
    IDENTIFY_ASKING,      /* word by word */
    IDENTIFY_MOVING,      /* the vector has not arrived */
    IDENTIFY_SETTLING,
    IDENTIFY_MEASURING
} identify_wait_t;

/* Results and progress of PULSE, CATCH and STILL. */
typedef struct {
    uint32_t axis;
    int32_t pulse;   /* voltage of the pulses, Q15 of U_b */
    int32_t quarter; /* ticks of a quarter of a pulse pattern */
    bool fine;       /* the pulses are 5/4 of the last ones */
    bool longer;     /* they last twice as long as the last ones, with 5/8 of the voltage */
    int32_t before;  /* largest current of the last ones */
    bool lag;        /* pulses of twice the time show that the current sensors follow late */
    dq_t peaks[IDENTIFY_AXES]; /* current of the last pulses, in the frame of each axis */
    /*
     * a larger imposed current may not hold a salient rotor, Q15 of I_b; 0: the pulses have not
     * ended
     */
    int32_t stiff_current;
    int32_t unlike;         /* b of the pulses' answers m + b·cos(2·(angle − rotor)), */
    int32_t mean;           /* and m, Q15 of I_b */
    bool tries;             /* 1.5 times stiff_current flows, and pulses show where the rotor is */
    uint32_t tried;         /* times that the rotor lay off the axis of the current */
    int32_t inductance_q16; /* volt-ticks for a change of the current, Q15 of U_b and I_b, Q16 */
    int32_t along_q16;      /* the same along a current, of the last pulses */
    /* the same across the current, from the differences of the last two pulses of unlike current */
    int32_t across_q16;
    int32_t across_volts;   /* volt-ticks of the last pulses across */
    int32_t across_current; /* their current */
    uint32_t looks;       /* looks so far at a rotor on its way to another axis; 0: it is at rest */
    int32_t mean_across;  /* i_q of an earlier look, */
    uint32_t steady;      /* and number of looks since then with about the same */
    int32_t high_voltage; /* means at the largest current of this axis */
    int32_t high_current;
    int32_t first_voltage[IDENTIFY_TWICE]; /* means at the levels that come twice, the first time */
    int32_t unsteady; /* largest change of voltage between the times, 1/256 of R·i, 0…256 */
    int32_t resistance_q13[IDENTIFY_AXES]; /* U_b/I_b */
    int32_t loss; /* of voltage in the legs, as it would be at no current, Q15 of U_b */
} identify_rest_t;

/* Results and progress of SPIN, RAMP and COAST. */
typedef struct {
    step_t top; /* highest speed */
    step_t low; /* the ramps' other speed */
    /* times that the rotor was lost, and the ramps begun anew with half of their slope */
    uint32_t slower;
    int32_t ramp_ticks;
    int32_t ramp_least;  /* a shorter ramp has not come down in its window; 0: each has */
    bool waited;         /* the last ramp has not come down in its window */
    int32_t swing_ticks; /* 1/ω_n of the rotor in the field of the current; 0: not known */
    int32_t flux_q14;    /* φ, with ωL·i, as half of the speed has shown it, U_b/Ω_b */
    bool loaded;         /* friction takes so much torque that the current is the continuous one */
    int32_t
        torque_down; /* of the last ramps: torque over the torque that the current can pull, Q14 */
    int32_t torque_up;
    bool steep;         /* the ramps are as steep as they get */
    int32_t pairs_left; /* pairs of such ramps that still follow */
    int32_t coast_ticks;
    int32_t coast_speed; /* mean of the second window, 2^-20 turns a tick */
} identify_turn_t;

typedef struct {
    app_t *app;
    const about_t *about;
    identify_phase_t phase;
    bool wait_is_said;     /* that it waits for the winding */
    uint32_t step;         /* experiments of the phase so far */
    identify_phase_t said; /* the last phase that was said */
    const char *why;       /* it was refused; NULL: it was not */
    const char *detail;    /* said after `why`: the name of a phase or a fault */
    int32_t needed;        /* current that the refusal names, Q15 of I_b; 0: none */
    identify_aim_t aim;
    drive_command_t before; /* the user's command, in force again at the end, without its request */
    uint32_t began;         /* tick of its start */
    uint32_t crc;           /* of the records so far, see text_crc() */
    int32_t in_force[IDENTIFY_WORDS];
    identify_wait_t wait;
    uint32_t since;   /* tick in which the wait began */
    uint32_t windows; /* so far */
    int32_t ms_ticks; /* of a millisecond, at least 1 */
    identify_rest_t rest;
    identify_turn_t turn;
} identify_t;

#endif
