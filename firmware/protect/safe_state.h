/* SPDX-License-Identifier: MIT */
/*
 * The safe state: the state of the gates while the drive drives nothing.
 *
 * Open gates are safe while the EMF stays below the voltage that the bus bears. At a higher speed
 * the diodes would rectify the EMF into the bus, so the three low sides short the motor instead.
 * The final short-circuit current is φ/L at most, and it brakes little. The gates open once the
 * rotor is slow.
 *
 * The change of the current shows when the rotor is slow. In the short circuit the EMF causes this
 * change, T/L·ω·φ in a tick, so it measures the voltage that would charge the bus. No observer
 * takes part, because a lost observer may be the fault. A current that only decays with L/R changes
 * little. If a wire is open, or a sensor is stuck or clips, the change is still large twice in each
 * electrical turn. The gates open when no change over span_ticks was large for settle_ticks, more
 * than a turn.
 *
 * They do not open while the bus is above its limit, because it then has no room for the energy of
 * the windings. If both sensors are dead no change is large, and only a bus above its limit shows a
 * fast rotor.
 *
 * Called from drive_step in each tick that drives nothing. Pure, total. Speeds are steps per tick,
 * currents Q15 of I_b, the bus Q15 of U_b.
 */
#ifndef SAFE_STATE_H
#define SAFE_STATE_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /*
     * opening the gates is safe up to this speed, 0…2^29; 0: safe at any speed, so the motor is
     * never shorted
     */
    step_t open_speed;
    uint32_t span_ticks; /* the change of the current is measured over this many ticks, 0…1024 */
    /* a change below this shows that the rotor is slow enough, Q15 of I_b, 0…32767 */
    int32_t change_min;
    /*
     * the gates open after this many ticks without a large change and with the bus within its
     * limit, 0…2^20
     */
    uint32_t settle_ticks;
} safe_state_cfg_t;

typedef enum {
    SAFE_STATE_OPEN = 0,
    SAFE_STATE_SHORT, /* gates on, all low sides: the rotor is fast, or the bus above its limit */
    SAFE_STATE_BROKEN /* the power stage has opened the gates by itself: nothing turns them on */
} safe_state_phase_t;

typedef struct {
    safe_state_phase_t phase;
    uint32_t ticks; /* ticks of this span so far, 0…1023 */
    ab_t before;    /* current at the beginning of this span */
    /* ticks without a large change and with the bus within its limit, 0…2^20 */
    uint32_t slow_ticks;
} safe_state_t;

/* Measured values of a tick. */
typedef struct {
    ab_t current;    /* alpha −16384…16383, beta −28379…28379 */
    int32_t bus;     /* 0…32767 */
    int32_t bus_max; /* 1…32766 */
} safe_state_in_t;

/* Goes to SAFE_STATE_OPEN, also from SAFE_STATE_BROKEN. */
void safe_state_reset(safe_state_t *safe);

/*
 * Call in the tick in which the drive stops driving. `speed`, 0…2^30, is an upper bound on the
 * speed of the rotor. If it is above cfg->open_speed, the motor is shorted; otherwise the gates
 * open.
 */
void safe_state_leave(safe_state_t *safe, const safe_state_cfg_t *cfg, step_t speed);

/*
 * Call when the power stage has opened the gates by itself. They stay open until
 * safe_state_reset().
 */
void safe_state_break(safe_state_t *safe);

/*
 * Call in each tick that drives nothing. Returns true when all low sides must be on, false when the
 * gates must be open. A bus above its limit also shorts the motor, because it shows that a load
 * turns the rotor and the diodes charge the bus.
 */
bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in);

static inline bool safe_state_is_short(const safe_state_t *safe)
{
    return safe->phase == SAFE_STATE_SHORT;
}

#endif
