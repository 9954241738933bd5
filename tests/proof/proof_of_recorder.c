/* SPDX-License-Identifier: MIT */
/*
 * One recorder_step from any state within the ranges below, after any tick, with a change of the
 * configuration before it or without, ends within them, and recorder_init begins there: an
 * induction over the ticks. What the background writes between two of them is chosen anew for each;
 * that it
 * keeps to the ranges is taken for granted. Read by Eva, see proof.py.
 *
 * `volatile` is for the background, which the step interrupts: while it runs, what was written is
 * what is read. Eva would take it to be any word.
 */
#include "any_frame.h"

#include <__fc_builtin.h>
#include <stddef.h>

/* For the compiler alone. */
#define __ATOMIC_SEQ_CST 5
/*@ assigns \nothing; */
void __atomic_signal_fence(int order);

#define volatile
#include "port/ring.h" /* in place of the header of that name */

#include "../../firmware/record/recorder.c"

/* Entries of a segment that a configuration allows at most; RECORDER_ENTRIES_MIN is the least. */
#define LONGEST (16384U)

static recorder_entry_t few[RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN];
static recorder_entry_t many[RECORDER_SEGMENTS * LONGEST];
static recorder_t recorder;
static drive_t drive;
static drive_cfg_t cfg;
static drive_cfg_t before;
static drive_in_t in;
static drive_out_t out;

/*@ requires lowest <= value <= highest;
    assigns \nothing; */
void within(int64_t value, int64_t lowest, int64_t highest);

static void choose_tick(void)
{
    cfg.crc = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    cfg.slow_ticks = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    drive.cfg = &cfg;
    drive.tick = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    drive.slow_count = Frama_C_unsigned_int_interval(1U, 100U);
    in = any_frame();
    out.compare.phase[0] = Frama_C_unsigned_short_interval(0, 65535);
    out.compare.phase[1] = Frama_C_unsigned_short_interval(0, 65535);
    out.compare.phase[2] = Frama_C_unsigned_short_interval(0, 65535);
    out.gate_enable = Frama_C_interval(0, 1) != 0;
}

/* An entry, or none: as an offer or a change leaves the stop. */
static const recorder_entry_t *any_place(uint32_t last)
{
    const recorder_entry_t *place = NULL;

    if (Frama_C_interval(0, 1) != 0) {
        place = &recorder.entries[Frama_C_unsigned_int_interval(0U, last)];
    }
    return place;
}

static void choose_state(uint32_t behind)
{
    recorder.at = &recorder.entries[Frama_C_unsigned_int_interval(0U, behind)];
    recorder.stop = any_place(behind - TICK_ENTRIES);
    recorder.due_stop = any_place(behind - TICK_ENTRIES);
    recorder.span = Frama_C_unsigned_short_interval(0, 65535);
    recorder.due_entries = (recorder_entry_t *)any_place(behind - TICK_ENTRIES);
    recorder.due_segment_entries = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    recorder.target = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    recorder.slow = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    recorder.current = Frama_C_unsigned_int_interval(0U, NONE);
    recorder.offered = Frama_C_interval(0, 1) != 0;
    recorder.frozen = Frama_C_interval(0, 1) != 0;
    recorder.next = Frama_C_unsigned_int_interval(0U, END);
    recorder.next_tick = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    recorder.gap = Frama_C_interval(0, 1) != 0;
    recorder.changed = Frama_C_interval(0, 1) != 0;
}

static void check_stop(const recorder_entry_t *entries, uint32_t last)
{
    if (recorder.stop != NULL) {
        within(recorder.stop - entries, 0, last);
    }
}

static void check_state(const recorder_entry_t *entries, uint32_t segment_entries)
{
    const uint32_t behind = RECORDER_SEGMENTS * segment_entries;

    within(recorder.entries == entries, 1, 1);
    within(recorder.segment_entries, segment_entries, segment_entries);
    within(recorder.at - entries, 0, behind);
    check_stop(entries, behind - TICK_ENTRIES);
    within(recorder.current, 0, NONE);
    within(recorder.next, 0, END);
}

static void record(recorder_entry_t *entries, uint32_t segment_entries)
{
    (void)recorder_init(&recorder, entries, segment_entries, RECORDER_POST_TICKS_MAX);
    check_state(entries, segment_entries);
    choose_state(RECORDER_SEGMENTS * segment_entries);
    choose_tick();
    if (Frama_C_interval(0, 1) != 0) {
        recorder_change(&recorder, &before);
        check_state(entries, segment_entries);
    }
    recorder_step(&recorder, &drive, &in, &out);
    check_state(entries, segment_entries);
}

/*
 * An offset is a multiple of the length of a segment: what holds of the shortest and the longest
 * holds of all.
 */
void proof_recorder(void)
{
    (void)recorder_init(&recorder, few, Frama_C_unsigned_int_interval(0U, UINT32_MAX),
                        Frama_C_unsigned_int_interval(0U, UINT32_MAX));
    record(few, RECORDER_ENTRIES_MIN);
    record(many, LONGEST);
}
