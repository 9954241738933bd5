/* SPDX-License-Identifier: MIT */
/*
 * The drive measures its own motor: which experiments follow each other, and with which current and
 * speed.
 *
 * The background asks the drive for one experiment at a time by the words of probe.h, waits for its
 * window, and sends the sums as a line of text, a record. Whoever has the records and the board's
 * files makes a motor file of them (`motorsim identify`). What an experiment needs of those before
 * it, a gain of the current control or how steep a ramp may be, is computed here, to some per cent.
 *
 *   PULSE   voltage pulses on the axes of the three phases, each larger than those before, until a
 *           quarter of the continuous current flows: are the phases connected, and what is L
 *   CATCH   half a turn with the continuous current takes the rotor along
 *   STILL   on the axis of each phase: voltage over current, at 14 currents; then pulses along and
 *           across the current
 *   SPIN    the vector turns at a quarter of the speed, at half of it and at the whole
 *   RAMP    down to half of the speed and up again, as steep as lets the rotor lag by about 17
 *           degrees
 *   COAST   no current, the frame follows the rotor
 *
 * No rule knows a motor. Currents are shares of those of the name plate, times are periods of a
 * rectified mains, or ticks of the current control, which follows the measured L. The highest speed
 * is half of that of the name plate, and less where the bus does not reach that.
 *
 * Records. `= KIND` and 19 numbers: axis, current, speed, pulse along, pulse across, quarter,
 * ticks; the sums of probe_sums_t in their order. KIND: pulse, catch, still, burst (pulses on a
 * current), spin, ramp, hold (the speed after a ramp), coast. A first line gives their scales:
 * `identify 2`, tick in ps, full scale of the current in µA and of the bus in µV, pole pairs, and
 * the shift of speeds (drive_cfg_t.speed_shift). The last one is `identify done`. Each of these
 * lines ends with ` #` and eight hexadecimal digits: the CRC-32 of its characters before that, and
 * of those of all these lines before it. So a line that was changed, lost or exchanged shows in the
 * next one at the latest, and a line that a log has twice is known. Lines of another kind may come
 * between them. Records of `identify 1` had no CRC and no end.
 *
 * Context: background.
 */
#ifndef IDENTIFY_H
#define IDENTIFY_H

#include "identify_state.h"
#include "text.h"

#include <stdbool.h>

void identify_init(identify_t *identify, app_t *app, const about_t *about);

/*
 * Begin. Returns NULL, or why not: it has begun, a change of the configuration is pending, the
 * drive is not READY, or the motor of the configuration is an example: its currents and speeds may
 * be far too high for the one that is connected. All other refusals are its last line. A run that
 * was asked for and not taken yet is taken back.
 */
const char *identify_start(identify_t *identify);

/* Whether it has begun and not ended. */
bool identify_is_busy(const identify_t *identify);

/*
 * End it: the gates open, and the speed that was asked for before is so again. Nothing happens when
 * it is not busy.
 */
void identify_stop(identify_t *identify);

/*
 * End it with a reason, which its last line says. The gates open at once. Nothing happens when it
 * is not busy, or has its reason.
 */
void identify_refuse(identify_t *identify, const char *why);

/*
 * One pass of the background, once a tick or less often. It says at most one line, and only in a
 * `text` that is empty: it waits until the lines before are sent, and none is lost. A warm winding
 * is waited for first (identify_heat.h). After 2 minutes it ends all the same, with open gates.
 */
void identify_step(identify_t *identify, text_t *text);

#endif
