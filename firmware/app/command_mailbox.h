/* SPDX-License-Identifier: MIT */
/*
 * The user's command on its way from the background to the control interrupt.
 *
 * A command has several words, and the interrupt may come between any two stores of the background.
 * So the background writes into the slot that is not in force, and one aligned store then puts that
 * slot in force. The interrupt sees either the old command or the whole new one, never a mixture.
 *
 * Between two posts both slots hold the same command, each with a check word. So a bit that flips
 * by itself in this memory changes no command: the interrupt takes the other slot, and the next
 * command_mailbox_mend() repairs the damaged one. If both slots are damaged, the command is speed 0
 * without a request.
 *
 * One background posts and one interrupt on the same core takes. The background must not interrupt
 * the interrupt. No function waits or fails. The interrupt takes once a slow period. Of two
 * commands posted between two takes, the later one counts.
 */
#ifndef COMMAND_MAILBOX_H
#define COMMAND_MAILBOX_H

#include "drive.h"

#include <stdint.h>

#define COMMAND_MAILBOX_SLOTS (2U)

typedef struct {
    drive_command_t command;
    uint32_t check; /* check word of the command */
} command_slot_t;

typedef struct {
    command_slot_t slots[COMMAND_MAILBOX_SLOTS];
    /* the lowest bit is the index of the slot in force; written by the background only */
    volatile uint32_t in_force;
} command_mailbox_t;

/*
 * Puts a command in force: speed 0 without a request. Call before the control interrupt is enabled.
 */
void command_mailbox_init(command_mailbox_t *box);

/*
 * Copies `command` and puts it in force as a whole. Context: background; the interrupt may come at
 * any instruction.
 */
void command_mailbox_post(command_mailbox_t *box, const drive_command_t *command);

/* Returns the command in force. Context: the interrupt, and the background that posts. */
drive_command_t command_mailbox_take(const command_mailbox_t *box);

/* Repairs a slot in which a bit has flipped. Call once per pass of the background. */
void command_mailbox_mend(command_mailbox_t *box);

#endif
