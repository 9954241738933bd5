/* SPDX-License-Identifier: MIT */
/*
 * The probe: an imposed current, all of whose properties are set by words from outside, and sums of
 * the motor's response. It measures a motor of which only the name plate is known.
 *
 *   vector   The current lies along the d axis of a frame. At rest the frame turns to an angle;
 *            otherwise it turns with a speed.
 *   EMF      e = v − R·i* − jωL·i, v: voltage that the current control demands. A rotor that lags
 *            behind the frame by δ gives e = jωφ·e^(−jδ), thus sin δ = ±e_d/|e| with the sign of ω.
 *   damping  The speed of the frame changes by −K·(sin δ − its mean). So a rotor in the field of a
 *            stiff current, which nothing else damps, settles with δ' = −K·δ.
 *   tracking The speed of the frame changes by −k·sin δ in each tick: with no current the frame
 *            follows a rotor that coasts.
 *   pulses   In a window with a pulse voltage the current control holds its voltage along the
 *            pulse. +V, −V, −V, +V are added to it, each for PROBE_PULSE_TICKS, again and again.
 *            The current along the pulse goes up, down and back: the rotor gets no momentum.
 *   window   A number of ticks over which the sums below are formed.
 *
 * Currents Q15 of I_b, voltages Q15 of U_b, speeds in steps per tick. Pure, total; one step a
 * control tick. firmware/app/identify.c sends the words. The reader of the sums evaluates them.
 */
#ifndef PROBE_H
#define PROBE_H

#include "current_loop.h"
#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * What a word sets. The numbers begin above the modes of the motion loops. Send several words in
 * this order: words that say how the vector moves come before words that move it.
 */
typedef enum {
    PROBE_CURRENT = 16, /* i_d*, 0…16383 */
    PROBE_RATE,         /* a vector at rest turns to its angle by at most this in a tick, 0…2^29 */
    PROBE_ANGLE,        /* that angle: any angle_t, as a signed word */
    /* K_p along the current: mantissa 0…32767, from bit 16 on its shift 1…30 (pi.h) */
    PROBE_GAIN_D,
    PROBE_GAIN_Q,     /* across */
    PROBE_INTEGRAL_D, /* K_i·T likewise, its shift less 11 */
    PROBE_INTEGRAL_Q,
    PROBE_RESISTANCE,  /* R in the EMF, Q13 of U_b/I_b, 0…32767 */
    PROBE_REACTANCE,   /* Ω_b·L likewise */
    PROBE_LOSS,        /* voltage that the legs lose along the current, not EMF, 0…32767 */
    PROBE_EMF,         /* a smaller EMF counts less, 1…32767 */
    PROBE_DAMPING,     /* 2·K in steps per tick, 0…2^29 */
    PROBE_TRACKING,    /* 2·k likewise */
    PROBE_PULSE_D,     /* V along the current, 0…32767 */
    PROBE_PULSE_Q,     /* V across the current, 0…32767 */
    PROBE_PULSE_TICKS, /* of a quarter, 1…64 */
    PROBE_RAMP,        /* change of the speed in a tick, 0…2^29 */
    PROBE_SPEED,       /* of the vector, ±2^29; 0: it goes to its angle */
    /*
     * a window of 1…131071 ticks, begins when the word changes; the bits from 20 on are a number
     * that tells windows apart
     */
    PROBE_WINDOW,
    PROBE_WORDS /* number after the last word */
} probe_word_t;

#define PROBE_WINDOW_BITS (20U) /* of the ticks in the word of a window */
#define PROBE_WINDOW_MAX (131071)

/*
 * Sums over a window. Each saturates just below 2^31. In the longest window that is a mean of 0.5.
 * No current has such a mean, and no voltage while the bus is below 0.9 of its full scale.
 */
typedef struct {
    dq_t voltage;    /* demanded */
    dq_t current;    /* measured */
    int32_t bus;     /* a quarter of it */
    int32_t noise_a; /* |change of i_a| from sample to sample */
    int32_t noise_b;
    dq_t change;      /* of the current by the pulses, each with the sign of its pulse */
    int32_t turn_q16; /* by which the vector has turned, Q16 turns; wraps */
    int32_t across;   /* largest |i_q| */
    /* (e_d·i_d + e_q·i_q)/ω of a vector that turns, Q15 of U_b·I_b/Ω_b: times 1.5·P the torque */
    int32_t torque;
} probe_sums_t;

typedef struct {
    /* values that the words have set */
    int32_t current;
    angle_t angle;
    step_t rate;
    step_t speed;
    step_t ramp;
    current_loop_cfg_t loop;
    int32_t loss;
    int32_t emf_full;
    step_t damping;
    step_t tracking;
    dq_t pulse;
    int32_t pulse_ticks;
    int32_t window; /* the last word that began a window */
    /* state */
    uint32_t tick; /* of the window, 1…; 0: none is open */
    probe_sums_t sums;
    step_t own_speed;     /* of the vector before damping */
    int32_t lag_q15;      /* sin δ */
    int32_t mean_lag_q29; /* its mean */
    dq_t before;          /* d, q: currents of phases a, b at the last sample */
    dq_t current_before;  /* in the frame */
    int32_t start_q16;    /* angle of the vector at the start of the window */
} probe_t;

/* No current, at rest at angle 0, gains of zero, no window. */
void probe_reset(probe_t *probe);

/*
 * Takes a word. The value is limited to the word's range. A `what` that is not a probe_word_t
 * changes nothing.
 */
void probe_set(probe_t *probe, uint32_t what, int32_t value);

/*
 * The speed with which the vector turns in this tick. angle: of the vector; emf: as above, of the
 * last tick; bus_bears: the bus can take the energy of a rotor that slows down. Changes own_speed.
 */
step_t probe_turn(probe_t *probe, angle_t angle, dq_t emf, bool bus_bears);

/* A sample of one tick. */
typedef struct {
    int32_t phase_a;
    int32_t phase_b;
    dq_t current; /* in the frame */
    dq_t voltage; /* demanded in the last tick */
    int32_t bus;
    int32_t turns_q16; /* angle of the vector, Q16 turns; wraps */
    dq_t emf;          /* as in probe_turn() */
    int32_t speed_q15; /* of the vector, Q15 of Ω_b */
} probe_sample_t;

/*
 * Adds the sample to the open window, and closes the window after its last sample. Call it before
 * probe_voltage().
 */
void probe_note(probe_t *probe, const probe_sample_t *sample);

/* Whether pulses are added in this tick. */
bool probe_pulses(const probe_t *probe);

/*
 * With pulses: the current that the current control takes for the measured one. Along the pulses
 * the control sees its reference, so it holds its voltage. In the other axis it goes on, because
 * the voltage that the legs lose there changes with the pulses.
 */
dq_t probe_controlled(const probe_t *probe, dq_t reference, dq_t measured);

/*
 * With pulses: the voltage to demand, saturated at ±32767. It is the pulse of this tick plus
 * `steady`, the voltage of the current control, 16 bits.
 */
dq_t probe_voltage(const probe_t *probe, dq_t steady);

/* Whether the window of this word is complete. */
bool probe_is_done(const probe_t *probe, int32_t window);

#endif
