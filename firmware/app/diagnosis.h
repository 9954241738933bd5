/* SPDX-License-Identifier: MIT */
/*
 * Tells the causes of a fault apart by what the drive knows: the frequency of a swing compared with
 * the rotor's turns and with the lag of the loop, the limits in force, the noise of the current
 * sensors at rest, the phase currents. fault_text.h has the signs and the advice.
 *
 * When asked, it looks at the state that the fault has left. The only cost in the tick is to note
 * the scene of a fault. Context: background, in FAULT.
 */
#ifndef DIAGNOSIS_H
#define DIAGNOSIS_H

#include "state.h"

#include <stdint.h>

/* The signs of the latched fault: bit k stands for the sign k of fault_sign_t. pole_pairs: 1…50. */
uint32_t diagnosis_signs(const drive_t *drive, uint32_t pole_pairs);

/* Advice on the latched fault. Never NULL. */
const char *diagnosis_advice(const drive_t *drive, uint32_t pole_pairs);

#endif
