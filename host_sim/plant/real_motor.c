/* SPDX-License-Identifier: MIT */
#include "motor_inside.h"

#include <stddef.h>

/*
 * Up to this rate * step x the midpoint method does. In the held frame only R times the current is
 * integrated, of which it misses the share x^2/24 = 2.5e-6. Most steps between two switchings are
 * that short.
 */
#define MIDPOINT_STEP 0.0078

/*
 * Runge-Kutta methods. For the length of a step the rotor frame of its beginning is held still, as
 * in ideal_motor.c: a constant voltage is constant there, and the flux linkage obeys psi' = v - R
 * i.
 */
typedef struct {
    pair_t flux;  /* held frame, magnet included */
    double omega; /* electrical */
    double turn;  /* of the rotor since the beginning, electrical */
    pair_t load;  /* twist of an elastic shaft and speed behind it, mechanical */
} point_t;

/* Cosine and sine of multiples of the rotor's angle. */
typedef struct {
    pair_t sixth;   /* 6 theta */
    pair_t cogging; /* N theta_m */
} waves_t;

/* The rotor, in its own frame. */
typedef struct {
    pair_t flux;
    pair_t own; /* flux linkage of the currents alone */
    pair_t current;
    pair_t by_angle; /* derivative of the magnet's flux linkage by the electrical angle */
    double cogging_nm;
} rotor_t;

/* What is the same for all of a step. */
typedef struct {
    const plant_motor_t *m;
    const plant_source_t *source; /* NULL: there is no current */
    bool is_tied;
    pair_t tied;    /* axis of the phase without current, held frame */
    pair_t held;    /* cosine and sine of the held frame */
    pair_t voltage; /* the source's constant, held frame */
    waves_t waves;  /* at the beginning */
    rotor_t rotor;  /* likewise */
    shaft_t shaft;
} context_t;

/* ---- rotor ---------------------------------------------------------------------------------- */

static inline pair_t sixth_power(pair_t r)
{
    const pair_t cube = turned(turned(r, r), r);
    return turned(cube, cube);
}

static inline waves_t waves_now(const plant_motor_t *m)
{
    const plant_motor_state_t *now = &m->now;
    return (waves_t){sixth_power((pair_t){now->cosine, now->sine}),
                     {now->cogging_cosine, now->cogging_sine}};
}

/* The waves after a turn of the rotor, small; `by` is its cosine and sine. */
static inline pair_t sixth_after(const waves_t *from, pair_t by)
{
    return turned(sixth_power(by), from->sixth);
}

static inline pair_t cogging_after(const plant_motor_t *m, const waves_t *from, double turn)
{
    return (m->cogging_nm > 0.0) ? turned(turn_of(m->cogging_ratio * turn), from->cogging)
                                 : from->cogging;
}

static inline waves_t waves_after(const plant_motor_t *m, const waves_t *from, double turn,
                                  pair_t by)
{
    return (waves_t){sixth_after(from, by), cogging_after(m, from, turn)};
}

/* Flux linkage of the magnet alone. */
static inline pair_t magnet_of(const plant_motor_t *m, const waves_t *waves)
{
    const pair_t harmonic = {m->harmonic_d_wb, m->harmonic_q_wb};
    return magnet(m) + harmonic * waves->sixth;
}

static inline plant_dq_t dq_of(pair_t a)
{
    return (plant_dq_t){a[0], a[1]};
}

static inline pair_t pair_of(plant_dq_t a)
{
    return (pair_t){a.d, a.q};
}

/* Of the flux linkage of the currents alone. */
static inline pair_t current_for(const plant_motor_t *m, pair_t flux)
{
    return m->iron.saturates ? pair_of(plant_iron_current(&m->iron, dq_of(flux)))
                             : inverse_inductance(m) * flux;
}

static inline rotor_t rotor_of(const plant_motor_t *m, const waves_t *waves, pair_t flux)
{
    const pair_t quarter = {-6.0 * m->harmonic_d_wb, 6.0 * m->harmonic_q_wb};
    const pair_t own = flux - magnet_of(m, waves);
    return (rotor_t){
        flux,
        own,
        current_for(m, own),
        quarter * swapped(waves->sixth),
        m->cogging_nm * waves->cogging[1],
    };
}

static inline double dot(pair_t a, pair_t b)
{
    const pair_t product = a * b;
    return product[0] + product[1];
}

static inline double torque_at(const plant_motor_t *m, const rotor_t *rotor)
{
    const double field = difference(swapped(rotor->flux) * rotor->current);
    return m->torque_factor * (field + dot(rotor->by_angle, rotor->current)) - rotor->cogging_nm;
}

/* As the motor stands. */
static inline rotor_t rotor_now(const plant_motor_t *m)
{
    const waves_t waves = waves_now(m);
    return rotor_of(m, &waves, load(m).flux);
}

pair_t plant_real_current(const plant_motor_t *motor)
{
    return rotor_now(motor).current;
}

double plant_real_torque(const plant_motor_t *motor)
{
    const rotor_t rotor = rotor_now(motor);
    return torque_at(motor, &rotor);
}

pair_t plant_real_flux(const plant_motor_t *motor, pair_t current)
{
    const pair_t inductance = {motor->inductance_d_h, motor->inductance_q_h};
    const waves_t waves = waves_now(motor);
    const pair_t own = motor->iron.saturates
                           ? pair_of(plant_iron_flux(&motor->iron, dq_of(current)))
                           : inductance * current;
    return own + magnet_of(motor, &waves);
}

plant_vector_t plant_real_emf(const plant_motor_t *motor)
{
    const core_t core = load(motor);
    const waves_t waves = waves_now(motor);
    const pair_t flux = magnet_of(motor, &waves);
    const rotor_t rotor = rotor_of(motor, &waves, flux);
    const pair_t emf = core.omega * turned(core.axis, rotor.by_angle + ahead_of(flux));
    return (plant_vector_t){emf[0], emf[1]};
}

/*
 * The whole turns, in periods of the cogging less whole ones, exactly: N turns mod P of them, over
 * P.
 */
void plant_real_place_cogging(plant_motor_t *motor)
{
    const double order = motor->cogging_ratio * motor->pole_pairs;
    const int64_t pairs = (int64_t)motor->pole_pairs;
    const int64_t part = ((motor->turns_el % pairs) * (int64_t)(order + 0.5)) % pairs;
    const double turns = (double)part / motor->pole_pairs;
    const plant_rotation_t r = plant_rotation_from_angle(
        motor->cogging_ratio * motor->now.theta_el_rad + PLANT_TWO_PI * turns);
    motor->now.cogging_cosine = r.cosine;
    motor->now.cogging_sine = r.sine;
}

/* ---- elastic shaft -------------------------------------------------------------------------- */

static inline bool is_elastic(const plant_motor_t *m)
{
    return m->load_gain > 0.0;
}

static inline pair_t load_now(const plant_motor_t *m)
{
    return (pair_t){m->now.twist_rad, m->now.load_speed_rad_s};
}

/* T_S of motor.h, from the rotor's electrical speed, and twist and speed of the load. */
static inline double twisting_torque(const plant_motor_t *m, double omega, pair_t load)
{
    return m->stiffness_nm * load[0] + m->damping_nm_s * (omega / m->pole_pairs - load[1]);
}

/* What the rotor has to drive, as the motor stands. */
static double load_torque(const plant_motor_t *m)
{
    return is_elastic(m) ? twisting_torque(m, m->now.omega_el_rad_s, load_now(m))
                         : m->load_torque_nm;
}

/* ---- stiffness ------------------------------------------------------------------------------ */

static inline plant_stiffness_t stiffness_at(const plant_motor_t *m, const rotor_t *rotor)
{
    const plant_stiffness_t linear = {{m->inverse_d, m->inverse_q}, 0.0};
    return m->iron.saturates ? plant_iron_stiffness(&m->iron, dq_of(rotor->own)) : linear;
}

/* How the currents change with a flux. */
static inline pair_t yielding(const plant_stiffness_t *s, pair_t flux)
{
    return pair_of(s->straight) * flux + s->cross * swapped(flux);
}

double plant_real_growth(const plant_motor_t *motor)
{
    const rotor_t rotor = rotor_now(motor);
    const plant_stiffness_t s = stiffness_at(motor, &rotor);
    /* The larger eigenvalue is below the sum of the larger term and the cross one. */
    const double largest = fmax(s.straight.d, s.straight.q) + fabs(s.cross);
    return fmax(largest / fmax(motor->inverse_d, motor->inverse_q), 1.0);
}

/* plant_motor_rate, as the motor stands. */
static double rate_now(const plant_motor_t *motor)
{
    const double rate = plant_motor_linear_rate(motor);
    return motor->iron.saturates ? rate * plant_real_growth(motor) : rate;
}

/* ---- slopes --------------------------------------------------------------------------------- */

/* The part of the voltage that follows the current, held frame. */
static inline pair_t following(const context_t *c, pair_t current)
{
    if (c->source->legs == NULL) {
        return (pair_t){0.0, 0.0};
    }
    const plant_windings_t *windings = &c->m->windings;
    const pair_t m = turned(c->held, current);
    const plant_vector_t i = plant_windings_inside(windings, (plant_vector_t){m[0], m[1]});
    const plant_vector_t v = plant_windings_inside(windings, plant_soft_legs_v(c->source->legs, i));
    return turned_back(c->held, (pair_t){v.alpha, v.beta});
}

/* What the resistance takes; both in the frame of an axis. */
static inline pair_t resistive(const plant_motor_t *m, pair_t axis, pair_t current)
{
    if (m->windings.are_alike) {
        return m->resistance_ohm * current;
    }
    return turned_back(axis, by_matrix(&m->windings.resistance, turned(axis, current)));
}

/*
 * The potential of the floating terminal that keeps the current along n at zero, for a voltage v
 * without it; v, n in the rotor frame, which is that of the axis.
 */
static inline double potential_at(const plant_motor_t *m, const rotor_t *rotor, double omega,
                                  pair_t axis, pair_t v, pair_t n)
{
    const pair_t turning = {omega, -omega};
    const plant_stiffness_t s = stiffness_at(m, rotor);
    const pair_t emf = turning * swapped(rotor->flux) - omega * rotor->by_angle;
    const pair_t free = yielding(&s, v - resistive(m, axis, rotor->current) + emf);
    const double along = dot(n, free - turning * swapped(rotor->current));
    return -along / (PLANT_CLARKE * dot(n, yielding(&s, n)));
}

/* With the rotor turned by `by` since the beginning; current: its current, held frame. */
static inline pair_t flux_slope(const context_t *c, const rotor_t *rotor, double omega, pair_t by,
                                pair_t current)
{
    pair_t voltage = c->voltage + following(c, current);
    if (c->is_tied) {
        const pair_t v = turned_back(by, voltage);
        const double potential =
            potential_at(c->m, rotor, omega, turned(by, c->held), v, turned_back(by, c->tied));
        voltage += (PLANT_CLARKE * potential) * c->tied;
    }
    return voltage - resistive(c->m, c->held, current);
}

/* All but that of the flux. */
static inline point_t motion_slope(const context_t *c, const rotor_t *rotor, const point_t *at)
{
    const plant_motor_t *m = c->m;
    point_t slope = {.turn = at->omega};
    double drag_nm = c->shaft.drag_nm;
    if (is_elastic(m)) {
        const double twisting_nm = twisting_torque(m, at->omega, at->load);
        drag_nm += twisting_nm;
        slope.load = (pair_t){at->omega / m->pole_pairs - at->load[1],
                              m->load_gain * (twisting_nm - m->load_torque_nm)};
    }
    slope.omega = c->shaft.gain * (torque_at(m, rotor) - drag_nm) - m->decay_shaft * at->omega;
    return slope;
}

/*
 * slope_at where the rotor has not turned yet, every second slope of the midpoint method: nothing
 * has to be turned.
 */
static inline point_t first_slope(const context_t *c, const point_t *at)
{
    const pair_t by = {1.0, 0.0};
    point_t slope = motion_slope(c, &c->rotor, at);
    if (c->source != NULL) {
        slope.flux = flux_slope(c, &c->rotor, at->omega, by, c->rotor.current);
    }
    return slope;
}

/*
 * In line, because a call costs a sixth of a run: its points would go through memory, written
 * number by number and read pair by pair, which the processor has to wait for.
 */
__attribute__((always_inline)) static inline point_t slope_at(const context_t *c, const point_t *at)
{
    const plant_motor_t *m = c->m;
    const pair_t by = turn_of(at->turn);
    const waves_t waves = waves_after(m, &c->waves, at->turn, by);
    rotor_t rotor = rotor_of(m, &waves, turned_back(by, at->flux));
    if (c->source == NULL) {
        rotor.current = (pair_t){0.0, 0.0};
        return motion_slope(c, &rotor, at);
    }
    point_t slope = motion_slope(c, &rotor, at);
    slope.flux = flux_slope(c, &rotor, at->omega, by, turned(by, rotor.current));
    return slope;
}

static inline point_t moved(const point_t *from, const point_t *slope, double step)
{
    return (point_t){from->flux + step * slope->flux, from->omega + step * slope->omega,
                     from->turn + step * slope->turn, from->load + step * slope->load};
}

/* Classical Runge-Kutta, or the midpoint method for a rate * step of effort. */
static inline point_t integrated(const context_t *c, const point_t *start, double h, double effort)
{
    const point_t k1 = first_slope(c, start);
    const point_t p2 = moved(start, &k1, 0.5 * h);
    const point_t k2 = slope_at(c, &p2);
    if (effort <= MIDPOINT_STEP) {
        return moved(start, &k2, h);
    }
    const point_t p3 = moved(start, &k2, 0.5 * h);
    const point_t k3 = slope_at(c, &p3);
    const point_t p4 = moved(start, &k3, h);
    const point_t k4 = slope_at(c, &p4);
    point_t end = moved(start, &k1, h * (1.0 / 6.0));
    end = moved(&end, &k2, h * (1.0 / 3.0));
    end = moved(&end, &k3, h * (1.0 / 3.0));
    return moved(&end, &k4, h * (1.0 / 6.0));
}

/* ---- steps ---------------------------------------------------------------------------------- */

/* Torque on the rotor as the motor stands, without friction. */
static inline double net_now(const plant_motor_t *m, const rotor_t *rotor)
{
    return torque_at(m, rotor) - load_torque(m);
}

/* The torque of an elastic shaft changes within a step, so motion_slope adds it. */
static inline shaft_t shaft_now(const plant_motor_t *m, const rotor_t *rotor)
{
    shaft_t shaft = {m->acceleration, is_elastic(m) ? 0.0 : m->load_torque_nm};
    if (m->coulomb_nm > 0.0) {
        add_friction(m, net_now(m, rotor), m->now.omega_el_rad_s, &shaft);
    }
    return shaft;
}

/* A vector of the stationary frame in the held one. */
static inline pair_t held_from(const core_t *core, plant_vector_t v)
{
    return turned_back(core->axis, (pair_t){v.alpha, v.beta});
}

/*
 * Without a voltage yet. Each member is given a value, else the compiler clears all of them first.
 */
static inline context_t context_of(const plant_motor_t *m, const core_t *core,
                                   const plant_source_t *source)
{
    const pair_t none = {0.0, 0.0};
    const waves_t waves = waves_now(m);
    const rotor_t rotor = rotor_of(m, &waves, core->flux);
    const shaft_t shaft = shaft_now(m, &rotor);
    return (context_t){
        .m = m,
        .source = source,
        .is_tied = false,
        .tied = none,
        .held = core->axis,
        .voltage = none,
        .waves = waves,
        .rotor = rotor,
        .shaft = shaft,
    };
}

static point_t start_of(const plant_motor_t *m, const core_t *core)
{
    return (point_t){core->flux, core->omega, 0.0, load_now(m)};
}

/*
 * Newton steps to a current of zero along a phase. A step squares the error: the one from below
 * CLEAR_A is the last.
 */
#define CLEAR_MAX 20
#define CLEAR_A 1.0e-9

/*
 * Flux, rotor frame, without current along n: the impulse of voltage that the terminal has had to
 * give lies along n.
 */
static pair_t flux_without(const plant_motor_t *m, const waves_t *waves, pair_t flux, pair_t n)
{
    pair_t cleared = flux;
    double along_a = HUGE_VAL;
    for (int k = 0; k < CLEAR_MAX && fabs(along_a) > CLEAR_A; k++) {
        const rotor_t rotor = rotor_of(m, waves, cleared);
        const plant_stiffness_t s = stiffness_at(m, &rotor);
        along_a = dot(n, rotor.current);
        cleared -= (along_a / dot(n, yielding(&s, n))) * n;
    }
    return cleared;
}

/* Flux linkage at the end of a step, in the frame of the rotor, which has turned by `by`. */
static inline pair_t flux_at(const context_t *c, const point_t *end, pair_t by)
{
    const pair_t flux = turned_back(by, end->flux);
    if (c->source != NULL && !c->is_tied) {
        return flux;
    }
    const waves_t waves = {sixth_after(&c->waves, by), c->waves.cogging};
    return c->is_tied ? flux_without(c->m, &waves, flux, turned_back(by, c->tied))
                      : magnet_of(c->m, &waves);
}

/* Takes over the end of a step of h. */
static void finish(plant_motor_t *motor, core_t *core, const context_t *c, const point_t *end,
                   double h)
{
    const double before = core->omega;
    const pair_t by = turn_of(end->turn);
    const pair_t cogging = cogging_after(motor, &c->waves, end->turn);
    core->flux = flux_at(c, end, by);
    core->axis = turned(by, core->axis);
    core->theta += end->turn;
    core->omega = end->omega;
    store(motor, core);
    motor->now.cogging_cosine = cogging[0];
    motor->now.cogging_sine = cogging[1];
    motor->now.twist_rad = end->load[0];
    motor->now.load_speed_rad_s = end->load[1];
    if (motor->coulomb_nm > 0.0 && before * end->omega < 0.0) {
        const rotor_t rotor = rotor_now(motor);
        motor->now.omega_el_rad_s =
            speed_past_zero(motor, net_now(motor, &rotor), before, end->omega, h);
    }
}

void plant_real_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                         const plant_vector_t *tied)
{
    core_t core = load(motor);
    context_t c = context_of(motor, &core, source);
    c.voltage = held_from(&core, source->constant);
    if (tied != NULL) {
        c.is_tied = true;
        c.tied = held_from(&core, *tied);
    }
    const point_t start = start_of(motor, &core);
    const point_t end = integrated(&c, &start, step_s, source->rate * step_s);
    finish(motor, &core, &c, &end, step_s);
}

void plant_real_step_open(plant_motor_t *motor, double step_s)
{
    core_t core = load(motor);
    const waves_t waves = waves_now(motor);
    core.flux = magnet_of(motor, &waves);
    store(motor, &core);
    const context_t c = context_of(motor, &core, NULL);
    const point_t start = start_of(motor, &core);
    const point_t end = integrated(&c, &start, step_s, rate_now(motor) * step_s);
    finish(motor, &core, &c, &end, step_s);
}

double plant_real_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                     plant_vector_t axis)
{
    const core_t core = load(motor);
    const rotor_t rotor = rotor_now(motor);
    return potential_at(motor, &rotor, core.omega, core.axis, held_from(&core, v),
                        held_from(&core, axis));
}

void plant_real_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    core_t core = load(motor);
    const waves_t waves = waves_now(motor);
    const pair_t n = held_from(&core, axis);
    core.flux = flux_without(motor, &waves, core.flux, n);
    store(motor, &core);
}
