/* SPDX-License-Identifier: MIT */
#include "board.h"

void board_start(hal_t *hal)
{
    hal->ticks = 0U;
    board_registers.run = 1U;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    in->adc_ia = (uint16_t)board_registers.current_a;
    in->adc_ib = (uint16_t)board_registers.current_b;
    in->adc_bus = (uint16_t)board_registers.bus;
    in->adc_temperature = (uint16_t)board_registers.temperature;
    in->angle = 0U;
    in->flags = (board_registers.broken != 0U) ? DRIVE_FLAG_BREAK : 0U;
    hal->ticks++;
}

/* No sensor of the shaft. */
hal_shaft_t hal_shaft(hal_t *hal)
{
    (void)hal;
    return (hal_shaft_t){0};
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    (void)hal;
    for (uint32_t phase = 0U; phase < 3U; phase++) {
        board_registers.compare[phase] = out->compare.phase[phase];
    }
    board_registers.gates = out->gate_enable ? 1U : 0U;
}

void hal_open_gates(hal_t *hal)
{
    (void)hal;
    board_registers.gates = 0U;
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    const uint32_t received = board_registers.received;

    (void)hal;
    if (received != 0U) {
        *byte = (uint8_t)received;
        board_registers.received = 0U;
    }
    return received != 0U;
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    const bool room = board_registers.sent == 0U;

    (void)hal;
    if (room) {
        board_registers.sent = BOARD_BYTE | byte;
    }
    return room;
}

/* The serial line alone commands. */
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

/* Two sensors: the sum of the three currents is zero. */
hal_health_t hal_health(const hal_t *hal)
{
    (void)hal;
    return (hal_health_t){
        .adc_ic =
            (uint16_t)(BOARD_NO_CURRENTS - board_registers.current_a - board_registers.current_b),
    };
}

/* No flash is kept for a configuration. */
bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    (void)slot;
    (void)unit;
    (void)bytes;
    return false;
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    (void)hal;
    (void)slot;
    return false;
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    (void)slot;
    (void)unit;
    (void)bytes;
    return false;
}

/* Nothing outlives a reset. */
void hal_keep(hal_t *hal, uint32_t index, uint32_t word)
{
    (void)hal;
    (void)index;
    (void)word;
}

uint32_t hal_kept(const hal_t *hal, uint32_t index)
{
    (void)hal;
    (void)index;
    return 0U;
}

/* The reason of the last reset is not known. */
hal_reset_t hal_reset(const hal_t *hal)
{
    (void)hal;
    return (hal_reset_t){.reason = HAL_RESET_UNKNOWN};
}
