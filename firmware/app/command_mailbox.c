/* SPDX-License-Identifier: MIT */
#include "command_mailbox.h"

#include "barrier.h"
#include "inlining.h"

#define REQUEST_SHIFT (8U)
#define SEED (0xA5A50000UL) /* with this seed, memory of zeros is not a sound slot */

/*
 * Returns the check word of a command. If a bit of the command flips, one bit of the check word
 * flips.
 */
static uint32_t check_of(const drive_command_t *command)
{
    const uint32_t rest = command->mode | ((uint32_t)command->request << REQUEST_SHIFT);

    return fx_unsigned(command->target) ^ rest ^ SEED;
}

static bool is_sound(const command_slot_t *slot)
{
    return slot->check == check_of(&slot->command);
}

static command_slot_t slot_of(const drive_command_t *command)
{
    return (command_slot_t){.command = *command, .check = check_of(command)};
}

void command_mailbox_init(command_mailbox_t *box)
{
    const drive_command_t none = {.target = 0, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};

    box->slots[0] = slot_of(&none);
    box->slots[1] = slot_of(&none);
    box->in_force = 0U;
}

/* The barriers keep the order of the stores: one slot, the index, the other slot. */
void command_mailbox_post(command_mailbox_t *box, const drive_command_t *command)
{
    const command_slot_t slot = slot_of(command);
    const uint32_t before = box->in_force % COMMAND_MAILBOX_SLOTS;
    const uint32_t next = 1U - before;

    box->slots[next] = slot;
    barrier_compiler();
    box->in_force = next;
    barrier_compiler();
    box->slots[before] = slot;
}

/*
 * Returns the slot to take in place of a damaged one: the other slot. If that one is damaged too,
 * returns speed 0 without a request.
 */
RARE static const command_slot_t *spare(const command_slot_t *other)
{
    static const command_slot_t none = {
        .command = {.target = 0, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U}};

    return is_sound(other) ? other : &none;
}

drive_command_t command_mailbox_take(const command_mailbox_t *box)
{
    const uint32_t first = box->in_force % COMMAND_MAILBOX_SLOTS;
    const command_slot_t *slot = &box->slots[first];

    if (!is_sound(slot)) {
        slot = spare(&box->slots[1U - first]);
    }
    return slot->command;
}

void command_mailbox_mend(command_mailbox_t *box)
{
    const bool same = box->slots[0].check == box->slots[1].check;

    if (!same || !is_sound(&box->slots[0]) || !is_sound(&box->slots[1])) {
        const drive_command_t command = command_mailbox_take(box);

        command_mailbox_post(box, &command);
    }
}
