/* SPDX-License-Identifier: MIT */
/*
 * Faults: why the gates were opened, with the numbers to see it by.
 *
 * A fault is latched by the drive in the tick that finds it. What merely lowers the drive's current
 * is no fault, see derating.h. Names, units and advice as text: fault_text.h.
 */
#ifndef FAULT_H
#define FAULT_H

#include <stdint.h>

/* Numbers are part of recordings: new ones go to the end. The first four are checked in this order. */
typedef enum {
    FAULT_NONE = 0,
    FAULT_BREAK, /* the power stage's own comparator, value: the largest phase current, limit: 0 */
    FAULT_OVERCURRENT,       /* value: the largest phase current */
    FAULT_OVERVOLTAGE,       /* value: bus */
    FAULT_UNDERVOLTAGE,      /* value: bus */
    FAULT_CURRENT_OFFSET,    /* value: offset of the worse sensor from mid-scale */
    FAULT_ADC_SATURATED,     /* a current sample at an end of its converter, value as OVERCURRENT */
    FAULT_ADC_STUCK,         /* a current stands still while the rotor turns, value: its range */
    FAULT_LOST_PHASE,        /* value: range of the weakest phase, or error of the current */
    FAULT_OVERLOAD,          /* i²t, value: heat, Q14 of what the continuous current makes */
    FAULT_OVERTEMPERATURE,   /* value: raw count of the sensor */
    FAULT_OBSERVER_LOST,     /* value: mean error of the model's current */
    FAULT_SPEED_IMPLAUSIBLE, /* value: |ω̂ − reference|, or |ω̂| at the observer's limit; step_t */
    FAULT_STALL,             /* value: |ω̂|, step_t */
    FAULT_OVERSPEED,         /* value: |ω̂|, step_t */
    FAULT_LATE,              /* value: late ticks within the window */
    FAULT_CONFIGURATION,     /* value: CRC of the configuration, limit: the CRC stored with it */
    FAULT_STARTUP,           /* value, limit: as the start-up says */
    FAULT_CURRENT_IMPLAUSIBLE, /* value: voltage beyond what the current explains */
    FAULT_COUNT                /* how many there are, no fault */
} fault_id_t;

/* What happened, what was measured, what was allowed, and when. Currents Q15 of I_b, bus Q15 of U_b. */
typedef struct {
    fault_id_t id;
    int32_t value;
    int32_t limit;
    uint32_t tick; /* of drive_t, wraps */
} fault_t;

#endif
