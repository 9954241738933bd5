/* SPDX-License-Identifier: MIT */
/*
 * On a PC the power stage is pretended: no current, 310 V, a cool stage. The program ends with 0 once the drive, by itself,
 * has measured its sensors' zeros and then enabled the gates for the run that it was asked for.
 */
#include "hal_mine.h"

#include <stdlib.h>

#define PERIODS (2000U) /* 0.2 s; the calibration takes 0.0256 s */

volatile mine_registers_t mine_registers = {
    .current_a = 2048U, .current_b = 2048U, .bus = 2822U, .temperature = 1024U};

void mine_wait(void)
{
    static uint32_t periods;

    if (mine_registers.run != 0U) {
        mine_conversions_complete();
    }
    periods++;
    if (mine_registers.gates != 0U) {
        exit((periods > 256U) ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    if (periods == PERIODS) {
        exit(EXIT_FAILURE);
    }
}
