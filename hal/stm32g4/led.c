/* SPDX-License-Identifier: MIT */
#include "led.h"

#include "board.h"
#include "reg.h"
#include "stm32g4.h"

#include <stdbool.h>

#define FAST_HZ (8U) /* changes per second */
#define SLOW_HZ (2U)

void led_show(drive_state_t state, uint32_t ticks)
{
    const uint32_t ticks_per_second = BOARD_CLOCK_HZ / (2U * BOARD.timer_counts);
    const uint32_t changes = (state == DRIVE_STATE_FAULT) ? FAST_HZ : SLOW_HZ;
    const bool blink = ((ticks / (ticks_per_second / changes)) % 2U) != 0U;
    const bool on = (state == DRIVE_STATE_RUN) || blink;

    reg_write(BOARD.led_port + GPIO_BSRR, on ? BOARD.led_on : BOARD.led_off);
}
