/* SPDX-License-Identifier: MIT */
/*
 * Plane rotations without libm, so that every machine computes the same bits.
 *
 *   plant_rotation_from_angle  any |angle| < 1e6 rad, error < 1e-14 + |angle| * 2^-52
 *   plant_rotation_small       |angle| <= PLANT_ROTATION_SMALL_RAD, error < 1e-16 from truncation
 */
#ifndef PLANT_ROTATION_H
#define PLANT_ROTATION_H

#include <math.h>

#define PLANT_PI 3.14159265358979323846
#define PLANT_TWO_PI 6.28318530717958647693
#define PLANT_SQRT3 1.73205080756887729353

/* Largest angle of one incremental turn. The first dropped terms are x^11/11! and x^12/12!. */
#define PLANT_ROTATION_SMALL_RAD 0.2

typedef struct {
    double cosine;
    double sine;
} plant_rotation_t;

/* Power series, for |angle_rad| <= PLANT_ROTATION_SMALL_RAD. */
static inline plant_rotation_t plant_rotation_small(double angle_rad)
{
    const double x = angle_rad;
    const double y = x * x;
    const double sine =
        x * (1.0 - y * (1.0 / 6.0 - y * (1.0 / 120.0 - y * (1.0 / 5040.0 - y * (1.0 / 362880.0)))));
    const double cosine =
        1.0 - y * (0.5 - y * (1.0 / 24.0 -
                              y * (1.0 / 720.0 - y * (1.0 / 40320.0 - y * (1.0 / 3628800.0)))));
    const plant_rotation_t r = {cosine, sine};
    return r;
}

/* a after b: angles add. */
static inline plant_rotation_t plant_rotation_compose(plant_rotation_t a, plant_rotation_t b)
{
    const plant_rotation_t r = {a.cosine * b.cosine - a.sine * b.sine,
                                a.sine * b.cosine + a.cosine * b.sine};
    return r;
}

/* Length back to 1: one Newton step of the inverse root, error squared. */
static inline plant_rotation_t plant_rotation_unit(plant_rotation_t r)
{
    const double scale = 1.5 - 0.5 * (r.cosine * r.cosine + r.sine * r.sine);
    const plant_rotation_t unit = {scale * r.cosine, scale * r.sine};
    return unit;
}

/* Series of a sixteenth of the wrapped angle, doubled four times. */
static inline plant_rotation_t plant_rotation_from_angle(double angle_rad)
{
    const double wrapped = angle_rad - PLANT_TWO_PI * floor(angle_rad / PLANT_TWO_PI + 0.5);
    plant_rotation_t r = plant_rotation_small(wrapped / 16.0);
    for (int doubling = 0; doubling < 4; doubling++) {
        r = plant_rotation_compose(r, r);
    }
    return plant_rotation_unit(r);
}

#endif
