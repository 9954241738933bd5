/* SPDX-License-Identifier: MIT */
#include "motor.h"

#include "check.h"
#include "motor_inside.h"

#include <stddef.h>

#define POLE_PAIRS_MAX 100U
#define ANGLE_MAX_RAD 1.0e6
#define HARMONIC_MAX 0.5
#define COGGING_ORDER_MAX 1000U

/*
 * rate * step of a real motor. The method is of the fourth order: x^5/120 = 8e-8 of what changes at
 * the rate in a step. Twice as much for sines of the angle, which are an effect of some percent:
 * 3e-6 of it.
 */
#define REAL_STEP 0.1
#define SINE_RATE 0.5

/* ---- configuration -------------------------------------------------------------------------- */

static bool saturates(const plant_motor_cfg_t *cfg)
{
    return cfg->saturation_d > 0.0 || cfg->saturation_q > 0.0;
}

static plant_iron_cfg_t iron_of(const plant_motor_cfg_t *cfg)
{
    return (plant_iron_cfg_t){
        .inductance_d_h = cfg->inductance_d_h,
        .inductance_q_h = cfg->inductance_q_h,
        .current_a = saturates(cfg) ? cfg->saturation_a : 1.0,
        .fall_d = cfg->saturation_d,
        .fall_q = cfg->saturation_q,
        .shared = cfg->saturation_shared,
    };
}

double plant_motor_shared_max(const plant_motor_cfg_t *cfg)
{
    const plant_iron_cfg_t iron = iron_of(cfg);
    return plant_iron_shared_max(&iron);
}

static bool is_elastic(const plant_motor_cfg_t *cfg)
{
    return cfg->load_inertia_kg_m2 > 0.0;
}

static bool are_shorted_in_range(const double shorted[PLANT_LEGS])
{
    bool good = true;
    for (int k = 0; k < PLANT_LEGS; k++) {
        good = good && shorted[k] >= 0.0 && shorted[k] <= PLANT_SHORTED_MAX;
    }
    return good;
}

static bool are_contacts_in_range(const double ohm[PLANT_LEGS])
{
    bool good = true;
    for (int k = 0; k < PLANT_LEGS; k++) {
        good = good && plant_is_not_negative(ohm[k]);
    }
    return good;
}

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
        {"motor.emf_5th", fabs(cfg->emf_5th) <= HARMONIC_MAX},
        {"motor.emf_7th", fabs(cfg->emf_7th) <= HARMONIC_MAX},
        {"motor.saturation_d",
         cfg->saturation_d >= 0.0 && cfg->saturation_d <= PLANT_IRON_FALL_D_MAX},
        {"motor.saturation_q",
         cfg->saturation_q >= 0.0 && cfg->saturation_q <= PLANT_IRON_FALL_Q_MAX},
        {"motor.saturation_a", !saturates(cfg) || plant_is_positive(cfg->saturation_a)},
        {"motor.saturation_shared",
         cfg->saturation_shared >= 0.0 && cfg->saturation_shared <= plant_motor_shared_max(cfg)},
        {"motor.cogging_nm", plant_is_not_negative(cfg->cogging_nm)},
        {"motor.cogging_order",
         !(cfg->cogging_nm > 0.0) ||
             (cfg->cogging_order >= 1U && cfg->cogging_order <= COGGING_ORDER_MAX)},
        {"motor.load_inertia_kg_m2", plant_is_not_negative(cfg->load_inertia_kg_m2)},
        {"motor.shaft_stiffness_nm",
         !is_elastic(cfg) || plant_is_positive(cfg->shaft_stiffness_nm)},
        {"motor.shaft_damping_nm_s", plant_is_not_negative(cfg->shaft_damping_nm_s)},
        {"motor.shorted", are_shorted_in_range(cfg->shorted)},
        {"motor.contact_ohm", are_contacts_in_range(cfg->contact_ohm)},
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
    motor->step_bound = PLANT_MOTOR_STEP;
}

/* Returns the rate of its swings and of their decay, 1/s. */
static double derive_shaft(plant_motor_t *motor, const plant_motor_cfg_t *cfg)
{
    const bool elastic = is_elastic(cfg);
    motor->load_gain = elastic ? 1.0 / cfg->load_inertia_kg_m2 : 0.0;
    motor->stiffness_nm = elastic ? cfg->shaft_stiffness_nm : 0.0;
    motor->damping_nm_s = elastic ? cfg->shaft_damping_nm_s : 0.0;
    const double both = 1.0 / cfg->inertia_kg_m2 + motor->load_gain;
    return sqrt(both * motor->stiffness_nm) + both * motor->damping_nm_s;
}

/* By which R/L is larger where the windings differ, 1/s. */
static double unequal_rate(const plant_motor_t *motor)
{
    const double more_ohm = motor->windings.resistance_max_ohm - motor->resistance_ohm;
    return fmax(more_ohm, 0.0) * fmax(motor->inverse_d, motor->inverse_q);
}

/* What an ideal motor has not, and the steps for it. */
static void derive_real(plant_motor_t *motor, const plant_motor_cfg_t *cfg)
{
    const double fifth_wb = cfg->emf_5th * cfg->flux_linkage_wb / 5.0;
    const double seventh_wb = cfg->emf_7th * cfg->flux_linkage_wb / 7.0;
    const double order = (double)cfg->cogging_order;
    const bool has_harmonics = fabs(fifth_wb) + fabs(seventh_wb) > 0.0;
    const bool has_cogging = cfg->cogging_nm > 0.0;
    motor->harmonic_d_wb = seventh_wb + fifth_wb;
    motor->harmonic_q_wb = seventh_wb - fifth_wb;
    const plant_iron_cfg_t iron = iron_of(cfg);
    plant_iron_init(&motor->iron, &iron);
    motor->cogging_nm = cfg->cogging_nm;
    motor->cogging_ratio = has_cogging ? order / motor->pole_pairs : 0.0;
    const double shaft_rate = derive_shaft(motor, cfg);
    plant_windings_init(&motor->windings, cfg->resistance_ohm, cfg->shorted, cfg->contact_ohm);
    motor->is_real = has_harmonics || has_cogging || motor->iron.saturates || is_elastic(cfg) ||
                     !motor->windings.are_alike;
    if (motor->is_real) {
        const double swing = sqrt(order * cfg->cogging_nm / cfg->inertia_kg_m2) + shaft_rate;
        const double sines = fmax(has_harmonics ? 6.0 : 0.0, motor->cogging_ratio);
        motor->step_bound = REAL_STEP;
        motor->rate_constant += swing + unequal_rate(motor);
        motor->rate_speed = fmax(motor->rate_speed, SINE_RATE * sines);
    }
}

/* What follows from angle and current of a rotor that has been put somewhere. */
static void place_parts(plant_motor_t *motor, pair_t current)
{
    if (motor->is_real) {
        plant_real_place_cogging(motor);
        const pair_t flux = plant_real_flux(motor, current);
        motor->now.flux_d_wb = flux[0];
        motor->now.flux_q_wb = flux[1];
    }
}

bool plant_motor_init(plant_motor_t *motor, const plant_motor_cfg_t *cfg, const char **bad_field)
{
    *bad_field = motor_bad_field(cfg);
    if (*bad_field != NULL) {
        return false;
    }
    derive_constants(motor, cfg);
    derive_real(motor, cfg);
    const plant_rotation_t r = plant_rotation_from_angle(cfg->initial_angle_el_rad);
    motor->now = (plant_motor_state_t){.flux_d_wb = cfg->flux_linkage_wb};
    motor->now.cosine = r.cosine;
    motor->now.sine = r.sine;
    motor->now.omega_el_rad_s = motor->pole_pairs * cfg->initial_speed_mech_rad_s;
    motor->now.theta_el_rad = cfg->initial_angle_el_rad;
    motor->now.load_speed_rad_s = cfg->initial_speed_mech_rad_s;
    motor->turns_el = 0;
    motor->load_torque_nm = 0.0;
    plant_motor_wrap(motor);
    place_parts(motor, (pair_t){0.0, 0.0});
    return true;
}

/* ---- read-outs ------------------------------------------------------------------------------ */

double plant_motor_growth(const plant_motor_t *motor)
{
    return motor->iron.saturates ? plant_real_growth(motor) : 1.0;
}

/* That makes the field; rotor frame. */
static pair_t current_in(const plant_motor_t *motor)
{
    return motor->is_real ? plant_real_current(motor) : current_of(motor, load(motor).flux);
}

static pair_t phase_current_in(const plant_motor_t *motor)
{
    const pair_t current = current_in(motor);
    const pair_t axis = load(motor).axis;
    return motor->windings.are_alike
               ? current
               : turned_back(axis, by_matrix(&motor->windings.inverse, turned(axis, current)));
}

double plant_motor_i_d(const plant_motor_t *motor)
{
    return phase_current_in(motor)[0];
}

double plant_motor_i_q(const plant_motor_t *motor)
{
    return phase_current_in(motor)[1];
}

double plant_motor_torque(const plant_motor_t *motor)
{
    return motor->is_real ? plant_real_torque(motor) : torque_of(motor, load(motor).flux);
}

plant_vector_t plant_motor_current(const plant_motor_t *motor)
{
    const core_t core = load(motor);
    const pair_t current =
        motor->is_real ? plant_real_current(motor) : current_of(motor, core.flux);
    const pair_t field = turned(core.axis, current);
    return plant_windings_inside(&motor->windings, (plant_vector_t){field[0], field[1]});
}

plant_vector_t plant_motor_emf(const plant_motor_t *motor)
{
    if (!motor->windings.are_alike) {
        return plant_symmetric_times(&motor->windings.linkage, plant_real_emf(motor));
    }
    if (motor->is_real) {
        return plant_real_emf(motor);
    }
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
    const pair_t current = turned_back(by, current_in(motor));
    core.flux = flux_of(motor, current);
    core.axis = turned(by, core.axis);
    core.theta += angle_el_rad;
    store(motor, &core);
    plant_motor_wrap(motor);
    place_parts(motor, current);
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
    if (motor->cogging_nm > 0.0) {
        plant_real_place_cogging(motor);
    }
}

/* ---- steps ---------------------------------------------------------------------------------- */

static void real_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[],
                            double rate)
{
    for (unsigned k = 0; k < count; k++) {
        const plant_source_t source = {
            .constant = plant_windings_inside(&motor->windings, interval[k].v), .rate = rate};
        const double steps = plant_motor_steps(interval[k].duration_s * rate / motor->step_bound);
        for (int64_t left = (int64_t)steps; left > 0; left--) {
            plant_real_step_fed(motor, interval[k].duration_s / steps, &source, NULL);
        }
    }
}

void plant_motor_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[])
{
    if (motor->is_real) {
        real_run_driven(motor, count, interval, plant_motor_rate(motor));
    } else {
        plant_ideal_run_driven(motor, count, interval, plant_motor_rate(motor));
    }
}

void plant_motor_step_driven(plant_motor_t *motor, double step_s, plant_vector_t v)
{
    const plant_interval_t interval = {step_s, v};
    if (motor->is_real) {
        const plant_source_t source = {.constant = v, .rate = plant_motor_rate(motor)};
        plant_motor_step_fed(motor, step_s, &source, NULL);
    } else {
        plant_ideal_run_driven(motor, 1, &interval, 0.0);
    }
}

void plant_motor_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis)
{
    if (motor->is_real) {
        const plant_source_t source = {.constant = v, .rate = plant_motor_rate(motor)};
        plant_motor_step_fed(motor, step_s, &source, &axis);
    } else {
        plant_ideal_step_tied(motor, step_s, v, axis);
    }
}

void plant_motor_step_open(plant_motor_t *motor, double step_s)
{
    if (motor->is_real) {
        plant_real_step_open(motor, step_s);
    } else {
        plant_ideal_step_open(motor, step_s);
    }
}

void plant_motor_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                          const plant_vector_t *tied_axis)
{
    if (motor->windings.are_alike) {
        plant_real_step_fed(motor, step_s, source, tied_axis);
    } else {
        plant_source_t inside = *source;
        inside.constant = plant_symmetric_times(&motor->windings.inverse, source->constant);
        plant_vector_t axis = {0.0, 0.0};
        if (tied_axis != NULL) {
            axis = plant_symmetric_times(&motor->windings.inverse, *tied_axis);
        }
        plant_real_step_fed(motor, step_s, &inside, (tied_axis != NULL) ? &axis : NULL);
    }
}

double plant_motor_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis)
{
    const plant_windings_t *const windings = &motor->windings;
    return motor->is_real ? plant_real_floating_potential(motor, plant_windings_inside(windings, v),
                                                          plant_windings_inside(windings, axis))
                          : plant_ideal_floating_potential(motor, v, axis);
}

void plant_motor_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    if (motor->is_real) {
        plant_real_clear_phase(motor, plant_windings_inside(&motor->windings, axis));
    } else {
        plant_ideal_clear_phase(motor, axis);
    }
}
