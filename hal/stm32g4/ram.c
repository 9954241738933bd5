/* SPDX-License-Identifier: MIT */
#include "ram.h"

/* ram.S writes it. If this word itself is broken, it may read as 0. */
uint32_t ram_fault __attribute__((section(".noinit"), used));
