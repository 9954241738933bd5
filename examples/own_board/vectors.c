/* SPDX-License-Identifier: MIT */
/* Of the chip: its interrupts, and what opens the gates when nothing else can be relied on. */
#include "board.h"
#include "reset.h"

#define INTERRUPTS (1U)

extern const vector_t device_vectors[INTERRUPTS];

const vector_t device_vectors[INTERRUPTS] __attribute__((section(".vectors.device"), used)) = {
    board_conversions_complete,
};

void board_safe_state(void)
{
    board_registers.gates = 0U;
}

void board_wait(void)
{
    __asm volatile("wfi" ::: "memory");
}
