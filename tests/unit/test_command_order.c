/* SPDX-License-Identifier: MIT */
/*
 * Commands over a line that loses, doubles, delays and reorders them, beside a person at the
 * console, a PC that goes silent, and a drive that fails: each run that a PC asks for starts the
 * motor at most once, and never behind a stop, a fault or the end of a session that came after it
 * was asked for. All short sequences of what can happen, and random long ones.
 *
 * The link, the console and the commander are those of the firmware. Of the drive there is what
 * they see of it: its state.
 */
#include "commander.h"
#include "config_guard.h"
#include "example_app.h"
#include "flash_model.h"
#include "link.h"
#include "link_line.h"
#include "seeded.h"
#include "testing.h"

#include <stdio.h>

#define KEPT (4U) /* messages that may still come */
#define PASSES_OF_ANSWER (3U)
#define TIMEOUT_TICKS (10000U)
#define SILENCE_TICKS (25000U) /* longer than any delay: the line is a person's again */
#define SHORT (4U)             /* what happens in all sequences */
#define SHORT_OF_MANY (5U)
#define LONG (24U) /* and in each random one */
#define SEQUENCES (20000U)
#define SEQUENCES_OF_MANY (1000000U)

typedef enum {
    RUN,
    RUN_WITHOUT_ANSWER,
    RUN_LATE, /* sent, and not there yet */
    STOP,
    STOP_WITHOUT_ANSWER,
    STOP_LATE,
    CLEAR,
    CLEAR_LATE,
    PING,
    TYPED_RUN, /* of LINK_LINE */
    TYPED_RUN_LATE,
    TYPED_STOP,
    FAULT,
    FLIP, /* a bit of memory: the state is no FAULT any more */
    HELLO,
    BYE,
    PERSON_RUNS,
    PERSON_STOPS,
    SILENCE,
    COMES_AGAIN, /* one of the messages kept, the newest first */
    HAPPENINGS = (int)COMES_AGAIN + (int)KEPT
} happening_t;

typedef struct {
    uint8_t bytes[16];
    uint32_t length;
    uint32_t made; /* when the PC asked for it, in happenings; 0: there is no such message */
    bool runs;     /* it is a COMMAND to run */
    bool starts;   /* it asks for a run, and has started none */
    bool ends;     /* it asks for a stop */
} kept_t;

/* What a sequence changes, so that the next one can begin anywhere in it. */
typedef struct {
    app_t app;
    live_config_t live;
    link_t serial;
    hal_t hardware;
    kept_t kept[KEPT];
    uint32_t newest;
    uint32_t now;    /* happenings so far */
    uint32_t ended;  /* when the last one that ends what was asked for has happened */
    uint32_t target; /* of the newest run that was obeyed */
    uint32_t ticket; /* as the PC has heard */
    uint8_t tag;
} world_t;

static world_t before_all;
static live_config_t live;
static link_t serial;
static kept_t kept[KEPT];
static uint32_t newest;
static uint32_t now;
static uint32_t ended;
static uint32_t target;
static uint32_t ticket;
static uint8_t tag;
static uint32_t path[LONG];

static world_t keep_world(void)
{
    world_t world = {.app = app,
                     .live = live,
                     .serial = serial,
                     .hardware = hardware,
                     .newest = newest,
                     .now = now,
                     .ended = ended,
                     .target = target,
                     .ticket = ticket,
                     .tag = tag};

    memcpy(world.kept, kept, sizeof kept);
    return world;
}

static void restore_world(const world_t *world)
{
    app = world->app;
    live = world->live;
    serial = world->serial;
    hardware = world->hardware;
    memcpy(kept, world->kept, sizeof kept);
    newest = world->newest;
    now = world->now;
    ended = world->ended;
    target = world->target;
    ticket = world->ticket;
    tag = world->tag;
}

static drive_command_t command(void)
{
    return command_mailbox_take(&app.mailbox);
}

static bool is_asked_to_run(void)
{
    return command().request == DRIVE_REQUEST_RUN;
}

/* What the drive makes of the command, and one pass of the background. */
static void pass(void)
{
    if (app.drive.state != DRIVE_STATE_FAULT) {
        app.drive.state = is_asked_to_run() ? DRIVE_STATE_RUN : DRIVE_STATE_READY;
    } else if (command().request == DRIVE_REQUEST_CLEAR) {
        app.drive.state = DRIVE_STATE_READY;
    } else {
        /* the fault is latched */
    }
    hardware.ticks++;
    link_step(&serial);
}

static void passes(void)
{
    for (uint32_t k = 0U; k < PASSES_OF_ANSWER; k++) {
        pass();
    }
}

void setUp(void)
{
    flash_new(0U);
    line_new();
    power_on();
    cfg.link.timeout_ticks = TIMEOUT_TICKS;
    cfg.crc = config_guard_crc(&cfg);
    live_config_init(&live, &app, &hardware, &ABOUT, &cfg);
    link_init(&serial, &live);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &live.in_force->cfg));
    app.drive.state = DRIVE_STATE_READY;
    memset(kept, 0, sizeof kept);
    newest = 0U;
    now = 0U;
    ended = 0U;
    target = 0U;
    ticket = 0U;
    tag = 0U;
}

/* ---- the PC ---- */

static kept_t *make(uint8_t type, const void *body, uint32_t length)
{
    kept_t *const message = &kept[newest % KEPT];

    tag = (uint8_t)((tag % 255U) + 1U);
    newest++;
    *message = (kept_t){.bytes = {type, tag}, .length = length + 2U, .made = now};
    memcpy(&message->bytes[2], body, length);
    return message;
}

static kept_t *make_command(uint8_t request)
{
    uint8_t body[10] = {request};
    kept_t *message;

    words_put(&body[2], now); /* as speed: the later, the larger */
    words_put(&body[6], ticket);
    message = make(LINK_COMMAND, body, sizeof body);
    message->runs = request == DRIVE_REQUEST_RUN;
    message->starts = message->runs;
    message->ends = request == 0U;
    return message;
}

static kept_t *make_line(const char *typed, bool starts)
{
    uint8_t body[8];
    const uint32_t length = (uint32_t)strlen(typed);
    kept_t *message;

    words_put(body, ticket);
    memcpy(&body[4], typed, length);
    message = make(LINK_LINE, body, length + 4U);
    message->starts = starts;
    message->ends = !starts;
    return message;
}

/* The PC takes the ticket of an answer that it has waited for. */
static void hear(const kept_t *message)
{
    const uint8_t type = message->bytes[0];
    const line_message_t *const answer = line_find((uint8_t)(type + LINK_ANSWER));

    if ((answer != NULL) && (type == (uint8_t)LINK_PING)) {
        ticket = words_get(&answer->bytes[2U + LINK_HEALTH_BYTES - 4U]);
    } else if ((answer != NULL) && (type == (uint8_t)LINK_HELLO)) {
        ticket = words_get(&answer->bytes[2U + LINK_IDENTITY_BYTES - 4U]);
    } else if ((answer != NULL) && (type != (uint8_t)LINK_BYE)) {
        ticket = words_get(&answer->bytes[2]);
    } else {
        /* nothing that has one */
    }
}

/* ---- what holds ---- */

static void holds(bool what, const char *why)
{
    if (!what) {
        for (uint32_t k = 0U; k < now; k++) {
            printf("%u: %u\n", (unsigned)k + 1U, (unsigned)path[k]);
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(what, why);
}

/* The board gets a message. */
static void deliver(kept_t *message, bool answered)
{
    const bool ran = is_asked_to_run();
    const bool was_linked = serial.is_linked;
    const int32_t before = command().target;

    line.in_at = 0U;
    line.in_length = 0U;
    line_frame(message->bytes, message->length, 0U);
    passes();
    line_listen();
    if (answered) {
        hear(message);
    }
    if (is_asked_to_run() && !ran) {
        holds(message->starts,
              "a message that asks for no run starts nothing, and a run starts once");
        holds(message->made > ended, "a run does not count behind what has ended it");
    }
    if (message->runs && (command().target != before)) {
        holds(message->made >= target, "a target does not go back to an older one");
        target = message->made;
    }
    message->starts = message->starts && !is_asked_to_run();
    if (message->ends && was_linked) {
        holds(!is_asked_to_run(), "a stop stops");
        ended = now;
    }
}

static void say(uint8_t type, const void *body, uint32_t length)
{
    const bool was_linked = serial.is_linked;

    deliver(make(type, body, length), true);
    if (was_linked || serial.is_linked) {
        ended = (type == (uint8_t)LINK_PING) ? ended : now;
    }
}

static void say_hello(void)
{
    uint8_t body[5] = {LINK_VERSION};

    words_put(&body[1], 7U * now);
    say(LINK_HELLO, body, sizeof body);
}

/* At the console, where the line is a person's. */
static void type(const char *typed)
{
    if (!serial.is_linked) {
        line.in_at = 0U;
        line.in_length = 0U;
        line_type(typed);
        passes();
        line_listen();
        ended = now;
    }
}

static void be_silent(void)
{
    hardware.ticks += SILENCE_TICKS;
    passes();
    line_listen();
    ended = now;
}

static void comes_again(uint32_t back)
{
    kept_t *const message = &kept[(newest - 1U - back) % KEPT];

    if ((newest > back) && (message->made > 0U)) {
        deliver(message, false);
    }
}

static void happens_on_the_line(uint32_t what)
{
    switch (what) {
    case RUN:
        deliver(make_command(DRIVE_REQUEST_RUN), true);
        break;
    case RUN_WITHOUT_ANSWER:
        deliver(make_command(DRIVE_REQUEST_RUN), false);
        break;
    case RUN_LATE:
        (void)make_command(DRIVE_REQUEST_RUN);
        break;
    case STOP:
        deliver(make_command(0U), true);
        break;
    case STOP_WITHOUT_ANSWER:
        deliver(make_command(0U), false);
        break;
    case STOP_LATE:
        (void)make_command(0U);
        break;
    case CLEAR:
        deliver(make_command(DRIVE_REQUEST_CLEAR), true);
        break;
    case CLEAR_LATE:
        (void)make_command(DRIVE_REQUEST_CLEAR);
        break;
    case TYPED_RUN:
        deliver(make_line("run", true), true);
        break;
    case TYPED_RUN_LATE:
        (void)make_line("run", true);
        break;
    case TYPED_STOP:
        deliver(make_line("stop", false), true);
        break;
    default:
        comes_again(what - (uint32_t)COMES_AGAIN);
        break;
    }
}

/* Into FAULT, or out of it. Where the drive is there already nothing has happened. */
static void change_state(drive_state_t state)
{
    const bool failed = app.drive.state == DRIVE_STATE_FAULT;

    if (failed != (state == DRIVE_STATE_FAULT)) {
        app.drive.state = state;
        passes();
        line_listen();
        holds(!is_asked_to_run(), "a fault ends a run, and out of it nothing starts by itself");
        ended = failed ? ended : now;
    }
}

static void happens(uint32_t what)
{
    path[now] = what;
    now++;
    switch (what) {
    case PING:
        say(LINK_PING, "", 0U);
        break;
    case FAULT:
    case FLIP:
        change_state((what == (uint32_t)FAULT) ? DRIVE_STATE_FAULT : DRIVE_STATE_READY);
        break;
    case HELLO:
        say_hello();
        break;
    case BYE:
        say(LINK_BYE, "", 0U);
        break;
    case PERSON_RUNS:
        type("run\n");
        break;
    case PERSON_STOPS:
        type("stop\n");
        break;
    case SILENCE:
        be_silent();
        break;
    default:
        happens_on_the_line(what);
        break;
    }
}

static void try_all(uint32_t left)
{
    const world_t world = keep_world();

    for (uint32_t what = 0U; (left > 0U) && (what < (uint32_t)HAPPENINGS); what++) {
        restore_world(&world);
        happens(what);
        try_all(left - 1U);
    }
}

/* From a session that has just begun. */
TEST(test_in_no_short_sequence_a_run_counts_behind_what_has_ended_it)
{
    happens(HELLO);
    try_all(testing_runs(SHORT, SHORT_OF_MANY));
}

TEST(test_in_no_long_sequence_a_run_counts_behind_what_has_ended_it)
{
    const uint32_t sequences = testing_runs(SEQUENCES, SEQUENCES_OF_MANY);
    seeded_t random = {.state = 20261129U};

    before_all = keep_world();
    for (uint32_t k = 0U; k < sequences; k++) {
        restore_world(&before_all);
        happens(HELLO);
        while (now < LONG) {
            happens((uint32_t)seeded_in(&random, 0, (int32_t)HAPPENINGS - 1));
        }
    }
}

/* What has to work: the PC knows the ticket, nothing is wrong, and nobody else has the line. */
TEST(test_a_run_counts_where_nothing_is_between)
{
    happens(HELLO);
    for (uint32_t k = 0U; k < 3U; k++) {
        happens(RUN);
        TEST_ASSERT_TRUE(is_asked_to_run());
        happens(STOP);
        happens(TYPED_RUN);
        TEST_ASSERT_TRUE(is_asked_to_run());
        happens(FAULT);
        happens(PING);
        happens(CLEAR);
        happens(RUN);
        TEST_ASSERT_TRUE(is_asked_to_run());
        happens(RUN);
        TEST_ASSERT_EQUAL_UINT32(now, (uint32_t)command().target);
        now = 1U;
        target = 0U;
    }
}
