/* SPDX-License-Identifier: MIT */
/*
 * Commands to the drive while it runs, from the sources of the background: the console, the link of
 * a PC, an input. Each function changes one part of the command in force and leaves the rest. The
 * table of source.h decides whether the source may; otherwise the command in force stays.
 *
 * Context: background. No function waits. The drive takes the command once a slow period. Of two
 * changes between two takes it sees the later one. A request to clear stays in force until the
 * drive has left FAULT. A fault ends a request to run.
 *
 * A message of a PC may arrive late, twice, or out of order. So each message that may command
 * carries a ticket, a number that is valid once. Each such message, each request to run, stop or
 * clear, each fault and anything else that ends a request makes a new ticket. A message that was
 * sent before carries an old ticket, and its command is refused, however late it arrives. Only a
 * stop is always carried out.
 *
 * What console and link command, each stop, each fault and each change of the configuration is an
 * upset: an input has to be seen at rest afterwards before it may start the motor (input.h).
 */
#ifndef COMMANDER_H
#define COMMANDER_H

#include "app.h"

#include <stdbool.h>

/* The reason why a command of an input is refused while another source is in command. */
#define COMMANDER_TAKEN "another source commands the drive"

/* The reason why a command with an old ticket is refused. */
#define COMMANDER_STALE "the drive has been commanded or has stopped since; ask again"

/*
 * Returns the source whose run or measurement is in force; SOURCE_NONE: nothing is asked of the
 * drive, or nobody has asked.
 */
source_t commander_source(const app_t *app);

/* An input has to be seen at rest from now on. */
void commander_upset(app_t *app);

/* Returns the ticket that is valid now. */
uint32_t commander_ticket(const app_t *app);

/*
 * Returns whether a ticket is valid. This call uses up a valid ticket: it is not valid a second
 * time.
 */
bool commander_take_ticket(app_t *app, uint32_t ticket);

/*
 * Makes a new ticket: earlier tickets are not valid any more. salt: 0, or the number that a PC has
 * drawn for its session.
 */
void commander_renew_ticket(app_t *app, uint32_t salt);

/*
 * Requests a run. Returns NULL, or the reason for a refusal: a fault is latched, or another source
 * is in command.
 */
const char *commander_run(app_t *app, source_t source);

/* Requests a stop: the gates open, and the motor coasts. */
void commander_stop(app_t *app, source_t source);

/*
 * Requests to clear the fault. Returns NULL, or the reason for a refusal: there is no fault, or
 * another source is in command.
 */
const char *commander_clear(app_t *app, source_t source);

/* The source has begun a measurement of the motor, so it is in command. */
void commander_measures(app_t *app, source_t source);

/*
 * Makes the present position of the rotor the zero from which positions are counted. In position
 * mode the target becomes 0, so the rotor stays where it is. The request stays in force until the
 * drive has taken it. The source is in command then, as with a target. Returns NULL, or the reason
 * for a refusal: with open gates and without a sensor the position is unknown.
 */
const char *commander_zero(app_t *app, source_t source);

/*
 * Sets speed mode with this electrical speed. Allowed while the drive runs. The caller must keep
 * the speed within the motor's limit. Returns whether the source may set it.
 */
bool commander_set_speed(app_t *app, source_t source, step_t speed);

/*
 * Sets torque mode with this torque, Q28 of T_b. The caller must keep the torque within
 * ±commander_torque_max(). Returns whether the source may set it.
 */
bool commander_set_torque(app_t *app, source_t source, int32_t torque_q28);

/*
 * Returns the torque of the motor at its largest current, computed from the configuration, Q28 of
 * T_b; 0 before the drive is initialised.
 */
int32_t commander_torque_max(const app_t *app);

/*
 * Puts a whole command of the link in force. counts: its ticket is valid. speed_max: the motor's
 * limit, electrical, for both directions. Returns NULL, or the reason for a refusal; then the
 * command in force stays. These commands are refused: an unknown request or mode, a run in FAULT, a
 * clear without a fault, a speed beyond speed_max, a torque beyond commander_torque_max(), and a
 * command whose ticket is not valid. A stop is never refused, whatever its ticket. A stop with a
 * wrong mode or target leaves the mode and target in force.
 */
const char *commander_command(app_t *app, const drive_command_t *command, bool counts,
                              step_t speed_max);

/* In speed mode: limits the target in force to ±speed_max, electrical. */
void commander_limit_speed(app_t *app, step_t speed_max);

/*
 * Puts speed 0 without a request in force, as at the start. Call after a change to another motor,
 * because the target in force is in steps of the old motor.
 */
void commander_begin_anew(app_t *app);

/* Whether the drive is in READY or FAULT with open gates, and no request is in force. */
bool commander_is_at_rest(const app_t *app);

/*
 * Lets the next configuration of a PC protect less than the one in force (config_lock.h). The
 * unlocking ends when that configuration is taken or refused, when the drive is no longer at rest,
 * and when a PC gives the line back or takes it again. Returns NULL, or the reason for a refusal:
 * the drive is not at rest.
 */
const char *commander_unlock(app_t *app);

/* Ends the unlocking by commander_unlock(). */
void commander_lock(app_t *app);

/*
 * Ends the unlocking when the drive is not at rest. Withdraws a clear once the drive has left
 * FAULT: otherwise it would clear the next fault unseen. Withdraws a run once there is a fault:
 * otherwise the motor would start when the drive leaves FAULT. Withdraws a zero once the drive has
 * taken it. Call once per pass of the background.
 */
void commander_step(app_t *app);

#endif
