/* SPDX-License-Identifier: MIT */
#include "iron.h"

#include <math.h>

/* Newton steps of plant_iron_flux: at most 12 for 30 I_s. */
#define NEWTON_MAX 60

/* Of the currents: the roundings of some ten operations. */
#define NEWTON_END 1.0e-14

/* Of what keeps the q axis invertible where i_d < 0 has taken all iron's flux away. */
#define SHARED_MARGIN 0.9

static double bend_of_d(double fall)
{
    const double left = 1.0 - fall;
    return fall / (left * left * (4.0 - fall));
}

static double bend_of_q(double fall)
{
    const double left = 1.0 - fall;
    return fall / (left * left * left);
}

/* There 1 - C/(2 L_q I_s) is left of 1/L_q. */
double plant_iron_shared_max(const plant_iron_cfg_t *cfg)
{
    const double bends = bend_of_d(cfg->fall_d) * bend_of_q(cfg->fall_q);
    const double squared = bends * cfg->inductance_d_h / cfg->inductance_q_h;
    return (squared > 0.0) ? fmin(SHARED_MARGIN / sqrt(squared), 1.0) : 1.0;
}

void plant_iron_init(plant_iron_t *iron, const plant_iron_cfg_t *cfg)
{
    const double flux_d = cfg->inductance_d_h * cfg->current_a;
    const double flux_q = cfg->inductance_q_h * cfg->current_a;
    iron->saturates = cfg->fall_d > 0.0 || cfg->fall_q > 0.0;
    iron->current_a = cfg->current_a;
    iron->per_flux = (plant_dq_t){1.0 / flux_d, 1.0 / flux_q};
    iron->inverse = (plant_dq_t){1.0 / cfg->inductance_d_h, 1.0 / cfg->inductance_q_h};
    iron->bend_d = bend_of_d(cfg->fall_d);
    iron->bend_q = bend_of_q(cfg->fall_q);
    const double common = cfg->shared * 2.0 * sqrt(iron->bend_d * iron->bend_q * flux_d * flux_q);
    iron->cross_d = common / flux_d;
    iron->cross_q = common / flux_q;
}

plant_dq_t plant_iron_flux(const plant_iron_t *iron, plant_dq_t current)
{
    plant_dq_t flux = {current.d / iron->inverse.d, current.q / iron->inverse.q};
    const double end_a = NEWTON_END * (iron->current_a + fabs(current.d) + fabs(current.q));
    for (int k = 0; k < NEWTON_MAX; k++) {
        const plant_dq_t now = plant_iron_current(iron, flux);
        const double over_d = now.d - current.d;
        const double over_q = now.q - current.q;
        if (fabs(over_d) + fabs(over_q) <= end_a) {
            break;
        }
        const plant_stiffness_t s = plant_iron_stiffness(iron, flux);
        const double area = s.straight.d * s.straight.q - s.cross * s.cross;
        flux.d -= (s.straight.q * over_d - s.cross * over_q) / area;
        flux.q -= (s.straight.d * over_q - s.cross * over_d) / area;
    }
    return flux;
}
