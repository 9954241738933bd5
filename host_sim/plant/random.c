/* SPDX-License-Identifier: MIT */
#include "random.h"

/* Counter step: the odd integer nearest 2^64 / golden ratio, so the counter visits every state. */
#define WEYL_STEP UINT64_C(0x9E3779B97F4A7C15)

/* Odd multipliers of the output mixer. */
#define MIX_A UINT64_C(0xBF58476D1CE4E5B9)
#define MIX_B UINT64_C(0x94D049BB133111EB)

#define LANE_BITS 16U
#define LANE_MASK UINT64_C(0xFFFF)
#define LANES_PER_DRAW 4
#define DRAWS_PER_DEVIATE 3

/* Twelve lanes of mean (2^16 - 1) / 2. */
#define DEVIATE_MEAN (12.0 * 65535.0 / 2.0)

/* A lane has variance (2^32 - 1) / 12, so the sum of twelve has the square of this. */
#define DEVIATE_SIGMA 65535.99999237060502

void plant_random_init(plant_random_t *random, uint64_t seed)
{
    random->state = seed;
}

uint64_t plant_random_bits(plant_random_t *random)
{
    random->state += WEYL_STEP;
    uint64_t z = random->state;
    z = (z ^ (z >> 30U)) * MIX_A;
    z = (z ^ (z >> 27U)) * MIX_B;
    return z ^ (z >> 31U);
}

double plant_random_gaussian(plant_random_t *random)
{
    uint64_t sum = 0;
    for (int draw = 0; draw < DRAWS_PER_DEVIATE; draw++) {
        uint64_t bits = plant_random_bits(random);
        for (int lane = 0; lane < LANES_PER_DRAW; lane++) {
            sum += bits & LANE_MASK;
            bits >>= LANE_BITS;
        }
    }
    return ((double)sum - DEVIATE_MEAN) / DEVIATE_SIGMA;
}
