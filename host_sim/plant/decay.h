/* SPDX-License-Identifier: MIT */
/*
 * exp(-x) without libm, so that every machine computes the same bits.
 *
 *   plant_decay  any x >= 0, error < 2e-13
 */
#ifndef PLANT_DECAY_H
#define PLANT_DECAY_H

/* Beyond it exp(-x) < 2e-18 counts as nothing. */
#define PLANT_DECAY_END 41.0

#define PLANT_DECAY_SQUARINGS 10

/*
 * Power series of x / 2^10 <= 0.041, squared ten times. The first dropped term is y^8 / 8! <=
 * 2e-16. A squaring doubles the relative error and adds a rounding of 2^-53: in all 2^10 (2e-16 /
 * e^-y + 2^-53) of the result.
 */
static inline double plant_decay(double x)
{
    if (!(x < PLANT_DECAY_END)) {
        return 0.0;
    }
    const double y = x / (double)(1UL << PLANT_DECAY_SQUARINGS);
    double result =
        1.0 -
        y * (1.0 - y * (1.0 / 2.0 -
                        y * (1.0 / 6.0 - y * (1.0 / 24.0 - y * (1.0 / 120.0 -
                                                                y * (1.0 / 720.0 - y / 5040.0))))));
    for (int k = 0; k < PLANT_DECAY_SQUARINGS; k++) {
        result *= result;
    }
    return result;
}

#endif
