/* SPDX-License-Identifier: MIT */
/*
 * Neural-network speed observer, paper A (14)–(22).
 *
 * A two-layer linear network predicts the stator current in the estimated rotor frame. Its weight
 * W2 = −T·ω̂ is the only trained one, trained on line by back-propagation of the current error; the
 * weight is the speed. The network runs in parallel to the motor: its own output feeds back.
 *
 *     x = i_d + φ/L_d,  y = (L_q/L_d)·i_q                     (7), y scaled so that saliency needs no weight
 *     v_x = (v_d + R·φ/L_d)/L_d,  v_y = v_q/L_d               (8)
 * With these the motor's (3), (4) become (5), (6), (9), and in the estimated frame (12), (13); sampled as (10), (11):
 *     x̂(k) = W1·x̂(k−1) − W2·ŷ(k−1) + W3·v_x(k−1)             (14)–(16)
 *     ŷ(k) = W1'·ŷ(k−1) + W2·x̂(k−1) + W3·v_y(k−1)
 *     W1 = 1 − T·R/L_d,  W1' = 1 − T·R/L_q,  W2 = −T·ω̂_out,  W3 = T
 *                                                              rotation by W2 exact, see below
 *     e_d = i_d − î_d,  e_q = i_q − î_q                        (17)
 *     e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q)                    flux error, turned; ρ = 0 is the paper
 *     b(k) = e'_q·x̂(k−1) − e'_d·ŷ(k−1)                        descent direction of (18)
 *     ΔW2(k) = η·b(k) + α·ΔW2(k−1)                             (19)–(21)
 *     ω̂(k+1) = ω̂(k) − ΔW2(k)/T                                (22)
 *     ω̂_out = ω̂ − κ_p/T·b(k)/(φ/L_d)²                         proportional path; κ_p = 0 is the paper
 * With κ = η·(φ/L_d)²/(1 − α).
 *
 * Index in (23). The paper prints θ̂(k+1) = θ̂(k) + T·ω̂(k); here θ̂, and with it W2, advances with ω̂(k+1). With the
 * printed index the law is stable for κ < T/τ only, τ = L/R: for the paper's motor κ = 0.025 then grows with 30/s; with
 * the newer one it is damped with 90/s.
 *
 * For L_d = L_q this is the paper's equation letter by letter. With saliency the states are the
 * stator flux linkages over L_d, for which the rotation by W2 is the same.
 *
 * Rotation. Forward Euler in (14) turns and stretches: it grows for ω > √(2/(T·τ)), τ = L/R. Here W2 turns the frame
 * instead: the states are kept in the stationary frame, where x̂ + j·ŷ = (α + j·β)·exp(−jθ̂), and θ̂ advances by
 * ω̂_out·T, which is −W2, between two instants. That rotation is exact at any speed, and what is stored is turned by
 * nothing, so it neither grows nor drifts. Voltage and resistance act in the middle of the turn: the inverter's voltage
 * stands still in this frame anyway, the current of k−1 is turned by half a step. To first order in ωT these are the
 * paper's weights.
 *
 * Static part. A constant current error e answers a voltage error ε = (R + jωL)·e. The back-EMF error that
 * a wrong angle causes is along d, so the angle is in Re ε; what the paper trains with, Im e, has at low
 * speed the speed error in it and the angle only by the share ωτ: an error ΔR·i_q then turns the estimate
 * by ΔR·i_q/(ωφ)/(ωτ). Turning e by the motor's own impedance, ρ = R/(ωL), gives e' = ε/(jωL), in which
 * ΔR·i_q leaves the angle alone. ρ is limited, as it lets noise through.
 *
 * Formats. Measured values and errors are Q15 of the current base I_b, voltages Q15 of U_b. States are
 * Q27 of I_x = 2^s·I_b, which covers the largest current vector beside φ/L_d. Speeds are step_t (2^32 = one
 * electrical turn a tick). Sine and cosine are Q15: x̂ and ŷ are within 2·(|α| + |β|)·2^-15 and one LSB of their
 * output of the exact ones.
 *
 * A tick is nn_observer_predict, then nn_observer_train or nn_observer_follow. Control interrupt only.
 */
#ifndef NN_OBSERVER_H
#define NN_OBSERVER_H

#include "fx.h"
#include "transforms.h"

#include <stdint.h>

/* A weight is mantissa / 2^shift; mantissas are 0…32767. */
typedef struct {
    int32_t decay;          /* 1 − W1 = T·R/L_d, times I_b/I_x·2^(12 + weight_shift) */
    int32_t volt_gain;      /* W3/L_d, times U_b/I_x·2^(12 + weight_shift) */
    uint32_t weight_shift;  /* 2…15 */
    int32_t flux_q27;       /* the shift of (7): (φ/L_d)/I_x, 1…2^27 − 1 */
    int32_t iq_gain_q14;    /* L_d/L_q: i_q = y·L_d/L_q, 1…32767 */
    int32_t saliency_q13;   /* L_q/L_d: an error of i_q as one of y, 1…32767 */
    uint32_t current_shift; /* s, 0…9 */
    uint32_t descent_shift; /* of b, 4…12: below 12 where φ/L_d is small against I_b */
    /* η and κ_p: steps = d·mantissa / 2^shift with the descent d = b >> descent_shift, saturated to 16 bits. */
    int32_t rate;
    uint32_t rate_shift; /* 0…30 */
    int32_t proportional;
    uint32_t proportional_shift; /* 0…30 */
    int32_t momentum_q15;        /* α */
    step_t speed_limit;          /* |ω̂| is kept within, 1…2^29 */
    step_t corner;               /* R/L_d as a speed, for ρ = corner/ω̂, 0…2^27 */
    int32_t rho_max_q13;         /* |ρ| is kept within, 0…32767; 0: off */
    step_t rho_speed_min;        /* below it ρ = 0: the back-EMF says nothing, 1…2^29 */
} nn_observer_cfg_t;

typedef struct {
    int32_t alpha_q27; /* x̂ + j·ŷ in the stationary frame, −2^27…2^27 − 1 */
    int32_t beta_q27;  /* the same range */
    dq_t
        state; /* x̂, ŷ of the last instant, Q15 of I_x, ±46341: what W2 has turned when it is trained */
    step_t speed;       /* ω̂(k+1), the integral (22): for the speed loop */
    step_t speed_out;   /* ω̂_out: inside the network and for the angle; within ±2^29 */
    step_t weight_step; /* ΔW2(k)/T, for the momentum term; −2^29…2^29 − 1 */
    dq_t current;       /* î_d, î_q, ±16384: the converters' full scale, saturated */
    dq_t error;         /* e_d, e_q, −8192…8191 (¼) */
    dq_t turned; /* e', same range: d is the error of the flux' magnitude, q that of the angle */
    int32_t descent; /* b >> descent_shift in Q30 of I_b·I_x, 16 bits, saturated */
    int32_t rho_q13; /* ρ in force */
} nn_observer_t;

/*
 * Start at the angle whose sine and cosine are given, with a current in that frame and a speed, limited to ±speed_limit.
 * Without both: at rest with x̂ = φ/L_d. current: Q15 of I_b, |i| ≤ 65535, as two phases that read full scale can give;
 * x̂ and ŷ saturate to 28 bits.
 */
void nn_observer_start(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t speed, dq_t current,
                       sincos_t angle);

/*
 * (14)–(18), the forward pass: the state at this instant and its errors. measured: i_d, i_q at this instant, turned with
 * θ̂, |i| ≤ 65535. voltage: what the inverter applied since the last instant, stationary frame, |v| ≤ 32768. angle: sine
 * and cosine of θ̂ at this instant, which is that of the last one and speed_out. Total within these ranges: states,
 * currents and errors saturate as stated at their fields.
 */
void nn_observer_predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                         ab_t voltage, sincos_t angle);

/* (19)–(22): train W2 along the descent. The speeds are limited as stated at their fields. */
void nn_observer_train(nn_observer_t *obs, const nn_observer_cfg_t *cfg);

/* In place of training: W2 is given. speed: within ±speed_limit. */
void nn_observer_follow(nn_observer_t *obs, step_t speed);

/*
 * Set ρ for a speed, within ±2^30: the best there is, not an estimate that still swings, for ρ has its sign. Call once
 * a slow period. One division.
 */
void nn_observer_update_rho(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t rotor_speed);

#endif
