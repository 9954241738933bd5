/* SPDX-License-Identifier: MIT */
/* A drive on noisy frames, with a recorder beside it as an interrupt and its background are. */
#ifndef RECORDED_RUN_H
#define RECORDED_RUN_H

#include "example_cfg.h"
#include "recorder.h"
#include "seeded.h"

#include <string.h>

#define RUN_SEGMENT_ENTRIES (128U)
#define RUN_POST_TICKS (20U)

typedef struct {
    drive_cfg_t cfg;
    drive_t drive;
    drive_in_t in;
    drive_out_t out;
    recorder_t recorder;
    recorder_entry_t entries[RECORDER_SEGMENTS * RUN_SEGMENT_ENTRIES];
    seeded_t noise;
} recorded_run_t;

/* Running at once, with whatever a motor that does not turn makes of it: supervision is off. */
static inline void recorded_run_start(recorded_run_t *run)
{
    (void)memset(run, 0, sizeof(*run));
    run->cfg = example_drive_cfg();
    example_supervise_nothing(&run->cfg);
    run->cfg.crc = config_guard_crc(&run->cfg);
    run->noise = (seeded_t){12345U};
    (void)drive_init(&run->drive, &run->cfg);
    (void)recorder_init(&run->recorder, run->entries, RUN_SEGMENT_ENTRIES, RUN_POST_TICKS);
    run->in.command.request = DRIVE_REQUEST_RUN;
    run->in.command.target = 1000000;
}

/* The frame of the next tick but for what a test puts there. */
static inline void recorded_run_noise(recorded_run_t *run)
{
    run->in.adc_ia = (uint16_t)seeded_in(&run->noise, 2040, 2056);
    run->in.adc_ib = (uint16_t)seeded_in(&run->noise, 2040, 2056);
    run->in.adc_bus = (uint16_t)seeded_in(&run->noise, 2810, 2830);
    run->in.adc_temperature = 700U;
    run->in.flags = 0U;
}

/* The control interrupt. */
static inline void recorded_run_interrupt(recorded_run_t *run)
{
    drive_step(&run->drive, &run->in, &run->out);
    recorder_step(&run->recorder, &run->drive, &run->in, &run->out);
}

/* Interrupt and background in turn. */
static inline void recorded_run_ticks(recorded_run_t *run, uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        recorded_run_noise(run);
        recorded_run_interrupt(run);
        recorder_service(&run->recorder, &run->drive);
    }
}

/* One tick with a fault. */
static inline void recorded_run_fail(recorded_run_t *run)
{
    recorded_run_noise(run);
    run->in.flags = DRIVE_FLAG_BREAK;
    recorded_run_interrupt(run);
    recorder_service(&run->recorder, &run->drive);
}

#endif
