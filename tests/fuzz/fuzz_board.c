/* SPDX-License-Identifier: MIT */
#include "fuzz_board.h"

/* The board's converters have 12 bits. */
#define COUNT_MAX (4095U)

uint8_t fed_byte(fed_t *fed)
{
    uint8_t byte = 0U;

    if (fed->left > 0U) {
        byte = fed->at[0];
        fed->at++;
        fed->left--;
    }
    return byte;
}

uint16_t fed_half(fed_t *fed)
{
    const unsigned low = fed_byte(fed);

    return (uint16_t)(low | ((unsigned)fed_byte(fed) << 8U));
}

uint16_t fed_count(fed_t *fed)
{
    return fed_half(fed) & COUNT_MAX;
}

void fuzz_board_rests(hal_t *hal, const drive_cfg_t *cfg)
{
    drive_in_t measured = {.adc_bus = (uint16_t)(14000U >> cfg->sampling.bus_shift)};

    measured.adc_ia = (uint16_t)(16384U >> cfg->sampling.current_shift);
    measured.adc_ib = measured.adc_ia;
    hal->measured = measured;
}

void fuzz_board_measures(hal_t *hal, fed_t *fed)
{
    hal->measured.adc_ia = fed_count(fed);
    hal->measured.adc_ib = fed_count(fed);
    hal->measured.adc_bus = fed_count(fed);
    hal->health.adc_ic = fed_count(fed);
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    const drive_command_t command = in->command;

    *in = hal->measured;
    in->command = command;
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    hal->demanded = *out;
    hal->ticks++;
}

void hal_open_gates(hal_t *hal)
{
    hal->demanded.gate_enable = false;
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}

hal_shaft_t hal_shaft(hal_t *hal)
{
    (void)hal;
    return (hal_shaft_t){0};
}

bool hal_pulse(hal_t *hal, hal_pulse_t *pulse)
{
    (void)hal;
    (void)pulse;
    return false;
}

uint32_t hal_pulse_now(const hal_t *hal)
{
    (void)hal;
    return 0U;
}

hal_inputs_t hal_inputs(const hal_t *hal)
{
    (void)hal;
    return (hal_inputs_t){.throttle = HAL_NO_THROTTLE};
}

hal_health_t hal_health(const hal_t *hal)
{
    return hal->health;
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
    (void)hal;
    return (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 3U};
}
