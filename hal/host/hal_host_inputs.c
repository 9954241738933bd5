/* SPDX-License-Identifier: MIT */
#include "hal_host_inputs.h"

#define PS_PER_UNIT (1000000000000U / HAL_PULSE_HZ)
#define HALF_OF_TIME (0x80000000U)

void hal_host_inputs_init(hal_host_inputs_t *inputs, uint64_t tick_ps)
{
    *inputs = (hal_host_inputs_t){.now = {.throttle = HAL_NO_THROTTLE}, .tick_ps = tick_ps};
}

void hal_host_inputs_step(hal_host_inputs_t *inputs)
{
    inputs->passed_ps += inputs->tick_ps;
    inputs->now.conversions++;
}

uint32_t hal_host_inputs_time(const hal_host_inputs_t *inputs)
{
    return (uint32_t)(inputs->passed_ps / PS_PER_UNIT);
}

void hal_host_inputs_send(hal_host_inputs_t *inputs, const hal_pulse_t *pulse)
{
    if (inputs->count < HAL_HOST_PULSES) {
        inputs->pulses[(inputs->first + inputs->count) % HAL_HOST_PULSES] = *pulse;
        inputs->count++;
    }
}

/* The time wraps, so a pulse that ended less than half of all time ago has ended. */
static bool has_ended(const hal_host_inputs_t *inputs, const hal_pulse_t *pulse)
{
    const uint32_t end = pulse->start + pulse->width;

    return (hal_host_inputs_time(inputs) - end) < HALF_OF_TIME;
}

bool hal_host_inputs_take(hal_host_inputs_t *inputs, hal_pulse_t *pulse)
{
    const hal_pulse_t *const oldest = &inputs->pulses[inputs->first];
    const bool there = (inputs->count > 0U) && has_ended(inputs, oldest);

    if (there) {
        *pulse = *oldest;
        inputs->first = (inputs->first + 1U) % HAL_HOST_PULSES;
        inputs->count--;
    }
    return there;
}
