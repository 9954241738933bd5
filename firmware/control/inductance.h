/* SPDX-License-Identifier: MIT */
/*
 * L_d and L_q of a motor whose rotor rests on an imposed current, from the response of that current
 * to two test voltages.
 *
 *   pulse   the voltage across the current is +V, −V, −V, +V, each for a quarter of the pulse. The
 *           current across rises, falls to the other side and comes back. So the rotor gets no
 *           momentum. The sum of these four changes, each with the sign of its voltage, is the
 *           response. The effects of the resistance, the dead time and the rotor on the response
 *           are odd in the current and cancel to first order
 *   step    the voltage along the current falls by V for some ticks. The fall of the current is the
 *           response
 *
 * The current control pauses meanwhile; otherwise the voltage would not be known.
 *
 * Voltage that the resistance takes. Δi = B·∫(v − R·i)dt, where B is the inverse of the inductances
 * in the frame of the current. The currents are summed up too. Their mean times the measured R is
 * subtracted from the test voltage.
 *
 * Load angle. A load turns the rotor out of the direction of the current by an angle δ. Then B is
 * not diagonal, and a voltage across also changes the current along the vector. For any δ below
 * 45°:
 *     1/L_d, 1/L_q = (B_dd + B_qq)/2 ± √((B_dd − B_qq)²/4 + B_dq²)
 *
 * Rotor. During the pulse the torque turns the rotor forward and back. The rotor's EMF makes L_q
 * look smaller by a share ω_x²·t²/3, with ω_x² = 1.5·P²·φ²/(J·L_q) and t the duration of a quarter.
 * The pulse leaves the rotor displaced by 2·(V·t/L_q)/I·(ω_n·t)², with ω_n² = 1.5·P²·φ·I/J.
 *
 * Pure, total. Currents Q15 of I_b, voltages Q15 of U_b.
 */
#ifndef INDUCTANCE_H
#define INDUCTANCE_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t pulse_ticks;  /* ticks of a quarter of the pulse, 1…16 */
    int32_t pulse_voltage; /* V of the pulse, 1…32767 */
    /*
     * sum of the current changes that the pulse would cause with the configured L_d and no
     * resistance, each with the sign of the voltage: 4·V·t/L_d, t = one quarter, 1…65535
     */
    int32_t pulse_response;
    uint32_t step_ticks;   /* ticks of the step, 2…16 */
    int32_t step_voltage;  /* V of the step, 1…32767 */
    int32_t step_response; /* the same for the step: V·t/L_d, 1…16384 */
} inductance_cfg_t;

typedef struct {
    dq_t change; /* sum of the changes of the current, each with the sign of the voltage */
    /* twice the sum over the ticks of the current along the voltage, with the voltage's sign */
    int32_t carried;
} inductance_response_t;

typedef struct {
    int32_t start_d; /* i_d before the step */
    inductance_response_t pulse;
    inductance_response_t step;
} inductance_t;

#define INDUCTANCE_UNKNOWN (-1)

typedef struct {
    int32_t ratio_q14;    /* L_d / configured L_d, 1…32767 */
    int32_t saliency_q13; /* L_q/L_d, 1…32767 */
} inductance_result_t;

/*
 * Whether the current control pauses in this tick. tick: 1 is the first tick of the test, 0 the
 * tick before it.
 */
bool inductance_holds_voltage(const inductance_cfg_t *cfg, uint32_t tick);

/*
 * Returns the change of the demanded voltage in this tick, ±65534. Between two changes the voltage
 * stays.
 */
dq_t inductance_voltage(const inductance_cfg_t *cfg, uint32_t tick);

/*
 * One tick of the test. tick: 1, 2, 3 … current: measured in the frame of the imposed current,
 * ±34400. *test must be zero before the first tick. Returns whether this was the last tick.
 */
bool inductance_step(inductance_t *test, const inductance_cfg_t *cfg, uint32_t tick, dq_t current);

/*
 * Call it after the last tick. resistance_q13: U_b/I_b, 0…32767. A result that the responses do not
 * give is INDUCTANCE_UNKNOWN; if L_d is unknown, both are. Nine divisions and a square root.
 */
inductance_result_t inductance_result(const inductance_t *test, const inductance_cfg_t *cfg,
                                      int32_t resistance_q13);

#endif
