/* SPDX-License-Identifier: MIT */
/*
 * Guard of the state: finds a bit that flips by itself in those words of drive_t that keep their
 * value for longer than a tick.
 *
 * Measured values, and values that follow from the configuration, are compared with a check word or
 * computed again, one part in each supervision period. In every supervision period the guard also
 * checks the values that can change only a little from one period to the next: a larger change is
 * a flipped bit. The fault is MEMORY, its value is the part, its limit is 0.
 *
 * One part is the settings that act at once: a wrong one makes speed or current wrong within
 * 100 ms, and the CRC of the whole configuration takes two seconds. Their check word is made when
 * the drive takes over the configuration. If it differs later, the fault is CONFIGURATION.
 *
 * Values that are computed anew in each tick or slow period are not checked: a flip in them is gone
 * with the next computation, and the other checks see its effect. docs/protection.md lists both
 * kinds of words.
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
    STATE_GUARD_LIMITS,  /* limits of protection */
    STATE_GUARD_CHOICES, /* impossible phases, flags or inertia */
    STATE_GUARD_START,   /* impossible count of starts */
    STATE_GUARD_CONFIG,  /* settings that act at once; the fault is CONFIGURATION */
    STATE_GUARD_PARTS,   /* number of these parts */
    /*
     * zeros of the current sensors, and whether R and L were measured; this part and all below are
     * checked in each supervision period, or when they are used
     */
    STATE_GUARD_MEASURED,
    STATE_GUARD_REFERENCE,
    STATE_GUARD_FLUX,
    STATE_GUARD_INTEGRALS,
    STATE_GUARD_ANGLE,
    STATE_GUARD_HEAT,
    STATE_GUARD_VECTOR,
    STATE_GUARD_WEAKENING,
    STATE_GUARD_PROFILE, /* profile of position control, or its zero */
    STATE_GUARD_TURNS,   /* turns of the rotor, or the angle that follows a sensor */
    /*
     * this or more: STATE_GUARD_STATE + the code in drive_t.state, which is not one of
     * drive_state_t
     */
    STATE_GUARD_STATE
} state_guard_part_t;

/*
 * Checks the next part, and the values that change only a little. Once per supervision period. Of
 * the motor it computes the words of the flux anew (model_holds()).
 */
fault_id_t state_guard_step(state_guard_t *guard, motor_t *motor, const drive_t *drive,
                            fault_t *fault);

/*
 * Call when values have been set anew: the next check does not compare with the values of the last
 * one.
 */
void state_guard_forget(state_guard_t *guard);

/* Call when the zeros of the current sensors, or R and L, have been measured. */
void state_guard_keep_measured(state_guard_t *guard, const drive_t *drive);

/* Call after each intended change of the heat. */
void state_guard_keep_heat(state_guard_t *guard, const derating_t *derating);

/* Call when the drive has taken over a configuration. */
void state_guard_keep_config(state_guard_t *guard, const drive_cfg_t *cfg);

/* Each tick that is not an ordinary one of RUN: finds MEMORY if the state's code is none. */
fault_id_t state_guard_check_state(const drive_t *drive, fault_t *fault);

/*
 * Each tick of a drive with a sensor, before it is read: finds MEMORY if the angle and the speed
 * that follow the sensor are not as they were written.
 */
fault_id_t state_guard_check_sensor(const drive_t *drive, fault_t *fault);

/* Finds MEMORY if the heat differs from the kept one. */
fault_id_t state_guard_check_heat(const drive_t *drive, fault_t *fault);

/*
 * Call before the motion loops move an imposed vector. Finds MEMORY if the vector's step is not the
 * one that they have set, if they want a step that no ramp leads to, if the rotor has been lost for
 * longer than is allowed, or if the zeros of the current sensors differ from the kept ones.
 */
fault_id_t state_guard_check_vector(const drive_t *drive, fault_t *fault);

#endif
