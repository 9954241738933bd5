/* SPDX-License-Identifier: MIT */
/*
 * Vectors of the plane in one register, and their turns: what the steps of the motor are written
 * in.
 */
#ifndef PLANT_PAIR_H
#define PLANT_PAIR_H

/*
 * Two components in one register, d then q or alpha then beta. The vector extension of gcc and
 * clang: half the instructions in the innermost loop, the same bits as component by component.
 */
typedef double pair_t __attribute__((vector_size(2 * sizeof(double))));

static inline pair_t swapped(pair_t a)
{
    return (pair_t){a[1], a[0]};
}

/* With a = swapped(x) * y the cross product of x and y. */
static inline double difference(pair_t a)
{
    return a[1] - a[0];
}

/*
 * The vector a right angle further on. A product, because gcc builds {-a[1], a[0]} component by
 * component.
 */
static inline pair_t ahead_of(pair_t a)
{
    return (pair_t){-1.0, 1.0} * swapped(a);
}

/* The vector after a turn forwards by r (cosine, sine), and seen from a frame turned by r. */
static inline pair_t turned(pair_t r, pair_t a)
{
    return r[0] * a + r[1] * ahead_of(a);
}

static inline pair_t turned_back(pair_t r, pair_t a)
{
    return r[0] * a - r[1] * ahead_of(a);
}

/*
 * Cosine and sine of a small angle, |turn| <= about 0.2, by power series up to 3e-14 (turn^10 /
 * 10!).
 */
static inline pair_t turn_of(double turn)
{
    const double y = turn * turn;
    const pair_t k1 = {1.0 / 2.0, 1.0 / 6.0};
    const pair_t k2 = {1.0 / 24.0, 1.0 / 120.0};
    const pair_t k3 = {1.0 / 720.0, 1.0 / 5040.0};
    const pair_t k4 = {1.0 / 40320.0, 1.0 / 362880.0};
    const pair_t first = {1.0, turn};
    return first * (1.0 - y * (k1 - y * (k2 - y * (k3 - y * k4))));
}

/*
 * Likewise of an angle given as the sum of three: second, much smaller, to second order; third,
 * smaller still, to first order. The later an angle is known, the fewer operations wait for it.
 */
static inline pair_t small_turn(double turn, double second, double third)
{
    const pair_t late = {1.0 - 0.5 * second * second, second};
    const pair_t by = turned(late, turn_of(turn));
    return by + third * ahead_of(by);
}

/* Voltage along a phase axis for a potential of its terminal: Clarke's factor. */
#define PLANT_CLARKE (2.0 / 3.0)

#endif
