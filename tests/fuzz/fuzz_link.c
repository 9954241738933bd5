/* SPDX-License-Identifier: MIT */
/*
 * Any bytes from the serial line to the link, while the drive runs, and whatever it does.
 *
 * The input is steps of two bytes and what belongs to them: see step(). Some bytes are received as
 * they are; others are the message of a frame whose CRC is right, so that the questions are
 * reached.
 */
#include "cobs.h"
#include "commander.h"
#include "crc32.h"
#include "drive_config.h"
#include "fuzz_board.h"
#include "fuzzed.h"
#include "link.h"
#include "words.h"

#include <string.h>

#define ENTRIES (RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN)
#define POST_TICKS (8U)
#define LINE_MAX (512U)
#define REQUESTS (DRIVE_REQUEST_RUN | DRIVE_REQUEST_CLEAR | DRIVE_REQUEST_ZERO)
#define COMMAND_TICKET_AT (8U) /* behind type, tag, request, mode and target */
#define LINE_TICKET_AT (2U)

static const about_t ABOUT = {DRIVE_ABOUT};

/*
 * The serial line: what is to be received, how much may be sent, and the frame that is being sent.
 */
typedef struct {
    uint8_t in[LINE_MAX];
    size_t in_at;
    size_t in_length;
    size_t room;
    uint8_t out[LINK_FRAME_BYTES_MAX + 1U];
    size_t out_length;
    bool in_frame;
} line_t;

static line_t line;
static app_t app;
static hal_t hardware;
static live_config_t live;
static link_t serial;
static recorder_t recorder;
static recorder_entry_t entries[ENTRIES];
static bool may_command; /* a message, or a line that was typed, came in */
static uint8_t store[HAL_FLASH_SLOTS][HAL_STORE_UNITS][HAL_STORE_UNIT_BYTES];

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    (void)hal;
    const bool there = line.in_at < line.in_length;

    if (there) {
        *byte = line.in[line.in_at];
        line.in_at++;
    }
    return there;
}

/* A frame that the board sends is whole, and its CRC is right. */
static void frame_holds(void)
{
    uint8_t bytes[LINK_FRAME_BYTES_MAX + 1U];
    cobs_decoder_t decoder;
    uint32_t crc = CRC32_START;
    uint32_t length = 0U;

    cobs_start(&decoder);
    for (size_t k = 0U; k < line.out_length; k++) {
        length += cobs_decode(&decoder, line.out[k], &bytes[length]) ? 1U : 0U;
    }
    HOLDS(cobs_may_end(&decoder) && (length >= (2U + LINK_CRC_BYTES)), "a frame is whole");
    for (uint32_t k = 0U; k < (length - LINK_CRC_BYTES); k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    HOLDS(~crc == words_get(&bytes[length - LINK_CRC_BYTES]), "the CRC of a frame is right");
}

static void sent(uint8_t byte)
{
    if (byte == 0U) {
        if (line.in_frame) {
            frame_holds();
        }
        line.in_frame = !line.in_frame;
        line.out_length = 0U;
    } else if (line.in_frame) {
        HOLDS(line.out_length < sizeof line.out, "a frame is no longer than it may be");
        line.out[line.out_length] = byte;
        line.out_length++;
    } else {
        HOLDS(((byte >= 0x20U) && (byte < 0x7FU)) || (byte == '\r') || (byte == '\n'),
              "outside of frames there is text");
    }
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    (void)hal;
    const bool room = line.room > 0U;

    if (room) {
        sent(byte);
        line.room--;
    }
    return room;
}

bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    memcpy(bytes, store[slot][unit], HAL_STORE_UNIT_BYTES);
    return true;
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    (void)hal;
    HOLDS(!app.out.gate_enable, "the store is written with open gates");
    memset(store[slot], 0xFF, sizeof store[slot]);
    return true;
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    HOLDS(!app.out.gate_enable, "the store is written with open gates");
    memcpy(store[slot][unit], bytes, HAL_STORE_UNIT_BYTES);
    return true;
}

static void receive(fed_t *input, size_t count)
{
    line.in_at = 0U;
    line.in_length = 0U;
    while ((line.in_length < count) && (input->left > 0U)) {
        line.in[line.in_length] = fed_byte(input);
        line.in_length++;
    }
    may_command = true;
}

static void put(uint8_t byte)
{
    line.in[line.in_length] = byte;
    line.in_length++;
}

/* A ticket of 0 becomes the one that counts: this PC has heard the last answer. */
static void give_ticket(uint8_t *message, uint32_t length)
{
    const bool is_line = message[0] == (uint8_t)LINK_LINE;
    const uint32_t at = is_line ? LINE_TICKET_AT : COMMAND_TICKET_AT;

    if ((is_line || (message[0] == (uint8_t)LINK_COMMAND)) && (length >= (at + WORDS_BYTES)) &&
        (words_get(&message[at]) == 0U)) {
        words_put(&message[at], commander_ticket(&app));
    }
}

/* A frame around the next bytes. */
static void receive_frame(fed_t *input, size_t count)
{
    const size_t most = (count < LINK_MESSAGE_BYTES_MAX) ? count : LINK_MESSAGE_BYTES_MAX;
    uint8_t bytes[LINK_FRAME_BYTES_MAX] = {0};
    uint32_t length = 0U;
    uint32_t crc = CRC32_START;

    while ((length < most) && (input->left > 0U)) {
        bytes[length] = fed_byte(input);
        length++;
    }
    give_ticket(bytes, length);
    for (uint32_t at = 0U; at < length; at++) {
        crc = crc32_byte(crc, bytes[at]);
    }
    words_put(&bytes[length], ~crc);
    line.in_at = 0U;
    line.in_length = 0U;
    put(0U);
    for (uint32_t at = 0U; at <= (length + LINK_CRC_BYTES); at++) {
        put(cobs_encoded(bytes, length + LINK_CRC_BYTES, at));
    }
    put(0U);
    may_command = true;
}

static void command_holds(const drive_command_t *before)
{
    const drive_command_t command = command_mailbox_take(&app.mailbox);
    const int64_t highest = units_step(&live.about.rotation, live.about.speed_max_rpm);
    const bool is_speed = command.mode == (uint8_t)DRIVE_MODE_SPEED;
    const bool probes = identify_is_busy(&serial.console.identify);

    HOLDS(probes || (command.mode <= (uint8_t)DRIVE_MODE_TORQUE), "a mode is one of the three");
    HOLDS(probes || !is_speed || ((command.target >= -highest) && (command.target <= highest)),
          "a target is within the motor's speed");
    HOLDS(probes || ((command.request & ~REQUESTS) == 0U), "a request is one of those there are");
    HOLDS(may_command || (before->request == command.request) || (before->request != 0U) ||
              (command.request != DRIVE_REQUEST_RUN),
          "nothing but a message or a line starts the motor");
}

static void link_holds(void)
{
    HOLDS(serial.console.length <= CONSOLE_LINE_MAX, "a line stays within its buffer");
    HOLDS((serial.console.out.length <= TEXT_MAX) && (serial.said <= serial.console.out.length),
          "the text stays within its buffer");
    HOLDS(serial.out.length <= LINK_FRAME_BYTES_MAX, "a frame stays within its buffer");
    HOLDS((app.drive.cfg == &live.in_force->cfg) || (app.drive.cfg == &live.prepared->cfg),
          "the drive has one of the two blocks");
    HOLDS(config_block_check(live.in_force, &ABOUT.identity).fault == CONFIG_BLOCK_GOOD,
          "the block in force is good");
}

/* What has come in is obeyed later while the last answer is still being sent. */
static bool is_waiting(void)
{
    return (serial.question != 0U) || (line.in_at < line.in_length);
}

static void tick(void)
{
    const drive_command_t before = command_mailbox_take(&app.mailbox);

    control_isr(&app);
    recorder_service(&recorder, &app.drive);
    link_step(&serial);
    command_holds(&before);
    may_command = is_waiting();
}

static size_t step(fed_t *input)
{
    const uint8_t what = fed_byte(input);
    const uint8_t count = fed_byte(input);
    size_t ticks = 1U;

    switch (what % 6U) {
    case 0U: /* bytes are received */
        receive(input, count);
        break;
    case 1U: /* time goes by */
        ticks = 1U + (TICKS_OF_A_BYTE * (size_t)count);
        break;
    case 2U: /* something is measured */
        fuzz_board_measures(&hardware, input);
        break;
    case 3U:
        hardware.measured.flags = count;
        hardware.health.tick_lost = (count & 0x80U) != 0U;
        break;
    case 4U: /* a frame is received */
        receive_frame(input, count);
        break;
    default:
        fuzz_board_rests(&hardware, &DRIVE_CONFIG);
        break;
    }
    line.room = (what >= 128U) ? count : SIZE_MAX;
    return ticks;
}

static void start(void)
{
    line = (line_t){0};
    hardware = (hal_t){0};
    app = (app_t){0};
    memset(store, 0xFF, sizeof store);
    live_config_init(&live, &app, &hardware, &ABOUT, &DRIVE_CONFIG);
    link_init(&serial, &live);
    HOLDS(app_init(&app, &hardware, &live.in_force->cfg) == NULL,
          "the board's configuration is taken");
    HOLDS(recorder_init(&recorder, entries, RECORDER_ENTRIES_MIN, POST_TICKS) == NULL,
          "the recorder's size is taken");
    app_record(&app, &recorder);
    fuzz_board_rests(&hardware, &DRIVE_CONFIG);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fed_t input = {data, size};
    size_t ticks = 0U;

    start();
    while ((input.left > 0U) && (ticks < TICKS_MAX)) {
        const size_t more = step(&input);

        for (size_t k = 0U; k < more; k++) {
            tick();
        }
        link_holds();
        ticks += more;
    }
    return 0;
}
