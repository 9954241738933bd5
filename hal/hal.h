/* SPDX-License-Identifier: MIT */
/*
 * The whole contract between the control interrupt and the hardware.
 *
 * The build links exactly one binding. A binding owns the PWM timer, the converters and
 * the gate drivers; no code above it uses a register. docs/porting.md says how to write one.
 *
 * Timing. The PWM is centre aligned. The control interrupt runs once per PWM period, started by the
 * conversion in the middle of the low-side on-time (t_k). hal_apply() preloads the compare values in
 * that interrupt. They act for one period from t_k+1, the next such instant.
 */
#ifndef HAL_H
#define HAL_H

#include "drive.h"

#include <stdint.h>

/* Opaque: whatever the binding needs. A target may have exactly one. */
typedef struct hal hal_t;

/*
 * Fill the measured part of the frame (adc_ia, adc_ib, adc_bus, adc_temperature, angle, flags) with the
 * conversions of t_k. The temperature may be an older one. The angle is 0 without a sensor.
 * Context: control interrupt, first. Does not wait: the conversions are complete when it is called.
 */
void hal_sample(hal_t *hal, drive_in_t *in);

/*
 * Preload the three compare values, and open or enable the gates. Opening acts at once, by hardware
 * where there is a main output enable. Enabling acts at t_k+1 at the latest.
 * Context: control interrupt, last. Must finish before t_k+1. After a tick that does not, the binding has equal
 * duty on all phases from t_k+1 to t_k+2, thus no voltage, and sets DRIVE_FLAG_LATE in the next frame.
 */
void hal_apply(hal_t *hal, const drive_out_t *out);

/* Open the gates now. Context: any, also before the first tick and from fault handlers. */
void hal_open_gates(hal_t *hal);

/*
 * Free-running time in control ticks since the start, wrapping. Context: any. For time stamps in the
 * background; the control step itself has no clock.
 */
uint32_t hal_ticks(const hal_t *hal);

#endif
