/* SPDX-License-Identifier: MIT */
/*
 * The control interrupt: sample, step, apply in this order, on a binding that only keeps a diary.
 */
#include "app.h"
#include "example_cfg.h"
#include "testing.h"

#include <string.h>

#define DIARY (16U)

struct hal {
    char diary[DIARY]; /* s: sampled, r: sensor read, a: applied, o: gates opened */
    uint32_t entries;
    drive_in_t next;
    drive_out_t applied;
    hal_shaft_t shaft;
    uint32_t tick_at_apply;
    const drive_t *drive;
};

static hal_t hal;
static app_t app;
static drive_cfg_t cfg;

static void note(hal_t *h, char what)
{
    if (h->entries < (DIARY - 1U)) {
        h->diary[h->entries] = what;
        h->entries++;
    }
}

void hal_sample(hal_t *h, drive_in_t *in)
{
    note(h, 's');
    in->adc_ia = h->next.adc_ia;
    in->adc_ib = h->next.adc_ib;
    in->adc_bus = h->next.adc_bus;
    in->flags = h->next.flags;
}

void hal_apply(hal_t *h, const drive_out_t *out)
{
    note(h, 'a');
    h->applied = *out;
    h->tick_at_apply = h->drive->tick;
}

void hal_open_gates(hal_t *h)
{
    note(h, 'o');
}

hal_shaft_t hal_shaft(hal_t *h)
{
    note(h, 'r');
    return h->shaft;
}

static void post(int32_t target, drive_mode_t mode, uint8_t request)
{
    const drive_command_t command = {.target = target, .mode = (uint8_t)mode, .request = request};

    command_mailbox_post(&app.mailbox, &command);
}

void setUp(void)
{
    cfg = example_drive_cfg();
    memset(&hal, 0, sizeof hal);
    memset(&app, 0x5A, sizeof app);
    hal.drive = &app.drive;
    hal.next = (drive_in_t){.adc_ia = 2048U, .adc_ib = 2048U, .adc_bus = 2822U};
    TEST_ASSERT_NULL(app_init(&app, &hal, &cfg));
}

static void interrupts(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        control_isr(&app);
    }
}

TEST(test_init_opens_the_gates_touches_nothing_else_of_the_hardware_and_leaves_empty_frames)
{
    const drive_in_t no_input = {0};
    const drive_out_t no_output = {0};

    TEST_ASSERT_EQUAL_STRING("o", hal.diary);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_INIT, app.drive.state);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
    TEST_ASSERT_EQUAL_MEMORY(&no_input, &app.in, sizeof app.in);
    TEST_ASSERT_EQUAL_MEMORY(&no_output, &app.out, sizeof app.out);
}

TEST(test_init_opens_the_gates_even_when_the_configuration_is_refused)
{
    memset(hal.diary, 0, sizeof hal.diary);
    hal.entries = 0U;
    cfg.slow_ticks = 0U;
    TEST_ASSERT_EQUAL_STRING("slow_ticks", app_init(&app, &hal, &cfg));
    TEST_ASSERT_EQUAL_STRING("o", hal.diary);
}

TEST(test_init_forgets_the_fault_that_was_seen_and_what_was_unlocked)
{
    TEST_ASSERT_FALSE(app.failed);
    TEST_ASSERT_FALSE(app.unlocked);
}

TEST(test_interrupt_samples_then_steps_then_applies_once_each)
{
    control_isr(&app);
    TEST_ASSERT_EQUAL_STRING("osa", hal.diary);
    TEST_ASSERT_EQUAL_UINT32(1U, hal.tick_at_apply);
    control_isr(&app);
    TEST_ASSERT_EQUAL_STRING("osasa", hal.diary);
    TEST_ASSERT_EQUAL_UINT32(2U, hal.tick_at_apply);
}

TEST(test_step_gets_the_sampled_frame)
{
    hal.next.adc_ia = 2111U;
    hal.next.flags = 0x8000U;
    control_isr(&app);
    TEST_ASSERT_EQUAL_UINT16(2111U, app.in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(0x8000U, app.in.flags);
}

TEST(test_command_of_the_background_is_taken_in_one_tick_of_each_slow_period)
{
    for (int32_t k = 0; k < 40; k++) {
        const drive_command_t before = app.in.command;
        const bool takes = drive_reads_slow_inputs(&app.drive);

        TEST_ASSERT_EQUAL(takes, ((uint32_t)k % cfg.slow_ticks) ==
                                     (cfg.slow_ticks - (uint32_t)SLOT_CHECKS - 1U));
        post(k + 1, DRIVE_MODE_POSITION, DRIVE_REQUEST_RUN);
        control_isr(&app);
        TEST_ASSERT_EQUAL_INT32(takes ? (k + 1) : before.target, app.in.command.target);
    }
    TEST_ASSERT_EQUAL_UINT8((uint8_t)DRIVE_MODE_POSITION, app.in.command.mode);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, app.in.command.request);
}

/* A faster ramp, and no other difference. */
static drive_cfg_t with_ramp(step_t ramp)
{
    drive_cfg_t other = cfg;

    other.speed_loop.ramp = ramp;
    other.crc = config_guard_crc(&other);
    return other;
}

TEST(test_a_configuration_is_taken_with_the_command_and_not_in_another_tick)
{
    const drive_cfg_t other = with_ramp(cfg.speed_loop.ramp + 1);

    TEST_ASSERT_FALSE(app_changes(&app));
    app_change(&app, &other);
    for (uint32_t k = 0U; k < cfg.slow_ticks; k++) {
        const bool takes = drive_reads_slow_inputs(&app.drive);
        const bool before = app_changes(&app);

        control_isr(&app);
        TEST_ASSERT_EQUAL(before && !takes, app_changes(&app));
        TEST_ASSERT_EQUAL_PTR(app_changes(&app) ? &cfg : &other, app.drive.cfg);
    }
    TEST_ASSERT_FALSE(app_changes(&app));
}

TEST(test_of_two_configurations_the_later_one_counts)
{
    const drive_cfg_t first = with_ramp(cfg.speed_loop.ramp + 1);
    const drive_cfg_t second = with_ramp(cfg.speed_loop.ramp + 2);

    app_change(&app, &first);
    app_change(&app, &second);
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_PTR(&second, app.drive.cfg);
}

/*
 * 400 interrupts beside a drive alone, which takes the other configuration, if there is one, in
 * front of the first step that reads slow inputs from tick 350 on.
 */
static void assert_same_as_alone(const drive_cfg_t *other)
{
    drive_t alone;
    drive_out_t out = {0};

    TEST_ASSERT_NULL(drive_init(&alone, &cfg));
    post(10000000, DRIVE_MODE_SPEED, DRIVE_REQUEST_RUN);
    for (uint32_t k = 0U; k < 400U; k++) {
        if ((k == 350U) && (other != NULL)) {
            app_change(&app, other);
        }
        if (app_changes(&app) && drive_reads_slow_inputs(&alone)) {
            drive_change(&alone, other);
        }
        control_isr(&app);
        drive_step(&alone, &app.in, &out);
        TEST_ASSERT_EQUAL_MEMORY(&alone, &app.drive, sizeof alone);
        TEST_ASSERT_EQUAL_UINT16_ARRAY(out.compare.phase, hal.applied.compare.phase, 3U);
        TEST_ASSERT_EQUAL_INT(out.gate_enable, hal.applied.gate_enable);
    }
    TEST_ASSERT_TRUE(hal.applied.gate_enable);
}

TEST(test_interrupt_does_what_the_same_frames_do_to_a_drive_alone)
{
    assert_same_as_alone(NULL);
}

TEST(test_a_change_is_in_front_of_the_step_of_its_tick)
{
    const drive_cfg_t other = with_ramp(cfg.speed_loop.ramp + 1);

    assert_same_as_alone(&other);
    TEST_ASSERT_EQUAL_PTR(&other, app.drive.cfg);
}

#define CHANGE_MARK (0x8000U) /* bit 15 of the third word of an entry: recorder.h */
#define ENTRIES (4U * RECORDER_ENTRIES_MIN)

TEST(test_a_change_is_recorded_in_front_of_its_frame)
{
    static recorder_t recorder;
    static recorder_entry_t entries[ENTRIES];
    const drive_cfg_t other = with_ramp(cfg.speed_loop.ramp + 1);
    uint32_t found = 0U;

    TEST_ASSERT_NULL(recorder_init(&recorder, entries, ENTRIES / RECORDER_SEGMENTS, 0U));
    app_record(&app, &recorder);
    app_change(&app, &other);
    for (uint32_t k = 0U; k < (2U * cfg.slow_ticks); k++) {
        recorder_service(&recorder, &app.drive);
        control_isr(&app);
    }
    for (uint32_t k = 0U; k < (3U * cfg.slow_ticks); k++) {
        const bool is_change = (entries[k].word[2] & CHANGE_MARK) != 0U;

        found += (is_change && (entries[k].word[3] == other.crc)) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(1U, found);
}

TEST(test_fault_in_a_frame_reaches_the_gates_in_the_same_interrupt)
{
    post(0, DRIVE_MODE_SPEED, DRIVE_REQUEST_RUN);
    interrupts(300U);
    TEST_ASSERT_TRUE(hal.applied.gate_enable);
    hal.next.flags = DRIVE_FLAG_BREAK;
    control_isr(&app);
    TEST_ASSERT_FALSE(hal.applied.gate_enable);
}

/*
 * The background tells of a fault by a request and a flag. A bit that flips by itself is only one
 * of them.
 */
TEST(test_a_failure_without_its_request_is_not_told)
{
    post(7, DRIVE_MODE_SPEED, 0U);
    app.failure = (drive_command_t){.mode = DRIVE_MODE_FAULT + FAULT_CURRENT_SUM,
                                    .request = DRIVE_REQUEST_RUN};
    app.fails = true;
    interrupts(300U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_EQUAL_INT32(7, app.in.command.target);
    app.failure.request = DRIVE_REQUEST_FAIL;
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, app.drive.state);
}

/* The request alone, as a bit that flips after the start leaves it. */
TEST(test_a_request_alone_tells_no_failure)
{
    interrupts(300U);
    app.failure = (drive_command_t){.mode = DRIVE_MODE_FAULT + FAULT_CURRENT_SUM,
                                    .request = DRIVE_REQUEST_FAIL};
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
}

/* With its numbers, and also where passes of the background come before the tick that takes it. */
TEST(test_a_failure_is_told_until_the_drive_is_in_fault_and_then_the_command_counts)
{
    const fault_t fault = {.id = FAULT_CURRENT_SUM, .value = 300, .limit = 228};

    post(7, DRIVE_MODE_SPEED, 0U);
    interrupts(300U);
    app_fail(&app, &fault);
    app_forget_failure(&app);
    app_forget_failure(&app);
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, app.drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, app.drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(300, app.drive.fault.value);
    TEST_ASSERT_EQUAL_INT32(228, app.drive.fault.limit);
    app_forget_failure(&app);
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
    TEST_ASSERT_EQUAL_INT32(7, app.in.command.target);
}

/* The bit of the request that flips next would tell of a fault. */
TEST(test_a_flag_that_has_flipped_is_taken_back)
{
    interrupts(300U);
    app.fails = true;
    app_forget_failure(&app);
    app.failure = (drive_command_t){.mode = DRIVE_MODE_FAULT + FAULT_CURRENT_SUM,
                                    .request = DRIVE_REQUEST_FAIL};
    interrupts(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
}

TEST(test_interrupt_records_each_tick_after_it_was_applied)
{
    static recorder_t recorder;
    static recorder_entry_t entries[RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN];
    recorder_frame_t frame = {0};

    TEST_ASSERT_NULL(recorder_init(&recorder, entries, RECORDER_ENTRIES_MIN, 0U));
    app_record(&app, &recorder);
    recorder_service(&recorder, &app.drive);
    hal.next.adc_ia = 2111U;
    control_isr(&app);
    TEST_ASSERT_EQUAL_STRING("osa", hal.diary);
    TEST_ASSERT_FALSE(recorder_unpack(&entries[0], &frame));
    TEST_ASSERT_TRUE(recorder_unpack(&entries[1], &frame));
    TEST_ASSERT_EQUAL_UINT16(2111U, frame.in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(hal.applied.compare.phase, frame.out.compare.phase, 3U);
}

TEST(test_init_leaves_no_recorder_behind)
{
    static recorder_t recorder;

    app_record(&app, &recorder);
    TEST_ASSERT_NULL(app_init(&app, &hal, &cfg));
    control_isr(&app);
    TEST_ASSERT_NULL(recorder.at);
}

static shaft_decoder_t shaft;

TEST(test_a_sensor_that_the_configuration_takes_away_is_not_read_any_more)
{
    cfg.sensor.kind = (uint32_t)SENSOR_KIND_ABSOLUTE;
    app_sense(&app, &shaft);
    interrupts(2U);
    TEST_ASSERT_EQUAL_STRING("osrasra", hal.diary);
    cfg.sensor.kind = (uint32_t)SENSOR_KIND_NONE;
    interrupts(2U);
    TEST_ASSERT_EQUAL_STRING("osrasrasasa", hal.diary);
}

TEST(test_a_trouble_that_is_none_has_a_text_all_the_same)
{
    TEST_ASSERT_EQUAL_STRING("none", shaft_trouble_text(SHAFT_TROUBLES));
    TEST_ASSERT_EQUAL_STRING("sensor_turned", shaft_trouble_text(SHAFT_TROUBLE_TURNED));
}
