/* SPDX-License-Identifier: MIT */
/* The boards' interrupts: none is used, and each is unexpected. */
#include "reset.h"

#define INTERRUPTS (32U)

#define FOUR safe_state_handler, safe_state_handler, safe_state_handler, safe_state_handler

extern const vector_t device_vectors[INTERRUPTS];

const vector_t device_vectors[INTERRUPTS] __attribute__((section(".vectors.device"), used)) = {
    FOUR, FOUR, FOUR, FOUR, FOUR, FOUR, FOUR, FOUR,
};
