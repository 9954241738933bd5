/* SPDX-License-Identifier: MIT */
/*
 * Guard of the state: finds a bit that flips by itself in the words of drive_t that hold for longer
 * than a tick.
 *
 * What was measured, and what the configuration gives, is compared with a check word or computed
 * again, a part in each supervision period. In each of them it also looks at what moves by little
 * from one to the next: a larger change is no motion. The fault is MEMORY, its value tells the
 * part, its limit is 0.
 *
 * The settings that act at once are among it: the CRC of the whole configuration takes two seconds.
 * Where their check word, made when the drive takes the configuration over, is another one, the
 * fault is CONFIGURATION.
 *
 * What is computed anew in each tick or slow period is not looked at: a flip there is gone after
 * it, and what it has done is seen by the other checks. docs/protection.md lists both.
 *
 * Part of the drive; called from drive_step only, in any state. Faults as fault.h says.
 */
#ifndef STATE_GUARD_H
#define STATE_GUARD_H

#include "state.h"

/* The value of a fault MEMORY. */
typedef enum {
    STATE_GUARD_MODEL_OBSERVER = 0, /* this and the next seven take turns */
    STATE_GUARD_MODEL_LOOPS,
    STATE_GUARD_MODEL_GAINS,
    STATE_GUARD_MODEL_FLUX,
    STATE_GUARD_LIMITS,  /* of protection */
    STATE_GUARD_CHOICES, /* phases and flags that cannot be */
    STATE_GUARD_START,   /* counts of a start that cannot be */
    STATE_GUARD_CONFIG,  /* settings that act at once; the fault is CONFIGURATION */
    STATE_GUARD_PARTS,   /* number of these parts */
    /*
     * zeros of the current sensors; this and all below in each supervision period, or when they are
     * used
     */
    STATE_GUARD_MEASURED,
    STATE_GUARD_REFERENCE,
    STATE_GUARD_FLUX,
    STATE_GUARD_INTEGRALS,
    STATE_GUARD_ANGLE,
    STATE_GUARD_HEAT,
    STATE_GUARD_VECTOR,
    STATE_GUARD_WEAKENING,
    STATE_GUARD_PROFILE, /* of position control, or its zero */
    STATE_GUARD_TURNS,
    STATE_GUARD_STATE /* and more: this plus the code, which is none of drive_state_t */
} state_guard_part_t;

/* The next part, and what moves by little. Once per supervision period. */
fault_id_t state_guard_step(drive_t *drive, fault_t *fault);

/* Something has been set anew: the next look compares nothing with the last one. */
void state_guard_forget(drive_t *drive);

/* The zeros of the current sensors have been measured, or R and L. */
void state_guard_keep_measured(drive_t *drive);

/* The heat is as derating.c has left it. */
void state_guard_keep_heat(drive_t *drive);

/* The drive has taken over a configuration. */
void state_guard_keep_config(drive_t *drive);

/* Finds MEMORY where the heat is another than was kept. */
fault_id_t state_guard_check_heat(const drive_t *drive, fault_t *fault);

/*
 * Before the motion loops move an imposed vector: finds MEMORY where its step is none that they
 * have given it, where they want another one than a ramp leads to, or where a rotor has been lost
 * for longer than it may be.
 */
fault_id_t state_guard_check_vector(const drive_t *drive, fault_t *fault);

#endif
