/* SPDX-License-Identifier: MIT */
/*
 * Faults: why the gates were opened, with the measured value and the limit.
 *
 * A check that can find a fault takes a `fault_t *fault`. Without a fault it returns FAULT_NONE and
 * leaves *fault as it is. With a fault it writes all of *fault but the tick, and returns the id.
 * The drive latches a fault in the tick that finds it. Derating only reduces the current and is not
 * a fault, see derating.h. Names, units and advice as text: fault_text.h.
 */
#ifndef FAULT_H
#define FAULT_H

#include <stdint.h>

/*
 * The numbers are part of recordings, so new faults go to the end. The first four are checked in
 * this order.
 */
typedef enum {
    FAULT_NONE = 0,
    /* the power stage has opened its gates by itself; value: the largest phase current, limit: 0 */
    FAULT_BREAK,
    FAULT_OVERCURRENT,    /* value: the largest phase current */
    FAULT_OVERVOLTAGE,    /* value: bus voltage */
    FAULT_UNDERVOLTAGE,   /* value: bus voltage */
    FAULT_CURRENT_OFFSET, /* value: the larger offset of the two sensors from mid-scale */
    /* a current sample is at an end of the converter's range; value as OVERCURRENT */
    FAULT_ADC_SATURATED,
    /*
     * a current is constant while the rotor turns, value: its range; or a current flows with open
     * gates and its vector does not turn, value: the larger one of the two measured currents
     */
    FAULT_ADC_STUCK,
    /* value: range of the weakest phase, current of that phase, or error of the current control */
    FAULT_LOST_PHASE,
    FAULT_OVERLOAD,          /* i²t, value: heat, Q14, 1 = steady state at the continuous current */
    FAULT_OVERTEMPERATURE,   /* value: raw count of the sensor */
    FAULT_OBSERVER_LOST,     /* value: mean of the error between measured and modelled current */
    FAULT_SPEED_IMPLAUSIBLE, /* value: |ω̂ − reference|, or |ω̂| at the observer's limit; step_t */
    FAULT_STALL,             /* value: |ω̂|, step_t */
    FAULT_OVERSPEED,         /* value: |ω̂|, step_t */
    FAULT_LATE,              /* value: late ticks within the window */
    FAULT_CONFIGURATION,     /* value: CRC of the configuration, limit: the CRC stored with it */
    FAULT_STARTUP,           /* value, limit: see open_loop.c */
    FAULT_CURRENT_IMPLAUSIBLE, /* value: voltage that the measured current does not explain */
    /* value: amplitude of i_q*; the frequency follows from oscillation_t.span */
    FAULT_OSCILLATION,
    /* value: raw count of the sensor, limit: the last count that a working sensor can have */
    FAULT_TEMPERATURE_SENSOR,
    /* value: mean of |i_a + i_b + i_c|, limit: the allowed mean at these currents */
    FAULT_CURRENT_SUM,
    FAULT_FLUX_IMPLAUSIBLE, /* value: change of the EMF within a second */
    /*
     * a word of the drive's state has changed though nothing wrote it; value: the part,
     * state_guard.h, or an index, config_guard.h
     */
    FAULT_MEMORY,
    FAULT_ANGLE_SENSOR, /* the sensor of the shaft tells no angle; value: why, shaft_trouble.h */
    FAULT_COUNT         /* number of entries, not a fault */
} fault_id_t;

/* Fault, measured value, limit, and tick. Currents Q15 of I_b, bus Q15 of U_b. */
typedef struct {
    fault_id_t id;
    int32_t value;
    int32_t limit;
    uint32_t tick; /* drive_t.tick at the fault, wraps */
} fault_t;

/*
 * Clears a fault. It does so word by word, because a library's memset takes 46 instructions on a
 * Cortex-M0+. The tick stays as it is: the drive sets it when it latches a fault.
 */
static inline void fault_clear(fault_t *fault)
{
    fault->id = FAULT_NONE;
    fault->value = 0;
    fault->limit = 0;
}

#endif
