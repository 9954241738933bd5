/* SPDX-License-Identifier: MIT */
/*
 * Phase compensator of a drive without current regulators, paper B (39)–(43).
 *
 * The inverter applies a voltage of magnitude U at the firing angle θ_s. The compensator turns θ_s
 * until i_d = 0. Its input is the angle of the current vector against the q axis:
 *     α_r = atan2(i_d, max(|i_q|, current_min))             (40), sign: see Sign
 *     θ_s(n+1) = θ_s(n) + T·ω(n) + g·α_r(n−1)               (41), (43)
 *     β(n) = θ_s(n) − θ(n),  v_d = −U·sin β,  v_q = U·cos β
 * (43) accumulates α_r, so i_d becomes exactly 0. The proportional form (42) would leave an i_d. K2
 * is 1, because ω is the advance of θ itself. At i_d = 0 the lead is β = atan(ω·L_q·i_q / (R·i_q +
 * ω·φ)).
 *
 * Sign. A larger lead lowers i_d, by U·(R·cos β + ω·L_q·sin β)/(R² + ω²·L_d·L_q) per unit of angle.
 * So α_r is counted in the direction of U, which is the direction of rotation: for backward
 * rotation α_r is negated. It must not be counted in the direction of i_q, because (40) would then
 * change its sign while braking, and the loop would run away at any braking current. di_d/dβ
 * changes its sign at tan β = −R/(ω·L_q). The derivative of the torque with respect to U changes
 * its sign at tan β = −R/(ω·L_d). `brake_max` keeps the lead above the second of these angles.
 * During harder braking i_d is not 0.
 *
 * No load. The angle of a vector that is small against `current_min` is noise. In (40) α_r fades to
 * 0 with the magnitude of the vector, and the lead stays. If α_r were the angle of the vector
 * itself, it would jump between ±90° at no load and keep the currents swinging.
 *
 * Currents Q15 of any common base. Pure, total. Call once a control tick, from the control
 * interrupt only. One division.
 */
#ifndef PHASE_COMPENSATOR_H
#define PHASE_COMPENSATOR_H

#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t gain;        /* g = gain / 2^(16 + gain_shift), 0…32767; 0: the lead stays as it is */
    uint32_t gain_shift; /* 0…15 */
    int32_t lead_max;    /* largest lead in the direction of U, 2^32 = one turn, 0…2^30 */
    int32_t brake_max;   /* largest lag in the direction of U, same unit and range as lead_max */
    int32_t current_min; /* |i_q| counts as at least this in (40), 1…32767 */
} phase_compensator_cfg_t;

typedef struct {
    angle_t angle; /* θ_s of the next sample */
    /* α_r of the last sample, not yet negated for backward rotation, ±2^30 */
    int32_t current_angle;
} phase_compensator_t;

/* Start with θ_s = `angle`. */
void phase_compensator_start(phase_compensator_t *comp, angle_t angle);

/*
 * One sample. Returns the lead β, 2^32 = one turn, within −brake_max…lead_max when U is forwards,
 * mirrored when it is backwards. When the lead is limited, θ_s is set to the limited angle.
 * current: i_d, i_q at this instant, |i| ≤ 2^30, saturated to 16 bits. rotor: θ. speed: advance of
 * θ to the next instant. g·α_r is rounded down to 2^-32 turn; the error of α_r is at most 2^-17
 * turn.
 */
int32_t phase_compensator_step(phase_compensator_t *comp, const phase_compensator_cfg_t *cfg,
                               dq_t current, angle_t rotor, step_t speed, bool forwards);

#endif
