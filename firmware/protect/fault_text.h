/* SPDX-License-Identifier: MIT */
/*
 * Names and advice of the faults as text: one table for simulator, console and documentation.
 *
 * Several causes end in the same fault. Signs tell them apart: facts that the drive knows in
 * addition to the fault. The first row of the table whose sign is present gives the advice. The
 * first half of an advice, up to the semicolon, names the likeliest cause and says what to do.
 *
 * Constant strings. The control step does not use them, so an image without a console does not
 * contain them. Pure, any context.
 */
#ifndef FAULT_TEXT_H
#define FAULT_TEXT_H

#include "fault.h"

/* Unit of value and limit of a fault. */
typedef enum {
    FAULT_UNIT_NONE = 0,    /* a plain number: ticks, attempts */
    FAULT_UNIT_CURRENT,     /* Q15 of I_b */
    FAULT_UNIT_VOLTAGE,     /* Q15 of U_b */
    FAULT_UNIT_SPEED,       /* step_t */
    FAULT_UNIT_HEAT,        /* Q14, 1 = steady state at the continuous current */
    FAULT_UNIT_TEMPERATURE, /* raw count of the sensor; the board file converts it to °C */
    FAULT_UNIT_WORD         /* 32 bits */
} fault_unit_t;

/*
 * Signs: facts that the drive knows in addition to a fault; diagnosis.c decides which are present.
 */
typedef enum {
    FAULT_SIGN_NONE = 0,    /* no sign is needed */
    FAULT_SIGN_DERATED_BUS, /* in RUN a low bus leaves less than 3/4 of the motoring current */
    /*
     * in RUN heat, temperature or the limit of the bus current leaves less than 3/4 of the motoring
     * current
     */
    FAULT_SIGN_DERATED_OTHER,
    FAULT_SIGN_SWING, /* in RUN some half-waves of a swing were seen before the fault */
    /*
     * a swing that the speed loop does not cause by itself: its frequency is the frequency of the
     * shaft, or 1/2, 2 or 3 times it
     */
    FAULT_SIGN_SHAFT,
    /* such a swing: its frequency is the electrical frequency, or twice it */
    FAULT_SIGN_ELECTRIC,
    FAULT_SIGN_SHAFT_OR_ELECTRIC, /* such a swing: both of these fit, with few pole pairs */
    /* such a swing: its frequency is six times the electrical frequency */
    FAULT_SIGN_SIX,
    /* a swing near the frequency at which the speed loop has a phase lag of 180° */
    FAULT_SIGN_LAG,
    /*
     * the noise of the current sensors at rest is large compared with the residual that the start
     * allows
     */
    FAULT_SIGN_NOISE,
    FAULT_SIGN_PROBE,      /* the drive was in PROBE */
    FAULT_SIGN_ALIGN,      /* the drive was in ALIGN */
    FAULT_SIGN_START,      /* the rotor was aligned, and an imposed current held or turned it */
    FAULT_SIGN_OPEN_GATES, /* nothing was driven */
    /* the torque was against the speed, or a high bus had derated such a torque */
    FAULT_SIGN_BRAKES,
    FAULT_SIGN_SLOW,         /* the drive was in RUN below the hand-over speed */
    FAULT_SIGN_NOT_FOLLOWED, /* the rotor did not follow the imposed vector */
    FAULT_SIGN_RUN,          /* the drive was in RUN */
    FAULT_SIGN_SENSED,       /* a sensor measures the angle */
    /* one of the two measured phases does not change while the other does */
    FAULT_SIGN_STUCK,
    FAULT_SIGN_NO_CURRENT, /* a phase had no current in the tick of the fault */
    FAULT_SIGN_OPEN_WIRE,  /* a phase had no current in the last half electrical turn */
    FAULT_SIGN_COLD,       /* the temperature is beyond the cold end of its sensor */
    FAULT_SIGN_GONE,       /* the bus is below half of its under-voltage limit */
    FAULT_SIGN_LATE,       /* there were late ticks */
    FAULT_SIGNS
} fault_sign_t;

typedef struct {
    const char *name; /* upper case, as in fault_id_t */
    fault_unit_t unit;
} fault_text_t;

/* Returns name and unit of a fault; if `id` is not a fault, those of FAULT_NONE. Never NULL. */
const fault_text_t *fault_text(fault_id_t id);

/*
 * Returns one line in ASCII: the likeliest cause and what to do, a semicolon, and what to try next.
 * signs: bit k stands for the sign k. Without any sign it names the most frequent cause. Never
 * NULL.
 */
const char *fault_advice(fault_id_t id, uint32_t signs);

#endif
