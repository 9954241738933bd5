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
    /*
     * waits until the winding is cool, then writes the scales of the records and asks the drive for
     * PROBE
     */
    IDENTIFY_BEGINS,
    IDENTIFY_PULSE,
    IDENTIFY_CATCH,
    IDENTIFY_STILL,
    IDENTIFY_SPIN,
    IDENTIFY_RAMP,
    IDENTIFY_COAST,
    IDENTIFY_HALL,
    IDENTIFY_ENDS /* opens the gates, and writes how the identification has ended */
} identify_phase_t;

#define IDENTIFY_WORDS ((uint32_t)PROBE_WORDS - (uint32_t)PROBE_CURRENT)
#define IDENTIFY_AXES (3U)
#define IDENTIFY_TWICE (3U)

/* One experiment. */
typedef struct {
    int32_t words[IDENTIFY_WORDS]; /* values of the words of probe.h, from PROBE_CURRENT on */
    const char *kind;              /* first word of the record of this experiment */
    /*
     * ticks from the vector's arrival to the start of the window; with `leads`: ticks from the
     * start of the window until the words are posted
     */
    int32_t settle;
    int32_t ticks; /* ticks of the window */
    bool leads;    /* the window begins before the words are posted */
    bool rushes;   /* the window does not wait for the vector's arrival */
} identify_aim_t;

typedef enum {
    IDENTIFY_LEADING = 0, /* the window is open, the words are not posted yet */
    IDENTIFY_ASKING,      /* the words are posted one by one */
    IDENTIFY_MOVING,      /* the vector has not yet reached its angle or speed */
    IDENTIFY_SETTLING,
    IDENTIFY_MEASURING
} identify_wait_t;

/* Results and progress of PULSE, CATCH and STILL. */
typedef struct {
    uint32_t axis;   /* phase on whose axis the experiments act, 0…2 */
    int32_t pulse;   /* voltage of the pulses, Q15 of U_b */
    int32_t quarter; /* ticks of a quarter of a pulse pattern */
    bool fine;       /* these pulses have 5/4 of the voltage of the pulses before */
    bool longer; /* these pulses last twice as long as the pulses before, with 5/8 of the voltage */
    int32_t before; /* largest peak current of the pulses before */
    bool lag;       /* the current sensors follow late, as pulses of twice the time have shown */
    /* peak current of the last pulses on each axis, in the frame of that axis */
    dq_t peaks[IDENTIFY_AXES];
    /*
     * largest imposed current that is expected to hold a salient rotor, Q15 of I_b; 0: the pulses
     * have not ended
     */
    int32_t stiff_current;
    /* pulses at `angle` have the peak current mean + unlike·cos(2·(angle − rotor)), Q15 of I_b */
    int32_t unlike;
    int32_t mean;
    /* a try is under way: 1.5 times stiff_current flows, and pulses show where the rotor is */
    bool tries;
    uint32_t tried; /* number of tries in which the rotor lay off the axis of the current */
    /* L: volt-ticks in Q15 of U_b over change of the current in Q15 of I_b, Q16 */
    int32_t inductance_q16;
    int32_t along_q16; /* L along an imposed current, from the last pulses, same unit */
    /*
     * L across an imposed current, from the differences between the last two pulses of unlike
     * current, same unit
     */
    int32_t across_q16;
    int32_t across_volts;   /* volt-ticks of the last pulses across */
    int32_t across_current; /* peak current of the last pulses across */
    /*
     * looks so far at a rotor that goes to another axis (a look is a window of 100 ms); 0: it is at
     * rest
     */
    uint32_t looks;
    int32_t mean_across;  /* mean i_q of an earlier look */
    uint32_t steady;      /* number of looks since then with about the same mean i_q */
    int32_t high_voltage; /* mean voltage at the largest current on this axis */
    int32_t high_current; /* mean current then */
    /* mean voltages at the levels that come twice, when they come first */
    int32_t first_voltage[IDENTIFY_TWICE];
    /*
     * largest change of voltage from the first to the second time of a level, 1/256 of R·i, 0…256
     */
    int32_t unsteady;
    int32_t resistance_q13[IDENTIFY_AXES]; /* R measured on each axis, Q13 of U_b/I_b */
    int32_t loss; /* voltage that the legs lose, extrapolated to zero current, Q15 of U_b */
} identify_rest_t;

/* Results and progress of SPIN, RAMP, COAST and HALL. */
typedef struct {
    step_t top; /* highest speed of the vector */
    step_t low; /* lower speed of the ramps */
    /*
     * how often the rotor was lost; after each time the ramps begin again with half of their slope
     */
    uint32_t slower;
    int32_t ramp_ticks; /* length of a ramp */
    /*
     * least length of a ramp, because a shorter ramp down has not ended in its window; 0: no such
     * ramp
     */
    int32_t ramp_least;
    bool waited;         /* the last ramp down has not ended in its window */
    int32_t swing_ticks; /* 1/ω_n of the rotor in the field of the current; 0: not known */
    int32_t flux_q14;    /* φ + L·i as measured at half of the highest speed, Q14 of U_b/Ω_b */
    bool loaded;         /* friction takes so much torque that the continuous current is imposed */
    /* mean torque of the last ramp down over the torque that the current can pull, Q14 */
    int32_t torque_down;
    int32_t torque_up;   /* the same for the last ramp up */
    bool steep;          /* the ramps are not made steeper any more */
    int32_t pairs_left;  /* number of pairs of these steepest ramps that still follow */
    int32_t coast_ticks; /* length of a window of COAST */
    int32_t coast_speed; /* mean speed in the second window, 2^-20 turns per tick */
} identify_turn_t;

typedef struct {
    app_t *app;
    const about_t *about;
    identify_phase_t phase;
    bool wait_is_said;     /* the line about waiting for a cool winding has been written */
    uint32_t step;         /* number of experiments in this phase so far */
    identify_phase_t said; /* last phase whose line was written */
    const char *why;       /* reason for a refusal; NULL: there is none */
    const char *detail;    /* said after `why`: the name of a phase or a fault */
    int32_t needed;        /* current that the refusal names, Q15 of I_b; 0: none */
    identify_aim_t aim;    /* the experiment under way */
    /*
     * the user's command before the identification, without its request; in force again at the end
     */
    drive_command_t before;
    uint32_t began;                   /* tick in which the identification began */
    uint32_t crc;                     /* CRC of the records so far, see text_crc() */
    int32_t in_force[IDENTIFY_WORDS]; /* value of each word that was posted last */
    identify_wait_t wait;
    uint32_t since;   /* tick in which the wait began */
    uint32_t windows; /* number of windows so far */
    int32_t ms_ticks; /* ticks in a millisecond, at least 1 */
    identify_rest_t rest;
    identify_turn_t turn;
} identify_t;

#endif
