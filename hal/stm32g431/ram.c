/* SPDX-License-Identifier: MIT */
#include "ram.h"

/* ram.S writes it. Where this word itself is broken it is not 0 either, but by chance. */
uint32_t ram_fault __attribute__((section(".noinit"), used));
