/* SPDX-License-Identifier: MIT */
#include "box.h"

#include "commander.h"
#include "crc32.h"
#include "fault_text.h"
#include "flash_unit.h"
#include "fx.h"
#include "inlining.h"
#include "recording_about.h"
#include "status.h"

#include <stddef.h>

#define PLACE_SLOTS (HAL_BOX_SLOTS / BOX_PLACES)
#define PLACE_UNITS (PLACE_SLOTS * HAL_STORE_UNITS)
#define STAMP_UNITS (16U)
#define CONTENT_UNITS (PLACE_UNITS - STAMP_UNITS)
#define FILE_WORD (FAULT_LOG_WORDS)
#define FILE_WORDS_MAX ((CONTENT_UNITS * FLASH_UNIT_WORDS) - FILE_WORD)
#define LENGTH_WORD (2U) /* index of recorder_header_t.words */
#define STAMPS_TO_KEEP (2U)
#define KEPT_AHEAD (2U) /* by how much step 1 raises the number of the kept place */
#define FILLING (0xFFFFFFFFU)
#define SECOND_US (1000000U)

_Static_assert(HAL_BOX_SLOTS == (BOX_PLACES * PLACE_SLOTS), "places of whole slots");
_Static_assert(offsetof(recorder_header_t, words) == (LENGTH_WORD * sizeof(uint32_t)),
               "place of the length");

static uint32_t box_slot_of(uint32_t place, uint32_t unit)
{
    return HAL_STORE_SLOTS + (place * PLACE_SLOTS) + (unit / HAL_STORE_UNITS);
}

static flash_unit_stamps_t box_stamps_of(uint32_t place)
{
    return (flash_unit_stamps_t){.slot = box_slot_of(place, PLACE_UNITS - 1U),
                                 .first = HAL_STORE_UNITS - STAMP_UNITS,
                                 .end = HAL_STORE_UNITS};
}

/* Reads word `at` of a place. Sets *bad when the flash cannot read it. */
static uint32_t read_place_word(hal_t *hal, uint32_t place, uint32_t at, bool *bad)
{
    const uint32_t unit = at / FLASH_UNIT_WORDS;
    uint32_t words[FLASH_UNIT_WORDS];

    if (!flash_unit_read(hal, box_slot_of(place, unit), unit % HAL_STORE_UNITS, words)) {
        *bad = true;
    }
    return words[at % FLASH_UNIT_WORDS];
}

/* Returns the length of the recording in a place; 0: it has none. */
static uint32_t recording_in(hal_t *hal, uint32_t place, bool *bad)
{
    const uint32_t magic = read_place_word(hal, place, FILE_WORD, bad);
    const uint32_t words = read_place_word(hal, place, FILE_WORD + LENGTH_WORD, bad);

    return ((magic == RECORDER_MAGIC) && (words <= FILE_WORDS_MAX)) ? words : 0U;
}

/* The words that a stamp covers come in whole units. */
static uint32_t units_of_place(uint32_t file_words)
{
    return (FILE_WORD + file_words + (FLASH_UNIT_WORDS - 1U)) / FLASH_UNIT_WORDS;
}

/* Takes note of a place if it is whole and newer than what was found before. */
static void look_at_place(box_t *box, uint32_t place)
{
    const flash_unit_stamps_t stamps = box_stamps_of(place);
    bool bad = false;
    const uint32_t words = recording_in(box->hal, place, &bad);
    const uint32_t end = units_of_place(words) * FLASH_UNIT_WORDS;
    uint32_t crc = CRC32_START;
    uint32_t sequence = 0U;

    for (uint32_t at = 0U; (at < end) && (words > 0U) && !bad; at++) {
        crc = crc32_word(crc, read_place_word(box->hal, place, at, &bad));
    }
    if ((words > 0U) && !bad && flash_unit_find_stamp(box->hal, &stamps, crc, &sequence) &&
        (!box->found || (fx_signed(sequence - box->sequence) > 0))) {
        box->found = true;
        box->place = place;
        box->sequence = sequence;
        box->crc = crc;
        box->file_words = words;
    }
}

static void read_place_log(const box_t *box)
{
    bool bad = false;

    for (uint32_t at = 0U; at < FAULT_LOG_WORDS; at++) {
        fault_log_set_word(box->log, at, read_place_word(box->hal, box->place, at, &bad));
    }
}

void box_init(box_t *box, app_t *app, hal_t *hal, const about_t *about, fault_log_t *log,
              bool is_power_up)
{
    *box = (box_t){.hal = hal, .app = app, .about = about, .log = log, .works = true};
    app->box = box;
    for (uint32_t place = 0U; place < BOX_PLACES; place++) {
        look_at_place(box, place);
    }
    if (is_power_up || !fault_log_is_whole(log)) {
        if (box->found) {
            read_place_log(box);
        } else {
            fault_log_init(log);
        }
        fault_log_power_up(log);
    }
}

bool box_is_saving(const box_t *box)
{
    return box->phase != BOX_IDLE;
}

bool box_has_saved(const box_t *box)
{
    const recorder_t *const recorder = box->app->recorder;

    return (recorder != NULL) && recorder->frozen && (recorder_newest(recorder) == box->log->saved);
}

static uint32_t other_place(const box_t *box)
{
    return box->found ? (BOX_PLACES - 1U - box->place) : 0U;
}

static void give_up_saving(box_t *box, bool works)
{
    box->works = works;
    box->phase = BOX_IDLE;
}

static void note_that_saved(box_t *box)
{
    box->log->saved = recorder_newest(box->pack.dump.recorder);
    fault_log_seal(box->log);
}

/* Begins a writing when it is known what fits. A recording without entries has nothing to save. */
static void measure_recording(box_t *box)
{
    if (recorder_pack_measure(&box->pack)) {
        /* a piece more in the next pass */
    } else if (box->pack.dump.header.entries == 0U) {
        note_that_saved(box);
        give_up_saving(box, true);
    } else {
        box->log->saves++;
        fault_log_seal(box->log);
        box->phase = BOX_KEEPS;
    }
}

/* Step 1. The number goes up even if no unit takes a stamp. */
static void keep_place(box_t *box)
{
    if (box->found) {
        const flash_unit_stamps_t stamps = box_stamps_of(box->place);

        box->sequence += KEPT_AHEAD;
        (void)flash_unit_put_stamps(box->hal, &stamps, STAMPS_TO_KEEP, box->sequence, box->crc);
    }
    box->at = 0U;
    box->phase = BOX_ERASES;
}

static void erase_slot(box_t *box)
{
    const uint32_t slot = box_slot_of(other_place(box), box->at * HAL_STORE_UNITS);

    box->at++;
    if (!hal_store_erase(box->hal, slot)) {
        give_up_saving(box, false);
    } else if (box->at >= PLACE_SLOTS) {
        box->at = 0U;
        box->new_crc = CRC32_START;
        box->phase = BOX_WRITES;
    } else {
        /* the next slot in the next pass */
    }
}

/* Returns the next word to be written: of the log, then of the recording. */
static uint32_t next_place_word(box_t *box, uint32_t at)
{
    uint32_t word = FILLING;

    if (at < FILE_WORD) {
        word = fault_log_word(box->log, at);
    } else if (at < (FILE_WORD + box->pack.dump.header.words)) {
        word = recorder_pack_next(&box->pack);
    } else {
        /* the rest of the last unit */
    }
    return word;
}

static void write_unit(box_t *box)
{
    const uint32_t at = box->at * FLASH_UNIT_WORDS;
    const uint32_t first = next_place_word(box, at);
    const uint32_t second = next_place_word(box, at + 1U);

    box->new_crc = crc32_word(crc32_word(box->new_crc, first), second);
    if (!flash_unit_program(box->hal, box_slot_of(other_place(box), box->at),
                            box->at % HAL_STORE_UNITS, first, second)) {
        give_up_saving(box, false);
    } else {
        box->at++;
        box->phase =
            (box->at < units_of_place(box->pack.dump.header.words)) ? BOX_WRITES : BOX_STAMPS;
    }
}

static void stamp_place(box_t *box)
{
    const uint32_t place = other_place(box);
    const flash_unit_stamps_t stamps = box_stamps_of(place);
    const uint32_t sequence = box->sequence + 1U;
    const bool good = flash_unit_put_stamps(box->hal, &stamps, 1U, sequence, box->new_crc);

    if (good) {
        box->found = true;
        box->place = place;
        box->sequence = sequence;
        box->crc = box->new_crc;
        box->file_words = box->pack.dump.header.words;
        note_that_saved(box);
    }
    give_up_saving(box, good);
}

static void begin_saving(box_t *box, const recorder_t *recorder, const about_t *about, bool cut)
{
    recorder_about_t facts = recording_about(about, hal_reset(box->hal));

    facts.cut = cut ? 1U : 0U;
    recorder_pack_start(&box->pack, recorder, &facts, FILE_WORDS_MAX);
    box->phase = BOX_MEASURES;
}

static void go_on_saving(box_t *box)
{
    switch (box->phase) {
    case BOX_BEGINS:
        begin_saving(box, box->app->recorder, box->about, false);
        break;
    case BOX_MEASURES:
        measure_recording(box);
        break;
    case BOX_KEEPS:
        keep_place(box);
        break;
    case BOX_ERASES:
        erase_slot(box);
        break;
    case BOX_WRITES:
        write_unit(box);
        break;
    case BOX_STAMPS:
        stamp_place(box);
        break;
    default: /* BOX_IDLE */
        break;
    }
}

/* Whether the recorder keeps the recording of a fault that is not saved. */
static bool has_fault_to_save(const box_t *box)
{
    const recorder_t *const recorder = box->app->recorder;

    return (recorder != NULL) && recorder->frozen && recorder->held && box->works &&
           (recorder_end_state(recorder)->state == DRIVE_STATE_FAULT) &&
           (recorder_newest(recorder) != box->log->saved);
}

/*
 * Whether the flash may be written. If the chip has a fault, it is not: the recording stays in the
 * RAM, and the next start saves it.
 */
static bool may_write_flash(const box_t *box)
{
    const hal_health_t health = hal_health(box->hal);

    return commander_is_at_rest(box->app) && (health.why_barred == NULL) && !health.tick_lost;
}

static void save_fault(box_t *box)
{
    if (!has_fault_to_save(box) || !may_write_flash(box)) {
        box->phase = BOX_IDLE;
    } else if (box_is_saving(box)) {
        go_on_saving(box);
    } else if (box->log->saves < BOX_SAVES_MAX) {
        box->phase = BOX_BEGINS; /* in a pass of its own: it takes most of what a pass may take */
    } else {
        /* the recording stays in the RAM until it is read */
    }
}

/* The log is not changed while it is written. */
static void note_fault(box_t *box)
{
    const drive_t *const drive = &box->app->drive;
    const bool failed = drive->state == DRIVE_STATE_FAULT;
    const uint32_t second = units_ticks(&box->about->rotation, SECOND_US);
    const uint32_t now = hal_ticks(box->hal);

    box->ticks += now - box->tick;
    box->tick = now;
    if (box->ticks >= second) {
        box->ticks -= second;
        box->log->seconds++;
        fault_log_seal(box->log);
    }
    if (failed && !box->failed) {
        fault_log_fault(box->log, &drive->fault);
    }
    box->failed = failed;
}

static void release_recorder(box_t *box)
{
    const drive_state_t state = box->app->drive.state;
    const bool runs = (state > DRIVE_STATE_READY) && (state != DRIVE_STATE_FAULT);

    if (runs && box_has_saved(box) && (box->log->saved != 0U)) {
        recorder_release(box->app->recorder);
    }
}

void box_step(box_t *box, box_reader_t reader)
{
    if ((box->phase != BOX_WRITES) || (box->at >= units_of_place(0U))) {
        note_fault(box);
    }
    if (reader == BOX_UNREAD) {
        release_recorder(box);
    }
    if (reader != BOX_READS_SAVED) {
        save_fault(box);
    }
}

static const drive_cfg_t *whole_config_of(const config_block_t *block, const about_t *about)
{
    const bool good = config_block_check(block, &about->identity).fault == CONFIG_BLOCK_GOOD;

    return good ? &block->cfg : NULL;
}

/* Returns why the recording that was rescued is not saved; NULL: it is to be saved. */
static const char *why_not_saved(const box_t *box, const recorder_t *recorder,
                                 recorder_rescued_t rescued)
{
    const bool failed = !rescued.cut && (recorder_end_state(recorder)->state == DRIVE_STATE_FAULT);
    const char *why = NULL;

    if (!rescued.found) {
        why = "what lies in the RAM is no recording";
    } else if (!failed && !rescued.drove) {
        why = "the drive was at rest";
    } else if (!failed && !rescued.cut) {
        why = "it was being read";
    } else if (failed && (recorder_newest(recorder) == box->log->saved)) {
        why = "it was saved before";
    } else if (box->log->saves >= BOX_SAVES_MAX) {
        why = "enough was saved since the power-up";
    } else {
        /* it is to be saved */
    }
    return why;
}

/* Notes a reset that was not asked for. */
static void note_last_reset(box_t *box, recorder_rescued_t rescued)
{
    const hal_reset_t reset = hal_reset(box->hal);
    const bool in_run = rescued.cut && rescued.drove;

    if (in_run || (reset.reason == HAL_RESET_WATCHDOG) || (reset.exception != 0U)) {
        fault_log_reset(box->log, reset);
    }
}

static void save_at_once(box_t *box, const recorder_t *recorder, const live_config_t *live,
                         bool cut)
{
    const drive_cfg_t *const cfg = recorder_end_state(recorder)->cfg;
    about_t about = *box->about;

    stored_config_about((cfg == &live->other.cfg) ? &live->other : &live->stored.block, &about);
    begin_saving(box, recorder, &about, cut);
    while (box_is_saving(box)) {
        go_on_saving(box);
    }
    box->rescued = box->works && (box->log->saved != 0U);
    box->why_none = box->rescued ? NULL : "the flash does not keep what is written";
}

void box_rescue(box_t *box, recorder_t *recorder, recorder_place_t *place,
                const live_config_t *live)
{
    const hal_reset_reason_t reason = hal_reset(box->hal).reason;
    recorder_rescued_t rescued;

    place->configs[0] = whole_config_of(&live->stored.block, box->about);
    place->configs[1] = whole_config_of(&live->other, box->about);
    place->powered = (reason != HAL_RESET_SUPPLY) && (reason != HAL_RESET_UNKNOWN);
    rescued = recorder_rescue(recorder, place);
    note_last_reset(box, rescued);
    box->why_none = why_not_saved(box, recorder, rescued);
    if (box->why_none == NULL) {
        save_at_once(box, recorder, live, rescued.cut);
    }
    box->log->saved = 0U; /* another recording begins */
    fault_log_seal(box->log);
}

uint32_t box_word(const box_t *box, uint32_t at)
{
    bool bad = false;
    uint32_t word = 0U;

    if (at < box->file_words) {
        word = read_place_word(box->hal, box->place, FILE_WORD + at, &bad);
    }
    return bad ? 0U : word;
}

void box_tell_start(text_t *text, const box_t *box)
{
    text_add(text, "last reset: ");
    fault_log_tell_reset(text, hal_reset(box->hal));
    if (box->rescued) {
        text_add(text, "; the run before it is saved, `last` sends it");
    } else if (box->why_none != NULL) {
        text_add(text, "; no recording of the run before it: ");
        text_add(text, box->why_none);
    } else if (box->found) {
        text_add(text, "; an earlier recording is saved, `last` sends it");
    } else {
        text_add(text, "; no recording is saved");
    }
}

void box_tell_entry(text_t *text, const box_t *box, uint32_t age)
{
    const fault_log_entry_t *const entry = fault_log_entry(box->log, age);
    const uint32_t id = entry->what & FAULT_LOG_ID_MASK;
    const uint32_t number = box->log->count - age;
    const uint32_t power_up = entry->what >> FAULT_LOG_POWER_UP_SHIFT;

    text_number(text, (int32_t)number, 0U);
    text_add(text, ": power-up ");
    text_number(text, (int32_t)power_up, 0U);
    text_add(text, ", ");
    text_number(text, (int32_t)entry->seconds, 0U);
    text_add(text, " s: ");
    if (id >= FAULT_LOG_RESET) {
        const uint32_t reason = id - FAULT_LOG_RESET;
        const hal_reset_t reset = {.reason = (hal_reset_reason_t)reason,
                                   .exception = (entry->what >> FAULT_LOG_EXCEPTION_SHIFT) &
                                                FAULT_LOG_EXCEPTION_MASK};

        text_add(text, "reset: ");
        fault_log_tell_reset(text, reset);
    } else {
        status_add_fault(text, box->about, (fault_id_t)id, (int32_t)entry->value,
                         (int32_t)entry->limit);
    }
}
