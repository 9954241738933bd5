/* SPDX-License-Identifier: MIT */
#include "link.h"

#include "box.h"
#include "commander.h"
#include "cross_check.h"
#include "kept_heat.h"
#include "link_answers.h"

#include <stddef.h>

#define PAUSE_US (LINK_PAUSE_MS * 1000U)
#define ALONE_US (100000U) /* a frame without a new byte for 100 ms is given up */

/*
 * The same times in passes of link_step(), for a board whose ticks stand still, such as one that
 * cannot start. A pass without work takes some µs. While ticks run, the number of passes between
 * two ticks stays far below these limits.
 */
#define ALONE_PASSES (100000U)
#define PAUSE_PASSES (LINK_PAUSE_MS * 1000U)

#define STOPS ": the drive stops"
#define STOPS_TYPED ": the drive stops; Enter keeps it running"

void link_init(link_t *link, live_config_t *live)
{
    *link = (link_t){.live = live};
    link->guard.source = SOURCE_LINK;
    link->typed.source = SOURCE_CONSOLE;
    console_init(&link->console, live->app, live->hal, &live->about);
    input_init(&link->input);
    link_in_start(&link->in);
    link_out_start(&link->out);
    link_stream_init(&link->stream, &live->about.rotation);
}

void link_say(link_t *link, const char *line)
{
    console_say(&link->console, line);
}

static uint32_t now(const link_t *link)
{
    return hal_ticks(link->live->hal);
}

/* Counts the passes in which the ticks stand still. The count begins again when the PC is heard. */
static void count_still(link_t *link)
{
    const uint32_t tick = now(link);

    if (tick == link->tick) {
        link->still++;
    } else {
        link->still = 0U;
    }
    link->tick = tick;
}

/*
 * Ends the stream, the preparation of a block and the unlocking, because the next PC must not
 * inherit them.
 */
static void end_session(link_t *link)
{
    link_stream_end(&link->stream);
    live_config_forget(link->live);
    commander_lock(link->live->app);
}

/* Gives the line back to the person. */
static void return_line(link_t *link)
{
    end_session(link);
    commander_renew_ticket(link->live->app, 0U);
    link->is_linked = false;
    link->is_framing = false;
    link->console.source = SOURCE_CONSOLE;
}

/*
 * Takes a whole message as a question if a PC has the line. Otherwise only a hello is taken, which
 * gives the line to a PC.
 */
static void take_message(link_t *link, uint32_t length)
{
    if (link->is_linked || (link->in.bytes[0] == (uint8_t)LINK_HELLO)) {
        link->question = length;
    }
}

static void take_framed(link_t *link, uint8_t byte)
{
    const bool was_open = link_in_is_open(&link->in);
    uint32_t length = 0U;

    link->byte_tick = now(link);
    link->still = link->is_linked ? link->still : 0U;
    if (link_in_take(&link->in, byte, &length)) {
        take_message(link, length);
    }
    link->is_framing = (byte != LINK_FRAME_DELIMITER) || !was_open;
}

static void take_typed(link_t *link, uint8_t byte)
{
    if (console_take(&link->console, byte, true)) {
        source_guard_leave(&link->guard); /* from now on that person commands the motor */
        source_guard_commanded(&link->typed);
    }
    source_guard_heard(&link->typed, now(link));
}

static void take_byte(link_t *link, uint8_t byte)
{
    if (link->is_linked || link->is_framing || (byte == LINK_FRAME_DELIMITER)) {
        take_framed(link, byte);
    } else {
        take_typed(link, byte);
    }
}

/*
 * Gives up a frame that does not go on: a single 0x00, as when a cable is plugged in, must not lock
 * a person out.
 */
static void give_up_frame(link_t *link)
{
    const uint32_t alone = units_ticks(&link->live->about.rotation, ALONE_US);
    const bool stops = ((now(link) - link->byte_tick) > alone) || (link->still > ALONE_PASSES);

    if (link->is_framing && !link->is_linked && stops) {
        link_in_start(&link->in);
        link->is_framing = false;
    }
}

/* Receives bytes up to the end of a question, which stays in the buffer until it is answered. */
static void link_receive(link_t *link)
{
    uint8_t byte = 0U;

    give_up_frame(link);
    while ((link->question == 0U) && hal_receive(link->live->hal, &byte)) {
        take_byte(link, byte);
    }
}

static void become_linked(link_t *link)
{
    end_session(link);
    console_forget(&link->console);
    link->is_linked = true;
    link->console.source = SOURCE_LINK;
}

static void answer_waiting(link_t *link)
{
    if ((link->question != 0U) && link_out_is_free(&link->out)) {
        const uint8_t type = link_answer(link, link->question);

        link->question = 0U;
        link->still = 0U;
        source_guard_heard(&link->guard, now(link));
        if (type == (uint8_t)LINK_HELLO) {
            become_linked(link);
        } else if (type == (uint8_t)LINK_BYE) {
            source_guard_leave(&link->guard);
            return_line(link);
        } else {
            /* the line keeps its owner */
        }
    }
}

static void say_silence(link_t *link, source_t source, const char *rest)
{
    text_add(&link->console.out, source_silence(source));
    link_say(link, rest);
}

static void watch_line(link_t *link)
{
    const live_config_t *const live = link->live;
    const uint32_t pause = units_ticks(&live->about.rotation, PAUSE_US);
    const uint32_t timeout = live->in_force->cfg.link.timeout_ticks;
    const bool silent =
        source_guard_is_silent(&link->guard, now(link), pause) || (link->still > PAUSE_PASSES);

    if (link->is_linked && silent) {
        return_line(link);
    }
    if (source_guard_step(&link->guard, live->app, &link->console.identify, now(link), timeout)) {
        say_silence(link, SOURCE_LINK, STOPS);
    }
}

/* Nobody types during a measurement of the motor, which ends by itself. */
static void watch_person(link_t *link)
{
    const live_config_t *const live = link->live;
    const uint32_t timeout = live->in_force->cfg.console.timeout_ticks;

    if (identify_is_busy(&link->console.identify)) {
        source_guard_heard(&link->typed, now(link));
    }
    if (source_guard_step(&link->typed, live->app, &link->console.identify, now(link), timeout)) {
        say_silence(link, SOURCE_CONSOLE, STOPS_TYPED);
    }
}

static void watch_input(link_t *link)
{
    const char *const lost =
        input_step(&link->input, link->live, &link->console.identify, now(link));

    if (lost != NULL) {
        text_add(&link->console.out, "the input is lost: ");
        text_add(&link->console.out, lost);
        link_say(link, STOPS);
    }
    link->console.input = input_text(&link->input);
}

static void text_is_sent(link_t *link, uint32_t count)
{
    text_t *const text = &link->console.out;

    link->said += count;
    if (link->said >= text->length) {
        link->said = 0U;
        text->length = 0U;
    }
}

/* Sends text of the console in a message LINK_TEXT. */
static void frame_text(link_t *link)
{
    const text_t *const text = &link->console.out;
    const uint32_t left = text->length - link->said;
    const uint32_t count = (left < LINK_TEXT_MAX) ? left : LINK_TEXT_MAX;

    link_out_begin(&link->out, (uint8_t)LINK_TEXT, 0U);
    for (uint32_t k = 0U; k < count; k++) {
        link_out_byte(&link->out, (uint8_t)text->characters[link->said + k]);
    }
    link_out_end(&link->out);
    text_is_sent(link, count);
}

/* Sends messages for which the PC has not asked: first text, then frames of the stream. */
static void speak(link_t *link)
{
    if (!link->is_linked || !link_out_is_free(&link->out)) {
        /* a person has the line, or a frame is still being sent */
    } else if (link->console.out.length > 0U) {
        frame_text(link);
    } else {
        link_stream_step(&link->stream, &link->out, now(link));
    }
}

static void send_frame(link_t *link)
{
    uint8_t byte = 0U;
    bool goes_on = link_out_next(&link->out, &byte);

    while (goes_on && hal_send(link->live->hal, byte)) {
        link_out_sent(&link->out);
        goes_on = link_out_next(&link->out, &byte);
    }
}

static void send_text(link_t *link)
{
    const text_t *const text = &link->console.out;

    while ((text->length > 0U) &&
           hal_send(link->live->hal, (uint8_t)text->characters[link->said])) {
        text_is_sent(link, 1U);
    }
}

/* Sends bytes. A frame is sent to its end, even if the line has changed its owner. */
static void link_send(link_t *link)
{
    send_frame(link);
    if (!link->is_linked && link_out_is_free(&link->out)) {
        send_text(link);
    }
}

static box_reader_t reader_of(console_dump_t phase)
{
    box_reader_t reader = BOX_READS_RECORDER;

    if (phase == CONSOLE_DUMP_NONE) {
        reader = BOX_UNREAD;
    } else if (phase == CONSOLE_LAST_SENT) {
        reader = BOX_READS_SAVED;
    } else {
        /* the recorder's */
    }
    return reader;
}

static void step_box(link_t *link)
{
    box_t *const box = link->live->app->box;

    if (box != NULL) {
        box_step(box, reader_of(link->console.dump_phase));
    }
}

void link_step(link_t *link)
{
    count_still(link);
    cross_check_step(link->live->app);
    kept_heat_step(link->live->app);
    step_box(link);
    /* before link_receive(), because a fault is older than the bytes that come in now */
    commander_step(link->live->app);
    link_receive(link);
    answer_waiting(link);
    live_config_step(link->live);
    watch_line(link);
    watch_person(link);
    watch_input(link);
    console_step(&link->console);
    speak(link);
    link_send(link);
}
