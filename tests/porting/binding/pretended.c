/* SPDX-License-Identifier: MIT */
/*
 * On a PC the power stage is pretended: no current, 310 V, a cool stage. The program ends with 0
 * once the drive, by itself, has measured its sensors' zeros and then enabled the gates for the run
 * that a person has typed. It prints what the console says.
 */
#include "board.h"

#include <stdio.h>
#include <stdlib.h>

#define PERIODS (2000U) /* 0.2 s; the calibration takes 0.0256 s */

volatile board_registers_t board_registers = {
    .current_a = 2048U, .current_b = 2048U, .bus = 2822U, .temperature = 1024U};

/* A byte a period at most, either way. */
static void use_console(void)
{
    static const char *typed = "speed 1000\rrun\r";

    if ((board_registers.received == 0U) && (*typed != '\0')) {
        board_registers.received = BOARD_BYTE | (uint32_t)*typed;
        typed++;
    }
    if (board_registers.sent != 0U) {
        (void)putchar((int)(board_registers.sent & 0xFFU));
        board_registers.sent = 0U;
    }
}

void board_wait(void)
{
    static uint32_t periods;
    static uint32_t enabled; /* in this period */

    if (board_registers.run != 0U) {
        board_conversions_complete();
    }
    use_console();
    periods++;
    if ((board_registers.gates != 0U) && (enabled == 0U)) {
        enabled = periods;
    }
    if (periods == PERIODS) {
        exit((enabled > 256U) ? EXIT_SUCCESS : EXIT_FAILURE);
    }
}
