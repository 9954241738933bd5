/* SPDX-License-Identifier: MIT */
#include "motor.h"

#include "check.h"

#define POLE_PAIRS_MAX 100U
#define ANGLE_MAX_RAD 1.0e6

/* Torque per unit of (potential of one terminal): Clarke's factor. */
#define CLARKE (2.0 / 3.0)

/* Two components in one register, d then q or alpha then beta. The vector extension of gcc and
 * clang: half the instructions in the innermost loop, the same bits as component by component. */
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

/* The vector after a turn forwards by r (cosine, sine), and seen from a frame turned by r. */
static inline pair_t turned(pair_t r, pair_t a)
{
    const pair_t sine = {-r[1], r[1]};
    return r[0] * a + sine * swapped(a);
}

static inline pair_t turned_back(pair_t r, pair_t a)
{
    const pair_t sine = {r[1], -r[1]};
    return r[0] * a + sine * swapped(a);
}

/* Cosine and sine of a small angle given as the sum of three: |turn| <= about PLANT_MOTOR_STEP, by
 * power series up to 3e-17 (turn^10 / 10!); second, much smaller, to second order; third, smaller
 * still, to first order. The later an angle is known, the fewer operations wait for it. */
static inline pair_t small_turn(double turn, double second, double third)
{
    const double y = turn * turn;
    const pair_t k1 = {1.0 / 2.0, 1.0 / 6.0};
    const pair_t k2 = {1.0 / 24.0, 1.0 / 120.0};
    const pair_t k3 = {1.0 / 720.0, 1.0 / 5040.0};
    const pair_t k4 = {1.0 / 40320.0, 1.0 / 362880.0};
    const pair_t first = {1.0, turn};
    const pair_t late = {1.0 - 0.5 * second * second, second};
    const pair_t by = turned(late, first * (1.0 - y * (k1 - y * (k2 - y * (k3 - y * k4)))));
    const pair_t across = {-by[1], by[0]};
    return by + third * across;
}

/* The state while it is worked on, in registers. */
typedef struct {
    pair_t flux;
    pair_t axis; /* cosine and sine of theta */
    double omega;
    double theta;
} core_t;

static inline core_t load(const plant_motor_t *motor)
{
    const plant_motor_state_t *now = &motor->now;
    return (core_t){
        {now->flux_d_wb, now->flux_q_wb},
        {now->cosine, now->sine},
        now->omega_el_rad_s,
        now->theta_el_rad,
    };
}

static inline void store(plant_motor_t *motor, const core_t *core)
{
    plant_motor_state_t *now = &motor->now;
    now->flux_d_wb = core->flux[0];
    now->flux_q_wb = core->flux[1];
    now->cosine = core->axis[0];
    now->sine = core->axis[1];
    now->omega_el_rad_s = core->omega;
    now->theta_el_rad = core->theta;
}

static inline pair_t inverse_inductance(const plant_motor_t *m)
{
    return (pair_t){m->inverse_d, m->inverse_q};
}

static inline pair_t magnet(const plant_motor_t *m)
{
    return (pair_t){m->flux_linkage_wb, 0.0};
}

static inline pair_t current_of(const plant_motor_t *m, pair_t flux)
{
    return inverse_inductance(m) * (flux - magnet(m));
}

static inline pair_t flux_of(const plant_motor_t *m, pair_t current)
{
    const pair_t inductance = {m->inductance_d_h, m->inductance_q_h};
    return inductance * current + magnet(m);
}

static inline double torque_of(const plant_motor_t *m, pair_t flux)
{
    return m->torque_factor * difference(swapped(flux) * current_of(m, flux));
}

/* ---- shaft ---------------------------------------------------------------------------------- */

/* What the shaft does for the length of a step: Coulomb friction does not change sign in it. */
typedef struct {
    double gain;    /* P/J, or 0 while the shaft sticks */
    double drag_nm; /* load and Coulomb torque */
} shaft_t;

static inline shaft_t shaft_of(const plant_motor_t *m, const core_t *core)
{
    shaft_t shaft = {m->acceleration, m->load_torque_nm};
    if (m->coulomb_nm > 0.0) {
        const double net = torque_of(m, core->flux) - m->load_torque_nm;
        const double direction = (core->omega != 0.0) ? core->omega : net;
        shaft.drag_nm += copysign(m->coulomb_nm, direction);
        if (core->omega == 0.0 && fabs(net) <= m->coulomb_nm) {
            shaft.gain = 0.0;
        }
    }
    return shaft;
}

/* Coulomb friction turned against the motion inside a step from speed before to speed after: the
 * shaft stops, or leaves zero speed with the friction reversed for what was left of the step.
 * By value, so that the caller's state need not be in memory. */
static double speed_past_zero(const plant_motor_t *m, pair_t flux, double before, double after,
                              double step_s)
{
    const double left_s = step_s * after / (after - before);
    const double net = torque_of(m, flux) - m->load_torque_nm;
    if (fabs(net) <= m->coulomb_nm) {
        return 0.0;
    }
    return m->acceleration * (net - copysign(m->coulomb_nm, net)) * left_s;
}

/* Takes over the speed at the end of a step. The flux must be that of the end already. */
static inline void shaft_finish(const plant_motor_t *m, core_t *core, double omega, double step_s)
{
    const double before = core->omega;
    core->omega = omega;
    if (m->coulomb_nm > 0.0 && before * omega < 0.0) {
        core->omega = speed_past_zero(m, core->flux, before, omega, step_s);
    }
}

/* Turns the rotor by the sum; returns cosine and sine of it. */
static inline pair_t shaft_turn(core_t *core, double turn, double second, double third)
{
    const pair_t by = small_turn(turn, second, third);
    core->axis = turned(by, core->axis);
    core->theta += turn + (second + third);
    return by;
}

/* ---- configuration -------------------------------------------------------------------------- */

static const char *motor_bad_field(const plant_motor_cfg_t *cfg)
{
    const plant_check_t checks[] = {
        {"motor.pole_pairs", cfg->pole_pairs >= 1U && cfg->pole_pairs <= POLE_PAIRS_MAX},
        {"motor.resistance_ohm", plant_is_not_negative(cfg->resistance_ohm)},
        {"motor.inductance_d_h", plant_is_positive(cfg->inductance_d_h)},
        {"motor.inductance_q_h", plant_is_positive(cfg->inductance_q_h)},
        {"motor.flux_linkage_wb", plant_is_not_negative(cfg->flux_linkage_wb)},
        {"motor.inertia_kg_m2", plant_is_positive(cfg->inertia_kg_m2)},
        {"motor.viscous_friction_nm_s", plant_is_not_negative(cfg->viscous_friction_nm_s)},
        {"motor.coulomb_friction_nm", plant_is_not_negative(cfg->coulomb_friction_nm)},
        {"motor.initial_angle_el_rad", fabs(cfg->initial_angle_el_rad) < ANGLE_MAX_RAD},
        {"motor.initial_speed_mech_rad_s", isfinite(cfg->initial_speed_mech_rad_s)},
    };
    return plant_first_bad(checks, sizeof checks / sizeof checks[0]);
}

static void derive_constants(plant_motor_t *motor, const plant_motor_cfg_t *cfg)
{
    const double pairs = (double)cfg->pole_pairs;
    const double l_d = cfg->inductance_d_h;
    const double l_q = cfg->inductance_q_h;
    const double l_min = fmin(l_d, l_q);
    motor->pole_pairs = pairs;
    motor->resistance_ohm = cfg->resistance_ohm;
    motor->inductance_d_h = l_d;
    motor->inductance_q_h = l_q;
    motor->flux_linkage_wb = cfg->flux_linkage_wb;
    motor->inverse_d = 1.0 / l_d;
    motor->inverse_q = 1.0 / l_q;
    motor->decay_d = cfg->resistance_ohm / l_d;
    motor->decay_q = cfg->resistance_ohm / l_q;
    motor->cross_d = l_q / l_d;
    motor->cross_q = l_d / l_q;
    motor->emf_d = cfg->flux_linkage_wb / l_d;
    motor->emf_q = cfg->flux_linkage_wb / l_q;
    motor->saliency = motor->inverse_d - motor->inverse_q;
    motor->torque_factor = 1.5 * pairs;
    motor->torque_magnet = 1.5 * pairs * cfg->flux_linkage_wb;
    motor->torque_salient = 1.5 * pairs * (l_d - l_q);
    motor->acceleration = pairs / cfg->inertia_kg_m2;
    motor->decay_shaft = cfg->viscous_friction_nm_s / cfg->inertia_kg_m2;
    motor->coulomb_nm = cfg->coulomb_friction_nm;
    motor->free_acceleration = motor->acceleration;
    motor->free_decay_shaft = motor->decay_shaft;
    motor->rate_constant = cfg->resistance_ohm / l_min + motor->decay_shaft +
                           sqrt(motor->torque_magnet * motor->acceleration * motor->emf_q);
    motor->rate_speed = fmax(motor->cross_d, motor->cross_q);
}

bool plant_motor_init(plant_motor_t *motor, const plant_motor_cfg_t *cfg, const char **bad_field)
{
    *bad_field = motor_bad_field(cfg);
    if (*bad_field != NULL) {
        return false;
    }
    derive_constants(motor, cfg);
    const plant_rotation_t r = plant_rotation_from_angle(cfg->initial_angle_el_rad);
    motor->now.flux_d_wb = cfg->flux_linkage_wb;
    motor->now.flux_q_wb = 0.0;
    motor->now.cosine = r.cosine;
    motor->now.sine = r.sine;
    motor->now.omega_el_rad_s = motor->pole_pairs * cfg->initial_speed_mech_rad_s;
    motor->now.theta_el_rad = cfg->initial_angle_el_rad;
    motor->turns_el = 0;
    motor->load_torque_nm = 0.0;
    plant_motor_wrap(motor);
    return true;
}

/* ---- read-outs ------------------------------------------------------------------------------ */

double plant_motor_torque(const plant_motor_t *motor)
{
    return torque_of(motor, load(motor).flux);
}

plant_vector_t plant_motor_current(const plant_motor_t *motor)
{
    const core_t core = load(motor);
    const pair_t current = turned(core.axis, current_of(motor, core.flux));
    return (plant_vector_t){current[0], current[1]};
}

plant_vector_t plant_motor_emf(const plant_motor_t *motor)
{
    const double peak = motor->now.omega_el_rad_s * motor->flux_linkage_wb;
    return (plant_vector_t){-peak * motor->now.sine, peak * motor->now.cosine};
}

double plant_motor_angle_mech(const plant_motor_t *motor)
{
    return (motor->now.theta_el_rad + PLANT_TWO_PI * (double)motor->turns_el) / motor->pole_pairs;
}

/* A shaft of infinite inertia that stands: the steps need no look at a flag. */
void plant_motor_block(plant_motor_t *motor, bool blocked)
{
    motor->acceleration = blocked ? 0.0 : motor->free_acceleration;
    motor->decay_shaft = blocked ? 0.0 : motor->free_decay_shaft;
    motor->now.omega_el_rad_s = blocked ? 0.0 : motor->now.omega_el_rad_s;
}

void plant_motor_turn(plant_motor_t *motor, double angle_el_rad)
{
    core_t core = load(motor);
    const plant_rotation_t r = plant_rotation_from_angle(angle_el_rad);
    const pair_t by = {r.cosine, r.sine};
    core.flux = flux_of(motor, turned_back(by, current_of(motor, core.flux)));
    core.axis = turned(by, core.axis);
    core.theta += angle_el_rad;
    store(motor, &core);
    plant_motor_wrap(motor);
}

void plant_motor_wrap(plant_motor_t *motor)
{
    plant_motor_state_t *now = &motor->now;
    plant_rotation_t r = {now->cosine, now->sine};
    if (now->theta_el_rad >= PLANT_PI || now->theta_el_rad < -PLANT_PI) {
        const double turns = floor(now->theta_el_rad / PLANT_TWO_PI + 0.5);
        now->theta_el_rad -= PLANT_TWO_PI * turns;
        motor->turns_el += (int64_t)turns;
        r = plant_rotation_from_angle(now->theta_el_rad);
    }
    r = plant_rotation_unit(r);
    now->cosine = r.cosine;
    now->sine = r.sine;
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
static void run(plant_motor_t *motor, unsigned count, const plant_interval_t interval[],
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

void plant_motor_step_driven(plant_motor_t *motor, double step_s, plant_vector_t v)
{
    const plant_interval_t interval = {step_s, v};
    run(motor, 1, &interval, 0.0);
}

void plant_motor_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[])
{
    run(motor, count, interval, plant_motor_rate(motor));
}

/* ---- one phase floating: Runge-Kutta -------------------------------------------------------- */

typedef struct {
    pair_t current;
    double omega;
    double theta; /* from the beginning of the step */
} point_t;

/* Current slope with the floating terminal at zero, all in the rotor frame of the moment, and the
 * potential that terminal must have for the current along n to stay at zero. */
static inline double tied_slope(const plant_motor_t *m, const point_t *at, pair_t v, pair_t n,
                                pair_t *slope)
{
    const pair_t turning = {at->omega, -at->omega};
    const pair_t inverse = inverse_inductance(m);
    const pair_t flux = flux_of(m, at->current);
    const pair_t free = inverse * (v - m->resistance_ohm * at->current + turning * swapped(flux));
    const pair_t along = n * (free - turning * swapped(at->current));
    const pair_t compliance = CLARKE * (n * n * inverse);
    const double potential = -(along[0] + along[1]) / (compliance[0] + compliance[1]);
    *slope = free + (CLARKE * potential) * (inverse * n);
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

void plant_motor_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
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

double plant_motor_floating_potential(const plant_motor_t *motor, plant_vector_t v,
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

void plant_motor_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    core_t core = load(motor);
    const pair_t direction = {axis.alpha, axis.beta};
    core.flux =
        flux_of(motor, without(current_of(motor, core.flux), turned_back(core.axis, direction)));
    store(motor, &core);
}

/* ---- no current ----------------------------------------------------------------------------- */

void plant_motor_step_open(plant_motor_t *motor, double step_s)
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
