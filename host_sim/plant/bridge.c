/* SPDX-License-Identifier: MIT */
#include "bridge.h"

#include <stddef.h>

/*
 * Events handled in one segment before the rest of it is run without looking for more. A real
 * segment has at most a few; the bound only keeps a degenerate case from going on for ever.
 */
#define EVENTS_MAX 64

/*
 * Trials to locate an event: two to four for a margin that falls steadily over the step. Every
 * third one bisects, for margins that rise first, so the rest is 2^-16 of the step at worst.
 */
#define LOCATE_MAX 48

const plant_vector_t plant_bridge_axis[PLANT_LEGS] = {
    {1.0, 0.0},
    {-0.5, 0.5 * PLANT_SQRT3},
    {-0.5, -0.5 * PLANT_SQRT3},
};

typedef struct {
    double lower[PLANT_LEGS];
    double upper[PLANT_LEGS];
} limits_t;

enum conduction {
    ALL_DRIVEN,
    ONE_FLOATS,
    NO_CURRENT
};

/* Which legs conduct, and where. */
typedef struct {
    enum conduction kind;
    int floating;                 /* the leg, if ONE_FLOATS */
    int direction[PLANT_LEGS];    /* of the current of a diode-like leg: +1, -1; 0: not watched */
    double potential[PLANT_LEGS]; /* of the conducting legs */
} state_t;

static bool is_in(uint32_t mask, unsigned leg)
{
    return ((mask >> leg) & 1U) != 0U;
}

static limits_t leg_limits(const plant_segment_t *segment, const plant_rails_t *rails)
{
    limits_t limits;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        limits.lower[leg] = (is_in(segment->high, leg) ? rails->bus_v : 0.0) - rails->drop_v;
        limits.upper[leg] = (is_in(segment->low, leg) ? 0.0 : rails->bus_v) + rails->drop_v;
        if (is_in(rails->broken, leg)) {
            limits.lower[leg] = -HUGE_VAL;
            limits.upper[leg] = HUGE_VAL;
        }
    }
    return limits;
}

static void conduct(state_t *state, const limits_t *limits, int leg, int direction)
{
    const bool rigid = !(limits->lower[leg] < limits->upper[leg]);
    state->direction[leg] = rigid ? 0 : direction;
    state->potential[leg] = (direction > 0) ? limits->lower[leg] : limits->upper[leg];
}

static plant_vector_t voltage_without(const state_t *state, int leg)
{
    double v[PLANT_LEGS] = {state->potential[0], state->potential[1], state->potential[2]};
    if (leg >= 0) {
        v[leg] = 0.0;
    }
    return plant_clarke(v[0], v[1], v[2]);
}

/* The other two legs conduct: does this one float or begin to conduct? */
static void resolve_single(const plant_motor_t *motor, const limits_t *limits, int leg,
                           state_t *state)
{
    const double potential =
        plant_motor_floating_potential(motor, voltage_without(state, leg), plant_bridge_axis[leg]);
    state->kind = ALL_DRIVEN;
    if (potential > limits->upper[leg]) {
        conduct(state, limits, leg, -1);
    } else if (potential < limits->lower[leg]) {
        conduct(state, limits, leg, 1);
    } else {
        state->kind = ONE_FLOATS;
        state->floating = leg;
        state->direction[leg] = 0;
    }
}

/*
 * Without current a star-point potential must exist that keeps all terminals within their limits.
 * Returns its play, negative if there is none; then current starts from leg *source (at its lower
 * limit) to leg *sink (at its upper limit).
 */
static double star_point_play(const plant_motor_t *motor, const limits_t *limits, int *source,
                              int *sink)
{
    double emf[PLANT_LEGS];
    plant_phases(plant_motor_emf(motor), emf);
    *source = 0;
    *sink = 0;
    for (int leg = 1; leg < PLANT_LEGS; leg++) {
        if (limits->lower[leg] - emf[leg] > limits->lower[*source] - emf[*source]) {
            *source = leg;
        }
        if (limits->upper[leg] - emf[leg] < limits->upper[*sink] - emf[*sink]) {
            *sink = leg;
        }
    }
    return (limits->upper[*sink] - emf[*sink]) - (limits->lower[*source] - emf[*source]);
}

static void resolve_none(const plant_motor_t *motor, const limits_t *limits, state_t *state)
{
    int source = 0;
    int sink = 0;
    if (star_point_play(motor, limits, &source, &sink) >= 0.0) {
        state->kind = NO_CURRENT;
        return;
    }
    conduct(state, limits, source, 1);
    conduct(state, limits, sink, -1);
    resolve_single(motor, limits, PLANT_LEGS - source - sink, state);
}

/* Finds the conduction state from the currents, or, for legs without, from the potentials. */
static void resolve(const plant_motor_t *motor, const limits_t *limits, state_t *state)
{
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(motor), current);
    int idle = 0;
    int last_idle = 0;
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        const bool rigid = !(limits->lower[leg] < limits->upper[leg]);
        if (!rigid && fabs(current[leg]) <= PLANT_BRIDGE_TOLERANCE) {
            idle++;
            last_idle = leg;
        } else {
            conduct(state, limits, leg, (current[leg] > 0.0) ? 1 : -1);
        }
    }
    if (idle == 0) {
        state->kind = ALL_DRIVEN;
    } else if (idle == 1) {
        resolve_single(motor, limits, last_idle, state);
    } else {
        resolve_none(motor, limits, state);
    }
}

static void step(plant_motor_t *motor, const state_t *state, double step_s)
{
    if (state->kind == ALL_DRIVEN) {
        plant_motor_step_driven(motor, step_s, voltage_without(state, -1));
    } else if (state->kind == ONE_FLOATS) {
        plant_motor_step_tied(motor, step_s, voltage_without(state, state->floating),
                              plant_bridge_axis[state->floating]);
    } else {
        plant_motor_step_open(motor, step_s);
    }
}

/*
 * Smallest distance to leaving the conduction state, A or V; negative once it has been left.
 * *leg tells a leg whose current has turned, -1 if it is a potential.
 */
static double margin(const plant_motor_t *motor, const limits_t *limits, const state_t *state,
                     int *leg)
{
    *leg = -1;
    if (state->kind == NO_CURRENT) {
        int source = 0;
        int sink = 0;
        return star_point_play(motor, limits, &source, &sink);
    }
    double least = HUGE_VAL;
    if (state->kind == ONE_FLOATS) {
        const int floating = state->floating;
        const double potential = plant_motor_floating_potential(
            motor, voltage_without(state, floating), plant_bridge_axis[floating]);
        least = fmin(potential - limits->lower[floating], limits->upper[floating] - potential);
    }
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(motor), current);
    for (int k = 0; k < PLANT_LEGS; k++) {
        if (state->direction[k] != 0 && (double)state->direction[k] * current[k] < least) {
            least = (double)state->direction[k] * current[k];
            *leg = k;
        }
    }
    return least;
}

/* An instant within a step, by its time from the beginning, and the margin there. */
typedef struct {
    double time_s;
    double margin;
} instant_t;

/* Where the line through both reaches half the tolerance beyond the event. */
static double aim(const instant_t *low, const instant_t *high)
{
    const double target = -0.5 * PLANT_BRIDGE_TOLERANCE;
    const double part = (low->margin - target) / (low->margin - high->margin);
    return low->time_s + part * (high->time_s - low->time_s);
}

/*
 * The event lies between from, the beginning of a step, and high, its end. Goes to just beyond it,
 * by false position with the stale end's margin halved (Illinois). Returns the time from the
 * beginning of the step; *leg is the leg whose current has turned, or -1.
 */
static double locate(plant_motor_t *motor, const plant_motor_state_t *from, const limits_t *limits,
                     const state_t *state, instant_t high, int *leg)
{
    int stale = 0;
    double time_s = high.time_s;
    motor->now = *from;
    instant_t low = {0.0, fmax(margin(motor, limits, state, leg), 0.0)};
    for (int k = 0; k < LOCATE_MAX; k++) {
        time_s = ((k % 3) == 2) ? 0.5 * (low.time_s + high.time_s) : aim(&low, &high);
        motor->now = *from;
        step(motor, state, time_s);
        const instant_t here = {time_s, margin(motor, limits, state, leg)};
        if (here.margin < -PLANT_BRIDGE_TOLERANCE) {
            low.margin *= (stale > 0) ? 0.5 : 1.0;
            stale = 1;
            high = here;
        } else if (here.margin > 0.0) {
            high.margin *= (stale < 0) ? 0.5 : 1.0;
            stale = -1;
            low = here;
        } else {
            return time_s;
        }
    }
    *leg = -1;
    return time_s;
}

/* One step of at most step_s, ended early by an event. Returns the time gone. */
static double step_to_event(plant_motor_t *motor, const limits_t *limits, const state_t *state,
                            double step_s)
{
    const plant_motor_state_t from = motor->now;
    int leg = -1;
    step(motor, state, step_s);
    const instant_t high = {step_s, margin(motor, limits, state, &leg)};
    if (!(high.margin < -PLANT_BRIDGE_TOLERANCE)) {
        return step_s;
    }
    const double gone_s = locate(motor, &from, limits, state, high, &leg);
    if (leg >= 0) {
        plant_motor_clear_phase(motor, plant_bridge_axis[leg]);
    }
    return gone_s;
}

/*
 * Current out of the positive rail: of the legs whose high side is closed, and back through the
 * upper diodes of open ones.
 */
static double rail_current(const plant_motor_t *motor, const plant_segment_t *segment,
                           const state_t *state)
{
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(motor), current);
    double sum = 0.0;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        const bool diode = !is_in(segment->low, leg) && state->direction[leg] < 0;
        if (is_in(segment->high, leg) || diode) {
            sum += current[leg];
        }
    }
    return sum;
}

void plant_bridge_run(plant_motor_t *motor, const plant_segment_t *segment,
                      const plant_rails_t *rails, double *charge_c)
{
    const limits_t limits = leg_limits(segment, rails);
    double left_s = segment->duration_s;
    for (int event = 0; left_s > 0.0; event++) {
        const double steps =
            plant_motor_steps(left_s * plant_motor_rate(motor) / motor->step_bound);
        double step_s = (steps > 1.0) ? left_s / steps : left_s;
        state_t state = {0};
        resolve(motor, &limits, &state);
        const double before_a = (charge_c != NULL) ? rail_current(motor, segment, &state) : 0.0;
        if (event < EVENTS_MAX + (int)steps) {
            step_s = step_to_event(motor, &limits, &state, step_s);
        } else {
            step(motor, &state, step_s);
        }
        left_s -= step_s;
        if (charge_c != NULL) {
            *charge_c += 0.5 * step_s * (before_a + rail_current(motor, segment, &state));
        }
    }
}

/* What is left by one open wire is the loop through the other two; by two, nothing. */
void plant_bridge_break(plant_motor_t *motor, uint32_t broken)
{
    const bool one = (broken & (broken - 1U)) == 0U;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        if (one && is_in(broken, leg)) {
            plant_motor_clear_phase(motor, plant_bridge_axis[leg]);
        }
    }
    if (!one) {
        plant_motor_step_open(motor, 0.0);
    }
}
