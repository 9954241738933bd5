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

/* Close the loop. Returns NULL, or why it is refused: a fault is latched. */
const char *commander_run(app_t *app);

/* Open the gates; the motor coasts. */
void commander_stop(app_t *app);

/* Acknowledge the fault. Returns NULL, or why it is refused: there is none. */
const char *commander_clear(app_t *app);

/* The electrical speed from now on, also while the drive runs. The caller keeps to the motor's limit. */
void commander_set_speed(app_t *app, step_t speed);

/*
 * Takes a clear back once the fault is left: kept, it would clear the next fault unseen. Call once per pass of the
 * background.
 */
void commander_step(app_t *app);

#endif
