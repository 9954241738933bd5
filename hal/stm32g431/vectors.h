/*
 * The interrupt that this target handles, beside SysTick of startup.h; all others are
 * safe_state_handler().
 */
#ifndef VECTORS_H
#define VECTORS_H

#include "startup.h"

/* The control tick: ADC1's injected sequence is complete. Number 18. */
void ADC1_2_IRQHandler(void);

#endif
