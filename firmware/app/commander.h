/* SPDX-License-Identifier: MIT */
/*
 * Whoever commands the drive while it runs: a console or another link of the background. Each
 * function changes what it names of the command in force, and leaves the rest of it. The last one
 * asked for counts, whoever asked.
 *
 * Context: background. No function waits. The drive takes the command once a slow period. Of two
 * changes between two takes it sees the later one. A request to clear stays in force until the next
 * take. A request to run ends with a fault.
 *
 * What a PC has sent may come late, twice, or in another order. So each of its messages that may
 * command carries a ticket, a number that is good once. Each such message, each command, each fault
 * and whatever else ends what was asked for makes a new ticket. What was sent before then carries
 * an old one, and does not count, however late it comes.
 */
#ifndef COMMANDER_H
#define COMMANDER_H

#include "app.h"

#include <stdbool.h>

/* Why a command does not count: its ticket is an old one. */
#define COMMANDER_STALE "the drive has been commanded or has stopped since; ask again"

/* The ticket that counts now. */
uint32_t commander_ticket(const app_t *app);

/* Whether a ticket counts. One that does is spent: it counts no second time. */
bool commander_take_ticket(app_t *app, uint32_t ticket);

/*
 * Makes a new ticket: no earlier one counts from now on. salt: 0, or the number that a PC has drawn
 * for its session.
 */
void commander_renew_ticket(app_t *app, uint32_t salt);

/* Close the loop. Returns NULL, or why it is refused: a fault is latched. */
const char *commander_run(app_t *app);

/* Open the gates; the motor coasts. */
void commander_stop(app_t *app);

/* Acknowledge the fault. Returns NULL, or why it is refused: there is none. */
const char *commander_clear(app_t *app);

/*
 * Positions count from here on. In position mode the drive is to stay here: the target becomes 0.
 * The request stays in force until the next take. Returns NULL, or why it is refused: with open
 * gates and without a sensor nobody knows where the rotor is.
 */
const char *commander_zero(app_t *app);

/*
 * Speed mode with this electrical speed from now on, also while the drive runs. The caller keeps to
 * the motor's limit.
 */
void commander_set_speed(app_t *app, step_t speed);

/*
 * Torque mode with this torque from now on, Q28 of T_b. The caller keeps to commander_torque_max().
 */
void commander_set_torque(app_t *app, int32_t torque_q28);

/*
 * The largest torque of the motor's largest current, by the configuration, Q28 of T_b; 0 before the
 * drive is initialised.
 */
int32_t commander_torque_max(const app_t *app);

/*
 * A whole command of a PC. speed_max: of the motor, electrical, either way. Returns NULL, or why it
 * is refused, and then the command in force stays: a request or a mode that there is not, a run in
 * FAULT, a clear without a fault, a speed beyond speed_max, a torque beyond commander_torque_max(),
 * a ticket that does not count. A stop is never refused: whatever its ticket, and with such a mode
 * or target it leaves those in force.
 */
const char *commander_command(app_t *app, const drive_command_t *command, bool counts,
                              step_t speed_max);

/* In speed mode the target in force stays within ±speed_max from now on, electrical. */
void commander_limit_speed(app_t *app, step_t speed_max);

/* As at the start: no request, and speed 0. For another motor, whose target is in other steps. */
void commander_begin_anew(app_t *app);

/* Whether the gates are open, and nothing in force closes them. */
bool commander_is_at_rest(const app_t *app);

/*
 * The next configuration of a PC may protect less than the one in force (config_lock.h). The
 * unlocking ends with that configuration, taken or refused; as soon as the drive does not rest; and
 * when a PC gives the line back or takes it anew. Returns NULL, or why it is refused: the drive
 * does not rest.
 */
const char *commander_unlock(app_t *app);

/* Ends the unlocking. */
void commander_lock(app_t *app);

/*
 * Locks again where the drive does not rest. Takes a clear back once the fault is left: kept, it
 * would clear the next fault unseen. Takes a run back once there is a fault: kept, whatever left
 * FAULT would start the motor. Takes a zero back once the drive has it. Call once per pass of the
 * background.
 */
void commander_step(app_t *app);

#endif
