/* SPDX-License-Identifier: MIT */
#include "motor.h"

#include "check.h"
#include "motor_inside.h"

#define POLE_PAIRS_MAX 100U
#define ANGLE_MAX_RAD 1.0e6

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

/* ---- steps ---------------------------------------------------------------------------------- */

void plant_motor_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[])
{
    plant_ideal_run_driven(motor, count, interval, plant_motor_rate(motor));
}

void plant_motor_step_driven(plant_motor_t *motor, double step_s, plant_vector_t v)
{
    const plant_interval_t interval = {step_s, v};
    plant_ideal_run_driven(motor, 1, &interval, 0.0);
}

void plant_motor_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis)
{
    plant_ideal_step_tied(motor, step_s, v, axis);
}

void plant_motor_step_open(plant_motor_t *motor, double step_s)
{
    plant_ideal_step_open(motor, step_s);
}

void plant_motor_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                          const plant_vector_t *tied_axis)
{
    plant_real_step_fed(motor, step_s, source, tied_axis);
}

double plant_motor_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis)
{
    return plant_ideal_floating_potential(motor, v, axis);
}

void plant_motor_clear_phase(plant_motor_t *motor, plant_vector_t axis)
{
    plant_ideal_clear_phase(motor, axis);
}
