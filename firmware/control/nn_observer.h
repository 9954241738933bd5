/* SPDX-License-Identifier: MIT */
/*
 * Neural-network speed observer, paper A (14)–(22).
 *
 * A two-layer linear network predicts the stator current in the estimated rotor frame. Only the
 * weight W2 = −T·ω̂ is trained, on line, by back-propagation of the current error. So the weight is
 * the speed estimate. The network runs in parallel to the motor: its input is its own last output,
 * not the measured current, except for a small share f of the error.
 *
 *     x = i_d + φ/L_d,  y = (L_q/L_d)·i_q                     (7), y scaled: see Saliency
 *     v_x = (v_d + R·φ/L_d)/L_d,  v_y = v_q/L_d               (8)
 * With these, the motor's equations (3), (4) become (5), (6), (9), and (12), (13) in the estimated
 * frame. Sampled as in (10), (11), the network is:
 *     x̂(k) = W1·x̂(k−1) − W2·ŷ(k−1) + W3·v_x(k−1) + f·e_d(k−1)  (14)–(16); f = 0 in the paper
 *     ŷ(k) = W1'·ŷ(k−1) + W2·x̂(k−1) + W3·v_y(k−1) + f·e_q(k−1)
 *     W1 = 1 − T·R/L_d,  W1' = 1 − T·R/L_q,  W2 = −T·ω̂_out,  W3 = T;  see Rotation
 *     e_d = i_d − î_d,  e_q = i_q − î_q                        (17)
 *     e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q)                    flux error, ρ = 0 in the paper
 *     b(k) = e'_q·x̂(k−1) − e'_d·ŷ(k−1)                        −∂E/∂W2, E of (18)
 *     ΔW2(k) = η·b(k) + α·ΔW2(k−1)                             (19)–(21)
 *     ω̂(k+1) = ω̂(k) − ΔW2(k)/T                                (22)
 *     ω̂_out = ω̂ − κ_p/T·b(k)/(φ/L_d)²                         κ_p = 0 in the paper
 * With κ = η·(φ/L_d)²/(1 − α).
 *
 * Index in (23). The paper prints θ̂(k+1) = θ̂(k) + T·ω̂(k). Here θ̂, and with it W2, advances with
 * ω̂(k+1). With the printed index the law is stable only for κ < T/τ, τ = L/R. For the motor of the
 * paper an error with κ = 0.025 would grow at 30/s; with ω̂(k+1) it decays at 90/s.
 *
 * Saliency. For L_d = L_q this is the paper's equation as printed. With saliency the states are the
 * stator flux linkages divided by L_d, for which the rotation by W2 is the same. So y is scaled,
 * and no weight is needed for saliency.
 *
 * Rotation. Forward Euler in (14) turns the state and also lengthens it: the state grows for ω >
 * √(2/(T·τ)), τ = L/R. Here W2 turns the frame instead. The states are stored in the stationary
 * frame, x̂ + j·ŷ = (α + j·β)·exp(−jθ̂), and θ̂ advances by ω̂_out·T = −W2 between two instants.
 * That rotation is exact at any speed. The stored state is not rotated, so it neither grows nor
 * drifts. Voltage and resistance act in the middle of the period: the voltage of the inverter is
 * constant in the stationary frame, and the current of k−1 is turned by half a step. To first order
 * in ωT this gives the weights of the paper.
 *
 * Feedback. Without it an error of the network turns with −ω̂ and decays with R/L only. Changes of
 * speed and the unknown part of the voltage excite this mode. Where T·R/L is small, this mode makes
 * the estimate lose the rotor. f damps the mode like a resistance f·L_d/T in series with R, but in
 * the error only: for e = 0 the network is that of the paper. For L_d = L_q
 *     e(k) = (1 − D)·exp(−jω̂T)·e(k−1) + …,  D = T·R/L_d + f,  R_v = R + f·L_d/T = D·L_d/T
 * The decay acts in the middle of the period on î − m·(î + e), m = f/D: D times this current is
 * T·R/L_d·î − f·e. î + e is the measured current. With f = 1 the state would follow the
 * measurement: e would hold the error of one tick only, and the estimate would lose the rotor. So f
 * stays small.
 *
 * Gradient. In b, x̂ and ŷ are the vector that W2 turns. A turn of the frame by δ also turns the
 * measured current, and changes e by δ·j·ψ_1 with
 *     ψ_c = x̂ − c·(L_q/L_d)·î_d + j·(ŷ − c·î_q),  c = 1
 * With the paper's c = 0 and L_q = L_d, b is δ·(φ/L_d)²·(1 + i_d·L_d/φ − ρ·i_q·L_d/φ): its loop
 * gain follows the current. With c = 1, b = e'_q·Re ψ_1 − e'_d·Im ψ_1 is δ·|ψ_1|² for every ρ, and
 * ψ_1 = φ/L_d where L_q = L_d.
 *
 * Static part. A constant voltage error ε causes a constant current error e, ε = (R_v + jωL)·e. A
 * wrong angle causes a back-EMF error along d, so Re ε shows the angle. The paper trains with Im e.
 * At low speed Im e shows the speed error, and the angle only with the share ωτ, τ = L/R_v. A
 * resistance error ΔR then turns the estimate by ΔR·i_q/(ωφ)/(ωτ). Turning e by the impedance angle
 * of the network, ρ = R_v/(ωL) = D/(ωT), gives e' = ε/(jωL), in which ΔR·i_q does not turn the
 * angle. ρ is limited, because it amplifies noise.
 *
 * Formats. Measured values and errors are Q15 of the current base I_b, voltages Q15 of U_b. States
 * are Q27 of I_x = 2^s·I_b, which covers the largest current vector plus φ/L_d. Speeds are step_t
 * (2^32 = one electrical turn a tick). Sine and cosine are Q15: the error of x̂ and ŷ is at most
 * 2·(|α| + |β|)·2^-15 plus one LSB of their output format.
 *
 * A tick calls nn_observer_predict, then nn_observer_train or nn_observer_follow. Control interrupt
 * only.
 */
#ifndef NN_OBSERVER_H
#define NN_OBSERVER_H

#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/* A weight is mantissa / 2^shift; mantissas are 0…32767. */
typedef struct {
    int32_t decay;           /* D = 1 − W1 + f; scale: I_b/I_x·2^(12 + weight_shift) */
    int32_t volt_gain;       /* W3/L_d; scale: U_b/I_x·2^(12 + weight_shift) */
    uint32_t weight_shift;   /* 2…15 */
    int32_t feedback_q15;    /* m = f/D, 0…32767; 0: none */
    int32_t flux_q27;        /* (φ/L_d)/I_x, the offset of x in (7), 1…2^27 − 1 */
    int32_t iq_gain_q14;     /* L_d/L_q: i_q = y·L_d/L_q, 1…32767 */
    int32_t saliency_q13;    /* L_q/L_d: converts an error of i_q to one of y, 1…32767 */
    uint32_t current_shift;  /* s, 0…9 */
    uint32_t gradient_shift; /* right shift of b, 4…12; below 12 where φ/L_d is small against I_b */
    /*
     * η and κ_p: steps = g·mantissa / 2^shift with the gradient g = b >> gradient_shift, saturated
     * to 16 bits.
     */
    int32_t eta;
    uint32_t eta_shift; /* 0…30 */
    int32_t kappa_p;
    uint32_t kappa_p_shift;  /* 0…30 */
    int32_t momentum_q15;    /* α */
    int32_t frame_share_q13; /* c of the gradient, 0…8192; 0: as in the paper */
    step_t speed_limit;      /* limit of |ω̂|, 1…2^29 */
    /* D/T as a speed, for ρ = corner/ω̂, 0…2^27: a D above 0.196 counts as 0.196 */
    step_t corner;
    int32_t rho_max_q13; /* limit of |ρ|, 0…32767; 0: off */
    /* ρ = 0 below this speed, because the back-EMF is too small there, 1…2^29 */
    step_t rho_speed_min;
} nn_observer_cfg_t;

typedef struct {
    int32_t alpha_q27; /* α component of x̂ + j·ŷ in the stationary frame, −2^27…2^27 − 1 */
    int32_t beta_q27;  /* β component, the same range */
    /*
     * the vector that is multiplied by e' to give b, Q15 of I_x, ±46341. c = 0: x̂, ŷ of the last
     * instant. c ≠ 0: ψ_c of the last refresh
     */
    dq_t state;
    /* ω̂(k+1), the integral (22): for the speed loop, limited to ±speed_limit */
    step_t speed;
    step_t speed_out;      /* ω̂_out: for the network and the angle, within ±2^29 */
    int32_t half_step_q15; /* half of ω̂·T at the last refresh, Q15 of 1 rad */
    dq_t current;          /* î_d, î_q, saturated at ±16384, the converters' full scale */
    dq_t error;            /* e_d, e_q, saturated to −8192…8191 (¼) */
    dq_t rotated_error; /* e', same range: d shows an error of the flux magnitude, q of the angle */
    step_t weight_step; /* ΔW2(k)/T, for the momentum term; −2^29…2^29 − 1 */
    int32_t gradient;   /* b >> gradient_shift in Q30 of I_b·I_x, saturated to 16 bits */
    int32_t rho_q13;    /* ρ in force */
    bool rotates;       /* ρ ≠ 0 or L_q ≠ L_d; else e' = e and its products are skipped */
} nn_observer_t;

/*
 * Start at the angle whose sine and cosine are given, with a current in that frame and a speed.
 * Zero current and speed mean a rotor at rest, x̂ = φ/L_d. speed is limited to ±speed_limit.
 * current: Q15 of I_b, |i| ≤ 65535, which two phases at full scale can give; x̂ and ŷ saturate to 28
 * bits.
 */
void nn_observer_start(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t speed, dq_t current,
                       sincos_t angle);

/*
 * Take over other weights. The states contain φ/L_d and L_q/L_d, so they change such that the
 * current of the network stays. The values of nn_observer_refresh() follow with its next call.
 * flux_q27, saliency_q13: values of the old weights. current_shift must be the same in old and new
 * weights. angle: the angle of the last nn_observer_predict(). Control interrupt only.
 */
void nn_observer_change(nn_observer_t *obs, const nn_observer_cfg_t *to, int32_t flux_q27,
                        int32_t saliency_q13, sincos_t angle);

/*
 * (14)–(18), the forward pass: state and errors at this instant. measured: i_d, i_q at this
 * instant, turned with θ̂, |i| ≤ 65535. voltage: applied by the inverter since the last instant,
 * stationary frame, |v| ≤ 32768. angle: sine and cosine of θ̂ at this instant, that is θ̂ of the last
 * instant plus speed_out. Total within these ranges: states, currents and errors saturate as stated
 * at their fields.
 */
void nn_observer_predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                         ab_t voltage, sincos_t angle);

/* (19)–(22): train W2 along the gradient. The speeds are limited as stated at their fields. */
void nn_observer_train(nn_observer_t *obs, const nn_observer_cfg_t *cfg);

/*
 * Sets W2. Call it instead of nn_observer_train() when the speed is known. speed: within
 * ±speed_limit.
 */
void nn_observer_follow(nn_observer_t *obs, step_t speed);

/*
 * Once a slow period in RUN: adds `change`, the change of the speed reference, to ω̂. By itself the
 * estimate follows a ramp with the delay T·κ_p/κ of the proportional path. While the rotor follows
 * its reference, this change is known before an error of the current shows it. Call the function
 * only then. In torque control, pass the change of speed that the torque causes. change: within
 * ±2^30. ω̂ is limited to ±speed_limit.
 */
void nn_observer_accelerate(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t change);

/*
 * Once a slow period, while the speed may change: computes ρ for rotor_speed, within ±2^30, the
 * half step by which the current is turned, and with c ≠ 0 ψ_c. Pass the most reliable speed, not
 * an estimate that still swings, because ρ takes the sign of rotor_speed. One division.
 */
void nn_observer_refresh(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t rotor_speed);

#endif
