/* SPDX-License-Identifier: MIT */
/*
 * The heat of the winding (i²t, derating.h) outlives a reset, because a motor does not cool down
 * when its drive starts again.
 *
 * The background keeps the heat, with its scale, in words that a reset leaves as they are
 * (hal_keep()). The start takes the heat from these words unchanged. It does not count the cooling
 * during the reset, so the heat is rather too high than too low. If there are no valid words, as
 * after a loss of supply, the heat is unknown and is set to KEPT_HEAT_UNKNOWN_Q24.
 */
#ifndef KEPT_HEAT_H
#define KEPT_HEAT_H

#include "app.h"

/*
 * 0.9 of the steady heat of the continuous current. Derating holds a winding at 1, so the winding
 * is hardly hotter, except after an OVERLOAD. Up to 0.9 derating allows the largest current
 * (derating_units.cpp). So a drive starts as usual, but the winding has little thermal reserve.
 */
#define KEPT_HEAT_UNKNOWN_Q24 (0xE66666)

/*
 * Set the drive's heat to the kept heat. Context: after app_init() has accepted the configuration,
 * before the control interrupt is enabled.
 */
void kept_heat_restore(app_t *app);

/*
 * Keep the drive's heat in the kept words. Does nothing before kept_heat_restore() has run.
 * Context: background, once per pass.
 */
void kept_heat_step(app_t *app);

#endif
