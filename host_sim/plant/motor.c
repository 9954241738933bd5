#include "motor.h"

#include "check.h"

#define POLE_PAIRS_MAX 100U
#define ANGLE_MAX_RAD 1.0e6

/* Torque per unit of (potential of one terminal): Clarke's factor. */
#define CLARKE (2.0 / 3.0)

/* Turns a stationary vector into the frame of r. */
static inline plant_vector_t into_frame(plant_rotation_t r, plant_vector_t u)
{
    return (plant_vector_t){r.cosine * u.alpha + r.sine * u.beta,
                            r.cosine * u.beta - r.sine * u.alpha};
}

static inline void set_current(plant_motor_t *motor, double i_d_a, double i_q_a)
{
    motor->flux_d_wb = motor->inductance_d_h * i_d_a + motor->flux_linkage_wb;
    motor->flux_q_wb = motor->inductance_q_h * i_q_a;
}

/* ---- shaft ---------------------------------------------------------------------------------- */

/* What the shaft does for the length of a step: Coulomb friction does not change sign in it. */
typedef struct {
    double gain;    /* P/J, or 0 while the shaft sticks */
    double drag_nm; /* load and Coulomb torque */
} shaft_t;

static inline shaft_t shaft_now(const plant_motor_t *motor)
{
    shaft_t shaft = {motor->acceleration, motor->load_torque_nm};
    if (motor->coulomb_nm > 0.0) {
        const double omega = motor->omega_el_rad_s;
        const double net = plant_motor_torque(motor) - motor->load_torque_nm;
        const double direction = (omega != 0.0) ? omega : net;
        shaft.drag_nm += copysign(motor->coulomb_nm, direction);
        if (omega == 0.0 && fabs(net) <= motor->coulomb_nm) {
            shaft.gain = 0.0;
        }
    }
    return shaft;
}

/* Coulomb friction turned against the motion inside a step that began at omega_before: the shaft
 * stops, or leaves zero speed with the friction reversed for what was left of the step. */
static void shaft_pass_zero(plant_motor_t *motor, double omega_before, double step_s)
{
    const double omega_after = motor->omega_el_rad_s;
    const double left_s = step_s * omega_after / (omega_after - omega_before);
    const double net = plant_motor_torque(motor) - motor->load_torque_nm;
    if (fabs(net) <= motor->coulomb_nm) {
        motor->omega_el_rad_s = 0.0;
    } else {
        const double driving = net - copysign(motor->coulomb_nm, net);
        motor->omega_el_rad_s = motor->acceleration * driving * left_s;
    }
}

/* Takes over the speed at the end of a step. */
static inline void shaft_finish(plant_motor_t *motor, double omega, double step_s)
{
    const double before = motor->omega_el_rad_s;
    motor->omega_el_rad_s = omega;
    if (motor->coulomb_nm > 0.0 && before * omega < 0.0) {
        shaft_pass_zero(motor, before, step_s);
    }
}

/* Turns the rotor by both angles and returns that rotation. The turn at constant speed is known
 * early; what acceleration adds is small and comes late, so it is applied to second order. */
static inline plant_rotation_t shaft_turn(plant_motor_t *motor, double turn_rad, double extra_rad)
{
    const plant_rotation_t extra = {1.0 - 0.5 * extra_rad * extra_rad, extra_rad};
    const plant_rotation_t by = plant_rotation_compose(plant_rotation_small(turn_rad), extra);
    motor->rotation = plant_rotation_compose(motor->rotation, by);
    motor->theta_el_rad += turn_rad + extra_rad;
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
    set_current(motor, 0.0, 0.0);
    motor->omega_el_rad_s = motor->pole_pairs * cfg->initial_speed_mech_rad_s;
    motor->theta_el_rad = cfg->initial_angle_el_rad;
    motor->turns_el = 0;
    motor->rotation = plant_rotation_from_angle(cfg->initial_angle_el_rad);
    motor->load_torque_nm = 0.0;
    plant_motor_wrap(motor);
    return true;
}

/* ---- read-outs ------------------------------------------------------------------------------ */

plant_vector_t plant_motor_current(const plant_motor_t *motor)
{
    const plant_rotation_t r = motor->rotation;
    const double i_d = plant_motor_i_d(motor);
    const double i_q = plant_motor_i_q(motor);
    return (plant_vector_t){r.cosine * i_d - r.sine * i_q, r.sine * i_d + r.cosine * i_q};
}

plant_vector_t plant_motor_emf(const plant_motor_t *motor)
{
    const double peak = motor->omega_el_rad_s * motor->flux_linkage_wb;
    return (plant_vector_t){-peak * motor->rotation.sine, peak * motor->rotation.cosine};
}

double plant_motor_angle_mech(const plant_motor_t *motor)
{
    return (motor->theta_el_rad + PLANT_TWO_PI * (double)motor->turns_el) / motor->pole_pairs;
}

void plant_motor_wrap(plant_motor_t *motor)
{
    if (motor->theta_el_rad >= PLANT_PI || motor->theta_el_rad < -PLANT_PI) {
        const double turns = floor(motor->theta_el_rad / PLANT_TWO_PI + 0.5);
        motor->theta_el_rad -= PLANT_TWO_PI * turns;
        motor->turns_el += (int64_t)turns;
        motor->rotation = plant_rotation_from_angle(motor->theta_el_rad);
    }
    motor->rotation = plant_rotation_unit(motor->rotation);
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
    double d;
    double q;
} pair_t;

static inline double cross(pair_t a, pair_t b)
{
    return a.d * b.q - a.q * b.d;
}

/* Derivatives of the flux linkage and of the current in the held frame. */
typedef struct {
    pair_t flux;
    pair_t flux_1;
    pair_t flux_2;
    pair_t flux_3;
    pair_t current;
    pair_t current_1;
    pair_t current_2;
} series_t;

static inline series_t expand(const plant_motor_t *m, plant_vector_t u, double w)
{
    series_t s;
    const double r = m->resistance_ohm;
    s.flux = (pair_t){m->flux_d_wb, m->flux_q_wb};
    s.current = (pair_t){plant_motor_i_d(m), plant_motor_i_q(m)};
    s.flux_1 = (pair_t){u.alpha - r * s.current.d, u.beta - r * s.current.q};
    const pair_t by_angle = {m->saliency * s.flux.q, m->saliency * s.flux.d - m->emf_d};
    s.current_1 = (pair_t){m->inverse_d * s.flux_1.d + w * by_angle.d,
                           m->inverse_q * s.flux_1.q + w * by_angle.q};
    s.flux_2 = (pair_t){-r * s.current_1.d, -r * s.current_1.q};
    const double twist = m->saliency * 2.0 * w;
    const double ww = w * w;
    s.current_2 = (pair_t){
        m->inverse_d * s.flux_2.d +
            (twist * s.flux_1.q - ww * (2.0 * m->saliency * s.flux.d - m->emf_d)),
        m->inverse_q * s.flux_2.q + (twist * s.flux_1.d + ww * (2.0 * m->saliency * s.flux.q)),
    };
    s.flux_3 = (pair_t){-r * s.current_2.d, -r * s.current_2.q};
    return s;
}

static inline void step_driven(plant_motor_t *m, double h, plant_vector_t v)
{
    const shaft_t shaft = shaft_now(m);
    const double w = m->omega_el_rad_s;
    const series_t s = expand(m, into_frame(m->rotation, v), w);
    const double gain = shaft.gain * m->torque_factor;
    const double w_1 =
        gain * cross(s.flux, s.current) - (shaft.gain * shaft.drag_nm + m->decay_shaft * w);
    const double w_2 =
        gain * (cross(s.flux_1, s.current) + cross(s.flux, s.current_1)) - m->decay_shaft * w_1;
    const double w_3 = gain * (cross(s.flux_2, s.current) + 2.0 * cross(s.flux_1, s.current_1) +
                               cross(s.flux, s.current_2)) -
                       m->decay_shaft * w_2;

    const double h2 = h * h * (1.0 / 2.0);
    const double h3 = h * h2 * (1.0 / 3.0);
    const double d = (s.flux.d + h * s.flux_1.d) + (h2 * s.flux_2.d + h3 * s.flux_3.d);
    const double q = (s.flux.q + h * s.flux_1.q) + (h2 * s.flux_2.q + h3 * s.flux_3.q);
    const plant_rotation_t by = shaft_turn(m, h * w, h2 * w_1 + h3 * w_2);
    m->flux_d_wb = by.cosine * d + by.sine * q;
    m->flux_q_wb = by.cosine * q - by.sine * d;
    shaft_finish(m, (w + h * w_1) + (h2 * w_2 + h3 * w_3), h);
}

void plant_motor_step_driven(plant_motor_t *motor, double step_s, plant_vector_t v)
{
    step_driven(motor, step_s, v);
}

void plant_motor_run_driven(plant_motor_t *motor, double duration_s, plant_vector_t v)
{
    const double effort = duration_s * plant_motor_rate(motor);
    if (effort <= PLANT_MOTOR_STEP) {
        step_driven(motor, duration_s, v);
        return;
    }
    const double steps = ceil(effort / PLANT_MOTOR_STEP);
    const double step_s = duration_s / steps;
    for (double done = 0.0; done < steps; done += 1.0) {
        step_driven(motor, step_s, v);
    }
}

/* ---- one phase floating: Runge-Kutta -------------------------------------------------------- */

typedef struct {
    double d;
    double q;
    double w;
    double theta; /* from the beginning of the step */
} point_t;

/* Current derivatives with the floating terminal at zero, and the potential that terminal must
 * have for the current along n (axis, rotor frame) to stay at zero. */
static double tied_slope(const plant_motor_t *m, const point_t *at, plant_vector_t v,
                         plant_vector_t n, plant_vector_t *slope)
{
    const double d = m->inverse_d * v.alpha - m->decay_d * at->d + m->cross_d * at->w * at->q;
    const double q =
        m->inverse_q * v.beta - m->decay_q * at->q - at->w * (m->cross_q * at->d + m->emf_q);
    const double along = n.alpha * (d - at->w * at->q) + n.beta * (q + at->w * at->d);
    const double compliance =
        CLARKE * (n.alpha * n.alpha * m->inverse_d + n.beta * n.beta * m->inverse_q);
    const double potential = -along / compliance;
    slope->alpha = d + CLARKE * m->inverse_d * n.alpha * potential;
    slope->beta = q + CLARKE * m->inverse_q * n.beta * potential;
    return potential;
}

static point_t tied_derivative(const plant_motor_t *m, const point_t *at, plant_vector_t v,
                               plant_vector_t axis, shaft_t shaft)
{
    const plant_rotation_t r = plant_rotation_compose(m->rotation, plant_rotation_small(at->theta));
    plant_vector_t slope;
    (void)tied_slope(m, at, into_frame(r, v), into_frame(r, axis), &slope);
    const double torque = (m->torque_magnet + m->torque_salient * at->d) * at->q;
    return (point_t){slope.alpha, slope.beta,
                     shaft.gain * (torque - shaft.drag_nm) - m->decay_shaft * at->w, at->w};
}

static inline point_t along(const point_t *from, const point_t *slope, double step)
{
    return (point_t){from->d + step * slope->d, from->q + step * slope->q,
                     from->w + step * slope->w, from->theta + step * slope->theta};
}

void plant_motor_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis)
{
    const shaft_t shaft = shaft_now(motor);
    const point_t start = {plant_motor_i_d(motor), plant_motor_i_q(motor), motor->omega_el_rad_s,
                           0.0};
    const point_t k1 = tied_derivative(motor, &start, v, axis, shaft);
    const point_t p2 = along(&start, &k1, 0.5 * step_s);
    const point_t k2 = tied_derivative(motor, &p2, v, axis, shaft);
    const point_t p3 = along(&start, &k2, 0.5 * step_s);
    const point_t k3 = tied_derivative(motor, &p3, v, axis, shaft);
    const point_t p4 = along(&start, &k3, step_s);
    const point_t k4 = tied_derivative(motor, &p4, v, axis, shaft);
    point_t end = along(&start, &k1, step_s / 6.0);
    end = along(&end, &k2, step_s / 3.0);
    end = along(&end, &k3, step_s / 3.0);
    end = along(&end, &k4, step_s / 6.0);
    set_current(motor, end.d, end.q);
    (void)shaft_turn(motor, step_s * start.w, end.theta - step_s * start.w);
    shaft_finish(motor, end.w, step_s);
    plant_motor_clear_phase(motor, axis);
}

double plant_motor_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis)
{
    const point_t here = {plant_motor_i_d(motor), plant_motor_i_q(motor), motor->omega_el_rad_s,
                          0.0};
    plant_vector_t slope;
    return tied_slope(motor, &here, into_frame(motor->rotation, v),
                      into_frame(motor->rotation, axis), &slope);
}

void plant_motor_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    const plant_vector_t n = into_frame(motor->rotation, axis);
    const double i_d = plant_motor_i_d(motor);
    const double i_q = plant_motor_i_q(motor);
    const double residue = n.alpha * i_d + n.beta * i_q;
    set_current(motor, i_d - residue * n.alpha, i_q - residue * n.beta);
}

/* ---- no current ----------------------------------------------------------------------------- */

void plant_motor_step_open(plant_motor_t *motor, double step_s)
{
    set_current(motor, 0.0, 0.0);
    const shaft_t shaft = shaft_now(motor);
    const double w0 = motor->omega_el_rad_s;
    const double decay = step_s * motor->decay_shaft;
    const double w1 = -step_s * shaft.gain * shaft.drag_nm - decay * w0;
    const double w2 = -decay * w1 * (1.0 / 2.0);
    const double w3 = -decay * w2 * (1.0 / 3.0);
    const double w4 = -decay * w3 * (1.0 / 4.0);
    const double extra = step_s * (w1 * (1.0 / 2.0) + (w2 * (1.0 / 3.0) + w3 * (1.0 / 4.0)));
    (void)shaft_turn(motor, step_s * w0, extra);
    shaft_finish(motor, w0 + (w1 + (w2 + (w3 + w4))), step_s);
}
