/* SPDX-License-Identifier: MIT */
/*
 * Finds which of several causes has led to a fault, by signs: facts that the drive knows. Signs are
 * the frequency of a swing, compared with the speed of the rotor and with the phase lag of the
 * speed loop; the limits in force; the noise of the current sensors at rest; the phase currents.
 * fault_text.h lists all signs and the advice.
 *
 * The functions look at the state of the drive as the fault has left it. The control tick does only
 * one thing for them: it notes the scene of a fault (fault_scene_t). Context: background, in FAULT.
 */
#ifndef DIAGNOSIS_H
#define DIAGNOSIS_H

#include "state.h"

#include <stdint.h>

/*
 * Returns the signs of the latched fault: bit k stands for the sign k of fault_sign_t. pole_pairs:
 * 1…50.
 */
uint32_t diagnosis_signs(const drive_t *drive, uint32_t pole_pairs);

/* Returns the advice on the latched fault. Never NULL. */
const char *diagnosis_advice(const drive_t *drive, uint32_t pole_pairs);

#endif
