/* SPDX-License-Identifier: MIT */
#include "recorder_roll.h"

#include "drive_words.h"
#include "ring.h"

#include <stddef.h>

#define SPARE (RECORDER_SEGMENTS) /* index of the state after the last frame */
#define CHANGE_MARK (0x8000U)
#define COMPARE_MASK (0x7FFFU) /* a compare value has 15 bits in an entry */

/* The states here are copies that no control interrupt steps. */
static void copy_state(drive_t *to, const drive_t *from)
{
    *to = *from;
}

static const drive_cfg_t *config_with(const recorder_place_t *place, uint32_t crc)
{
    const drive_cfg_t *found = NULL;

    for (uint32_t k = 0U; k < 2U; k++) {
        if ((place->configs[k] != NULL) && (place->configs[k]->crc == crc)) {
            found = place->configs[k];
        }
    }
    return found;
}

/* Gives the drive the configuration that a change names. False when it is not known. */
static bool roll_change(drive_t *drive, const recorder_place_t *place,
                        const recorder_entry_t *entry)
{
    const drive_cfg_t *const cfg = config_with(place, entry->word[3]);

    if ((cfg != NULL) && (cfg->crc != drive->cfg->crc)) {
        drive_change(drive, cfg);
    }
    return cfg != NULL;
}

static bool is_as_recorded(const drive_out_t *computed, const drive_out_t *recorded)
{
    const uint32_t third = computed->compare.phase[2] & COMPARE_MASK;

    return (computed->compare.phase[0] == recorded->compare.phase[0]) &&
           (computed->compare.phase[1] == recorded->compare.phase[1]) &&
           (third == recorded->compare.phase[2]) &&
           (computed->gate_enable == recorded->gate_enable);
}

/*
 * Steps the drive over entries of a segment. Returns the number of entries before the first one
 * that is not as recorded.
 */
static uint32_t roll_entries(drive_t *drive, const recorder_place_t *place,
                             const recorder_entry_t *entries, uint32_t count)
{
    recorder_frame_t frame = {0};
    uint32_t done = 0U;
    bool good = true;

    while (good && (done < count)) {
        const recorder_entry_t *const entry = &entries[done];

        if (recorder_unpack(entry, &frame)) {
            drive_out_t out = {0};

            drive_step(drive, &frame.in, &out);
            good = is_as_recorded(&out, &frame.out);
        } else {
            good = roll_change(drive, place, entry);
        }
        done += good ? 1U : 0U;
    }
    return done;
}

static bool is_config(const recorder_place_t *place, const drive_cfg_t *cfg)
{
    return (cfg != NULL) && ((cfg == place->configs[0]) || (cfg == place->configs[1]));
}

static const drive_cfg_t *any_config(const recorder_place_t *place)
{
    return (place->configs[0] != NULL) ? place->configs[0] : place->configs[1];
}

/*
 * Whether the state before a segment has the configuration of this place, and the hash that was
 * noted of it.
 */
static bool is_state_whole(const recorder_t *recorder, const recorder_place_t *place,
                           uint32_t segment)
{
    const drive_t *const state = &recorder->states[segment];

    return is_config(place, state->cfg) &&
           (recorder->segments[segment].hash == recorder_hash(state));
}

/*
 * Makes all pointers of the recorder pointers that may be followed. A segment whose state is not
 * whole gets a configuration with a wrong CRC, so it is not a part of a history.
 */
static void mend_pointers(recorder_t *recorder, const recorder_place_t *place)
{
    for (uint32_t k = 0U; k < RECORDER_SEGMENTS; k++) {
        if (!is_state_whole(recorder, place, k)) {
            recorder->states[k].cfg = any_config(place);
            recorder->segments[k].config_crc = ~any_config(place)->crc;
        }
    }
    if (!is_config(place, recorder->states[SPARE].cfg)) {
        recorder->states[SPARE].cfg = any_config(place);
    }
    if (!is_config(place, recorder->before)) {
        recorder->before = NULL;
    }
}

/* Whether the recorder is one of this place, and at least one configuration is known. */
static bool is_of_place(const recorder_t *recorder, const recorder_place_t *place)
{
    return (any_config(place) != NULL) && (recorder->entries == place->entries) &&
           (recorder->due_entries == place->entries) &&
           (recorder->segment_entries == place->segment_entries) &&
           (recorder->due_segment_entries == place->segment_entries) &&
           (recorder->current < RECORDER_SEGMENTS);
}

static const recorder_entry_t *first_entry_of(const recorder_place_t *place, uint32_t segment)
{
    const uint32_t at = segment * place->segment_entries;

    return &place->entries[at];
}

/* Returns the number of entries of a segment up to `end`; 0 when `end` is not in this segment. */
static uint32_t entries_to(const recorder_place_t *place, uint32_t segment,
                           const recorder_entry_t *end)
{
    const size_t count = ring_entries_between(first_entry_of(place, segment), end);

    return (count <= place->segment_entries) ? (uint32_t)count : 0U;
}

/*
 * Returns the number of entries of the segment that was written last. If the reset came while the
 * recorder entered a segment, or before the hash of its state was noted, this is the segment before
 * it.
 */
static uint32_t find_end(recorder_t *recorder, const recorder_place_t *place)
{
    const uint32_t before = (recorder->current + RECORDER_SEGMENTS - 1U) % RECORDER_SEGMENTS;
    uint32_t count = entries_to(place, recorder->current, recorder->at);

    if (count == 0U) {
        recorder->current = before;
        count = entries_to(place, before, recorder->at);
    } else if (recorder->segments[recorder->current].hash == 0U) {
        recorder->current = before;
        count = entries_to(place, before, recorder->segments[before].end);
    } else {
        /* the segment has begun */
    }
    return count;
}

/*
 * Freezes a recording that was written until the reset. The last entry is left out if it is not
 * whole. False when an earlier one is not as recorded.
 */
static bool freeze_here(recorder_t *recorder, const recorder_place_t *place, drive_t *work)
{
    const uint32_t count = find_end(recorder, place);
    const uint32_t segment = recorder->current;
    const recorder_entry_t *const first = first_entry_of(place, segment);
    const bool known = is_state_whole(recorder, place, segment);
    uint32_t whole = 0U;

    copy_state(work, &recorder->states[segment]);
    if (known) {
        whole = roll_entries(work, place, first, count);
    }
    if (known && (whole < count) && ((whole + 1U) == count)) {
        copy_state(work, &recorder->states[segment]); /* the last entry has stepped it */
        whole = roll_entries(work, place, first, whole);
    }
    recorder->segments[segment].end = &first[whole];
    copy_state(&recorder->states[SPARE], work);
    recorder->frozen = true;
    return known && (count > 0U) && ((whole + 1U) >= count);
}

/* Whether a segment leads to the state `after`. */
static bool leads_to(const recorder_t *recorder, const recorder_place_t *place, uint32_t segment,
                     uint32_t after, drive_t *work)
{
    const uint32_t count = entries_to(place, segment, recorder->segments[segment].end);

    copy_state(work, &recorder->states[segment]);
    return is_state_whole(recorder, place, segment) &&
           (roll_entries(work, place, first_entry_of(place, segment), count) == count) &&
           (drive_words_hash(work) == drive_words_hash(&recorder->states[after]));
}

/* Leaves out the older segments up to the last one that is not as recorded. */
static void check_older(recorder_t *recorder, const recorder_place_t *place, drive_t *work)
{
    const recorder_history_t history = recorder_history(recorder);
    uint32_t segment = history.first;

    while ((history.entries > 0U) && (segment != recorder->current)) {
        const uint32_t next = (segment + 1U) % RECORDER_SEGMENTS;

        if (!leads_to(recorder, place, segment, next, work)) {
            recorder->segments[next].follows = false;
        }
        segment = next;
    }
}

bool recorder_rescue(recorder_t *recorder, const recorder_place_t *place, drive_t *work, bool *cut)
{
    bool good = is_of_place(recorder, place);

    *cut = good && !recorder->frozen;
    if (good) {
        mend_pointers(recorder, place);
        good = *cut ? freeze_here(recorder, place, work)
                    : leads_to(recorder, place, recorder->current, SPARE, work);
    }
    if (good) {
        recorder->held = true;
        recorder->triggered = true;
        recorder->kept = 0U;
        check_older(recorder, place, work);
        copy_state(work, &recorder->states[SPARE]);
        good = recorder_history(recorder).entries > 0U;
    }
    return good;
}
