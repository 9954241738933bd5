/* SPDX-License-Identifier: MIT */
/*
 * The whole contract between the control interrupt and the hardware.
 *
 * Exactly one binding is linked, chosen by the build. A binding owns the PWM timer, the converters and
 * the gate drivers; nothing above it knows a register. docs/porting.md says how to write one.
 *
 * Timing. The PWM is centre aligned and the control interrupt runs once a PWM period, started by the
 * conversion taken in the middle of the low-side on-time (t_k). Compare values handed to hal_apply()
 * in that interrupt are preloaded and act from t_k+1, the next such instant, for one period.
 */
#ifndef HAL_H
#define HAL_H

#include "drive.h"

#include <stdint.h>

/* Opaque: whatever the binding needs. A target may have exactly one. */
typedef struct hal hal_t;

/*
 * Fill the measured part of the frame (adc_ia, adc_ib, adc_bus, adc_temperature, angle, flags) with the
 * conversions of t_k; the temperature may be an older one, the angle is 0 without a sensor.
 * Context: control interrupt, first. Does not wait: the conversions are complete when it is called.
 */
void hal_sample(hal_t *hal, drive_in_t *in);

/*
 * Preload the three compare values, and open or enable the gates. Opening acts at once, by hardware
 * where there is a main output enable; enabling acts no later than t_k+1.
 * Context: control interrupt, last. Must finish before t_k+1: a tick that does not leaves equal duty on
 * all phases from t_k+1 to t_k+2, thus no voltage, and the next frame has DRIVE_FLAG_LATE.
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
