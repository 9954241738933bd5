/* SPDX-License-Identifier: MIT */
/*
 * Whoever commands the drive while it runs: a console or another link of the background. Each function changes what it names
 * of the command in force, and leaves the rest of it. The last one asked for counts, whoever asked.
 *
 * Context: background. No function waits. The drive takes the command once a slow period. Of two changes between two takes
 * it sees the later one. A request to clear stays in force until the next take.
 */
#ifndef COMMANDER_H
#define COMMANDER_H

#include "app.h"

#include <stdbool.h>

/* Close the loop. Returns NULL, or why it is refused: a fault is latched. */
const char *commander_run(app_t *app);

/* Open the gates; the motor coasts. */
void commander_stop(app_t *app);

/* Acknowledge the fault. Returns NULL, or why it is refused: there is none. */
const char *commander_clear(app_t *app);

/* Speed mode with this electrical speed from now on, also while the drive runs. The caller keeps to the motor's limit. */
void commander_set_speed(app_t *app, step_t speed);

/* Torque mode with this torque from now on, Q28 of T_b. The caller keeps to commander_torque_max(). */
void commander_set_torque(app_t *app, int32_t torque_q28);

/* The largest torque of the motor's largest current, by the configuration, Q28 of T_b; 0 before the drive is initialised. */
int32_t commander_torque_max(const app_t *app);

/*
 * A whole command. speed_max: of the motor, electrical, either way. Returns NULL, or why it is refused, and then the command in
 * force stays: a request or a mode that there is not, a run in FAULT, a clear without a fault, a speed beyond speed_max, a torque beyond
 * commander_torque_max(). A stop is never refused: with such a mode or target it leaves those in force.
 */
const char *commander_command(app_t *app, const drive_command_t *command, step_t speed_max);

/* In speed mode the target in force stays within ±speed_max from now on, electrical. */
void commander_limit_speed(app_t *app, step_t speed_max);

/* As at the start: no request, and speed 0. For another motor, whose target is in other steps. */
void commander_begin_anew(app_t *app);

/* Whether the gates are open, and nothing in force closes them. */
bool commander_is_at_rest(const app_t *app);

/*
 * Takes a clear back once the fault is left: kept, it would clear the next fault unseen. Call once per pass of the
 * background.
 */
void commander_step(app_t *app);

#endif
