/* SPDX-License-Identifier: MIT */
/*
 * Alignment: pull a standing rotor to a known angle with an imposed current, and measure R and L at
 * the same time.
 *
 *   PULL          the current rises fast to current_high while its vector makes half a turn; then
 *                 the vector rests. The turning vector catches a rotor at any angle, and the rotor
 *                 comes to rest on it
 *   MEASURE_HIGH  forms the mean of voltage and current at current_high
 *   INDUCTANCE    a voltage pulse across the current gives L_q, a voltage step along it gives L_d,
 *                 see inductance.h
 *   SETTLE        waits at current_low
 *   MEASURE_LOW   forms the mean of voltage and current at current_low. The difference between both
 *                 measurements gives R, because the offset by dead time and device drop cancels.
 *                 The voltage extrapolated to zero current is that offset
 *   EVALUATE      computes R, L_d, L_q and the offset
 *
 * Why the vector turns: a rotor opposite to a fixed vector would not start. A rotor just before
 * that angle would swing back by half a turn, or by more under load. A vector that turns in the
 * wanted direction reaches every rotor angle.
 *
 * Whether the rotor rests. A rotor that swings or slips in the field of the vector induces a
 * current across the vector, and the measured values are worthless. While the vector rests and the
 * current control damps the rotor, that current is 1.4·(angle of the swing) times the imposed
 * current. It is smaller where R·I is many times the EMF. The largest sample of |i_q| in a
 * measurement decides, so noise counts too. Up to swing_max the rotor counts as at rest. Above
 * swing_max, up to 1/5 of current_high, the rotor may be swinging: the measurement is repeated as
 * long as its largest |i_q| is at most 15/16 of the larger one of the two measurements before it.
 * The swing of a rotor that slips does not shrink.
 *
 * The current vector lies on the d axis of a frame, which the caller turns by frame_speed. Pure,
 * total. One step per control tick.
 */
#ifndef ALIGN_H
#define ALIGN_H

#include "inductance.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * If |i_q| exceeds 1/5 of current_high, the rotor slips. Its load accelerates it, so the
 * measurement is not repeated.
 */
#define ALIGN_SLIP_SHARE (5)

typedef struct {
    int32_t current_high; /* current of PULL and MEASURE_HIGH, Q15 of I_b, 1…16384 */
    int32_t current_low;  /* current of MEASURE_LOW, 0…current_high − 1 */
    int32_t swing_max;    /* largest |i_q| of a rotor that rests, Q15 of I_b, 1…current_high */
    int32_t slope;        /* change of the current per tick in PULL, Q15 of I_b, 1…16384 */
    /* speed of the vector in its half turn, 1…2^29, within the observer's speed_limit */
    step_t sweep_speed;
    uint32_t sweep_ticks;  /* duration of the half turn, 1…pull_ticks */
    uint32_t pull_ticks;   /* duration of the whole PULL, 1…2^20 */
    uint32_t settle_ticks; /* duration of SETTLE, 1…2^20 */
    uint32_t measure_log2; /* a measurement takes 2^measure_log2 ticks, 6…16 */
    inductance_cfg_t inductance;
} align_cfg_t;

typedef enum {
    ALIGN_PULL = 0,
    ALIGN_MEASURE_HIGH,
    ALIGN_INDUCTANCE,
    ALIGN_SETTLE,
    ALIGN_MEASURE_LOW,
    ALIGN_EVALUATE, /* takes one tick, so that the tick that uses the result need not compute it */
    ALIGN_DONE
} align_phase_t;

/*
 * One measurement, Q15 of U_b and I_b. While it runs: sums of the samples. After it: 64 times the
 * means.
 */
typedef struct {
    int32_t voltage;
    int32_t current;
} align_point_t;

/* Results. A value of R or L that the measurements do not give is ALIGN_UNKNOWN. */
typedef struct {
    int32_t resistance_q13;         /* R in U_b/I_b, 0…32767 */
    inductance_result_t inductance; /* known only if resistance_q13 > 0 */
    /*
     * The voltage that R·i does not explain, extrapolated to zero current: the part of dead time
     * and device drop that is not compensated. Q15 of U_b, ±16384, rounded down; 0 when there is no
     * valid measurement. The two currents must differ by more than a quarter of the larger one: the
     * extrapolation reaches at most four times their difference.
     */
    int32_t lost_voltage;
} align_found_t;

#define ALIGN_UNKNOWN (INDUCTANCE_UNKNOWN)

typedef struct {
    align_phase_t phase;
    uint32_t tick;       /* ticks since the phase began */
    bool backwards;      /* the vector turns from β towards α */
    int32_t current_ref; /* i_d* of this tick */
    step_t frame_speed;
    int32_t swing;        /* largest |i_q| of this measurement, 0…34400 */
    int32_t swing_before; /* largest |i_q| of the measurement before this one, 0…34400 */
    /* if `swing` exceeds this, the rotor slips and the measurement is not repeated, 0…32250 */
    int32_t swing_bound;
    inductance_t inductance;
    align_point_t high;
    align_point_t low;
    align_found_t found; /* valid in ALIGN_DONE */
} align_t;

/* Starts with PULL. backwards: the drive is going to turn backwards. */
void align_reset(align_t *align, bool backwards);

/*
 * Starts in PULL after the half turn. Call it where a resting vector of current_ref holds the rotor
 * already. A rotor that still swings has the rest of PULL to come to rest.
 */
void align_reset_held(align_t *align, const align_cfg_t *cfg, int32_t current_ref);

/*
 * One tick. current: measured i_d, i_q, Q15 of I_b, ±34400. voltage: v_d demanded in the last tick,
 * Q15 of U_b, ±32767. Sets current_ref and frame_speed for this tick.
 */
void align_step(align_t *align, const align_cfg_t *cfg, dq_t current, int32_t voltage);

/* Whether MEASURE_HIGH or MEASURE_LOW has ended in this tick. */
bool align_has_measured(const align_t *align);

/* Call it in that tick. Whether the rotor has rested during the measurement: |i_q| ≤ swing_max. */
bool align_is_at_rest(const align_t *align, const align_cfg_t *cfg);

/*
 * Whether the current control pauses in this tick. It pauses from the tick that ends MEASURE_HIGH
 * until the last tick in which INDUCTANCE sets the voltage.
 */
bool align_holds_voltage(const align_t *align, const align_cfg_t *cfg);

/*
 * While the current control pauses: returns the change of the demanded voltage in this tick, see
 * inductance.h.
 */
dq_t align_voltage(const align_t *align, const align_cfg_t *cfg);

#endif
