/*
 * The binding of hal.h to the simulated hardware: the plant is the timer, the converters and the gates.
 *
 * Time stands still between two calls of hal_host_step(), so the control interrupt of tick k sees the
 * plant exactly at t_k, however long it takes. The plant keeps the preload registers: compare values
 * act from t_k+1; opening and enabling the gates act at once.
 */
#ifndef HAL_HOST_H
#define HAL_HOST_H

#include "hal.h"
#include "plant.h"

#include <stdint.h>

struct hal {
    plant_t *plant;
    uint32_t ticks; /* PWM periods since the binding */
};

/* Bind to a plant that plant_init() has accepted and that outlives the binding. */
void hal_host_init(hal_t *hal, plant_t *plant);

/* Let one PWM period pass. Call after each control_isr(), never from within. */
void hal_host_step(hal_t *hal);

#endif
