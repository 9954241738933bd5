/* SPDX-License-Identifier: MIT */
/*
 * Replays frames.nfr through the control interrupt and writes results.nfr, both in the working
 * folder of the emulator (recording.h). The exit code is 0, or one of the codes below; then the
 * reason is printed.
 */
#include "app.h"
#include "drive_config.h"
#include "hal_mps2.h"
#include "recording.h"
#include "reset.h"
#include "semihost.h"

#include <stddef.h>

#define EXIT_REFUSED (2U)    /* the file, its header or the configuration is refused */
#define EXIT_UNEXPECTED (3U) /* an unexpected exception has come */

/* Ticks that are read, run and written together: the RAM of the smallest board is small. */
#define BLOCK_TICKS (16U)

/* Ticks that the flight recorder goes on for after a fault. */
#define POST_TICKS (8U)

static hal_t hardware;
static app_t app;
static recorder_t recorder;
static uint8_t frames[BLOCK_TICKS * RECORDING_FRAME_BYTES];
static uint8_t results[BLOCK_TICKS * RECORDING_RESULT_BYTES];

// NOLINTNEXTLINE(misc-use-internal-linkage): tools look for this name
void control_interrupt(void);

void board_safe_state(void)
{
    semihost_print("unexpected exception\n");
    semihost_exit(EXIT_UNEXPECTED);
}

static void refuse(const char *why)
{
    semihost_print(why);
    semihost_exit(EXIT_REFUSED);
}

static void need(bool holds, const char *otherwise)
{
    if (!holds) {
        refuse(otherwise);
    }
}

/*
 * The interrupt controller would call this. It is a function of its own, so that its cost can be
 * counted.
 */
__attribute__((noinline, used)) void control_interrupt(void)
{
    control_isr(&app);
}

static void run_block(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        const drive_in_t in = recording_get_frame(&frames[k * RECORDING_FRAME_BYTES]);

        hal_mps2_feed(&hardware, &in);
        command_mailbox_post(&app.mailbox, &in.command);
        control_interrupt();
        recorder_service(&recorder, &app.drive);
        recording_put_result(&results[k * RECORDING_RESULT_BYTES], &hardware.applied, &app.drive);
    }
}

static void replay(int32_t from, int32_t to, uint32_t ticks)
{
    uint32_t left = ticks;

    while (left > 0U) {
        const uint32_t block = (left < BLOCK_TICKS) ? left : BLOCK_TICKS;

        need(semihost_read(from, frames, block * RECORDING_FRAME_BYTES),
             "frames.nfr ends too early\n");
        run_block(block);
        need(semihost_write(to, results, block * RECORDING_RESULT_BYTES),
             "results.nfr cannot be written\n");
        left -= block;
    }
}

/*
 * Checks the header and writes the header of the results. Returns the number of ticks to replay;
 * their frames follow in the file.
 */
static uint32_t begin(int32_t from, int32_t to, uint32_t config_hash)
{
    recording_header_t header;
    const char *why;

    need(semihost_read(from, frames, RECORDING_HEADER_BYTES), "frames.nfr has no header\n");
    header = recording_get_header(frames);
    why = recording_refuse(&header, config_hash);
    need(why == NULL, why);
    header = recording_header(RECORDING_RESULTS, config_hash, header.ticks);
    recording_put_header(results, &header);
    need(semihost_write(to, results, RECORDING_HEADER_BYTES), "results.nfr cannot be written\n");
    return header.ticks;
}

int main(void)
{
    static const char from_name[] = "frames.nfr";
    static const char to_name[] = "results.nfr";
    static recorder_entry_t recorded[RECORDER_SEGMENTS * DRIVE_RECORDER_ENTRIES];
    const int32_t from = semihost_open(from_name, sizeof(from_name) - 1U, SEMIHOST_READ);
    const int32_t to = semihost_open(to_name, sizeof(to_name) - 1U, SEMIHOST_WRITE);
    uint32_t ticks;

    need(from >= 0, "frames.nfr cannot be read\n");
    need(to >= 0, "results.nfr cannot be written\n");
    need(app_init(&app, &hardware, &DRIVE_CONFIG) == NULL, "the drive refuses its configuration\n");
    need(recorder_init(&recorder, recorded, DRIVE_RECORDER_ENTRIES, POST_TICKS) == NULL,
         "the recorder refuses its size\n");
    app_record(&app, &recorder);
    ticks = begin(from, to, recording_config_hash(&DRIVE_CONFIG));
    replay(from, to, ticks);
    need(semihost_close(to), "results.nfr cannot be written\n");
    semihost_exit(0U);
    return 0;
}
