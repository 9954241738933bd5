/* SPDX-License-Identifier: MIT */
#include "command_mailbox.h"

#include "barrier.h"

void command_mailbox_init(command_mailbox_t *box)
{
    *box = (command_mailbox_t){.in_force = 0U};
}

/* The barriers keep the slot's stores between this store of the index and the one before. */
void command_mailbox_post(command_mailbox_t *box, const drive_command_t *command)
{
    const uint32_t next = (box->in_force + 1U) % COMMAND_MAILBOX_SLOTS;

    box->slots[next] = *command;
    barrier_compiler();
    box->in_force = next;
    barrier_compiler();
}

drive_command_t command_mailbox_take(const command_mailbox_t *box)
{
    return box->slots[box->in_force];
}
