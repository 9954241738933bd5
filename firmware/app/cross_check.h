/* SPDX-License-Identifier: MIT */
/*
 * The check of the measurements by the background, in addition to those by the control interrupt
 * (supervision.h): it checks the sum of the three phase currents (current_sum.h). It reports a
 * fault to the drive by app_fail().
 */
#ifndef CROSS_CHECK_H
#define CROSS_CHECK_H

#include "app.h"

/*
 * Call once per pass of the background. It checks once a tick. If a control interrupt comes during
 * a check, that check is discarded. Context: background.
 */
void cross_check_step(app_t *app);

#endif
