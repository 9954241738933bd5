/* SPDX-License-Identifier: MIT */
/* The chip's interrupts, RM0440 table 97: one is used, the others are unexpected. */
#include "vectors.h"

#define EIGHT \
    safe_state_handler, safe_state_handler, safe_state_handler, safe_state_handler, \
        safe_state_handler, safe_state_handler, safe_state_handler, safe_state_handler
#define INTERRUPTS (102U)

extern const vector_t device_vectors[INTERRUPTS];

const vector_t device_vectors[INTERRUPTS] __attribute__((section(".vectors.device"), used)) = {
    EIGHT,
    EIGHT,
    safe_state_handler,
    safe_state_handler,
    ADC1_2_IRQHandler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    EIGHT,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
    safe_state_handler,
};
