/*
 * Neural-network speed observer, paper A (14)–(22).
 *
 * A two-layer linear network predicts the stator current in the estimated rotor frame. Its weight
 * W2 = −T·ω̂ is the only trained one, trained on line by back-propagation of the current error; the
 * weight is the speed. The network runs in parallel to the motor: its own output feeds back.
 *
 *     x = i_d + φ/L_d,  y = (L_q/L_d)·i_q                     (7), y scaled so that saliency needs no weight
 *     v_x = (v_d + R·φ/L_d)/L_d,  v_y = v_q/L_d               (8)
 *     x̂(k) = W1·x̂(k−1) − W2·ŷ(k−1) + W3·v_x(k−1)             (14)–(16)
 *     ŷ(k) = W1'·ŷ(k−1) + W2·x̂(k−1) + W3·v_y(k−1)
 *     W1 = 1 − T·R/L_d,  W1' = 1 − T·R/L_q,  W2 = −T·ω̂_out,  W3 = T
 *     e_d = i_d − î_d,  e_q = i_q − î_q                        (17)
 *     b(k) = e_q·x̂(k−1) − e_d·ŷ(k−1)                          descent direction of (18)
 *     ΔW2(k) = η·b(k) + α·ΔW2(k−1)                             (19)–(21)
 *     ω̂(k+1) = ω̂(k) − ΔW2(k)/T                                (22)
 *     ω̂_out = ω̂ − κ_p/T·b(k)/(φ/L_d)²                         proportional path; κ_p = 0 is the paper
 * With κ = η·(φ/L_d)²/(1 − α).
 *
 * For L_d = L_q this is the paper's equation letter by letter. With saliency the states are the
 * stator flux linkages over L_d, for which the rotation by W2 is the same.
 *
 * Stability: forward Euler in (14) grows for ω > √(2/(T·τ)), τ = L/R; the configuration refuses such a
 * speed and `speed_limit` keeps the estimate below it.
 *
 * Formats. Measured values and errors are Q15 of the current base I_b, voltages Q15 of U_b. States are
 * Q27 of I_x = 2^s·I_b, which covers the largest current vector beside φ/L_d; their upper 16 bits enter
 * the products. Speeds are step_t (2^32 = one electrical turn a tick); W2 enters its products with 32
 * bits, for a bias of one LSB there would turn the angle at standstill.
 */
#ifndef NN_OBSERVER_H
#define NN_OBSERVER_H

#include "fx.h"
#include "transforms.h"

#include <stdint.h>

/* A weight is mantissa / 2^shift; mantissas are 0…32767. */
typedef struct {
    int32_t decay_d;             /* 1 − W1 = T·R/L_d, times 2^(12 + weight_shift) */
    int32_t decay_q;             /* 1 − W1' = T·R/L_q, same format */
    int32_t volt_gain;           /* W3/L_d·U_b/I_x, same format */
    uint32_t weight_shift;       /* 2…15 */
    int32_t flux_q27;            /* the shift of (7): (φ/L_d)/I_x, 1…2^27 − 1 */
    int32_t flux_drive_q27;      /* the constant part of v_x: T·R/L_d·(φ/L_d)/I_x, 0…2^26 */
    int32_t iq_gain_q14;         /* L_d/L_q: i_q = y·L_d/L_q, 1…32767 */
    uint32_t current_shift;      /* s, 0…10 */
    int32_t rate;                /* η: ΔW2 in steps = (b >> 14)·rate / 2^rate_shift */
    uint32_t rate_shift;         /* 0…30 */
    int32_t proportional;        /* κ_p: steps = (b >> 14)·proportional / 2^proportional_shift */
    uint32_t proportional_shift; /* 0…30 */
    int32_t momentum_q15;        /* α */
    step_t speed_limit;          /* |ω̂| is kept within, 1…2^29 */
} nn_observer_cfg_t;

typedef struct {
    int32_t x_q27;      /* x̂, −2^27…2^27 − 1 */
    int32_t y_q27;      /* ŷ, −2^27…2^27 − 1 */
    step_t speed;       /* ω̂(k+1), the integral (22): for the speed loop */
    step_t speed_out;   /* ω̂_out: inside the network and for the angle; within 1.5·2^30 */
    step_t weight_step; /* ΔW2(k)/T, for the momentum term; −2^29…2^29 − 1 */
    dq_t current;       /* î_d, î_q */
    dq_t error;         /* e_d, e_q, −8192…8191 (¼) */
} nn_observer_t;

/* Start at rest with no current: x̂ = φ/L_d, everything else zero. */
void nn_observer_reset(nn_observer_t *obs, const nn_observer_cfg_t *cfg);

/*
 * One tick. measured: i_d, i_q at this sampling instant, turned with θ̂, |i| ≤ 65535. voltage: what the
 * inverter applied since the last instant, in the estimated frame at the middle of that interval,
 * |v| ≤ 32767. Total within these ranges: states, speeds and errors saturate as stated at their fields.
 */
void nn_observer_step(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                      dq_t voltage);

#endif
