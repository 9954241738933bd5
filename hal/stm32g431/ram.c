/* SPDX-License-Identifier: MIT */
#include "ram.h"

/* ram.S writes it. If this word itself is broken, it differs from 0 only by chance. */
uint32_t ram_fault __attribute__((section(".noinit"), used));
