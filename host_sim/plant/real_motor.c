/* SPDX-License-Identifier: MIT */
#include "motor_inside.h"

#include <stddef.h>

/*
 * Classical Runge-Kutta. For the length of a step the rotor frame of its beginning is held still, as in ideal_motor.c: a
 * constant voltage is constant there, and the flux linkage obeys psi' = v - R i.
 */
typedef struct {
    pair_t flux;  /* held frame, magnet included */
    double omega; /* electrical */
    double turn;  /* of the rotor since the beginning, electrical */
} point_t;

/* What is the same for all of a step. */
typedef struct {
    const plant_motor_t *m;
    const plant_source_t *source;
    bool is_tied;
    pair_t tied;    /* axis of the phase without current, held frame */
    pair_t held;    /* cosine and sine of the held frame */
    pair_t voltage; /* the source's constant, held frame */
    shaft_t shaft;
} context_t;

/* The rotor at a point of a step, in its own frame. */
typedef struct {
    pair_t by; /* cosine and sine of the turn */
    pair_t flux;
    pair_t current;
} rotor_t;

static inline rotor_t rotor_at(const plant_motor_t *m, const point_t *at)
{
    rotor_t rotor;
    rotor.by = small_turn(at->turn, 0.0, 0.0);
    rotor.flux = turned_back(rotor.by, at->flux);
    rotor.current = current_of(m, rotor.flux);
    return rotor;
}

static inline double torque_at(const plant_motor_t *m, const rotor_t *rotor)
{
    return m->torque_factor * difference(swapped(rotor->flux) * rotor->current);
}

/* The part of the voltage that follows the current, held frame. */
static inline pair_t following(const context_t *c, pair_t current)
{
    const plant_source_t *source = c->source;
    if (source->follow == NULL) {
        return (pair_t){0.0, 0.0};
    }
    const pair_t i = turned(c->held, current);
    const plant_vector_t v = source->follow(source->what, (plant_vector_t){i[0], i[1]});
    return turned_back(c->held, (pair_t){v.alpha, v.beta});
}

/* The potential of the floating terminal that keeps the current along n at zero, for a voltage v without it; v, n in the
 * rotor frame. */
static inline double potential_at(const plant_motor_t *m, const rotor_t *rotor, double omega,
                                  pair_t v, pair_t n)
{
    const pair_t turning = {omega, -omega};
    const pair_t inverse = inverse_inductance(m);
    const pair_t free =
        inverse * (v - m->resistance_ohm * rotor->current + turning * swapped(rotor->flux));
    const pair_t along = n * (free - turning * swapped(rotor->current));
    const pair_t compliance = PLANT_CLARKE * (n * n * inverse);
    return -(along[0] + along[1]) / (compliance[0] + compliance[1]);
}

static void slope_at(const context_t *c, const point_t *at, point_t *slope)
{
    const plant_motor_t *m = c->m;
    const rotor_t rotor = rotor_at(m, at);
    const pair_t current = turned(rotor.by, rotor.current);
    pair_t voltage = c->voltage + following(c, current);
    if (c->is_tied) {
        const double potential = potential_at(m, &rotor, at->omega, turned_back(rotor.by, voltage),
                                              turned_back(rotor.by, c->tied));
        voltage += (PLANT_CLARKE * potential) * c->tied;
    }
    slope->flux = voltage - m->resistance_ohm * current;
    slope->omega =
        c->shaft.gain * (torque_at(m, &rotor) - c->shaft.drag_nm) - m->decay_shaft * at->omega;
    slope->turn = at->omega;
}

static inline point_t moved(const point_t *from, const point_t *slope, double step)
{
    return (point_t){from->flux + step * slope->flux, from->omega + step * slope->omega,
                     from->turn + step * slope->turn};
}

static point_t integrated(const context_t *c, const point_t *start, double h)
{
    point_t k1;
    point_t k2;
    point_t k3;
    point_t k4;
    slope_at(c, start, &k1);
    const point_t p2 = moved(start, &k1, 0.5 * h);
    slope_at(c, &p2, &k2);
    const point_t p3 = moved(start, &k2, 0.5 * h);
    slope_at(c, &p3, &k3);
    const point_t p4 = moved(start, &k3, h);
    slope_at(c, &p4, &k4);
    point_t end = moved(start, &k1, h * (1.0 / 6.0));
    end = moved(&end, &k2, h * (1.0 / 3.0));
    end = moved(&end, &k3, h * (1.0 / 3.0));
    return moved(&end, &k4, h * (1.0 / 6.0));
}

/* ---- shaft ---------------------------------------------------------------------------------- */

static inline double net_torque(const plant_motor_t *m, const rotor_t *rotor)
{
    return torque_at(m, rotor) - m->load_torque_nm;
}

static shaft_t shaft_of(const plant_motor_t *m, const point_t *start)
{
    shaft_t shaft = {m->acceleration, m->load_torque_nm};
    if (m->coulomb_nm > 0.0) {
        const rotor_t rotor = rotor_at(m, start);
        add_friction(m, net_torque(m, &rotor), start->omega, &shaft);
    }
    return shaft;
}

/* ---- steps ---------------------------------------------------------------------------------- */

static point_t start_of(const core_t *core)
{
    return (point_t){core->flux, core->omega, 0.0};
}

/* Flux, rotor frame, without current along n: the impulse of voltage that the terminal has had to give lies along n. */
static pair_t flux_without(const plant_motor_t *m, pair_t flux, pair_t n)
{
    const pair_t along = n * current_of(m, flux);
    const pair_t compliance = n * n * inverse_inductance(m);
    return flux - ((along[0] + along[1]) / (compliance[0] + compliance[1])) * n;
}

/* Takes over the end of a step of h. */
static void finish(plant_motor_t *motor, core_t *core, const point_t *end, double h)
{
    const double before = core->omega;
    const point_t here = {core->flux, end->omega, 0.0};
    (void)shaft_turn(core, end->turn, 0.0, 0.0);
    core->omega = end->omega;
    if (motor->coulomb_nm > 0.0 && before * end->omega < 0.0) {
        const rotor_t rotor = rotor_at(motor, &here);
        core->omega = speed_past_zero(motor, net_torque(motor, &rotor), before, end->omega, h);
    }
    store(motor, core);
}

void plant_real_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                         const plant_vector_t *tied)
{
    core_t core = load(motor);
    const point_t start = start_of(&core);
    context_t c = {.m = motor, .source = source, .is_tied = tied != NULL, .held = core.axis};
    const pair_t constant = {source->constant.alpha, source->constant.beta};
    c.voltage = turned_back(core.axis, constant);
    c.shaft = shaft_of(motor, &start);
    if (tied != NULL) {
        c.tied = turned_back(core.axis, (pair_t){tied->alpha, tied->beta});
    }
    const point_t end = integrated(&c, &start, step_s);
    const pair_t by = small_turn(end.turn, 0.0, 0.0);
    core.flux = turned_back(by, end.flux);
    if (tied != NULL) {
        core.flux = flux_without(motor, core.flux, turned_back(by, c.tied));
    }
    finish(motor, &core, &end, step_s);
}
