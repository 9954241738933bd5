/* SPDX-License-Identifier: MIT */
#include "recorder_rescue.h"

#include "ring.h"

#include <stddef.h>

#define SPARE (RECORDER_SEGMENTS) /* index of the state after the last frame */

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

static bool is_config(const recorder_place_t *place, const drive_cfg_t *cfg)
{
    return (cfg != NULL) && ((cfg == place->configs[0]) || (cfg == place->configs[1]));
}

static const drive_cfg_t *any_config(const recorder_place_t *place)
{
    return (place->configs[0] != NULL) ? place->configs[0] : place->configs[1];
}

/* Whether a state has a configuration of this place, and the hash that was noted of it. */
static bool is_state_whole(const recorder_place_t *place, const drive_t *state, uint32_t hash)
{
    return is_config(place, state->cfg) && (hash == recorder_hash(state));
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

static const recorder_entry_t *place_of_segment(const recorder_place_t *place, uint32_t segment)
{
    const uint32_t at = segment * place->segment_entries;

    return &place->entries[at];
}

/* Returns the number of entries of a segment up to `end`; 0 when `end` is not in this segment. */
static uint32_t entries_to(const recorder_place_t *place, uint32_t segment,
                           const recorder_entry_t *end)
{
    const size_t count = ring_entries_between(place_of_segment(place, segment), end);

    return (count <= place->segment_entries) ? (uint32_t)count : 0U;
}

/* Whether the check word of a segment is that of its entries. */
static bool is_sum_right(const recorder_t *recorder, const recorder_place_t *place,
                         uint32_t segment)
{
    const recorder_segment_t *const about = &recorder->segments[segment];
    const recorder_entry_t *const first = place_of_segment(place, segment);
    const bool fits = about->summed <= place->segment_entries;
    uint32_t sum = RECORDER_SUM_START;

    for (uint32_t k = 0U; fits && (k < about->summed); k++) {
        sum = recorder_entry_sum(sum, &first[k]);
    }
    return fits && (sum == about->sum);
}

/*
 * Makes all pointers of the recorder pointers that may be followed, and all sums cover entries of
 * the ring. A segment that is not whole gets a configuration with a wrong CRC, so it is not a part
 * of a history.
 */
static void mend_pointers(recorder_t *recorder, const recorder_place_t *place)
{
    for (uint32_t k = 0U; k < RECORDER_SEGMENTS; k++) {
        recorder_segment_t *const segment = &recorder->segments[k];

        if (!is_state_whole(place, &recorder->states[k], segment->hash) ||
            !is_sum_right(recorder, place, k)) {
            recorder->states[k].cfg = any_config(place);
            segment->summed = 0U;
            segment->config_crc = ~any_config(place)->crc;
        }
    }
    if (!is_config(place, recorder->before)) {
        recorder->before = NULL;
    }
}

/*
 * Makes the segment that was written last the current one, and returns the number of its entries;
 * the last one may be half written. If the reset came while the recorder entered a segment, or
 * before the hash of its state was noted, this is the segment before it.
 */
static uint32_t find_end(recorder_t *recorder, const recorder_place_t *place)
{
    const uint32_t before = (recorder->current + RECORDER_SEGMENTS - 1U) % RECORDER_SEGMENTS;
    const recorder_entry_t *end = recorder->at;

    if (entries_to(place, recorder->current, end) == 0U) {
        recorder->current = before;
    } else if (recorder->segments[recorder->current].hash == 0U) {
        recorder->current = before;
        end = recorder->segments[before].end;
    } else {
        /* the segment has begun */
    }
    return entries_to(place, recorder->current, end);
}

/* Steps the tick and the configuration of a state over the entries of a segment. */
static void count_on(drive_t *state, const recorder_place_t *place, const recorder_entry_t *entries,
                     uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        if (!recorder_entry_is_change(&entries[k])) {
            state->tick++;
        } else if (config_with(place, entries[k].word[3]) != NULL) {
            state->cfg = config_with(place, entries[k].word[3]);
        } else {
            /* a configuration that is not known, so there will be no history */
        }
    }
}

/* Freezes a recording that was written until the reset. */
static void freeze_here(recorder_t *recorder, const recorder_place_t *place)
{
    const uint32_t written = find_end(recorder, place);
    const uint32_t segment = recorder->current;
    const uint32_t summed = recorder->segments[segment].summed;
    const recorder_entry_t *const first = place_of_segment(place, segment);
    uint32_t count = summed;

    if (place->powered && (written > summed)) {
        count = written - 1U;
    }
    recorder->segments[segment].end = &first[count];
    recorder->states[SPARE] = recorder->states[segment];
    count_on(&recorder->states[SPARE], place, first, count);
    recorder->frozen = true;
}

static bool had_gates_on(const recorder_t *recorder, const recorder_history_t *history)
{
    recorder_frame_t frame = {0};
    bool had = false;

    for (uint32_t k = 0U; !had && (k < history->entries); k++) {
        had =
            recorder_unpack(recorder_entry(recorder, history, k), &frame) && frame.out.gate_enable;
    }
    return had;
}

recorder_rescued_t recorder_rescue(recorder_t *recorder, const recorder_place_t *place)
{
    recorder_rescued_t rescued = {false, false, false};

    if (is_of_place(recorder, place)) {
        recorder_history_t history;

        mend_pointers(recorder, place);
        rescued.cut = !recorder->frozen ||
                      !is_state_whole(place, &recorder->states[SPARE], recorder->end_hash);
        if (rescued.cut) {
            freeze_here(recorder, place);
        }
        recorder->held = true;
        recorder->triggered = true;
        recorder->kept = 0U;
        history = recorder_history(recorder);
        rescued.found = history.entries > 0U;
        rescued.drove = had_gates_on(recorder, &history);
    }
    return rescued;
}
