/* SPDX-License-Identifier: MIT */
/*
 * Seedable noise source: the same seed gives the same sequence on every machine
 * (integer arithmetic only up to the last multiplication).
 */
#ifndef PLANT_RANDOM_H
#define PLANT_RANDOM_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint64_t state;
} plant_random_t;

/* Any seed is valid, 0 included. */
void plant_random_init(plant_random_t *random, uint64_t seed);

/* Uniform 64 bits, period 2^64. */
uint64_t plant_random_bits(plant_random_t *random);

/*
 * Zero mean, unit variance, bell shaped: the sum of twelve uniform 16-bit numbers.
 * |result| < 6; excess kurtosis -0.1, so beyond 3 sigma it is rarer than a true normal deviate
 * (0.0020 instead of 0.0027 of all samples). Resolution 2^-16.
 */
double plant_random_gaussian(plant_random_t *random);

#ifdef __cplusplus
}
#endif

#endif
