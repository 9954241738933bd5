/* SPDX-License-Identifier: MIT */
/*
 * The mailbox between background and interrupt. The background is a child process that is stopped
 * after each of its instructions; what an interrupt would take there is read from the memory that
 * both share.
 */
#define _DEFAULT_SOURCE
#include "command_mailbox.h"
#include "testing.h"

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#define POSTED (3U)
#define SLOT_BITS ((uint32_t)(8U * sizeof(command_slot_t)))
#define INSTRUCTIONS_MAX (100000U) /* of the background, far more than three posts need */

typedef struct {
    command_mailbox_t box;
    volatile bool done;
} shared_t;

/* Every field differs from that of every other: a mixture is none of them. */
static const drive_command_t commands[POSTED + 1U] = {
    {.target = 0, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U},
    {.target = 0x11223344, .mode = (uint8_t)DRIVE_MODE_POSITION, .request = DRIVE_REQUEST_RUN},
    {.target = -5, .mode = 7U, .request = DRIVE_REQUEST_CLEAR},
    {.target = 0x7FFF0000, .mode = 9U, .request = 0x83U},
};

static shared_t *shared;

void setUp(void)
{
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(shared != MAP_FAILED);
    command_mailbox_init(&shared->box);
}

void tearDown(void)
{
    (void)munmap(shared, sizeof *shared);
}

static bool same(drive_command_t a, drive_command_t b)
{
    return (a.target == b.target) && (a.mode == b.mode) && (a.request == b.request);
}

TEST(test_first_command_asks_for_nothing)
{
    TEST_ASSERT_TRUE(same(commands[0], command_mailbox_take(&shared->box)));
}

TEST(test_command_posted_last_is_taken_again_and_again)
{
    for (uint32_t k = 0U; k < (2U * POSTED); k++) {
        const drive_command_t *const command = &commands[(k % POSTED) + 1U];

        command_mailbox_post(&shared->box, command);
        TEST_ASSERT_TRUE(same(*command, command_mailbox_take(&shared->box)));
        TEST_ASSERT_TRUE(same(*command, command_mailbox_take(&shared->box)));
    }
}

TEST(test_init_forgets_what_was_posted)
{
    command_mailbox_post(&shared->box, &commands[1]);
    command_mailbox_init(&shared->box);
    TEST_ASSERT_TRUE(same(commands[0], command_mailbox_take(&shared->box)));
    command_mailbox_post(&shared->box, &commands[2]);
    TEST_ASSERT_TRUE(same(commands[2], command_mailbox_take(&shared->box)));
}

/* Of the whole box, also of its index. */
static void flip(command_mailbox_t *box, uint32_t bit)
{
    uint8_t *const bytes = (uint8_t *)box;

    bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
}

TEST(test_a_bit_that_flips_changes_no_command_and_is_mended)
{
    for (uint32_t k = 0U; k <= POSTED; k++) {
        for (uint32_t bit = 0U; bit < (8U * sizeof shared->box); bit++) {
            command_mailbox_t *const box = &shared->box;

            command_mailbox_init(box);
            command_mailbox_post(box, &commands[(k + 1U) % (POSTED + 1U)]);
            command_mailbox_post(box, &commands[k]);
            flip(box, bit);
            TEST_ASSERT_TRUE(same(commands[k], command_mailbox_take(box)));
            command_mailbox_mend(box);
            flip(box, (bit + SLOT_BITS) % (2U * SLOT_BITS));
            TEST_ASSERT_TRUE_MESSAGE(same(commands[k], command_mailbox_take(box)),
                                     "the other slot was mended");
        }
    }
}

/*
 * A bit that flips in a command and the same one in its check word leave a sound slot of another
 * command.
 */
TEST(test_sound_slots_that_are_unlike_are_made_alike)
{
    command_mailbox_t *const box = &shared->box;

    for (uint32_t slot = 0U; slot < COMMAND_MAILBOX_SLOTS; slot++) {
        command_mailbox_t other;

        command_mailbox_init(box);
        command_mailbox_init(&other);
        command_mailbox_post(&other, &commands[1]);
        box->slots[slot] = other.slots[slot];
        box->in_force = slot;
        command_mailbox_mend(box);
        flip(box, slot * SLOT_BITS);
        TEST_ASSERT_TRUE(same(commands[1], command_mailbox_take(box)));
    }
}

/* The same bits in both slots. */
TEST(test_where_both_slots_are_damaged_nothing_is_asked_for)
{
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        command_mailbox_post(&shared->box, &commands[1]);
        flip(&shared->box, bit);
        flip(&shared->box, bit + SLOT_BITS);
        TEST_ASSERT_TRUE(same(commands[0], command_mailbox_take(&shared->box)));
        command_mailbox_mend(&shared->box);
        TEST_ASSERT_TRUE(same(commands[0], command_mailbox_take(&shared->box)));
    }
    memset(&shared->box, 0, sizeof shared->box);
    TEST_ASSERT_TRUE_MESSAGE(same(commands[0], command_mailbox_take(&shared->box)),
                             "before it is initialised");
}

/* The child: stops, and goes on by single steps. No check of the test's framework in it. */
static void be_the_background(void)
{
    if ((ptrace(PTRACE_TRACEME, 0, NULL, NULL) != 0) || (raise(SIGSTOP) != 0)) {
        _exit(1);
    }
    for (uint32_t k = 1U; k <= POSTED; k++) {
        command_mailbox_post(&shared->box, &commands[k]);
    }
    shared->done = true;
    _exit(0);
}

/* Which of the commands an interrupt finds here: the present one or the next. */
static uint32_t command_found(uint32_t before)
{
    const drive_command_t found = command_mailbox_take(&shared->box);
    const uint32_t next = (before < POSTED) ? (before + 1U) : before;

    TEST_ASSERT_TRUE_MESSAGE(same(found, commands[before]) || same(found, commands[next]),
                             "the interrupt takes a command that nobody has posted");
    return same(found, commands[before]) ? before : next;
}

TEST(test_interrupt_at_any_instruction_takes_a_whole_command)
{
    const pid_t background = fork();
    uint32_t instructions = 0U;
    uint32_t found = 0U;
    int status = 0;

    if (background == 0) {
        be_the_background();
    }
    TEST_ASSERT_TRUE(background > 0);
    TEST_ASSERT_EQUAL_INT(background, waitpid(background, &status, 0));
    while (WIFSTOPPED(status) && !shared->done) {
        found = command_found(found);
        instructions++;
        TEST_ASSERT_LESS_THAN_UINT32(INSTRUCTIONS_MAX, instructions);
        TEST_ASSERT_EQUAL_INT(0, ptrace(PTRACE_SINGLESTEP, background, NULL, NULL));
        TEST_ASSERT_EQUAL_INT(background, waitpid(background, &status, 0));
    }
    TEST_ASSERT_TRUE_MESSAGE(shared->done, "the background did not come to its end");
    TEST_ASSERT_EQUAL_UINT32(POSTED, found);
    TEST_ASSERT_EQUAL_INT(0, ptrace(PTRACE_CONT, background, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(background, waitpid(background, &status, 0));
}
