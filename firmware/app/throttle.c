/* SPDX-License-Identifier: MIT */
#include "throttle.h"

#include "fx.h"

#define ONE (FX_Q15_MAX)
#define Q15_TO_Q30 (32768)
#define STEP_MAX (0x3FFFFFFFU)

/* Returns part/whole in Q15, at most 1. part: 0…65535; whole: 0…32767. */
static int32_t ratio_q15(int32_t part, int32_t whole)
{
    return (part < whole) ? ((part * ONE) / whole) : ONE;
}

/* Returns the share of a side without its dead band, Q15. x: 0…32767. */
static int32_t beyond(int32_t x, int32_t dead_q15)
{
    return (x > dead_q15) ? ratio_q15(x - dead_q15, ONE - dead_q15) : 0;
}

int32_t throttle_share(const input_cfg_t *cfg, uint32_t reading)
{
    const int32_t from_middle = (int32_t)reading - cfg->middle;
    int32_t x = 0;

    if (from_middle > 0) {
        x = beyond(ratio_q15(from_middle, cfg->high - cfg->middle), cfg->dead_q15);
    } else if ((from_middle < 0) && (cfg->low < cfg->middle)) {
        x = -beyond(ratio_q15(-from_middle, cfg->middle - cfg->low), cfg->dead_q15);
    } else {
        /* at the middle, or below the range of an input for one way */
    }
    return x;
}

int32_t throttle_curve(const input_cfg_t *cfg, int32_t x)
{
    const int32_t square = (x * x) / Q15_TO_Q30;
    const int32_t cube = (square * x) / Q15_TO_Q30;
    const int32_t curve = x + ((cfg->expo_q15 * (cube - x)) / Q15_TO_Q30);

    return (curve * cfg->share_q15) / ONE;
}

int32_t throttle_slope(const input_cfg_t *cfg, int32_t demand_q30, int32_t wanted_q15,
                       uint32_t ticks)
{
    const uint64_t most = (uint64_t)fx_unsigned(cfg->slope_q30) * ticks;

    return fx_towards(demand_q30, wanted_q15 * Q15_TO_Q30,
                      (int32_t)((most < STEP_MAX) ? most : STEP_MAX));
}
