/* SPDX-License-Identifier: MIT */
#include "recorder.h"

#include "barrier.h"
#include "drive_words.h"
#include "fx.h"
#include "inlining.h"
#include "ring.h"

#include <stddef.h>

#define NONE (RECORDER_SEGMENTS)  /* in place of a segment: there is none */
#define END (RECORDER_SEGMENTS)   /* in place of a segment: the recording ends */
#define SPARE (RECORDER_SEGMENTS) /* index of the state that belongs to no segment */
#define HALF_MASK (0xFFFFU)
#define BYTE_MASK (0xFFU)
#define COMPARE_MASK (0x7FFFU)
#define GATE_BIT (15U)
#define TICK_ENTRIES (3U) /* entries reserved for a tick */
#define SLACK_SHARE (2U)  /* at most 1/2 of a segment is slack, even in a long slow period */

_Static_assert(sizeof(recorder_entry_t) == (1U << RING_ENTRY_LOG2), "an entry has 16 bytes");
_Static_assert(RECORDER_STATES == (SPARE + 1U), "one state more than segments");

static uint32_t pair(uint32_t lower, uint32_t upper)
{
    return lower | (upper << 16U);
}

static uint32_t slow_part(const drive_in_t *in)
{
    const uint32_t command = in->command.mode | ((uint32_t)in->command.request << 8U);

    return pair(command, in->adc_temperature);
}

/* Returns an index within the ring, even if a bit of `segment` has flipped by itself. */
static uint32_t in_ring(uint32_t segment)
{
    return segment % RECORDER_SEGMENTS;
}

static recorder_entry_t *first_of(const recorder_t *recorder, uint32_t segment)
{
    const uint32_t at = in_ring(segment) * recorder->segment_entries;

    return &recorder->entries[at];
}

/*
 * Returns the number of entries that the ticks leave free at the end of this segment; only the last
 * segment of the ring has such entries. A flipped bit in the stop is found only once per slow
 * period. Until then the ticks may write beyond the true stop, into these entries.
 */
static uint32_t slack(const recorder_t *recorder, uint32_t segment, uint32_t slow_ticks)
{
    const bool last = in_ring(segment) == (RECORDER_SEGMENTS - 1U);
    const uint32_t most = recorder->segment_entries / SLACK_SHARE;
    const uint32_t bound = (slow_ticks < most) ? slow_ticks : most;

    return last ? bound : 0U;
}

/*
 * Returns the last place in a segment at which a tick may begin. A tick needs two entries at most;
 * three are reserved, because the proof cannot show it.
 */
static const recorder_entry_t *stop_of(const recorder_t *recorder, uint32_t segment,
                                       uint32_t slow_ticks)
{
    const uint32_t behind = (in_ring(segment) + 1U) * recorder->segment_entries;

    return &recorder->entries[behind - TICK_ENTRIES - slack(recorder, segment, slow_ticks)];
}

/* Whether place and size of the ring are as recorder_init() has set them. */
static bool is_ring_sound(const recorder_t *recorder)
{
    return (recorder->entries == recorder->due_entries) &&
           (recorder->segment_entries == recorder->due_segment_entries);
}

/* Whether a tick may begin at `at`. */
static bool is_within(const recorder_t *recorder, const recorder_entry_t *at)
{
    return ring_is_within(at, recorder->stop, recorder->span);
}

static void set_stop(recorder_t *recorder, uint32_t segment, uint32_t slow_ticks)
{
    /*@ split segment; */
    const recorder_entry_t *const stop = stop_of(recorder, segment, slow_ticks);

    recorder->span = (uint16_t)ring_entries_between(first_of(recorder, segment), stop);
    recorder->due_stop = stop;
    recorder->stop = stop;
}

/*
 * Whether a slow input has changed. Bit operations compare the inputs, so that there is only one
 * branch.
 */
static bool has_changed(const recorder_t *recorder, const drive_in_t *in)
{
    const uint32_t target = fx_unsigned(in->command.target);

    return ((target ^ recorder->target) | (slow_part(in) ^ recorder->slow)) != 0U;
}

/*
 * Whether a bit of the stop has flipped or a slow input has changed. Called in one tick of each
 * slow period.
 */
static bool needs_attention(const recorder_t *recorder, const drive_in_t *in)
{
    return (recorder->stop != recorder->due_stop) || has_changed(recorder, in);
}

static recorder_entry_t *put_change(recorder_t *recorder, recorder_entry_t *at,
                                    const drive_t *drive, const drive_in_t *in)
{
    recorder->target = fx_unsigned(in->command.target);
    recorder->slow = slow_part(in);
    recorder->changed = false;
    *at = (recorder_entry_t){
        {recorder->target, recorder->slow, RECORDER_CHANGE_MARK, drive->cfg->crc}};
    return &at[1];
}

static recorder_entry_t *put_frame(recorder_entry_t *at, const drive_in_t *in,
                                   const drive_out_t *out)
{
    const uint32_t gate = out->gate_enable ? 1U : 0U;

    at->word[0] = pair(in->adc_ia, in->adc_ib);
    at->word[1] = pair(in->adc_bus, in->flags);
    at->word[2] = pair(out->compare.phase[0], out->compare.phase[1]);
    at->word[3] = pair(out->compare.phase[2] | (gate << GATE_BIT), in->angle);
    return &at[1];
}

/* Ends the current segment here. */
static void leave_segment(recorder_t *recorder)
{
    if (recorder->current != NONE) {
        recorder->segments[in_ring(recorder->current)].end = recorder->at;
    }
}

static void enter_segment(recorder_t *recorder, const drive_t *drive, const drive_in_t *in)
{
    const uint32_t next = in_ring(recorder->next);

    recorder->segments[next].follows = (recorder->current != NONE) && !recorder->gap;
    recorder->gap = false;
    recorder->current = next;
    set_stop(recorder, next, drive->cfg->slow_ticks);
    recorder->at = put_change(recorder, first_of(recorder, next), drive, in);
}

/*
 * Returns the place for this tick in the current segment, after the change if there is one, or NULL
 * if there is no room.
 */
static recorder_entry_t *room_for_tick(recorder_t *recorder, const drive_t *drive,
                                       const drive_in_t *in)
{
    recorder_entry_t *at = recorder->at;

    set_stop(recorder, recorder->current, drive->cfg->slow_ticks);
    if (!is_within(recorder, at)) {
        recorder->gap = true;
        at = NULL;
    } else if (recorder->changed) {
        at = put_change(recorder, at, drive, in);
    } else {
        /* the frame alone */
    }
    return at;
}

/*
 * Returns the place for the entries of this tick, or NULL when the recording is frozen or there is
 * no room.
 */
static recorder_entry_t *next_room(recorder_t *recorder, const drive_t *drive, const drive_in_t *in)
{
    const bool fits = recorder->offered && (recorder->next_tick == (drive->tick - 1U));
    recorder_entry_t *at = NULL;

    if (fits && (recorder->next == END)) {
        leave_segment(recorder);
        recorder->frozen = true;
    } else if (fits) {
        leave_segment(recorder);
        enter_segment(recorder, drive, in);
        at = recorder->at;
    } else if (!recorder->frozen && (recorder->current != NONE)) {
        at = room_for_tick(recorder, drive, in);
    } else {
        /* nothing to record to */
    }
    recorder->offered = false;
    return at;
}

/*
 * Returns the place for the entries of this tick, or NULL if a bit in the place or the size of the
 * ring has flipped: then nothing is written to the ring any more.
 */
RARE static recorder_entry_t *turn_over(recorder_t *recorder, const drive_t *drive,
                                        const drive_in_t *in)
{
    return is_ring_sound(recorder) ? next_room(recorder, drive, in) : NULL;
}

/*
 * Handles a flipped bit of the stop and a change of the slow inputs. Returns the place for the
 * frame, or NULL.
 */
RARE static recorder_entry_t *attend_change(recorder_t *recorder, recorder_entry_t *at,
                                            const drive_t *drive, const drive_in_t *in)
{
    recorder_entry_t *room = at;

    if (recorder->stop != recorder->due_stop) {
        room = turn_over(recorder, drive, in);
    }
    if ((room != NULL) && has_changed(recorder, in)) {
        room = put_change(recorder, room, drive, in);
    }
    return room;
}

void recorder_step(recorder_t *recorder, const drive_t *drive, const drive_in_t *in,
                   const drive_out_t *out)
{
    recorder_entry_t *at = recorder->at;

    if (!is_within(recorder, at)) {
        at = turn_over(recorder, drive, in);
    }
    if ((at != NULL) && drive_has_read_slow_inputs(drive) && needs_attention(recorder, in)) {
        at = attend_change(recorder, at, drive, in);
    }
    if (at != NULL) {
        recorder->at = put_frame(at, in, out);
    }
}

/*
 * With the stop NULL, the next tick finds its segment full. Only such a tick reads `changed`, so
 * the other ticks save that time.
 */
void recorder_change(recorder_t *recorder, const drive_cfg_t *before)
{
    recorder->before = before;
    recorder->changed = true;
    recorder->stop = NULL;
}

uint32_t recorder_newest(const recorder_t *recorder)
{
    const uint32_t current = recorder->current;

    return (current == NONE) ? 0U : recorder->segments[in_ring(current)].number;
}

/*
 * Restarts with the same memory. While the recorder is frozen the interrupt does not touch it, so
 * `frozen` is cleared last.
 */
static void begin_anew(recorder_t *recorder)
{
    for (uint32_t k = 0U; k < RECORDER_SEGMENTS; k++) {
        recorder->segments[k] = (recorder_segment_t){0};
    }
    recorder->at = recorder->entries;
    recorder->stop = NULL; /* no place is within it, so the next tick calls turn_over() */
    recorder->current = NONE;
    recorder->offered = false;
    recorder->gap = false;
    recorder->triggered = false;
    recorder->kept = 0U;
    recorder->changed = false;
    recorder->end_hash = 0U;
    barrier_compiler();
    recorder->frozen = false;
}

const char *recorder_init(recorder_t *recorder, recorder_entry_t *entries, uint32_t segment_entries,
                          uint32_t post_ticks)
{
    const char *bad = NULL;

    *recorder = (recorder_t){.entries = entries,
                             .segment_entries = segment_entries,
                             .due_entries = entries,
                             .due_segment_entries = segment_entries,
                             .post_ticks = post_ticks,
                             .current = NONE};
    begin_anew(recorder);
    if ((segment_entries < RECORDER_ENTRIES_MIN) || (segment_entries > RECORDER_ENTRIES_MAX)) {
        bad = "segment_entries";
    } else if (post_ticks > RECORDER_POST_TICKS_MAX) {
        bad = "post_ticks";
    } else {
        /* both are valid */
    }
    return bad;
}

/* Returns the number of the next segment. It skips 0, which means an empty segment. */
static uint32_t number_after(const recorder_t *recorder)
{
    const uint32_t newest = recorder_newest(recorder);
    const uint32_t before = (newest == 0U) ? recorder->ended : newest;

    return (before == UINT32_MAX) ? 1U : (before + 1U);
}

/*
 * Copies the state, and offers the copy when no tick came meanwhile. A tick that finds its segment
 * full reads `offered`, any other tick reads the stop. So both are written last, after everything
 * that belongs to the offer.
 */
static void offer(recorder_t *recorder, const volatile drive_t *drive, uint32_t next)
{
    const uint32_t tick = drive->tick;

    if (next == END) {
        recorder->kept = 0U;
    } else {
        recorder->segments[next] = (recorder_segment_t){.number = number_after(recorder),
                                                        .config_crc = drive->cfg->crc,
                                                        .sum = RECORDER_SUM_START};
    }
    barrier_compiler();
    recorder->states[next] = *drive;
    barrier_compiler();
    if (drive->tick == tick) {
        recorder->next = next;
        recorder->next_tick = tick;
        barrier_compiler();
        recorder->offered = true;
        recorder->stop = NULL;
    }
}

static bool is_nearly_full(const recorder_t *recorder, uint32_t slow_ticks)
{
    const uint32_t current = recorder->current;

    return (current == NONE) || (&recorder->at[RECORDER_MARGIN + 1U - TICK_ENTRIES] >
                                 stop_of(recorder, current, slow_ticks));
}

static uint32_t segment_after(uint32_t segment)
{
    return (segment >= (RECORDER_SEGMENTS - 1U)) ? 0U : (segment + 1U);
}

static void trigger(recorder_t *recorder, uint32_t tick)
{
    recorder->triggered = true;
    recorder->trigger = tick;
}

/* Whether post_ticks were recorded after the tick of the trigger. */
static bool is_over(const recorder_t *recorder, uint32_t tick)
{
    return recorder->triggered && (recorder->current != NONE) &&
           ((tick - recorder->trigger) > recorder->post_ticks);
}

/* Offers the end, or the next segment, if it is time. Call while no offer is open. */
static void prepare(recorder_t *recorder, const volatile drive_t *live)
{
    if (is_over(recorder, live->tick)) {
        offer(recorder, live, END);
    } else if (is_nearly_full(recorder, live->cfg->slow_ticks)) {
        offer(recorder, live, segment_after(recorder->current));
    } else {
        /* there is room */
    }
}

static uint32_t segment_before(uint32_t segment)
{
    return (segment == 0U) ? (RECORDER_SEGMENTS - 1U) : (segment - 1U);
}

/*
 * Returns the number of entries of a segment up to `end`. It is found by bisection to save time,
 * because a reader calls this in each of its passes.
 */
static uint32_t count_entries(const recorder_t *recorder, uint32_t segment,
                              const recorder_entry_t *end)
{
    const recorder_entry_t *const first = first_of(recorder, segment);
    uint32_t least = 0U;
    uint32_t most = recorder->segment_entries;

    while (least < most) {
        const uint32_t middle = (least + most) / 2U;

        if (&first[middle] < end) {
            least = middle + 1U;
        } else {
            most = middle;
        }
    }
    return least;
}

uint32_t recorder_hash(const drive_t *state)
{
    return drive_words_hash(state) | 1U;
}

/* Once for each segment. The interrupt neither writes the state of the current one nor its hash. */
static void note_hash(recorder_t *recorder)
{
    const uint32_t segment = recorder->current;

    if ((segment < NONE) && (recorder->segments[segment].hash == 0U)) {
        recorder->segments[segment].hash = recorder_hash(&recorder->states[segment]);
    }
}

/* Extends the sum of a segment to the entries before `end`. */
static void sum_entries_to(recorder_t *recorder, uint32_t segment, const recorder_entry_t *end)
{
    const recorder_entry_t *const first = first_of(recorder, segment);
    const uint32_t count = count_entries(recorder, segment, end);
    recorder_segment_t *const about = &recorder->segments[segment];

    for (uint32_t k = about->summed; k < count; k++) {
        about->sum = recorder_entry_sum(about->sum, &first[k]);
    }
    about->summed = count;
}

/*
 * Sums the entries since the last call: of the segment that is written, and of the one before it,
 * whose last entries may have come after that call. If a tick enters a segment just now, the next
 * call sums them.
 */
static void note_sums(recorder_t *recorder)
{
    const uint32_t segment = recorder->current;
    const recorder_entry_t *const at = recorder->at;

    if ((segment < NONE) && is_ring_sound(recorder) &&
        (ring_entries_between(first_of(recorder, segment), at) <= recorder->segment_entries)) {
        if (recorder->segments[segment].follows) {
            const uint32_t before = segment_before(segment);

            sum_entries_to(recorder, before, recorder->segments[before].end);
        }
        sum_entries_to(recorder, segment, at);
    }
}

/* Once for each recording that is frozen. */
static void note_end(recorder_t *recorder)
{
    if (recorder->end_hash == 0U) {
        note_sums(recorder);
        recorder->end_hash = recorder_hash(&recorder->states[SPARE]);
    }
}

void recorder_service(recorder_t *recorder, const drive_t *drive)
{
    const volatile drive_t *const live = drive;
    const bool failed = live->state == DRIVE_STATE_FAULT;

    recorder->passed = failed && (recorder->followed || recorder->passed);
    if (failed && !recorder->triggered && !recorder->passed) {
        trigger(recorder, live->fault.tick);
        recorder->held = true;
    }
    if (recorder->frozen) {
        note_end(recorder);
        if ((!failed || recorder->passed) && !recorder->held) {
            recorder->ended = recorder_newest(recorder);
            begin_anew(recorder);
        }
    } else if (!recorder->offered) {
        note_hash(recorder);
        note_sums(recorder);
        prepare(recorder, live);
    } else {
        /* the next tick decides */
    }
}

void recorder_follow(recorder_t *recorder, bool on)
{
    recorder->followed = on;
}

void recorder_hold(recorder_t *recorder, const drive_t *drive)
{
    const volatile drive_t *const live = drive;

    recorder->held = true;
    if (!recorder->triggered) {
        trigger(recorder, (live->tick - 1U) - recorder->post_ticks);
    }
}

void recorder_release(recorder_t *recorder)
{
    recorder->held = false;
}

/*
 * Returns the second of the two configurations that a history can have, or NULL when it can have
 * only one.
 */
static const drive_cfg_t *other_config(const recorder_t *recorder, const drive_cfg_t *begin)
{
    const drive_cfg_t *const end = recorder->states[SPARE].cfg;

    return (end == begin) ? recorder->before : end;
}

/* Returns the number of ticks from the state before a segment to the state after it. */
static uint32_t ticks_of_segment(const recorder_t *recorder, uint32_t segment)
{
    const uint32_t after =
        (segment == recorder->current) ? SPARE : ((segment + 1U) % RECORDER_SEGMENTS);

    return recorder->states[after].tick - recorder->states[segment].tick;
}

/* What the entries of a segment say. */
typedef struct {
    uint32_t entries;
    uint32_t changes;
    uint32_t crc[2]; /* of the configurations that its changes name; the same one twice: only one */
    bool too_many;   /* its changes name more than two configurations */
} segment_facts_t;

RARE static void note_further(segment_facts_t *facts, uint32_t crc)
{
    if (facts->changes == 0U) {
        facts->crc[0] = crc;
        facts->crc[1] = crc;
    } else if ((crc == facts->crc[0]) || (crc == facts->crc[1])) {
        /* known already */
    } else if (facts->crc[0] == facts->crc[1]) {
        facts->crc[1] = crc;
    } else {
        facts->too_many = true;
    }
    facts->changes++;
}

/*
 * Reads the entries of a segment. A recording has thousands of them, and the background has to come
 * round before the watchdog waits in vain: each entry is read once only.
 */
static segment_facts_t facts_of(const recorder_t *recorder, uint32_t segment)
{
    const recorder_entry_t *const first = first_of(recorder, segment);
    segment_facts_t facts = {.entries =
                                 count_entries(recorder, segment, recorder->segments[segment].end)};

    for (uint32_t at = 0U; at < facts.entries; at++) {
        if (recorder_entry_is_change(&first[at])) {
            note_further(&facts, first[at].word[3]);
        }
    }
    return facts;
}

/* Whether the changes of a segment name no other configurations than these two. */
RARE static bool names_only(const segment_facts_t *facts, uint32_t one, uint32_t other)
{
    const bool first = (facts->crc[0] == one) || (facts->crc[0] == other);
    const bool second = (facts->crc[1] == one) || (facts->crc[1] == other);

    return (facts->changes == 0U) || (!facts->too_many && first && second);
}

/*
 * Whether a segment is sound: its changes name only the two configurations of a history that begins
 * with `begin`, and it has a frame for each of its ticks. If a bit of the write pointer has
 * flipped, old frames remain or new ones are overwritten, so the number of frames differs.
 */
RARE static bool has_only_two(const recorder_t *recorder, const segment_facts_t *facts,
                              uint32_t segment, const drive_cfg_t *begin)
{
    const drive_cfg_t *const other = other_config(recorder, begin);
    const uint32_t other_crc = (other == NULL) ? begin->crc : other->crc;

    return names_only(facts, begin->crc, other_crc) &&
           ((facts->entries - facts->changes) == ticks_of_segment(recorder, segment));
}

/*
 * Whether the configurations from this segment to the end are known: none was overwritten, and they
 * are two at most. `facts` has those of these segments.
 */
RARE static bool is_configured(const recorder_t *recorder,
                               const segment_facts_t facts[RECORDER_SEGMENTS], uint32_t segment)
{
    const drive_cfg_t *const begin = recorder->states[segment].cfg;
    const uint32_t more = ((recorder->current + RECORDER_SEGMENTS) - segment) % RECORDER_SEGMENTS;
    bool known = begin->crc == recorder->segments[segment].config_crc;

    for (uint32_t k = 0U; k <= more; k++) {
        const uint32_t next = (segment + k) % RECORDER_SEGMENTS;

        known = known && has_only_two(recorder, &facts[next], next, begin);
    }
    return known;
}

/*
 * Returns the number of segments of the history, up to the current one: there is no gap between
 * them, and their configurations are known. Fills in the facts of these segments.
 */
RARE static uint32_t count_segments(const recorder_t *recorder,
                                    segment_facts_t facts[RECORDER_SEGMENTS])
{
    uint32_t segment = in_ring(recorder->current);
    uint32_t count = 0U;
    bool more = true;

    while (more && (count < RECORDER_SEGMENTS)) {
        facts[segment] = facts_of(recorder, segment);
        more = is_configured(recorder, facts, segment);
        count += more ? 1U : 0U;
        more = more && recorder->segments[segment].follows;
        segment = segment_before(segment);
    }
    return count;
}

/* Adds the next segment to the history. */
RARE static void add_segment(const recorder_t *recorder, recorder_history_t *history, uint32_t at,
                             const segment_facts_t *facts)
{
    const uint32_t begin_crc = recorder_begin_state(recorder, history)->cfg->crc;

    history->of_segment[at] = facts->entries;
    history->entries += facts->entries;
    history->changes = history->changes || !names_only(facts, begin_crc, begin_crc);
}

recorder_history_t recorder_history(const recorder_t *recorder)
{
    recorder_history_t history = {.first = END, .entries = 0U};

    if (recorder->frozen && is_ring_sound(recorder)) {
        segment_facts_t facts[RECORDER_SEGMENTS];
        uint32_t count;

        barrier_compiler(); /* read the recording only after `frozen` */
        count = count_segments(recorder, facts);
        if (count > 0U) {
            history.first =
                ((recorder->current + RECORDER_SEGMENTS + 1U) - count) % RECORDER_SEGMENTS;
        }
        for (uint32_t k = 0U; k < count; k++) {
            add_segment(recorder, &history, k, &facts[(history.first + k) % RECORDER_SEGMENTS]);
        }
    }
    return history;
}

const recorder_entry_t *recorder_entry(const recorder_t *recorder,
                                       const recorder_history_t *history, uint32_t at)
{
    uint32_t segment = 0U;
    uint32_t left = at;

    while (left >= history->of_segment[segment]) {
        left -= history->of_segment[segment];
        segment++;
    }
    return &first_of(recorder, (history->first + segment) % RECORDER_SEGMENTS)[left];
}

const drive_t *recorder_begin_state(const recorder_t *recorder, const recorder_history_t *history)
{
    return &recorder->states[history->first];
}

const drive_t *recorder_end_state(const recorder_t *recorder)
{
    return &recorder->states[SPARE];
}

/*
 * Fills the view with what has been written of a segment. `at` is read before `current`: if a tick
 * begins another segment between the two reads, this segment is complete and has an end.
 */
static void fill_view(const recorder_t *recorder, uint32_t segment, recorder_view_t *view)
{
    const recorder_segment_t *const about = &recorder->segments[segment];
    const recorder_entry_t *end = recorder->at;

    barrier_compiler();
    view->complete = (recorder->current != segment) || recorder->frozen;
    barrier_compiler();
    if (view->complete) {
        end = about->end;
    }
    view->first = first_of(recorder, segment);
    view->entries = count_entries(recorder, segment, end);
    view->follows = about->follows;
    view->config_crc = about->config_crc;
    view->state = &recorder->states[segment];
}

const drive_cfg_t *recorder_further_config(const recorder_t *recorder,
                                           const recorder_history_t *history)
{
    const drive_cfg_t *const begin = recorder_begin_state(recorder, history)->cfg;

    return history->changes ? other_config(recorder, begin) : NULL;
}

bool recorder_find(const recorder_t *recorder, uint32_t number, recorder_view_t *view)
{
    const uint32_t newest = recorder_newest(recorder);
    const bool may_be =
        (number != 0U) && ((newest - number) < RECORDER_SEGMENTS) && is_ring_sound(recorder);
    bool found = false;

    for (uint32_t k = 0U; may_be && (k < RECORDER_SEGMENTS); k++) {
        if (recorder->segments[k].number == number) {
            fill_view(recorder, k, view);
            found = true;
        }
    }
    return found;
}

const drive_t *recorder_keep_state(recorder_t *recorder, uint32_t number)
{
    const bool is_kept = (number != 0U) && (number == recorder->kept);
    const drive_t *state = is_kept ? &recorder->states[SPARE] : NULL;
    recorder_view_t view = {0};

    if (!is_kept && recorder_find(recorder, number, &view)) {
        state = view.state;
        if (!recorder->triggered) {
            recorder->states[SPARE] = *state;
            recorder->kept = number;
        }
    }
    return state;
}

bool recorder_unpack(const recorder_entry_t *entry, recorder_frame_t *frame)
{
    const uint32_t *const word = entry->word;
    const bool is_frame = !recorder_entry_is_change(entry);
    drive_in_t *const in = &frame->in;
    drive_out_t *const out = &frame->out;

    if (is_frame) {
        in->adc_ia = (uint16_t)(word[0] & HALF_MASK);
        in->adc_ib = (uint16_t)(word[0] >> 16U);
        in->adc_bus = (uint16_t)(word[1] & HALF_MASK);
        in->flags = (uint16_t)(word[1] >> 16U);
        out->compare.phase[0] = (uint16_t)(word[2] & HALF_MASK);
        out->compare.phase[1] = (uint16_t)(word[2] >> 16U);
        out->compare.phase[2] = (uint16_t)(word[3] & COMPARE_MASK);
        out->gate_enable = ((word[3] >> GATE_BIT) & 1U) != 0U;
        in->angle = (uint16_t)(word[3] >> 16U);
    } else {
        in->command.target = (int32_t)word[0];
        in->command.mode = (uint8_t)(word[1] & BYTE_MASK);
        in->command.request = (uint8_t)((word[1] >> 8U) & BYTE_MASK);
        in->adc_temperature = (uint16_t)(word[1] >> 16U);
    }
    return is_frame;
}
