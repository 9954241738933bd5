/* SPDX-License-Identifier: MIT */
#include "ram.h"

#include "hal_g4.h"
#include "reg.h"
#include "reset.h"
#include "stm32g4.h"

/* of the linker script */
extern uint32_t kept_start;
extern uint32_t kept_end;

/* ram.S writes them. If such a word itself is broken, it may read as 0. */
uint32_t ram_fault __attribute__((section(".noinit"), used));
const uint32_t *ram_tested_end __attribute__((section(".noinit"), used)); /* of the reset entry */

/* A number of this image. It is not 0, which an empty backup register has. */
static uint32_t mark(void)
{
    return build_id_note[BUILD_ID_FIRST_WORD] | 1U;
}

/* Returns the end of what the reset entry has to test. ram.S calls it, before any variable is used.
 */
__attribute__((used)) const uint32_t *ram_test_end(void)
{
    reg_set(RCC_APB1ENR1, RCC_APB1ENR1_RTCAPB);
    (void)reg_read(RCC_APB1ENR1);
    return (reg_read(HAL_G4_RAM_MARK) == mark()) ? &kept_start : &kept_end;
}

bool ram_is_kept(void)
{
    return ram_tested_end == &kept_start;
}

void ram_test_kept(void)
{
    if (ram_is_kept() && (ram_fault == 0U)) {
        ram_fault = ram_test(&kept_start, &kept_end);
    }
}

void ram_keep(void)
{
    reg_write(HAL_G4_RAM_MARK, mark());
}

void ram_forget(void)
{
    reg_write(HAL_G4_RAM_MARK, 0U);
}
