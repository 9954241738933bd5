/* SPDX-License-Identifier: MIT */
/*
 * What the background checks of the measurements, beside what the control interrupt does
 * (supervision.h): the sum of the three phase currents (current_sum.h). A fault goes to the drive
 * as that of the background does, app_fail().
 */
#ifndef CROSS_CHECK_H
#define CROSS_CHECK_H

#include "app.h"

/*
 * Once per pass of the background; within one tick it does nothing more. A pass in which a control
 * interrupt comes counts for nothing. Context: background.
 */
void cross_check_step(app_t *app);

#endif
