/* SPDX-License-Identifier: MIT */
/*
 * The heat of the winding (i²t, derating.h) outlives a reset: a motor does not cool down because
 * its drive starts anew.
 *
 * The background keeps it in words that a reset leaves as they are (hal_keep()), with the scale
 * that it is in. The start takes it from there as it was: what the winding has cooled meanwhile is
 * not counted, so the heat errs to the warm side. Where no valid words are found, as after the
 * supply was away, nobody knows the winding: the heat is KEPT_HEAT_UNKNOWN_Q24.
 */
#ifndef KEPT_HEAT_H
#define KEPT_HEAT_H

#include "app.h"

/*
 * 0.9 of the steady heat of the continuous current. Derating holds a winding at 1, so the winding
 * is hardly hotter; only after an OVERLOAD it may be. Up to 0.9 derating leaves the largest current
 * (derating_units.cpp): a drive starts as ever, and has little reserve.
 */
#define KEPT_HEAT_UNKNOWN_Q24 (0xE66666)

/*
 * Warm the drive by what was kept. Context: after app_init() has accepted the configuration, before
 * the control interrupt is enabled.
 */
void kept_heat_restore(app_t *app);

/*
 * Keep the heat. Before kept_heat_restore() it leaves the words as they are. Context: background,
 * once per pass.
 */
void kept_heat_step(app_t *app);

#endif
