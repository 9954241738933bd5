/* SPDX-License-Identifier: MIT */
/*
 * The motor and the inverter of example_cfg.h, as far as a closed loop in a unit test needs them.
 */
#ifndef EXAMPLE_MOTOR_H
#define EXAMPLE_MOTOR_H

#include "drive.h"

#include <math.h>

#define EXAMPLE_PI (3.141592653589793)

/* Motor A on an average inverter: rotor frame, 20 steps of Euler's method a tick. */
typedef struct {
    double d;
    double q;
    double speed; /* electrical, rad/s */
    double angle;
    compare_t acting;
} example_motor_t;

static inline example_motor_t example_motor_at(double angle, double speed)
{
    return (example_motor_t){
        .speed = speed, .angle = angle, .acting = {.phase = {4250U, 4250U, 4250U}}};
}

/*
 * One period with the compare values of the tick before; those of `out` act in the next. Open
 * gates: the diodes end the current at once, as the EMF stays below the bus.
 */
static inline void example_motor_tick(example_motor_t *m, const drive_out_t *out, double load_nm)
{
    const double a = m->acting.phase[0];
    const double b = m->acting.phase[1];
    const double c = m->acting.phase[2];
    const double volt = 310.0 / 8500.0;
    const double alpha = volt * ((2.0 * a) - b - c) / 3.0;
    const double beta = volt * (b - c) / sqrt(3.0);

    for (int32_t i = 0; i < 20; i++) {
        const double h = 1e-4 / 20.0;
        const double v_d = (alpha * cos(m->angle)) + (beta * sin(m->angle));
        const double v_q = (beta * cos(m->angle)) - (alpha * sin(m->angle));
        const double torque = 3.0 * 0.387 * m->q;
        const double d = (v_d - (2.125 * m->d) + (m->speed * 0.0116 * m->q)) / 0.0116;
        const double q = (v_q - (2.125 * m->q) - (m->speed * ((0.0116 * m->d) + 0.387))) / 0.0116;

        m->d = out->gate_enable ? (m->d + (h * d)) : 0.0;
        m->q = out->gate_enable ? (m->q + (h * q)) : 0.0;
        m->speed += h * 2.0 / 0.003 * (torque - load_nm - (0.001 * m->speed / 2.0));
        m->angle += h * m->speed;
    }
    m->acting = out->compare;
}

static inline uint16_t example_motor_counts(double ampere)
{
    return (uint16_t)(2048.0 + floor((ampere / 20.0 * 2048.0) + 0.5));
}

/* What the converter reads of both currents. */
static inline void example_motor_measure(const example_motor_t *m, drive_in_t *in)
{
    const double shifted = m->angle - (2.0 * EXAMPLE_PI / 3.0);

    in->adc_ia = example_motor_counts((m->d * cos(m->angle)) - (m->q * sin(m->angle)));
    in->adc_ib = example_motor_counts((m->d * cos(shifted)) - (m->q * sin(shifted)));
}

#endif
