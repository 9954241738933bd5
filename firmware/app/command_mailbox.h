/* SPDX-License-Identifier: MIT */
/*
 * The user's command on its way from the background to the control interrupt.
 *
 * A command is several words; the interrupt may come between any two of the background's stores. So the background
 * writes into the slot that is not in force, and one aligned store then puts it in force: the interrupt sees the
 * command before or the whole new one, never target and mode of two.
 *
 * One background posts and one interrupt on the same core takes; the background cannot interrupt the interrupt.
 * Nothing waits, nothing fails. Two commands posted between two ticks: the later one counts.
 */
#ifndef COMMAND_MAILBOX_H
#define COMMAND_MAILBOX_H

#include "drive.h"

#include <stdint.h>

#define COMMAND_MAILBOX_SLOTS (2U)

typedef struct {
    drive_command_t slots[COMMAND_MAILBOX_SLOTS];
    volatile uint32_t in_force; /* index, 0 or 1; written by the background only */
} command_mailbox_t;

/* In force: speed 0, no request. Call before the control interrupt is enabled. */
void command_mailbox_init(command_mailbox_t *box);

/* Puts the whole of `command` in force, copied. From the background only; the interrupt may come at any instruction. */
void command_mailbox_post(command_mailbox_t *box, const drive_command_t *command);

/* The command in force. From the interrupt, and from the background that posts. */
drive_command_t command_mailbox_take(const command_mailbox_t *box);

#endif
