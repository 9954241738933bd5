/* SPDX-License-Identifier: MIT */
/*
 * From the reading of an input to a demand, −1 to 1 in Q15.
 *
 * 1. Range: `middle` is 0, `high` is 1, `low` is −1, with a straight line on either side; beyond
 *    `high` and `low` the demand stays. With low = middle the input commands one way only.
 * 2. Dead band: |x| up to dead_q15 is 0; the rest of the side is stretched, so it begins at 0.
 * 3. Curve: (1 − e)·x + e·x³, with e = expo_q15: finer at small demands, the same at the ends.
 * 4. Share: times share_q15, whose sign is the direction.
 * 5. Slope: the demand moves to this value by at most slope_q30 in a tick.
 *
 * All steps are monotone, and round towards zero. Pure functions on their state. Context:
 * background.
 */
#ifndef THROTTLE_H
#define THROTTLE_H

#include "input_cfg.h"

#include <stdint.h>

/*
 * Steps 1 and 2. 0: the input is at rest. reading: 0…65535. Returns Q15, ±32767. With
 * high = middle, which config_check() refuses for an input, it is 0 or 1.
 */
int32_t throttle_share(const input_cfg_t *cfg, uint32_t reading);

/* Steps 3 and 4. x: Q15, ±32767. Returns Q15, ±32766. */
int32_t throttle_curve(const input_cfg_t *cfg, int32_t x);

/*
 * Step 5. demand_q30: the present demand, ±2^30; wanted_q15: ±32767; ticks: passed since the last
 * call. Returns the next demand, Q30.
 */
int32_t throttle_slope(const input_cfg_t *cfg, int32_t demand_q30, int32_t wanted_q15,
                       uint32_t ticks);

#endif
