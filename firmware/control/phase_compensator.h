/* SPDX-License-Identifier: MIT */
/*
 * Phase compensator of a drive without current regulators, paper B (39)–(43).
 *
 * The inverter holds a voltage of magnitude U at the firing angle θ_s. What turns θ_s until no current flows along the
 * magnet's flux is the angle of the current vector against the q axis:
 *     α_r = atan2(i_d, max(|i_q|, current_min))             (40), in the direction of U, see below
 *     θ_s(n+1) = θ_s(n) + T·ω(n) + g·α_r(n−1)               (41), (43)
 *     β(n) = θ_s(n) − θ(n),  v_d = −U·sin β,  v_q = U·cos β
 * (43) accumulates α_r, and only that takes i_d to 0; the proportional form (42) would leave a rest of it. K2 = 1: ω is
 * what θ goes on by. At i_d = 0 the lead is β = atan(ω·L_q·i_q / (R·i_q + ω·φ)).
 *
 * Sign. A larger lead lowers i_d by U·(R·cos β + ω·L_q·sin β)/(R² + ω²·L_d·L_q), so α_r is taken in the direction of U,
 * which is that of rotation: backwards with the other sign. Not in that of i_q, with which (40) would turn round
 * while braking: the loop would then run away at any braking current. The slope itself turns round at
 * tan β = −R/(ω·L_q), and that of the torque over U at tan β = −R/(ω·L_d): `brake_max` keeps the lead above, and what
 * brakes harder does so with some i_d.
 *
 * A vector that is small against `current_min` is noise and has no angle: its α_r fades to 0 with it, and the lead
 * stays. With the vector's own angle α_r would jump between ±90° at no load and keep the currents swinging.
 *
 * Currents Q15 of any one base. Pure, total; once a control tick, control interrupt only. One division.
 */
#ifndef PHASE_COMPENSATOR_H
#define PHASE_COMPENSATOR_H

#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t gain;        /* g = gain / 2^(16 + gain_shift), 0…32767; 0: the lead stays for ever */
    uint32_t gain_shift; /* 0…15 */
    int32_t lead_max;    /* largest lead in the direction of U, 2^32 = one turn, 0…2^30 */
    int32_t brake_max;   /* largest lag, as lead_max */
    int32_t current_min; /* i_q below it counts as this, 1…32767 */
} phase_compensator_cfg_t;

typedef struct {
    angle_t angle;         /* θ_s of the next sample */
    int32_t current_angle; /* α_r of the last one, forwards as backwards, ±2^30 */
} phase_compensator_t;

/* From here on with θ_s = `angle`. */
void phase_compensator_start(phase_compensator_t *comp, angle_t angle);

/*
 * One sample: the lead β, 2^32 = one turn, within −brake_max…lead_max for a U forwards, mirrored backwards. θ_s
 * follows where the lead is limited. current: i_d, i_q at this instant, |i| ≤ 2^30, saturated to 16 bits; rotor: θ;
 * speed: by which θ goes on to the next instant. g·α_r is rounded down to 2^-32 turn, α_r is exact to 2^-17 turn.
 */
int32_t phase_compensator_step(phase_compensator_t *comp, const phase_compensator_cfg_t *cfg,
                               dq_t current, angle_t rotor, step_t speed, bool forwards);

#endif
