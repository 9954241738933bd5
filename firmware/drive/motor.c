/* SPDX-License-Identifier: MIT */
#include "motor.h"

/* Returns the parts of the configuration that the model corrects. */
static model_nominal_t nominal_of(const drive_cfg_t *cfg)
{
    return (model_nominal_t){&cfg->observer, &cfg->current_loop, &cfg->hold_loop};
}

void motor_reset(motor_t *motor, const drive_cfg_t *cfg)
{
    const model_nominal_t nominal = nominal_of(cfg);

    motor->identified = false;
    model_reset(&motor->model, &nominal);
}

void motor_change(motor_t *motor, const drive_cfg_t *cfg)
{
    const model_nominal_t nominal = nominal_of(cfg);

    model_change(&motor->model, &cfg->model, &nominal);
}

void motor_set(motor_t *motor, const drive_cfg_t *cfg, const model_measured_t *measured)
{
    const model_nominal_t nominal = nominal_of(cfg);

    model_set(&motor->model, &cfg->model, &nominal, measured);
}

void motor_identify(motor_t *motor)
{
    motor->identified = true;
}

void motor_pace(motor_t *motor, const drive_cfg_t *cfg, step_t speed)
{
    const model_nominal_t nominal = nominal_of(cfg);

    model_pace(&motor->model, &cfg->model, &nominal, speed);
}

void motor_refine(motor_t *motor, const drive_cfg_t *cfg, const nn_observer_t *observer,
                  step_t calm)
{
    const model_nominal_t nominal = nominal_of(cfg);

    model_track_flux(&motor->model, &cfg->model, &nominal, observer->rotated_error.d,
                     observer->speed);
    if (!model_is_whole(&motor->model, &cfg->model, fx_abs(calm))) {
        model_pace(&motor->model, &cfg->model, &nominal, calm);
    }
}

int32_t motor_emf(const motor_t *motor, int32_t speed_q15)
{
    return fx_asr(speed_q15 * motor->model.hold_loop.emf_q13, 13U);
}

bool motor_check(motor_t *motor, const drive_cfg_t *cfg, model_part_t part)
{
    const model_nominal_t nominal = nominal_of(cfg);

    return model_holds(&motor->model, &nominal, part);
}
