/* SPDX-License-Identifier: MIT */
/*
 * The interrupt that this target handles, beside SysTick of reset.h; all others are
 * safe_state_handler().
 */
#ifndef VECTORS_H
#define VECTORS_H

#include "reset.h"

/* The control tick: ADC1's injected sequence is complete. Number 18. */
void ADC1_2_IRQHandler(void);

#endif
