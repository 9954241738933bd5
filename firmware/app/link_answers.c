/* SPDX-License-Identifier: MIT */
#include "link_answers.h"

#include "box.h"
#include "commander.h"
#include "drive_words.h"
#include "frame_code.h"
#include "words.h"

#include <stddef.h>

#define LOAD_MAX (100U)
#define EXCEPTION_MAX (255U)
#define DUMP_FIRST "a dump is under way; ask again when it has ended"
#define TAKES_WORDS (3U) /* bytes of the body before the words of LINK_WRITE */
#define TAKES_LINE (4U)  /* bytes of the body before the characters of LINK_LINE */

/* A question in the buffer of incoming bytes. */
typedef struct {
    uint8_t type;
    uint8_t tag;
    const uint8_t *body;
    uint32_t length; /* bytes of the body */
    uint32_t crc;    /* CRC of type, tag and body */
} question_t;

static uint32_t half_at(const uint8_t *bytes)
{
    return bytes[0] | ((uint32_t)bytes[1] << 8U);
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

/*
 * Returns the length that the body of this question has to have. The body of LINK_WRITE contains
 * its number of words; the line of LINK_LINE may have any length.
 */
static uint32_t length_of(const question_t *question)
{
    uint32_t length = 0U; /* BYE, PING, STORE, DEFAULTS */

    switch (question->type) {
    case LINK_STREAM:
        length = 1U;
        break;
    case LINK_HELLO:
        length = 5U;
        break;
    case LINK_READ:
        length = 3U;
        break;
    case LINK_APPLY:
    case LINK_BOX:
        length = 4U;
        break;
    case LINK_COMMAND:
        length = 10U;
        break;
    case LINK_STATE:
    case LINK_AGAIN:
        length = 7U;
        break;
    case LINK_LINE:
        length = (question->length < TAKES_LINE) ? TAKES_LINE : question->length;
        break;
    case LINK_WRITE:
        length = TAKES_WORDS;
        if (question->length >= TAKES_WORDS) {
            length += WORDS_BYTES * question->body[2];
        }
        break;
    default:
        break;
    }
    return length;
}

static bool is_question(const question_t *question)
{
    return (question->type >= (uint8_t)LINK_HELLO) && (question->type <= (uint8_t)LINK_BOX) &&
           (question->length == length_of(question));
}

static void put_verdict(link_t *link, const live_config_verdict_t *verdict)
{
    link_out_t *const out = &link->out;

    link_out_word(out, commander_ticket(link->live->app));
    if (verdict->path != NULL) {
        link_out_text(out, verdict->path);
        link_out_text(out, " ");
    }
    if (verdict->why != NULL) {
        link_out_text(out, verdict->why);
    }
}

static void put_identity(link_t *link)
{
    const about_t *const about = &link->live->about;
    const recorder_t *const recorder = link->live->app->recorder;
    link_out_t *const out = &link->out;
    const uint32_t stream = (recorder == NULL) ? 0U : LINK_CAN_STREAM;

    link_out_byte(out, LINK_VERSION);
    link_out_byte(out, stream | (live_config_can_store(link->live) ? LINK_CAN_STORE : 0U));
    link_out_half(out, drive_words_count());
    link_out_half(out, CONFIG_BLOCK_WORDS);
    link_out_half(out, (recorder == NULL) ? 0U : recorder->segment_entries);
    link_out_word(out, about->identity.schema);
    link_out_word(out, about->identity.board);
    link_out_word(out, about->rotation.tick_ps);
    link_out_word(out, about->baud);
    link_out_word(out, about->current_full_scale_ua);
    link_out_word(out, about->bus_full_scale_uv);
    for (uint32_t k = 0U; k < RECORDER_BUILD_WORDS; k++) {
        link_out_word(out, (about->build == NULL) ? 0U : about->build[k]);
    }
    link_out_word(out, commander_ticket(link->live->app));
}

/* Returns the flags of the health. */
static uint32_t health_flags(const link_t *link, bool tick_lost)
{
    const uint32_t source = (uint32_t)commander_source(link->live->app);
    const bool has_input = link->input.kind != (uint8_t)INPUT_KIND_NONE;
    const uint32_t lost = has_input ? link->input.signal.lost : (uint32_t)INPUT_LOST_NOT;

    return (tick_lost ? LINK_HEALTH_TICK_LOST : 0U) | (source << LINK_HEALTH_SOURCE) |
           (lost << LINK_HEALTH_INPUT);
}

static void put_health(link_t *link)
{
    const hal_health_t health = hal_health(link->live->hal);
    const hal_reset_t reset = hal_reset(link->live->hal);
    link_out_t *const out = &link->out;

    link_out_byte(out, smaller(health.load_pct, LOAD_MAX));
    link_out_byte(out, health_flags(link, health.tick_lost));
    link_out_half(out, health.adc_ic);
    link_out_word(out, health.late_ticks);
    link_out_word(out, link->stream.lost);
    link_out_byte(out, (uint32_t)reset.reason);
    link_out_byte(out, smaller(reset.exception, EXCEPTION_MAX));
    link_out_word(out, commander_ticket(link->live->app));
}

/* The PC commands the drive, and nobody else does any more. */
static void link_commanded(link_t *link)
{
    source_guard_commanded(&link->guard);
    source_guard_leave(&link->typed);
}

/*
 * Carries out LINK_COMMAND. A stop ends a measurement of the motor. During a measurement every
 * other command is refused, because the target in force is a word of the probe.
 */
static const char *do_command(link_t *link, const uint8_t *body)
{
    const drive_command_t command = {
        .target = (int32_t)words_get(&body[2]), .mode = body[1], .request = body[0]};
    const bool counts = commander_take_ticket(link->live->app, words_get(&body[6]));
    const about_t *const about = &link->live->about;
    identify_t *const identify = &link->console.identify;
    const char *why = NULL;

    if (identify_is_busy(identify) && (command.request != 0U)) {
        why = CONSOLE_MEASURING;
    } else {
        identify_stop(identify);
        why = commander_command(link->live->app, &command, counts,
                                units_step(&about->rotation, about->speed_max_rpm));
    }
    if (why == NULL) {
        link_commanded(link);
    }
    return why;
}

static void take_character(link_t *link, uint8_t byte, bool counts)
{
    if (console_take(&link->console, byte, counts)) {
        link_commanded(link);
    }
}

static void take_line(link_t *link, const question_t *question)
{
    const bool counts = commander_take_ticket(link->live->app, words_get(question->body));

    console_forget(&link->console);
    for (uint32_t k = TAKES_LINE; k < question->length; k++) {
        take_character(link, question->body[k], counts);
    }
    take_character(link, (uint8_t)'\n', counts);
}

/*
 * Returns how many of `total` words exist from `first` on, limited to `count` and
 * LINK_READ_WORDS_MAX.
 */
static uint32_t words_there(uint32_t first, uint32_t count, uint32_t total)
{
    const uint32_t left = (first < total) ? (total - first) : 0U;

    return smaller(smaller(count, LINK_READ_WORDS_MAX), left);
}

static void put_block(link_t *link, const uint8_t *body)
{
    const uint32_t first = half_at(body);
    const uint32_t count = words_there(first, body[2], CONFIG_BLOCK_WORDS);

    link_out_half(&link->out, first);
    link_out_byte(&link->out, count);
    for (uint32_t k = 0U; k < count; k++) {
        link_out_word(&link->out, config_block_word(link->live->in_force, first + k));
    }
}

/* Returns the number of words of a part of the black box. */
static uint32_t words_of_box(const box_t *box, uint32_t part)
{
    uint32_t words = 0U;

    if ((box != NULL) && (part == LINK_BOX_LOG)) {
        words = FAULT_LOG_WORDS;
    } else if ((box != NULL) && (part == LINK_BOX_RECORDING)) {
        words = box->file_words;
    } else {
        /* there is none */
    }
    return words;
}

static void put_box(link_t *link, const uint8_t *body)
{
    const box_t *const box = link->live->app->box;
    const uint32_t part = body[0];
    const uint32_t first = half_at(&body[1]);
    const uint32_t count = words_there(first, body[3], words_of_box(box, part));

    link_out_half(&link->out, first);
    link_out_byte(&link->out, count);
    for (uint32_t at = first; at < (first + count); at++) {
        link_out_word(&link->out,
                      (part == LINK_BOX_LOG) ? fault_log_word(box->log, at) : box_word(box, at));
    }
}

static live_config_verdict_t write_block(link_t *link, const uint8_t *body)
{
    const uint32_t first = half_at(body);
    const uint32_t count = body[2];
    live_config_verdict_t verdict = {NULL, NULL};

    for (uint32_t k = 0U; (k < count) && (verdict.why == NULL); k++) {
        const uint32_t at = TAKES_WORDS + (WORDS_BYTES * k);

        verdict = live_config_write(link->live, first + k, words_get(&body[at]));
    }
    return verdict;
}

/*
 * Writes words of the state before a segment. If the recorder does not have this state, writes no
 * words. The recorder keeps the state while the PC asks for its words.
 */
static void put_state(link_t *link, const uint8_t *body)
{
    recorder_t *const recorder = link->live->app->recorder;
    const uint32_t segment = words_get(body);
    const uint32_t first = half_at(&body[4]);
    const drive_t *state = NULL;
    uint32_t count = 0U;

    if (recorder != NULL) {
        state = recorder_keep_state(recorder, segment);
    }
    if (state != NULL) {
        count = words_there(first, body[6], drive_words_count());
    }
    link_out_word(&link->out, segment);
    link_out_half(&link->out, first);
    link_out_byte(&link->out, count);
    for (uint32_t k = 0U; k < count; k++) {
        link_out_word(&link->out, drive_words_get(state, first + k));
    }
}

/* Starts or ends the stream. on: as for LINK_STREAM. Returns NULL, or the reason for a refusal. */
static const char *turn_stream(link_t *link, uint32_t on)
{
    recorder_t *const recorder = link->live->app->recorder;
    const char *why = NULL;

    link_stream_end(&link->stream);
    if (on == 0U) {
        /* the stream has ended */
    } else if (recorder == NULL) {
        why = "there is no recorder";
    } else if (link->console.dump_phase != CONSOLE_DUMP_NONE) {
        why = DUMP_FIRST;
    } else if (recorder->triggered && recorder->held) {
        why = "the recording of a fault is kept until it is read";
    } else {
        link_stream_begin(&link->stream, recorder);
        link_stream_limit(&link->stream, (on == 1U) ? FRAME_CODE_ENTRIES_MAX : on);
    }
    return why;
}

static live_config_verdict_t do_block(link_t *link, const question_t *question)
{
    live_config_verdict_t verdict = {NULL, NULL};

    switch (question->type) {
    case LINK_WRITE:
        verdict = write_block(link, question->body);
        break;
    case LINK_APPLY:
        verdict = live_config_apply(link->live, words_get(question->body));
        break;
    case LINK_STORE:
        verdict = live_config_store(link->live);
        break;
    default: /* LINK_DEFAULTS */
        verdict = live_config_restore(link->live);
        break;
    }
    return verdict;
}

/*
 * Answers a question about the block. A dump or the black box reads the block that is not in force,
 * so nothing may be written there meanwhile. A measurement of the motor depends on the block in
 * force, so this block has to stay the same during a measurement.
 */
static live_config_verdict_t judge_block(link_t *link, const question_t *question)
{
    const bool dumps = link->console.dump_phase != CONSOLE_DUMP_NONE;
    const box_t *const box = link->live->app->box;
    const bool saves = (box != NULL) && box_is_saving(box);
    live_config_verdict_t verdict = {NULL, NULL};

    if (dumps && (question->type != (uint8_t)LINK_STORE)) {
        verdict.why = DUMP_FIRST;
    } else if (saves && (question->type != (uint8_t)LINK_STORE)) {
        verdict.why = "the recording of a fault is being saved; ask again";
    } else if (identify_is_busy(&link->console.identify)) {
        verdict.why = CONSOLE_MEASURING;
    } else {
        verdict = do_block(link, question);
    }
    return verdict;
}

/* Carries out a question that is answered with a verdict. */
static live_config_verdict_t judge_question(link_t *link, const question_t *question)
{
    live_config_verdict_t verdict = {NULL, NULL};

    switch (question->type) {
    case LINK_COMMAND:
        verdict.why = do_command(link, question->body);
        break;
    case LINK_LINE:
        take_line(link, question);
        break;
    case LINK_STREAM:
        verdict.why = turn_stream(link, question->body[0]);
        break;
    default:
        verdict = judge_block(link, question);
        break;
    }
    return verdict;
}

static bool is_typed_stop(const question_t *question)
{
    static const uint8_t stop[] = {(uint8_t)'s', (uint8_t)'t', (uint8_t)'o', (uint8_t)'p'};
    bool same = question->length == (TAKES_LINE + sizeof stop);

    for (uint32_t k = 0U; same && (k < sizeof stop); k++) {
        same = question->body[TAKES_LINE + k] == stop[k];
    }
    return same;
}

/* Whether the question is a stop: it does no harm to obey it twice. */
static bool is_stop(const question_t *question)
{
    bool stop = false;

    if (question->type == (uint8_t)LINK_COMMAND) {
        stop = question->body[0] == 0U;
    } else if (question->type == (uint8_t)LINK_LINE) {
        stop = is_typed_stop(question);
    } else {
        /* the question changes something else */
    }
    return stop;
}

/*
 * Answers a hello. A repeated hello does not begin another session, because the first answer may
 * still be on its way.
 */
static void answer_hello(link_t *link, const question_t *question)
{
    if (link->last.crc != question->crc) {
        commander_renew_ticket(link->live->app, words_get(&question->body[1]));
    }
    put_identity(link);
}

/*
 * A PC repeats a question whose answer was lost. A repeated question is answered with the last
 * verdict, but not carried out again. It is recognised by the CRC of the whole message: by the tag
 * alone, a stop could be taken for a repeated run. A stop is obeyed each time.
 */
static void answer_verdict(link_t *link, const question_t *question)
{
    const bool is_again = link->last.crc == question->crc;

    if (!is_again || is_stop(question)) {
        link->last.verdict = judge_question(link, question);
    }
    put_verdict(link, &link->last.verdict);
}

static void answer_question(link_t *link, const question_t *question)
{
    const uint8_t *const body = question->body;

    switch (question->type) {
    case LINK_HELLO:
        answer_hello(link, question);
        break;
    case LINK_BYE:
        break;
    case LINK_PING:
        put_health(link);
        break;
    case LINK_READ:
        put_block(link, body);
        break;
    case LINK_STATE:
        put_state(link, body);
        break;
    case LINK_BOX:
        put_box(link, body);
        break;
    case LINK_AGAIN:
        (void)link_stream_put_entries(link->live->app->recorder, &link->out, words_get(body),
                                      half_at(&body[4]), body[6]);
        break;
    default:
        answer_verdict(link, question);
        break;
    }
    link->last.crc = question->crc;
}

uint8_t link_answer(link_t *link, uint32_t length)
{
    const uint8_t *const bytes = link->in.bytes;
    const question_t question = {.type = bytes[0],
                                 .tag = bytes[1],
                                 .body = &bytes[LINK_FRAME_HEAD_BYTES],
                                 .length = length - LINK_FRAME_HEAD_BYTES,
                                 .crc = words_get(&bytes[length])};
    const bool good = is_question(&question);

    if (good) {
        link_out_begin(&link->out, (uint8_t)(question.type + LINK_ANSWER), question.tag);
        answer_question(link, &question);
    } else {
        link_out_begin(&link->out, (uint8_t)LINK_REFUSED, question.tag);
        link_out_byte(&link->out, question.type);
    }
    link_out_end(&link->out);
    return good ? question.type : (uint8_t)LINK_REFUSED;
}
