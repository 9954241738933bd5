/* SPDX-License-Identifier: MIT */
/*
 * The one interrupt that this target handles; all others are safe_state_handler(). It also handles
 * the exceptions NMI and SysTick of reset.h.
 */
#ifndef VECTORS_H
#define VECTORS_H

#include "reset.h"

/* The control tick: the longer one of the injected sequences is complete. Number 18. */
void ADC1_2_IRQHandler(void);

#endif
