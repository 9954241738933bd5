/* SPDX-License-Identifier: MIT */
/*
 * The probe imposes a current and sums the motor's response. All properties of the current are set
 * by words from outside. The probe measures a motor of which only the name plate is known.
 *
 *   vector   The current lies along the d axis of a frame. With PROBE_SPEED = 0 the frame turns to
 *            an angle and rests there; otherwise it turns with that speed.
 *   EMF      e = v − R·i* − jωL·i, v: voltage that the current control demands. A rotor that lags
 *            behind the frame by δ gives e = jωφ·e^(−jδ), thus sin δ = ±e_d/|e| with the sign of ω.
 *   damping  The speed of the frame changes by −K·(sin δ − mean of sin δ). So a rotor in the
 *            field of a stiff current, which nothing else damps, settles with δ' = −K·δ.
 *   tracking The speed of the frame changes by −k·sin δ in each tick. So with no current the frame
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
 * The property that a word sets. The numbers begin above the modes of the motion loops. Send
 * several words in this order: words that say how the vector moves come before words that move it.
 */
typedef enum {
    PROBE_CURRENT = 16, /* i_d*, 0…16383 */
    PROBE_RATE,         /* largest step in a tick towards PROBE_ANGLE, 0…2^29 */
    /* with PROBE_SPEED = 0 the vector turns to this angle: any angle_t, as a signed word */
    PROBE_ANGLE,
    /* K_p of the d axis: mantissa 0…32767 in bits 0…14, shift 1…30 from bit 16 on (pi.h) */
    PROBE_GAIN_D,
    PROBE_GAIN_Q,     /* K_p of the q axis, same format */
    PROBE_INTEGRAL_D, /* K_i·T of the d axis, same format; the shift is ki_shift of pi.h */
    PROBE_INTEGRAL_Q, /* K_i·T of the q axis, same format */
    PROBE_RESISTANCE, /* R in the EMF, Q13 of U_b/I_b, 0…32767 */
    PROBE_REACTANCE,  /* Ω_b·L in the EMF, Q13 of U_b/I_b, 0…32767 */
    /*
     * voltage that the legs lose along the current, subtracted from the EMF's d component, 0…32767
     */
    PROBE_LOSS,
    PROBE_EMF,         /* where |e| is below this, sin δ is reduced in proportion to |e|, 1…32767 */
    PROBE_DAMPING,     /* 2·K in steps per tick, 0…2^29 */
    PROBE_TRACKING,    /* 2·k in steps per tick, 0…2^29 */
    PROBE_PULSE_D,     /* V along the current, 0…32767 */
    PROBE_PULSE_Q,     /* V across the current, 0…32767 */
    PROBE_PULSE_TICKS, /* ticks of a quarter of the pulses, 1…64 */
    PROBE_RAMP,        /* largest change of the vector's speed in a tick, 0…2^29 */
    PROBE_SPEED,       /* speed of the vector, ±2^29; 0: the vector turns to PROBE_ANGLE */
    /*
     * Bits 0…19: ticks of a window, 1…131071. The bits from 20 on are a number that tells windows
     * apart. A window begins when this word changes.
     */
    PROBE_WINDOW,
    PROBE_WORDS /* number after the last word */
} probe_word_t;

#define PROBE_WINDOW_BITS (20U) /* bits of PROBE_WINDOW that hold the ticks */
#define PROBE_WINDOW_MAX (131071)

/*
 * Sums over a window. Each saturates just below 2^31. In the longest window this is reached with a
 * mean of 0.5. No current has such a mean. No voltage has it while the bus is below 0.9 of its full
 * scale.
 */
typedef struct {
    dq_t voltage;     /* demanded voltage */
    dq_t current;     /* measured current */
    int32_t bus;      /* a quarter of the bus voltage */
    int32_t noise_a;  /* |change of i_a| from sample to sample */
    int32_t noise_b;  /* the same for i_b */
    dq_t change;      /* changes of the current by the pulses, each with the sign of its pulse */
    int32_t turn_q16; /* angle by which the vector has turned, Q16 turns; wraps */
    int32_t across;   /* largest |i_q|, not a sum */
    /*
     * (e_d·i_d + e_q·i_q)/ω of a vector that turns, Q15 of U_b·I_b/Ω_b; times 1.5·P it is the
     * torque
     */
    int32_t torque;
} probe_sums_t;

typedef struct {
    /* Values that the words have set. */
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
    /* State. */
    uint32_t tick; /* tick of the open window, 1…; 0: no window is open */
    probe_sums_t sums;
    step_t own_speed;     /* speed of the vector without damping */
    int32_t lag_q15;      /* sin δ */
    int32_t mean_lag_q29; /* mean of sin δ */
    dq_t before;          /* d, q: currents of phases a, b at the last sample */
    dq_t current_before;  /* current of the last sample, in the frame */
    int32_t start_q16;    /* angle of the vector at the start of the window */
} probe_t;

/* Sets no current, a vector at rest at angle 0, gains of zero and no window. */
void probe_reset(probe_t *probe);

/*
 * Takes a word. The value is limited to the word's range. A `what` that is not a probe_word_t
 * changes nothing.
 */
void probe_set(probe_t *probe, uint32_t what, int32_t value);

/*
 * Returns the speed with which the vector turns in this tick. angle: angle of the vector. emf: EMF
 * of the last tick, as defined at the top. bus_bears: true while the bus can take the energy of a
 * rotor that slows down. Changes own_speed.
 */
step_t probe_turn(probe_t *probe, angle_t angle, dq_t emf, bool bus_bears);

/* Sample of one tick. */
typedef struct {
    int32_t phase_a; /* measured i_a */
    int32_t phase_b; /* measured i_b */
    dq_t current;    /* measured current, in the frame */
    dq_t voltage;    /* voltage that was demanded in the last tick */
    int32_t bus;
    int32_t turns_q16; /* angle of the vector, Q16 turns; wraps */
    dq_t emf;          /* EMF as defined at the top */
    int32_t speed_q15; /* speed of the vector, Q15 of Ω_b */
} probe_sample_t;

/*
 * Adds the sample to the open window, and closes the window after its last sample. Call it before
 * probe_voltage().
 */
void probe_note(probe_t *probe, const probe_sample_t *sample);

/* Whether pulses are added in this tick. */
bool probe_pulses(const probe_t *probe);

/*
 * Call it while pulses are added. Returns the current that replaces the measured one in the current
 * control. Along the pulses this is the reference, so the control holds its voltage. In the other
 * axis it is the measured current, because the voltage that the legs lose there changes with the
 * pulses.
 */
dq_t probe_controlled(const probe_t *probe, dq_t reference, dq_t measured);

/*
 * Call it while pulses are added. Returns the voltage to demand, saturated at ±32767: the pulse of
 * this tick plus `steady`, the voltage of the current control, 16 bits.
 */
dq_t probe_voltage(const probe_t *probe, dq_t steady);

/* Whether the window of this word is complete. */
bool probe_is_done(const probe_t *probe, int32_t window);

#endif
