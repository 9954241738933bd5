/* SPDX-License-Identifier: MIT */
/*
 * The background checks the measurements too, in addition to the control interrupt (supervision.h).
 * It checks the sum of the three phase currents (current_sum.h), and reports a fault to the drive
 * by app_fail().
 */
#ifndef CROSS_CHECK_H
#define CROSS_CHECK_H

#include "app.h"

/*
 * Call once per pass of the background. It checks at most once a tick. If a control interrupt comes
 * during a check, that check is discarded. Context: background.
 */
void cross_check_step(app_t *app);

#endif
