/* SPDX-License-Identifier: MIT */
#include "knee.h"

#include <stddef.h>

/* As fmax() of two numbers, without its call. */
static inline double larger(double a, double b)
{
    return (a > b) ? a : b;
}

static bool is_in(uint32_t mask, unsigned leg)
{
    return ((mask >> leg) & 1U) != 0U;
}

static bool is_open(const plant_segment_t *segment, unsigned leg)
{
    return !is_in((uint32_t)segment->high | segment->low, leg);
}

/* Potentials without current, and what they lose with one. Of a leg whose wire is open: nothing. */
static void resolve_legs(const plant_segment_t *segment, const plant_rails_t *rails,
                         double middle_v[PLANT_LEGS], plant_soft_legs_t *legs)
{
    legs->knee_a = rails->knee_a;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        const bool broken = is_in(rails->broken, leg);
        const bool open = is_open(segment, leg);
        const double half_v = 0.5 * rails->bus_v;
        const double closed_v = is_in(segment->high, leg) ? rails->bus_v : 0.0;
        middle_v[leg] = broken ? 0.0 : (open ? half_v : closed_v);
        legs->half_v[leg] = broken ? 0.0 : (open ? half_v + rails->drop_v : rails->drop_v);
    }
}

/* Current out of the positive rail. */
static double rail_current(const plant_motor_t *motor, const plant_segment_t *segment,
                           const plant_rails_t *rails)
{
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(motor), current);
    double sum = 0.0;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        if (is_in(segment->high, leg)) {
            sum += current[leg];
        } else if (is_open(segment, leg)) {
            sum += 0.5 * (1.0 - plant_share_lost(current[leg], rails->knee_a)) * current[leg];
        }
    }
    return sum;
}

/*
 * At most so fast does the motor follow the legs, 1/s. Their slope is largest at zero current, half
 * / (2 knee), and falls with the square of the current beyond the knee: what counts is the least
 * that a current can come to by the end.
 */
static double legs_rate(const plant_motor_t *motor, const plant_soft_legs_t *legs, double bus_v,
                        double duration_s)
{
    const double inverse = motor->windings.compliance * plant_motor_growth(motor) *
                           larger(motor->inverse_d, motor->inverse_q);
    const double emf_v = fabs(motor->now.omega_el_rad_s) * motor->flux_linkage_wb;
    const double swing_a = (bus_v + emf_v) * inverse * duration_s;
    double current[PLANT_LEGS];
    double slope = 0.0;
    plant_phases(plant_motor_current(motor), current);
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        const double least = larger(fabs(current[leg]) - swing_a, legs->knee_a);
        slope = larger(slope, 0.5 * legs->half_v[leg] * legs->knee_a / (least * least));
    }
    return slope * inverse;
}

/* The axis of the one phase that is broken, NULL if none is. */
static const plant_vector_t *floating_axis(uint32_t broken)
{
    const plant_vector_t *axis = NULL;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        axis = is_in(broken, leg) ? &plant_bridge_axis[leg] : axis;
    }
    return axis;
}

void plant_knee_run(plant_motor_t *motor, const plant_segment_t *segment,
                    const plant_rails_t *rails, double *charge_c)
{
    double middle[PLANT_LEGS];
    plant_soft_legs_t legs;
    resolve_legs(segment, rails, middle, &legs);
    const double whole_s = segment->duration_s;
    const double by_legs = legs_rate(motor, &legs, rails->bus_v, whole_s);
    const double by_motor = plant_motor_rate(motor);
    const plant_source_t source = {
        .constant = plant_clarke(middle[0], middle[1], middle[2]),
        .rate = larger(by_motor, by_legs),
        .legs = &legs,
    };
    const plant_vector_t *const axis = floating_axis(rails->broken);
    const double effort = larger(by_motor / motor->step_bound, by_legs / PLANT_MOTOR_FED_STEP);
    const double steps = plant_motor_steps(effort * whole_s);
    const double step_s = whole_s / steps;
    double before_a = (charge_c != NULL) ? rail_current(motor, segment, rails) : 0.0;
    for (int64_t left = (int64_t)steps; left > 0; left--) {
        plant_motor_step_fed(motor, step_s, &source, axis);
        if (charge_c != NULL) {
            const double after_a = rail_current(motor, segment, rails);
            *charge_c += 0.5 * step_s * (before_a + after_a);
            before_a = after_a;
        }
    }
}
