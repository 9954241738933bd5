/* SPDX-License-Identifier: MIT */
/*
 * Any bytes that are typed at the console, while the drive runs, and whatever it does.
 *
 * The input is steps of two bytes and what belongs to them: see step().
 */
#include "commander.h"
#include "console.h"
#include "drive_config.h"
#include "fuzz_board.h"
#include "fuzzed.h"

#include <string.h>

#define ENTRIES (RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN)
#define POST_TICKS (8U)

static const about_t ABOUT = {DRIVE_ABOUT};

/*
 * The serial line: what is to be received, how much may be sent, how much of the console's text
 * was.
 */
typedef struct {
    const uint8_t *in;
    size_t in_left;
    size_t room;
    uint32_t sent;
} line_t;

static line_t line;
static app_t app;
static hal_t hardware;
static console_t console;
static recorder_t recorder;
static recorder_entry_t entries[ENTRIES];

/* The console has no flash. */
bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    (void)slot;
    (void)unit;
    (void)bytes;
    return false;
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    (void)hal;
    (void)slot;
    return false;
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    (void)slot;
    (void)unit;
    (void)bytes;
    return false;
}

static void receive(fed_t *input, size_t count)
{
    line.in = input->at;
    line.in_left = (count < input->left) ? count : input->left;
    input->at += line.in_left;
    input->left -= line.in_left;
}

static void type(void)
{
    while (line.in_left > 0U) {
        console_take(&console, line.in[0], true);
        line.in++;
        line.in_left--;
    }
}

/* Text for a person: nothing but what can be read, in lines that end with both. */
static void send(void)
{
    text_t *const out = &console.out;

    while ((line.sent < out->length) && (line.room > 0U)) {
        const char said = out->characters[line.sent];

        HOLDS(((said >= 0x20) && (said < 0x7F)) || (said == '\r') || (said == '\n'),
              "the console sends text");
        line.sent++;
        line.room--;
    }
    if (line.sent == out->length) {
        line.sent = 0U;
        out->length = 0U;
    }
}

static void tick(void)
{
    control_isr(&app);
    recorder_service(&recorder, &app.drive);
    type();
    commander_step(&app);
    console_step(&console);
    send();
}

static void console_holds(void)
{
    const int64_t highest = units_step(&ABOUT.rotation, ABOUT.speed_max_rpm);
    const drive_command_t command = command_mailbox_take(&app.mailbox);
    const int64_t target = command.target;
    const uint8_t request = command.request;

    HOLDS((target >= -highest) && (target <= highest), "a target is within the board's speed");
    HOLDS((request == 0U) || (request == DRIVE_REQUEST_RUN) || (request == DRIVE_REQUEST_CLEAR),
          "a request is one of those there are");
    HOLDS(console.length <= CONSOLE_LINE_MAX, "a line stays within its buffer");
    HOLDS((console.out.length <= TEXT_MAX) && (line.sent <= console.out.length),
          "the answer stays within its buffer");
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
        hardware.health.late_ticks = (uint32_t)fed_half(input) << 16U;
        hardware.health.load_pct = fed_half(input);
        break;
    case 4U:
        hardware.measured.adc_temperature = (uint16_t)(count * 16U);
        break;
    default:
        fuzz_board_rests(&hardware, &DRIVE_CONFIG);
        break;
    }
    line.room = (what >= 128U) ? count : SIZE_MAX;
    return ticks;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fed_t input = {data, size};
    size_t ticks = 0U;

    line = (line_t){0};
    hardware = (hal_t){0};
    HOLDS(app_init(&app, &hardware, &DRIVE_CONFIG) == NULL, "the board's configuration is taken");
    HOLDS(recorder_init(&recorder, entries, RECORDER_ENTRIES_MIN, POST_TICKS) == NULL,
          "the recorder's size is taken");
    app_record(&app, &recorder);
    console_init(&console, &app, &hardware, &ABOUT);
    fuzz_board_rests(&hardware, &DRIVE_CONFIG);
    while ((input.left > 0U) && (ticks < TICKS_MAX)) {
        const size_t more = step(&input);
        for (size_t k = 0U; k < more; k++) {
            tick();
            console_holds();
        }
        ticks += more;
    }
    return 0;
}
