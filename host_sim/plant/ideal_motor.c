/* SPDX-License-Identifier: MIT */
#include "motor_inside.h"

/* ---- shaft ---------------------------------------------------------------------------------- */

static inline shaft_t shaft_of(const plant_motor_t *m, const core_t *core)
{
    shaft_t shaft = {m->acceleration, m->load_torque_nm};
    if (m->coulomb_nm > 0.0) {
        add_friction(m, torque_of(m, core->flux) - m->load_torque_nm, core->omega, &shaft);
    }
    return shaft;
}

/* Takes over the speed at the end of a step. The flux must be that of the end already. */
static inline void shaft_finish(const plant_motor_t *m, core_t *core, double omega, double step_s)
{
    const double before = core->omega;
    core->omega = omega;
    if (m->coulomb_nm > 0.0 && before * omega < 0.0) {
        const double net_nm = torque_of(m, core->flux) - m->load_torque_nm;
        core->omega = speed_past_zero(m, net_nm, before, omega, step_s);
    }
}

/* ---- all phases driven: Taylor series ------------------------------------------------------- */

/*
 * For the length of one step the rotor frame of its beginning is held still. In it the voltage u
 * is constant and the flux linkage psi obeys psi' = u - R i, so only the small resistive part
 * needs a series. With M(delta) the inverse inductance seen from a rotor turned by delta,
 *   i = M psi - phi/L_d e,   M = m0 + m1 [cos 2 delta, sin 2 delta; sin 2 delta, -cos 2 delta],
 *   i' = M psi' + w i_delta,
 *   i'' = M psi'' + 2 w M_delta psi' + w^2 i_delta_delta + w' i_delta, at delta = 0.
 */
typedef struct {
    pair_t flux; /* and its derivatives */
    pair_t flux_1;
    pair_t flux_2;
    pair_t flux_3;
    pair_t current; /* and its derivatives */
    pair_t current_1;
    pair_t current_2;
} series_t;

static inline series_t expand(const plant_motor_t *m, pair_t flux, pair_t voltage, double w,
                              double w_1)
{
    const pair_t inverse = inverse_inductance(m);
    const pair_t emf = {m->emf_d, 0.0};
    const double r = m->resistance_ohm;
    const double k = m->saliency;
    const pair_t k_flip = {-2.0 * k, 2.0 * k};
    series_t s;
    s.flux = flux;
    s.current = current_of(m, flux);
    s.flux_1 = voltage - r * s.current;
    const pair_t by_angle = k * swapped(flux) - swapped(emf);
    s.current_1 = inverse * s.flux_1 + w * by_angle;
    s.flux_2 = -r * s.current_1;
    s.current_2 = inverse * s.flux_2 + (2.0 * k * w * swapped(s.flux_1) +
                                        ((w * w) * (k_flip * flux + emf) + w_1 * by_angle));
    s.flux_3 = -r * s.current_2;
    return s;
}

static inline void advance(const plant_motor_t *m, core_t *core, double h, pair_t v)
{
    const shaft_t shaft = shaft_of(m, core);
    const double gain = shaft.gain * m->torque_factor;
    const double slow = m->decay_shaft;
    const double w = core->omega;
    const double w_1 = gain * difference(swapped(core->flux) * current_of(m, core->flux)) -
                       (shaft.gain * shaft.drag_nm + slow * w);
    const series_t s = expand(m, core->flux, turned_back(core->axis, v), w, w_1);
    const pair_t flux_x = swapped(s.flux);
    const pair_t flux_1_x = swapped(s.flux_1);
    const double w_2 = gain * difference(flux_1_x * s.current + flux_x * s.current_1) - slow * w_1;
    const double w_3 = gain * difference(swapped(s.flux_2) * s.current +
                                         (2.0 * flux_1_x * s.current_1 + flux_x * s.current_2)) -
                       slow * w_2;

    const double h2 = h * h * (1.0 / 2.0);
    const double h3 = h * h2 * (1.0 / 3.0);
    const pair_t flux = (s.flux + h * s.flux_1) + (h2 * s.flux_2 + h3 * s.flux_3);
    core->flux = turned_back(shaft_turn(core, h * w, h2 * w_1, h3 * w_2), flux);
    shaft_finish(m, core, (w + h * w_1) + (h2 * w_2 + h3 * w_3), h);
}

/* The only caller of advance, so that it is inlined here and the state stays in registers. */
void plant_ideal_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[],
                            double rate)
{
    core_t core = load(motor);
    for (unsigned k = 0; k < count; k++) {
        const pair_t v = {interval[k].v.alpha, interval[k].v.beta};
        const double effort = interval[k].duration_s * rate;
        double step_s = interval[k].duration_s;
        int64_t steps = 1;
        if (effort > PLANT_MOTOR_STEP) {
            steps = (int64_t)ceil(effort / PLANT_MOTOR_STEP);
            step_s /= (double)steps;
        }
        for (; steps > 0; steps--) {
            advance(motor, &core, step_s, v);
        }
    }
    store(motor, &core);
}

/* ---- one phase floating: Runge-Kutta -------------------------------------------------------- */

typedef struct {
    pair_t current;
    double omega;
    double theta; /* from the beginning of the step */
} point_t;

/*
 * Current slope with the floating terminal at zero, all in the rotor frame of the moment, and the
 * potential that terminal must have for the current along n to stay at zero.
 */
static inline double tied_slope(const plant_motor_t *m, const point_t *at, pair_t v, pair_t n,
                                pair_t *slope)
{
    const pair_t turning = {at->omega, -at->omega};
    const pair_t inverse = inverse_inductance(m);
    const pair_t flux = flux_of(m, at->current);
    const pair_t free = inverse * (v - m->resistance_ohm * at->current + turning * swapped(flux));
    const pair_t along = n * (free - turning * swapped(at->current));
    const pair_t compliance = PLANT_CLARKE * (n * n * inverse);
    const double potential = -(along[0] + along[1]) / (compliance[0] + compliance[1]);
    *slope = free + (PLANT_CLARKE * potential) * (inverse * n);
    return potential;
}

typedef struct {
    pair_t v;
    pair_t axis;
    pair_t rotor;
    shaft_t shaft;
} tied_t;

static point_t tied_derivative(const plant_motor_t *m, const tied_t *tied, const point_t *at)
{
    const pair_t rotor = turned(small_turn(at->theta, 0.0, 0.0), tied->rotor);
    point_t derivative;
    (void)tied_slope(m, at, turned_back(rotor, tied->v), turned_back(rotor, tied->axis),
                     &derivative.current);
    const double torque = torque_of(m, flux_of(m, at->current));
    derivative.omega =
        tied->shaft.gain * (torque - tied->shaft.drag_nm) - m->decay_shaft * at->omega;
    derivative.theta = at->omega;
    return derivative;
}

static inline point_t moved(const point_t *from, const point_t *slope, double step)
{
    return (point_t){from->current + step * slope->current, from->omega + step * slope->omega,
                     from->theta + step * slope->theta};
}

/* Takes the current along a phase axis away. */
static inline pair_t without(pair_t current, pair_t n)
{
    const pair_t along = n * current;
    return current - (along[0] + along[1]) * n;
}

void plant_ideal_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis)
{
    core_t core = load(motor);
    const tied_t tied = {
        {v.alpha, v.beta}, {axis.alpha, axis.beta}, core.axis, shaft_of(motor, &core)};
    const point_t start = {current_of(motor, core.flux), core.omega, 0.0};
    const point_t k1 = tied_derivative(motor, &tied, &start);
    const point_t p2 = moved(&start, &k1, 0.5 * step_s);
    const point_t k2 = tied_derivative(motor, &tied, &p2);
    const point_t p3 = moved(&start, &k2, 0.5 * step_s);
    const point_t k3 = tied_derivative(motor, &tied, &p3);
    const point_t p4 = moved(&start, &k3, step_s);
    const point_t k4 = tied_derivative(motor, &tied, &p4);
    point_t end = moved(&start, &k1, step_s * (1.0 / 6.0));
    end = moved(&end, &k2, step_s * (1.0 / 3.0));
    end = moved(&end, &k3, step_s * (1.0 / 3.0));
    end = moved(&end, &k4, step_s * (1.0 / 6.0));

    (void)shaft_turn(&core, step_s * start.omega, end.theta - step_s * start.omega, 0.0);
    core.flux = flux_of(motor, without(end.current, turned_back(core.axis, tied.axis)));
    shaft_finish(motor, &core, end.omega, step_s);
    store(motor, &core);
}

double plant_ideal_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis)
{
    const core_t core = load(motor);
    const point_t here = {current_of(motor, core.flux), core.omega, 0.0};
    const pair_t voltage = {v.alpha, v.beta};
    const pair_t direction = {axis.alpha, axis.beta};
    pair_t slope;
    return tied_slope(motor, &here, turned_back(core.axis, voltage),
                      turned_back(core.axis, direction), &slope);
}

void plant_ideal_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    core_t core = load(motor);
    const pair_t direction = {axis.alpha, axis.beta};
    core.flux =
        flux_of(motor, without(current_of(motor, core.flux), turned_back(core.axis, direction)));
    store(motor, &core);
}

/* ---- no current ----------------------------------------------------------------------------- */

void plant_ideal_step_open(plant_motor_t *motor, double step_s)
{
    core_t core = load(motor);
    core.flux = magnet(motor);
    const shaft_t shaft = shaft_of(motor, &core);
    const double decay = step_s * motor->decay_shaft;
    const double w1 = -step_s * shaft.gain * shaft.drag_nm - decay * core.omega;
    const double w2 = -decay * w1 * (1.0 / 2.0);
    const double w3 = -decay * w2 * (1.0 / 3.0);
    const double w4 = -decay * w3 * (1.0 / 4.0);
    const double extra = step_s * (w1 * (1.0 / 2.0) + (w2 * (1.0 / 3.0) + w3 * (1.0 / 4.0)));
    (void)shaft_turn(&core, step_s * core.omega, extra, 0.0);
    shaft_finish(motor, &core, core.omega + (w1 + (w2 + (w3 + w4))), step_s);
    store(motor, &core);
}
