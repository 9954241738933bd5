/* SPDX-License-Identifier: MIT */
/*
 * The drive measures its own motor. This module plans the sequence of experiments, with their
 * currents and speeds.
 *
 * The background asks the drive for one experiment at a time by the words of probe.h, waits for its
 * window, and sends the sums as a line of text, a record. `motorsim identify` makes a motor file
 * from the records and the board's files. An experiment needs results of earlier ones, such as a
 * gain of the current control or the slope of a ramp. This module computes them, with an error of
 * some per cent.
 *
 *   PULSE   voltage pulses on the axes of the three phases, each larger than those before, until a
 *           quarter of the continuous current flows; they show whether the phases are connected,
 *           and L
 *   CATCH   the current rises to the continuous current, and its vector turns by half an electrical
 *           turn and takes the rotor along
 *   STILL   on the axis of each phase: the voltage at each of 14 currents; then pulses along and
 *           across the current
 *   SPIN    the vector turns at a quarter of the highest speed, at half of it and at all of it
 *   RAMP    the speed goes down to half of the highest speed and up again, so fast that the rotor
 *           lags by about 17 degrees
 *   COAST   no current flows, and the frame follows the rotor that coasts
 *   HALL    with Hall sensors: the vector turns backwards and then forwards, at a constant speed. A
 *           failure here does not lose what is measured: the identification ends as well as without
 *
 * The rules are not made for a particular motor. Currents are shares of the name plate's currents.
 * Times are periods of a rectified mains, or ticks of the current control, whose gains follow the
 * measured L. The highest speed is half of the name plate's speed, and less where the bus voltage
 * is too low for that.
 *
 * A record is `= KIND` and 19 numbers: axis, current, speed, pulse along, pulse across, quarter,
 * ticks; the sums of probe_sums_t in their order. KIND is one of pulse, catch, still, burst (pulses
 * on a current), spin, ramp, hold (constant speed after a ramp), coast, hall. A record of hall has
 * eleven more numbers: those of hall_survey_t from start_q16 on, in their order. A first line gives
 * the scales of the records: `identify 2`, tick in ps, full scale of the current in µA and of the
 * bus in µV, pole pairs, and the shift of speeds (drive_cfg_t.speed_shift). The last line is
 * `identify done`. Each of these lines ends with ` #` and eight hexadecimal digits: the CRC-32 of
 * the characters before ` #` in this line and in all earlier lines of these kinds. So the CRC of
 * the next line at the latest shows that a line was changed, lost or exchanged, and a reader can
 * recognise a line that a log contains twice. Other lines may come between these lines. Records of
 * `identify 1` had no CRC and no end.
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
 * Begins an identification. Returns NULL, or the reason for a refusal: an identification is under
 * way, a change of the configuration is pending, the drive is not READY, or the configuration has
 * an example motor, whose currents and speeds may be far too high for the connected one. The last
 * line of the identification says every other refusal. Withdraws a run that the drive has not taken
 * yet.
 */
const char *identify_start(identify_t *identify);

/* Whether an identification is under way. */
bool identify_is_busy(const identify_t *identify);

/*
 * Ends the identification: the gates open, and the target from before it is in force again. Does
 * nothing if no identification is under way.
 */
void identify_stop(identify_t *identify);

/*
 * Ends the identification for a reason, which the last line says. The gates open at once. Does
 * nothing if no identification is under way, or if it is ending already.
 */
void identify_refuse(identify_t *identify, const char *why);

/*
 * One pass of the background, once a tick or less often. Writes at most one line, and only into an
 * empty `text`: earlier lines are sent first, so no line is lost. An identification first waits for
 * a warm winding to cool (identify_heat.h). After 2 minutes it ends in any case, with open gates.
 */
void identify_step(identify_t *identify, text_t *text);

#endif
