/* SPDX-License-Identifier: MIT */
/*
 * The black box on a simulated flash: after a fault or a reset, and whatever step power fails in,
 * the next start finds the old recording or the new one, whole, and it repeats.
 */
#include "box.h"
#include "commander.h"
#include "config_guard.h"
#include "crc32.h"
#include "drive_words.h"
#include "example_app.h"
#include "flash_model.h"
#include "flash_unit.h"
#include "frame_code.h"
#include "recorder_pack.h"
#include "seeded.h"
#include "testing.h"

#include <string.h>

#define SEGMENT_ENTRIES (300U)
#define POST_TICKS (20U)
#define FILE_MAX (2048U)
#define CONFIG_WORDS ((uint32_t)(sizeof(drive_cfg_t) / 4U))
#define LEAST_TICKS (200U)
#define STRIDE (testing_runs(7U, 1U)) /* of the steps that are cut */
#define CHANCES (testing_runs(1U, 4U))
#define NOISE (6)
#define UNCHECKED_TICKS (10U) /* since the background has noted the last check word */
#define PLACE_SLOTS (HAL_BOX_SLOTS / BOX_PLACES)

static recorder_t recorder;
static recorder_entry_t entries[RECORDER_SEGMENTS * SEGMENT_ENTRIES];
static live_config_t live;
static fault_log_t faults;
static box_t box;
static about_t about;
static seeded_t chance;
static int32_t noise; /* counts */
static uint32_t file[FILE_MAX];

static void make_block(config_block_t *block)
{
    const config_about_t facts = {
        .pole_pairs = 2U, .speed_max_rpm = 2000, .is_example = 0U, .name = "a motor"};

    config_block_make(block, &about.identity, &facts, &cfg);
}

/* As an image starts, with whatever lies in flash and in the kept memory. */
static void start(bool is_power_up)
{
    box_init(&box, &app, &hardware, &about, &faults, is_power_up);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &live.stored.block.cfg));
    TEST_ASSERT_NULL(recorder_init(&recorder, entries, SEGMENT_ENTRIES, POST_TICKS));
    app_record(&app, &recorder);
    hardware.ticks = 0U;
}

void setUp(void)
{
    flash_new(1U);
    power_on();
    example_supervise_nothing(&cfg);
    cfg.crc = config_guard_crc(&cfg);
    about = ABOUT;
    about.identity = (config_identity_t){.schema = 1U, .board = 2U};
    make_block(&live.stored.block);
    make_block(&live.other);
    chance = (seeded_t){5U};
    noise = NOISE;
    hardware.reset = (hal_reset_t){.reason = HAL_RESET_SUPPLY};
    (void)memset(&faults, 0xA5, sizeof faults);
    start(true);
}

static uint16_t noisy(uint32_t count)
{
    const int32_t value = (int32_t)count + seeded_in(&chance, -noise, noise);

    return (uint16_t)((value < 0) ? 0 : ((value > 4095) ? 4095 : value));
}

static void pass(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        measured.adc_ia = noisy(EXAMPLE_MIDDLE);
        measured.adc_ib = noisy(EXAMPLE_MIDDLE);
        measured.adc_bus = noisy(EXAMPLE_BUS_COUNT);
        control_isr(&app);
        recorder_service(&recorder, &app.drive);
        commander_step(&app);
        box_step(&box, BOX_UNREAD);
    }
}

static void run_for(uint32_t ticks)
{
    pass(EXAMPLE_CALIBRATION_TICKS + 20U);
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    pass(ticks);
    TEST_ASSERT_GREATER_THAN(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
}

static void fail_in_a_pass(void)
{
    measured.flags = DRIVE_FLAG_BREAK;
    pass(1U);
    measured.flags = 0U;
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
}

static void fail_and_freeze(void)
{
    fail_in_a_pass();
    while (!recorder.frozen) {
        pass(1U);
    }
}

/* To where the recording of the fault is frozen. */
static void fail_after(uint32_t ticks)
{
    run_for(ticks);
    fail_and_freeze();
}

static void save(void)
{
    const uint32_t most = 3000U; /* passes: more than a place has units */

    for (uint32_t k = 0U; (k < most) && (!box_has_saved(&box) || box_is_saving(&box)); k++) {
        pass(1U);
    }
    TEST_ASSERT_TRUE(box_has_saved(&box));
}

static uint32_t crc_of(const uint32_t *words, uint32_t count)
{
    uint32_t crc = CRC32_START;

    for (uint32_t k = 0U; k < count; k++) {
        crc = crc32_word(crc, words[k]);
    }
    return ~crc;
}

static const recorder_header_t *header(void)
{
    return (const recorder_header_t *)(const void *)file;
}

/* Steps the drive over the entries of a piece, and compares the CRC of the outputs. */
static uint32_t assert_piece(drive_t *drive, recorder_frame_t *frame, const uint32_t *words)
{
    const uint32_t count = words[0] & 0xFFU;
    const uint32_t length = words[0] >> 8U;
    recorder_entry_t decoded[FRAME_CODE_ENTRIES_MAX];
    uint32_t crc = CRC32_START;

    TEST_ASSERT_TRUE(frame_code_decode((const uint8_t *)&words[2], length, decoded, count));
    for (uint32_t k = 0U; k < count; k++) {
        drive_out_t out = {0};

        if (recorder_unpack(&decoded[k], frame)) {
            drive_step(drive, &frame->in, &out);
            crc = crc32_word(crc, out.compare.phase[0] | ((uint32_t)out.compare.phase[1] << 16U));
            crc = crc32_word(crc, out.compare.phase[2] | (out.gate_enable ? 0x8000U : 0U));
        }
    }
    TEST_ASSERT_EQUAL_HEX32(words[1], ~crc);
    return 2U + ((length + 3U) / 4U);
}

/* The saved recording is whole, and the drive repeats it from its begin to its end. */
static void assert_file_repeats(void)
{
    const uint32_t state = RECORDER_HEADER_WORDS + CONFIG_WORDS;
    const uint32_t first = state + drive_words_count();
    static drive_cfg_t recorded;
    recorder_frame_t frame = {0};
    drive_t drive = {0};

    TEST_ASSERT_LESS_THAN_UINT32(FILE_MAX, box.file_words);
    for (uint32_t at = 0U; at < box.file_words; at++) {
        file[at] = box_word(&box, at);
    }
    TEST_ASSERT_EQUAL_HEX32(RECORDER_MAGIC, header()->magic);
    TEST_ASSERT_EQUAL_UINT32(RECORDER_VERSION, header()->version);
    TEST_ASSERT_EQUAL_UINT32(box.file_words, header()->words);
    TEST_ASSERT_EQUAL_HEX32(file[box.file_words - 1U], crc_of(file, box.file_words - 1U));
    (void)memcpy(&recorded, &file[RECORDER_HEADER_WORDS], sizeof recorded);
    TEST_ASSERT_EQUAL_HEX32(recorded.crc, config_guard_crc(&recorded));
    for (uint32_t at = 0U; at < drive_words_count(); at++) {
        drive_words_set(&drive, at, file[state + at]);
    }
    drive.cfg = &recorded;
    TEST_ASSERT_EQUAL_UINT32(header()->first_tick, drive.tick);
    for (uint32_t at = 0U; at < header()->packed;) {
        at += assert_piece(&drive, &frame, &file[first + at]);
    }
    TEST_ASSERT_EQUAL_UINT32(header()->end_tick, drive.tick);
    if (header()->about.cut == 0U) {
        TEST_ASSERT_EQUAL_HEX32(header()->end_hash, drive_words_hash(&drive));
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(LEAST_TICKS, header()->end_tick - header()->first_tick);
}

TEST(test_an_empty_flash_has_no_recording_and_an_empty_log)
{
    TEST_ASSERT_FALSE(box.found);
    TEST_ASSERT_EQUAL_UINT32(0U, box.file_words);
    TEST_ASSERT_EQUAL_UINT32(0U, fault_log_size(&faults));
    TEST_ASSERT_EQUAL_UINT32(0U, box_word(&box, 0U));
}

TEST(test_a_fault_is_saved_and_there_after_a_loss_of_power)
{
    uint32_t tick;

    fail_after(2000U);
    tick = app.drive.fault.tick;
    save();
    (void)memset(&faults, 0x5A, sizeof faults);
    start(true);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(FAULT_BREAK, header()->fault_id);
    TEST_ASSERT_EQUAL_UINT32(tick, header()->fault_tick);
    TEST_ASSERT_EQUAL_UINT32(HAL_RESET_SUPPLY, header()->about.reset);
    TEST_ASSERT_EQUAL_UINT32(0U, header()->about.cut);
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
    TEST_ASSERT_EQUAL_UINT32(2U, faults.power_up);
    TEST_ASSERT_EQUAL_UINT32((1U << 16U) | FAULT_BREAK, fault_log_entry(&faults, 0U)->what);
}

/* The ring has some 1100 ticks, of which all but the oldest segment fit. */
TEST(test_most_of_the_ring_fits)
{
    recorder_history_t history;

    fail_after(4000U);
    history = recorder_history(&recorder);
    save();
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(history.entries, header()->entries);
}

/* Of 600 counts peak to peak, 170 rms: more is an over-current. */
TEST(test_with_much_noise_there_are_200_ticks)
{
    noise = 300;
    fail_after(2000U);
    save();
    assert_file_repeats();
}

TEST(test_the_second_fault_takes_the_other_place_and_is_the_newest)
{
    uint32_t place;

    fail_after(1500U);
    save();
    place = box.place;
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(50U);
    fail_after(1700U);
    save();
    TEST_ASSERT_NOT_EQUAL(place, box.place);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(app.drive.fault.tick, header()->fault_tick);
    start(true);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(2U, fault_log_size(&faults));
}

TEST(test_nothing_is_written_while_the_drive_is_not_at_rest)
{
    fail_after(1500U);
    pass(100U);
    TEST_ASSERT_TRUE(box_is_saving(&box));
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(2U * cfg.slow_ticks);
    TEST_ASSERT_FALSE(box_is_saving(&box));
    run_for(2U * cfg.slow_ticks); /* it began again while the drive was READY */
    const uint32_t steps = flash.steps;
    pass(300U);
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
    TEST_ASSERT_TRUE(recorder.held); /* it is not saved */
    commander_stop(&app, SOURCE_LINK);
    save();
    assert_file_repeats();
}

TEST(test_a_chip_with_a_fault_writes_nothing)
{
    hardware.health.why_barred = "a register";
    fail_after(1500U);
    pass(1000U);
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
    hardware.health.why_barred = NULL;
    hardware.health.tick_lost = true;
    pass(1000U);
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
}

TEST(test_a_reader_keeps_the_recording_that_is_saved)
{
    fail_after(1500U);
    save();
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    for (uint32_t k = 0U; k < 400U; k++) {
        control_isr(&app);
        recorder_service(&recorder, &app.drive);
        commander_step(&app);
        box_step(&box, BOX_READS_RECORDER);
    }
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    for (uint32_t k = 0U; k < 100U; k++) {
        control_isr(&app);
        recorder_service(&recorder, &app.drive);
        box_step(&box, BOX_READS_RECORDER);
    }
    TEST_ASSERT_TRUE(recorder.frozen);
    pass(3U);
    TEST_ASSERT_FALSE(recorder.held);
}

/* The log counts it, and the saved recording that is being sent stays. */
TEST(test_a_fault_that_comes_and_goes_while_the_saved_recording_is_sent_is_noted)
{
    fail_after(1500U);
    save();
    const uint32_t steps = flash.steps;

    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    for (uint32_t k = 0U; k < 800U; k++) {
        measured.flags = (k == 500U) ? DRIVE_FLAG_BREAK : 0U;
        if (k == 600U) {
            TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
        }
        control_isr(&app);
        recorder_service(&recorder, &app.drive);
        commander_step(&app);
        box_step(&box, BOX_READS_SAVED);
    }
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
    TEST_ASSERT_EQUAL_UINT32(2U, fault_log_size(&faults));
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
}

TEST(test_the_flash_is_spared_after_eight_savings)
{
    for (uint32_t k = 0U; k < BOX_SAVES_MAX; k++) {
        fail_after(400U);
        save();
        TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
        pass(50U);
    }
    const uint32_t steps = flash.steps;
    fail_after(400U);
    pass(2000U);
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
    TEST_ASSERT_TRUE(recorder.held);
    TEST_ASSERT_EQUAL_UINT32(BOX_SAVES_MAX + 1U, fault_log_size(&faults));
}

TEST(test_a_flash_that_does_not_work_leaves_the_recording_in_the_ram)
{
    fail_after(1500U);
    flash.refuses_program = true;
    pass(2000U);
    TEST_ASSERT_FALSE(box_has_saved(&box));
    TEST_ASSERT_TRUE(recorder.held);
    start(true);
    flash.refuses_program = false;
    TEST_ASSERT_FALSE(box.found);
    fail_after(1500U);
    flash.refuses_erase = true;
    pass(2000U);
    TEST_ASSERT_FALSE(box_has_saved(&box));
}

TEST(test_a_stamp_that_the_flash_does_not_keep_leaves_the_recording_in_the_ram)
{
    uint32_t steps;

    fail_after(1500U);
    while (box.phase != BOX_STAMPS) {
        pass(1U);
    }
    flash.refuses_program = true;
    pass(1U);
    steps = flash.steps;
    pass(100U);
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
    TEST_ASSERT_FALSE(box_is_saving(&box));
    TEST_ASSERT_FALSE(box_has_saved(&box));
    TEST_ASSERT_TRUE(recorder.held);
    start(true);
    TEST_ASSERT_FALSE(box.found);
}

TEST(test_without_a_recorder_a_fault_is_noted_and_nothing_is_saved)
{
    app_record(&app, NULL);
    run_for(400U);
    fail_in_a_pass();
    pass(1000U);
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
    TEST_ASSERT_FALSE(box_has_saved(&box));
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
}

/* ---- a word that has flipped by itself ---- */

/* The write pointer has moved, so an old frame stays between the new ones. */
TEST(test_a_recording_that_is_spoilt_is_not_written_and_the_next_fault_is_saved)
{
    run_for(900U);
    recorder.at = &recorder.at[1];
    fail_and_freeze();
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&recorder).entries);
    save();
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
    TEST_ASSERT_EQUAL_UINT32(0U, faults.saves);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(50U);
    fail_after(1000U);
    save();
    assert_file_repeats();
}

TEST(test_a_phase_that_is_none_writes_nothing_and_the_saving_begins_anew_at_the_next_rest)
{
    const box_phase_t none = (box_phase_t)(BOX_STAMPS + 1);
    uint32_t steps;

    fail_after(1500U);
    pass(100U);
    TEST_ASSERT_TRUE(box_is_saving(&box));
    box.phase = none;
    steps = flash.steps;
    pass(100U);
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(2U * cfg.slow_ticks);
    TEST_ASSERT_FALSE(box_is_saving(&box));
    save();
    assert_file_repeats();
}

/* The number 0, of no segment, is also that of a log without a saved recording. */
TEST(test_a_recording_that_is_not_saved_is_not_released_when_its_last_segment_is_lost)
{
    flash.refuses_erase = true;
    fail_after(1500U);
    pass(100U);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(50U);
    recorder.current = RECORDER_SEGMENTS;
    run_for(50U);
    TEST_ASSERT_TRUE(recorder.held);
    TEST_ASSERT_TRUE(recorder.frozen);
}

TEST(test_a_word_that_the_flash_cannot_read_is_zero)
{
    hal_host_flash_unit_t *unit;
    uint32_t behind;

    fail_after(1500U);
    save();
    TEST_ASSERT_EQUAL_HEX32(RECORDER_MAGIC, box_word(&box, 0U));
    behind = box_word(&box, FLASH_UNIT_WORDS);
    unit = &flash.units[HAL_STORE_SLOTS + (box.place * PLACE_SLOTS)]
                       [FAULT_LOG_WORDS / FLASH_UNIT_WORDS];
    unit->half_done = true;
    unit->half = HAL_HOST_FLASH_UNREADABLE;
    TEST_ASSERT_EQUAL_HEX32(0U, box_word(&box, 0U));
    TEST_ASSERT_EQUAL_HEX32(behind, box_word(&box, FLASH_UNIT_WORDS));
}

/* ---- resets ---- */

static void reset_by(hal_reset_t cause)
{
    recorder_place_t place = {.entries = entries, .segment_entries = SEGMENT_ENTRIES};

    hardware.reset = cause;
    box_init(&box, &app, &hardware, &about, &faults, false);
    box_rescue(&box, &recorder, &place, &live);
}

static void reset(hal_reset_reason_t reason)
{
    reset_by((hal_reset_t){.reason = reason});
}

TEST(test_a_reset_in_a_run_is_saved_with_its_reason)
{
    uint32_t tick;

    run_for(1234U);
    tick = app.drive.tick;
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_TRUE(box.rescued);
    TEST_ASSERT_NULL(box.why_none);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(tick, header()->end_tick);
    TEST_ASSERT_EQUAL_HEX32(0U, header()->end_hash);
    TEST_ASSERT_EQUAL_UINT32(HAL_RESET_WATCHDOG, header()->about.reset);
    TEST_ASSERT_EQUAL_UINT32(1U, header()->about.cut);
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
    start(true);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32((1U << 16U) | FAULT_LOG_RESET | HAL_RESET_WATCHDOG,
                             fault_log_entry(&faults, 0U)->what);
}

TEST(test_a_reset_at_rest_is_not_saved)
{
    pass(EXAMPLE_CALIBRATION_TICKS + 200U);
    reset(HAL_RESET_PIN);
    TEST_ASSERT_EQUAL_STRING("the drive was at rest", box.why_none);
    TEST_ASSERT_FALSE(box.found);
    TEST_ASSERT_EQUAL_UINT32(0U, fault_log_size(&faults));
}

TEST(test_a_watchdog_at_rest_is_noted_without_a_recording)
{
    pass(EXAMPLE_CALIBRATION_TICKS + 200U);
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_EQUAL_STRING("the drive was at rest", box.why_none);
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
    TEST_ASSERT_EQUAL_HEX32((1U << FAULT_LOG_POWER_UP_SHIFT) | FAULT_LOG_RESET | HAL_RESET_WATCHDOG,
                            fault_log_entry(&faults, 0U)->what);
}

TEST(test_an_exception_at_rest_is_noted_with_its_number)
{
    const uint32_t exception = 3U;

    pass(EXAMPLE_CALIBRATION_TICKS + 200U);
    reset_by((hal_reset_t){.reason = HAL_RESET_SOFTWARE, .exception = exception});
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
    TEST_ASSERT_EQUAL_HEX32((1U << FAULT_LOG_POWER_UP_SHIFT) |
                                (exception << FAULT_LOG_EXCEPTION_SHIFT) | FAULT_LOG_RESET |
                                HAL_RESET_SOFTWARE,
                            fault_log_entry(&faults, 0U)->what);
}

/* Returns how many ticks behind the last check word the saved recording has. */
static uint32_t unchecked_ticks_after(hal_reset_reason_t reason)
{
    uint32_t checked;

    setUp();
    run_for(900U);
    checked = app.drive.tick;
    tick(UNCHECKED_TICKS);
    reset(reason);
    TEST_ASSERT_TRUE(box.rescued);
    assert_file_repeats();
    return header()->end_tick - checked;
}

/* The last entry may be half written. */
TEST(test_ticks_without_a_check_word_count_only_if_the_supply_was_there_for_certain)
{
    TEST_ASSERT_EQUAL_UINT32(UNCHECKED_TICKS - 1U, unchecked_ticks_after(HAL_RESET_PIN));
    TEST_ASSERT_EQUAL_UINT32(0U, unchecked_ticks_after(HAL_RESET_SUPPLY));
    TEST_ASSERT_EQUAL_UINT32(0U, unchecked_ticks_after(HAL_RESET_UNKNOWN));
}

TEST(test_a_run_that_the_flash_does_not_keep_after_a_reset_is_not_said_to_be_saved)
{
    fail_after(1500U);
    save();
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(50U);
    run_for(900U);
    flash.refuses_program = true;
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_FALSE(box.rescued);
    TEST_ASSERT_EQUAL_STRING("the flash does not keep what is written", box.why_none);
    assert_file_repeats(); /* the earlier one */
    TEST_ASSERT_EQUAL_UINT32(FAULT_BREAK, header()->fault_id);
    TEST_ASSERT_EQUAL_UINT32(2U, fault_log_size(&faults));
}

/* 0 says that none is saved. */
TEST(test_a_run_whose_number_is_lost_is_not_said_to_be_saved)
{
    run_for(900U);
    recorder.segments[recorder.current].number = 0U;
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_FALSE(box.rescued);
    TEST_ASSERT_NOT_NULL(box.why_none);
}

TEST(test_a_fault_that_was_not_saved_is_saved_after_a_reset)
{
    fail_after(1500U);
    reset(HAL_RESET_PIN);
    TEST_ASSERT_TRUE(box.rescued);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(FAULT_BREAK, header()->fault_id);
    TEST_ASSERT_EQUAL_UINT32(0U, header()->about.cut);
}

TEST(test_a_fault_that_was_saved_is_not_saved_again)
{
    fail_after(1500U);
    save();
    const uint32_t steps = flash.steps;
    reset(HAL_RESET_PIN);
    TEST_ASSERT_EQUAL_STRING("it was saved before", box.why_none);
    TEST_ASSERT_EQUAL_UINT32(steps, flash.steps);
    assert_file_repeats();
}

/* The background has not had a pass since the fault, so only the recording tells it. */
TEST(test_a_reset_right_after_a_fault_saves_the_run)
{
    run_for(900U);
    measured.flags = DRIVE_FLAG_BREAK;
    control_isr(&app);
    measured.flags = 0U;
    control_isr(&app);
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_TRUE(box.rescued);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(app.drive.fault.tick + 1U, header()->end_tick);
    TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&faults));
}

/* A fault in a start that never had its gates on. */
TEST(test_a_fault_at_rest_that_was_not_saved_is_saved_after_a_reset)
{
    pass(EXAMPLE_CALIBRATION_TICKS + 100U);
    fail_in_a_pass();
    pass(POST_TICKS + 3U);
    TEST_ASSERT_TRUE(recorder.frozen);
    reset(HAL_RESET_PIN);
    TEST_ASSERT_TRUE(box.rescued);
    assert_file_repeats();
    TEST_ASSERT_EQUAL_UINT32(FAULT_BREAK, header()->fault_id);
}

TEST(test_a_recording_that_was_being_read_is_not_saved)
{
    run_for(900U);
    recorder_hold(&recorder, &app.drive);
    pass(5U);
    TEST_ASSERT_TRUE(recorder.frozen);
    reset(HAL_RESET_PIN);
    TEST_ASSERT_EQUAL_STRING("it was being read", box.why_none);
}

TEST(test_a_memory_that_has_lost_its_bits_is_said_to_be_no_recording)
{
    run_for(900U);
    (void)memset(&recorder, 0x55, sizeof recorder);
    (void)memset(&faults, 0x55, sizeof faults);
    reset(HAL_RESET_SUPPLY);
    TEST_ASSERT_EQUAL_STRING("what lies in the RAM is no recording", box.why_none);
    TEST_ASSERT_FALSE(box.found);
}

TEST(test_a_block_that_is_not_whole_is_not_followed)
{
    run_for(900U);
    live.stored.block.about.pole_pairs ^= 4U;
    reset(HAL_RESET_PIN);
    TEST_ASSERT_EQUAL_STRING("what lies in the RAM is no recording", box.why_none);
}

TEST(test_resets_that_go_on_do_not_wear_the_flash)
{
    for (uint32_t k = 0U; k < (BOX_SAVES_MAX + 2U); k++) {
        run_for(400U);
        reset(HAL_RESET_WATCHDOG);
        TEST_ASSERT_EQUAL(k < BOX_SAVES_MAX, box.rescued);
        start(false);
    }
    TEST_ASSERT_EQUAL_UINT32(BOX_SAVES_MAX + 2U, fault_log_size(&faults));
}

/* ---- what is said ---- */

static text_t text;

static const char *said(void)
{
    TEST_ASSERT_LESS_THAN_UINT32(TEXT_MAX, text.length);
    text.characters[text.length] = '\0';
    return text.characters;
}

static const char *said_at_start(void)
{
    text.length = 0U;
    box_tell_start(&text, &box);
    return said();
}

static const char *said_of_entry(uint32_t age)
{
    text.length = 0U;
    box_tell_entry(&text, &box, age);
    return said();
}

TEST(test_a_start_says_its_reset_and_that_no_recording_is_saved)
{
    TEST_ASSERT_EQUAL_STRING("last reset: supply; no recording is saved", said_at_start());
}

TEST(test_a_start_says_that_an_earlier_recording_is_saved)
{
    fail_after(1500U);
    save();
    start(true);
    TEST_ASSERT_EQUAL_STRING("last reset: supply; an earlier recording is saved, `last` sends it",
                             said_at_start());
}

TEST(test_a_start_after_a_reset_in_a_run_says_that_the_run_is_saved)
{
    run_for(900U);
    reset(HAL_RESET_WATCHDOG);
    TEST_ASSERT_EQUAL_STRING("last reset: watchdog; the run before it is saved, `last` sends it",
                             said_at_start());
}

/* Also when an earlier recording is there: of the run before, there is none. */
TEST(test_a_start_after_a_reset_at_rest_says_why_there_is_no_recording_of_the_run)
{
    fail_after(1500U);
    save();
    start(false);
    pass(EXAMPLE_CALIBRATION_TICKS + 200U);
    reset(HAL_RESET_PIN);
    TEST_ASSERT_TRUE(box.found);
    TEST_ASSERT_EQUAL_STRING(
        "last reset: pin; no recording of the run before it: the drive was at rest",
        said_at_start());
}

TEST(test_entries_of_the_log_say_their_number_their_time_and_what_happened)
{
    /* of 32768 for 450 V */
    const fault_t fault = {.id = FAULT_OVERVOLTAGE, .value = 24576, .limit = 16384};

    faults.power_up = 65535U;
    faults.seconds = 7U;
    fault_log_fault(&faults, &fault);
    faults.seconds = 3600U;
    fault_log_reset(&faults, (hal_reset_t){.reason = HAL_RESET_PIN});
    fault_log_reset(&faults, (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 255U});
    TEST_ASSERT_EQUAL_STRING("1: power-up 65535, 7 s: OVERVOLTAGE 337.500 V, limit 225.000 V",
                             said_of_entry(2U));
    TEST_ASSERT_EQUAL_STRING("2: power-up 65535, 3600 s: reset: pin", said_of_entry(1U));
    TEST_ASSERT_EQUAL_STRING("3: power-up 65535, 3600 s: reset: watchdog after exception 255",
                             said_of_entry(0U));
}

/* ---- loss of power ---- */

typedef struct {
    recorder_t recorder;
    recorder_entry_t entries[RECORDER_SEGMENTS * SEGMENT_ENTRIES];
    app_t app;
    box_t box;
    fault_log_t faults;
    hal_host_flash_t flash;
    struct hal hardware;
} moment_t;

static moment_t moment;

static void remember(void)
{
    moment.recorder = recorder;
    (void)memcpy(moment.entries, entries, sizeof entries);
    moment.app = app;
    moment.box = box;
    moment.faults = faults;
    moment.flash = flash;
    moment.hardware = hardware;
}

static void go_back(void)
{
    recorder = moment.recorder;
    (void)memcpy(entries, moment.entries, sizeof entries);
    app = moment.app;
    box = moment.box;
    faults = moment.faults;
    flash = moment.flash;
    hardware = moment.hardware;
}

/* Saves, and loses power in this step. Whether the saving was over before. */
static bool save_cut(uint32_t step)
{
    volatile bool done = false;

    flash.left = step;
    if (setjmp(power_off) == 0) {
        save();
        done = true;
    }
    flash.left = HAL_HOST_FLASH_NEVER;
    return done;
}

/* What a start finds: the tick of the fault of its recording, which is whole; 0: it has none. */
static uint32_t fault_found(void)
{
    start(true);
    if (box.found) {
        assert_file_repeats();
        TEST_ASSERT_GREATER_THAN_UINT32(0U, fault_log_size(&faults));
    }
    return box.found ? header()->fault_tick : 0U;
}

/* In each step of a saving, from this moment on. */
static void assert_cuts(uint32_t before, uint32_t now)
{
    bool done = false;

    remember();
    for (uint32_t step = 0U; !done; step += STRIDE) {
        for (uint32_t way = 0U; way < CHANCES; way++) {
            uint32_t found;

            go_back();
            plant_random_init(&flash.chance, (step * CHANCES) + way);
            done = save_cut(step);
            found = fault_found();
            TEST_ASSERT_TRUE((found == now) || (!done && (found == before)));
        }
    }
}

TEST(test_power_that_fails_in_the_first_saving_leaves_no_recording_or_a_whole_one)
{
    fail_after(1200U);
    assert_cuts(0U, app.drive.fault.tick);
}

TEST(test_power_that_fails_in_a_saving_leaves_the_old_recording_or_the_new_one)
{
    uint32_t before;

    fail_after(1200U);
    before = app.drive.fault.tick;
    save();
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    pass(50U);
    fail_after(1300U);
    assert_cuts(before, app.drive.fault.tick);
}

/* Half-done units read otherwise each time, and the next savings are cut, too. */
TEST(test_savings_that_are_cut_again_and_again_leave_a_recording)
{
    const uint32_t runs = testing_runs(30U, 1000U);
    seeded_t steps = {3U};

    fail_after(1200U);
    save();
    remember();
    for (uint32_t run = 0U; run < runs; run++) {
        go_back();
        flash.unstable = true;
        plant_random_init(&flash.chance, run);
        for (uint32_t k = 0U; k < 4U; k++) {
            start(true);
            TEST_ASSERT_TRUE(box.found);
            fail_after(300U);
            (void)save_cut(seeded_u32(&steps) % 600U);
        }
        TEST_ASSERT_NOT_EQUAL(0U, fault_found());
    }
}
