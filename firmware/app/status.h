/* SPDX-License-Identifier: MIT */
/*
 * The state of the drive as one line of text, in the units of a person:
 *
 *     RUN, speed 1500 of 1500 rpm, phases 1.200 -0.600 -0.600 A, bus 24.010 V, 31 C, late 0, …
 *
 * With open gates and without a sensor the speed is unknown: "READY, speed unknown, asked 1500 rpm,
 * …". In position mode the line has "speed 1500 rpm, turn 2.75, to turn 3.00", and in torque mode
 * "speed 1500 rpm, torque 2.500000 N m". While the motor is measured, "measuring the motor" takes
 * the place of the target speed. In FAULT, the fault follows the state's name, with value, limit
 * and what to check; OSCILLATION also has its frequency. If there was a swing since the start that
 * was not a fault (oscillation.h), its frequency comes next. Then the line says if the bandwidth of
 * the speed loop is lowered.
 *
 * With a sensor of the shaft the line ends with "angle by sensor" or, in RUN, "angle by observer".
 * "sensor: hall_signal" follows if there was a trouble since the last request to run, or if the
 * angle is unknown: shaft_trouble_text(), "sensor_turned" if the drive found the sensor wrong.
 */
#ifndef STATUS_H
#define STATUS_H

#include "about.h"
#include "app.h"
#include "text.h"

/*
 * Append a fault with value and limit in their units: "OVERVOLTAGE 61.200 V, limit 60.000 V".
 * Context: background.
 */
void status_add_fault(text_t *text, const about_t *about, fault_id_t id, int32_t value,
                      int32_t limit);

/*
 * Append the status, without the end of a line. The currents are as measured, with the amplifiers'
 * offset: check this offset at the first power-up. `hal` gives its health; it is the same as
 * app->hal, which app_init() sets. Context: background. A tick may come in between, so the
 * quantities may be of different ticks.
 */
void status_add(text_t *text, const app_t *app, const hal_t *hal, const about_t *about);

#endif
