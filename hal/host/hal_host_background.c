/* SPDX-License-Identifier: MIT */
/*
 * The functions of hal.h for the background. They have a file of their own, so that a program that
 * defines them itself can link the rest of the binding.
 */
#include "hal_host.h"

#include <stddef.h>

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    return (hal->line != NULL) && hal_host_line_receive(hal->line, byte);
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    return (hal->line != NULL) && hal_host_line_send(hal->line, byte);
}

/*
 * Returns the count of the third phase. The three currents add up to zero, and each has its zero at
 * half scale. The count is limited to the range of a converter.
 */
static uint32_t third_count(const hal_t *hal, uint32_t most)
{
    const uint32_t both = (uint32_t)hal->seen_ia + hal->seen_ib;
    const uint32_t all = 3U * ((most + 1U) / 2U);
    const uint32_t left = (all > both) ? (all - both) : 0U;

    return (left < most) ? left : most;
}

/*
 * Returns the count of the third phase as the board would. A board with two sensors computes it
 * from the counts that it gave the drive for the other two.
 */
static uint16_t third_phase(const hal_t *hal)
{
    const plant_t *const plant = hal->plant;
    uint16_t count = hal->seen_ic;

    if ((plant != NULL) && !plant->sensors.measures_c) {
        count = (uint16_t)third_count(hal, (uint32_t)plant->sensors.count_max);
    }
    return count;
}

hal_health_t hal_health(const hal_t *hal)
{
    return (hal_health_t){
        .adc_ic = third_phase(hal),
        .late_ticks = hal->late_ticks,
    };
}

bool hal_pulse(hal_t *hal, hal_pulse_t *pulse)
{
    return (hal->inputs != NULL) && hal_host_inputs_take(hal->inputs, pulse);
}

uint32_t hal_pulse_now(const hal_t *hal)
{
    return (hal->inputs != NULL) ? hal_host_inputs_time(hal->inputs) : 0U;
}

hal_inputs_t hal_inputs(const hal_t *hal)
{
    return (hal->inputs != NULL) ? hal->inputs->now : (hal_inputs_t){.throttle = HAL_NO_THROTTLE};
}

bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    return (hal->flash != NULL) && hal_host_flash_read(hal->flash, slot, unit, bytes);
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    hal_open_gates(hal);
    return (hal->flash != NULL) && hal_host_flash_erase(hal->flash, slot);
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    hal_open_gates(hal);
    return (hal->flash != NULL) && hal_host_flash_program(hal->flash, slot, unit, bytes);
}

void hal_keep(hal_t *hal, uint32_t index, uint32_t word)
{
    hal->kept[index] = word;
}

uint32_t hal_kept(const hal_t *hal, uint32_t index)
{
    return hal->kept[index];
}

hal_reset_t hal_reset(const hal_t *hal)
{
    return hal->reset;
}
