/* SPDX-License-Identifier: MIT */
/*
 * Inputs and sensor of the shaft of a simulated board. Whoever simulates them sets the levels
 * (`now`, `shaft`) before the tick that is to see them, and puts pulses into a queue. A field stays
 * in force until it is changed.
 */
#ifndef HAL_HOST_INPUTS_H
#define HAL_HOST_INPUTS_H

#include "hal.h"

#include <stdbool.h>
#include <stdint.h>

/* Pulses that the queue holds. */
#define HAL_HOST_PULSES (64U)

typedef struct {
    hal_inputs_t now;   /* what hal_inputs() returns */
    hal_shaft_t shaft;  /* what hal_shaft() returns; that call clears `indexed` */
    uint64_t tick_ps;   /* duration of a control tick, ps */
    uint64_t passed_ps; /* time since hal_host_inputs_init(), ps */
    hal_pulse_t pulses[HAL_HOST_PULSES];
    uint32_t first;
    uint32_t count;
} hal_host_inputs_t;

/* No throttle, the button released, a sensor that reads 0, no pulses. tick_ps: above 0. */
void hal_host_inputs_init(hal_host_inputs_t *inputs, uint64_t tick_ps);

/* Lets one tick pass, in which a conversion of the throttle ends. */
void hal_host_inputs_step(hal_host_inputs_t *inputs);

/* Present time, in 1/HAL_PULSE_HZ, rounded down. */
uint32_t hal_host_inputs_time(const hal_host_inputs_t *inputs);

/*
 * A pulse comes at the command pin. It may lie in the future: the board sees it once it has ended.
 * Pulses have to be sent in the order of their time. A pulse that the full queue cannot take is
 * lost.
 */
void hal_host_inputs_send(hal_host_inputs_t *inputs, const hal_pulse_t *pulse);

/* Takes the oldest pulse that has ended. False when there is none; then `pulse` stays as it is. */
bool hal_host_inputs_take(hal_host_inputs_t *inputs, hal_pulse_t *pulse);

#endif
