/* SPDX-License-Identifier: MIT */
/* When an input starts the motor, what it commands then, and what stops it. */
#include "throttled_app.h"

#define NO_SLOPE (0x3FFFFFFF) /* the demand may become the whole in a tick */

static input_cfg_t settings;

static void throttle(uint32_t count)
{
    hardware.inputs.throttle = (uint16_t)count;
}

static void button(bool pressed)
{
    hardware.inputs.button = pressed;
}

static void power_up(void)
{
    begin_with(&settings);
    throttle(REST_COUNT);
}

void setUp(void)
{
    settings = example_input_cfg();
    power_up();
}

/* At rest for so long that it is armed. */
static void arm(void)
{
    throttle(REST_COUNT);
    passes(ARM + 300U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_ARMED, input.state);
}

static void run_at_half(void)
{
    arm();
    throttle(HALF_COUNT);
    passes(5000U);
    TEST_ASSERT_EQUAL(SOURCE_INPUT, commander_source(&app));
}

/* ---- arming ---- */

TEST(test_a_throttle_that_is_high_at_power_up_starts_nothing)
{
    throttle(HALF_COUNT);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    TEST_ASSERT_EQUAL_STRING("has to be seen at rest", input_text(&input));
}

TEST(test_a_throttle_that_was_seen_at_rest_for_the_time_starts_the_motor_and_not_before)
{
    passes(ARM);
    throttle(HALF_COUNT);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    throttle(REST_COUNT);
    passes(ARM + 300U); /* and some time constants of the low-pass */
    TEST_ASSERT_EQUAL_STRING("armed", input_text(&input));
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    throttle(HALF_COUNT);
    passes(100U);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_EQUAL_STRING("runs the motor", input_text(&input));
}

/* The older target must not act for a moment. */
TEST(test_a_start_begins_with_no_demand_whatever_was_asked_before)
{
    TEST_ASSERT_TRUE(commander_set_speed(&app, SOURCE_CONSOLE, EXAMPLE_SPEED_STEP));
    arm();
    throttle(HALF_COUNT);
    while (!runs()) {
        pass();
    }
    TEST_ASSERT_EQUAL_INT32(0, target());
}

/* The count of readings at rest begins with the arming, not with the power-up. */
TEST(test_a_throttle_that_moves_as_the_input_is_armed_needs_eight_readings_too)
{
    uint32_t armed_after = 0U;

    settings.filter_q15 = 32767; /* no low-pass: the median is all that delays */
    power_up();
    while (input.state != (uint8_t)INPUT_ARMED) {
        pass();
        armed_after++;
    }
    power_up();
    passes(armed_after - 1U);
    throttle(HALF_COUNT);
    pass(); /* the first reading, which the median leaves out */
    TEST_ASSERT_EQUAL_UINT8(INPUT_ARMED, input.state);
    passes(INPUT_SIGNAL_GOOD - 1U);
    TEST_ASSERT_FALSE(runs());
    pass();
    TEST_ASSERT_TRUE(runs());
}

TEST(test_each_of_these_disarms)
{
    for (uint32_t k = 0U; k < 7U; k++) {
        power_up();
        arm();
        if (k == 0U) {
            commander_stop(&app, SOURCE_CONSOLE);
        } else if (k == 1U) {
            TEST_ASSERT_TRUE(commander_set_speed(&app, SOURCE_LINK, 1));
        } else if (k == 2U) {
            app.drive.state = DRIVE_STATE_FAULT;
            pass();
            app.drive.state = DRIVE_STATE_READY;
        } else if (k == 3U) {
            commander_upset(&app); /* another configuration */
        } else if (k == 4U) {
            throttle(0U);
            passes(TIMEOUT + 2U);
        } else if (k == 5U) {
            TEST_ASSERT_NULL(commander_run(&app, SOURCE_CONSOLE));
            pass();
            commander_stop(&app, SOURCE_CONSOLE);
        } else {
            live.other.cfg.input.kind = (uint32_t)INPUT_KIND_RC_PULSE;
            pass();
            live.other.cfg.input.kind = (uint32_t)INPUT_KIND_VOLTAGE;
        }
        throttle(HALF_COUNT);
        passes(10U * ARM);
        TEST_ASSERT_FALSE(runs());
        arm();
    }
}

TEST(test_a_drive_that_is_not_ready_is_not_started_later)
{
    arm();
    app.drive.state = DRIVE_STATE_FAULT;
    commander_step(&app);
    app.failed = true;
    input.upsets = app.upsets; /* as if the fault were older than the arming */
    throttle(HALF_COUNT);
    passes(200U);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_CONSOLE));
    passes(10U * ARM);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_FALSE(runs());
}

TEST(test_nothing_starts_while_the_motor_is_measured)
{
    arm();
    identify.phase = IDENTIFY_BEGINS;
    throttle(HALF_COUNT);
    passes(ARM);
    TEST_ASSERT_FALSE(runs());
    identify.phase = IDENTIFY_IDLE;
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* A zero that the drive has not taken yet, here without the upset that its source makes. */
TEST(test_an_armed_input_starts_nothing_while_something_is_asked_of_the_drive)
{
    const drive_command_t zero = {.target = 77, .request = (uint8_t)DRIVE_REQUEST_ZERO};
    const drive_command_t nothing = {.target = 77};

    arm();
    command_mailbox_post(&app.mailbox, &zero);
    throttle(HALF_COUNT);
    passes(200U);
    TEST_ASSERT_FALSE(runs());
    TEST_ASSERT_EQUAL_INT32(77, target());
    TEST_ASSERT_EQUAL_UINT8(INPUT_WAITS, input.state);
    command_mailbox_post(&app.mailbox, &nothing);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* No reading is bad then: there is none. */
TEST(test_an_armed_input_whose_converter_stands_still_is_disarmed_after_the_time)
{
    arm();
    converts_each = UINT32_MAX;
    passes(TIMEOUT - 1U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_ARMED, input.state);
    passes(2U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_WAITS, input.state);
    TEST_ASSERT_EQUAL_STRING("no signal", input_text(&input));
    converts_each = 1U;
    throttle(HALF_COUNT);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* Its configuration was refused, so no drive is there that the input could command. */
TEST(test_a_board_that_did_not_start_reads_no_input)
{
    app.drive.cfg = NULL;
    passes(ARM + 300U);
    TEST_ASSERT_EQUAL_UINT8(0U, input.signal.good);
    TEST_ASSERT_EQUAL_STRING("no signal", input_text(&input));
    app.drive.cfg = &cfg;
    arm();
}

TEST(test_without_an_input_nothing_is_read)
{
    settings = (input_cfg_t){.kind = (uint32_t)INPUT_KIND_NONE};
    power_up();
    passes(ARM + 10U);
    throttle(HALF_COUNT);
    passes(ARM);
    TEST_ASSERT_FALSE(runs());
    TEST_ASSERT_NULL(input_text(&input));
}

/* ---- in command ---- */

TEST(test_the_target_follows_the_throttle_by_the_slope)
{
    arm();
    throttle(HALF_COUNT);
    while (!runs()) {
        pass();
    }
    passes(1250U); /* an eighth of a second, 25 % of the largest */
    TEST_ASSERT_INT32_WITHIN(EXAMPLE_SPEED_STEP / 100, EXAMPLE_SPEED_STEP / 4, target());
    passes(5000U);
    TEST_ASSERT_INT32_WITHIN(EXAMPLE_SPEED_STEP / 100, (EXAMPLE_SPEED_STEP / 1000) * 501, target());
}

TEST(test_both_ways_and_the_direction)
{
    arm();
    throttle(1000U);
    passes(10000U);
    TEST_ASSERT_TRUE(target() < -(EXAMPLE_SPEED_STEP / 4));
    settings.share_q15 = -16384;
    power_up();
    arm();
    throttle(3900U); /* full */
    passes(10000U);
    TEST_ASSERT_INT32_WITHIN(2000, -(EXAMPLE_SPEED_STEP / 2), target());
}

TEST(test_a_torque_is_a_share_of_the_largest)
{
    settings.commands = (uint32_t)INPUT_COMMANDS_TORQUE;
    power_up();
    arm();
    throttle(3900U);
    passes(10000U);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_TORQUE, command_mailbox_take(&app.mailbox).mode);
    TEST_ASSERT_INT32_WITHIN(commander_torque_max(&app) / 10000, commander_torque_max(&app),
                             target());
}

TEST(test_back_at_rest_the_motor_ramps_down_and_the_gates_open_when_it_is_slow)
{
    run_at_half();
    throttle(REST_COUNT);
    passes(200U);
    TEST_ASSERT_TRUE(runs());
    while (runs()) {
        pass();
    }
    TEST_ASSERT_EQUAL_INT32(0, target());
    TEST_ASSERT_TRUE(fx_abs(speed) < (EXAMPLE_SPEED_STEP / 256));
    TEST_ASSERT_NULL(lost);
    throttle(HALF_COUNT); /* a stop disarms */
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* Without slope and low-pass the demand ends at once, and the motor takes its time. */
TEST(test_a_run_whose_demand_has_ended_goes_on_until_the_motor_is_slow)
{
    settings.slope_q30 = NO_SLOPE;
    settings.filter_q15 = 32767;
    power_up();
    run_at_half();
    throttle(REST_COUNT);
    while (target() != 0) {
        pass();
    }
    passes(50U);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_EQUAL_INT32(0, target());
    while (runs()) {
        TEST_ASSERT_TRUE(speed > 0);
        pass();
    }
    TEST_ASSERT_TRUE(speed < (EXAMPLE_SPEED_STEP / 256));
}

TEST(test_a_throttle_that_comes_back_while_the_motor_slows_down_goes_on)
{
    run_at_half();
    throttle(REST_COUNT);
    passes(500U);
    throttle(HALF_COUNT);
    passes(5000U);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_TRUE(target() > (EXAMPLE_SPEED_STEP / 2));
}

/* A PC's ticket is not used up by a throttle that moves. */
TEST(test_a_moving_throttle_does_not_lock_a_pc_out)
{
    const drive_command_t run = {.target = 9, .request = (uint8_t)DRIVE_REQUEST_RUN};

    run_at_half();
    const uint32_t ticket = commander_ticket(&app);

    throttle(3900U);
    passes(1000U);
    TEST_ASSERT_NULL(commander_command(&app, &run, commander_take_ticket(&app, ticket), 1000));
    passes(1000U);
    TEST_ASSERT_EQUAL_INT32(9, target());
}

TEST(test_console_and_link_take_over_and_the_throttle_does_not_take_back)
{
    static const source_t others[] = {SOURCE_CONSOLE, SOURCE_LINK};

    for (uint32_t k = 0U; k < 2U; k++) {
        power_up();
        run_at_half();
        TEST_ASSERT_TRUE(commander_set_speed(&app, others[k], 1234));
        for (uint32_t j = 0U; j < 10U; j++) {
            throttle((j % 2U) == 0U ? REST_COUNT : HALF_COUNT);
            passes(ARM + 400U);
            TEST_ASSERT_EQUAL(others[k], commander_source(&app));
            TEST_ASSERT_EQUAL_INT32(1234, target());
        }
    }
}

/* Whatever it may be: no run goes on that nobody follows. */
TEST(test_an_upset_ends_the_run_of_the_input)
{
    run_at_half();
    commander_upset(&app);
    pass();
    TEST_ASSERT_FALSE(runs());
}

/* ---- a signal that is lost ---- */

TEST(test_an_open_wire_ramps_to_a_stop_within_the_time_and_is_named)
{
    static const struct {
        uint16_t count;
        const char *reason;
    } wires[] = {{0U, "its voltage is below its range"},
                 {4095U, "its voltage is above its range"},
                 {HAL_NO_THROTTLE, "the board has no pin for it"}};

    for (uint32_t k = 0U; k < 3U; k++) {
        power_up();
        run_at_half();
        throttle(wires[k].count);
        passes(TIMEOUT);
        TEST_ASSERT_NULL(lost);
        passes(2U);
        TEST_ASSERT_EQUAL_STRING(wires[k].reason, lost);
        TEST_ASSERT_EQUAL_INT32(0, target());
        TEST_ASSERT_TRUE(runs());
        TEST_ASSERT_EQUAL_STRING(wires[k].reason, input_text(&input));
        passes(STOP_TICKS);
        TEST_ASSERT_FALSE(runs());
        throttle(HALF_COUNT); /* the wire is mended */
        passes(10U * ARM);
        TEST_ASSERT_FALSE(runs());
    }
}

TEST(test_a_converter_that_stands_still_ramps_to_a_stop_within_the_time)
{
    run_at_half();
    converts_each = UINT32_MAX;
    passes(TIMEOUT);
    TEST_ASSERT_NULL(lost);
    passes(2U);
    TEST_ASSERT_EQUAL_STRING("no signal", lost);
    passes(STOP_TICKS);
    TEST_ASSERT_FALSE(runs());
}

/* Each of them is one reading: of the board, one in 128 ticks, and 256 where one is left out. */
TEST(test_rare_conversions_keep_the_motor_running_and_eight_of_them_start_it)
{
    for (converts_each = 128U; converts_each <= 256U; converts_each += 128U) {
        const uint32_t each = converts_each;

        power_up();
        converts_each = each;
        passes(2U * ARM);
        TEST_ASSERT_EQUAL_UINT8(INPUT_ARMED, input.state);
        throttle(HALF_COUNT);
        passes((INPUT_SIGNAL_GOOD - 1U) * each);
        TEST_ASSERT_FALSE(runs());
        passes(4U * each); /* the median and the low-pass */
        TEST_ASSERT_TRUE(runs());
        passes(20000U);
        TEST_ASSERT_TRUE(runs());
        TEST_ASSERT_NULL(lost);
        TEST_ASSERT_INT32_WITHIN(EXAMPLE_SPEED_STEP / 100, (EXAMPLE_SPEED_STEP / 1000) * 501,
                                 target());
    }
}

TEST(test_a_wire_that_is_mended_while_the_motor_slows_down_does_not_speed_it_up)
{
    run_at_half();
    throttle(0U);
    passes(TIMEOUT + 2U);
    throttle(HALF_COUNT);
    while (runs()) {
        pass();
        TEST_ASSERT_EQUAL_INT32(0, target());
    }
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

TEST(test_a_person_takes_a_motor_that_slows_down_and_it_is_not_stopped)
{
    run_at_half();
    throttle(0U);
    passes(TIMEOUT + 2U);
    TEST_ASSERT_TRUE(commander_set_speed(&app, SOURCE_CONSOLE, 7));
    passes(STOP_TICKS);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_EQUAL_INT32(7, target());
}

TEST(test_a_torque_that_is_lost_becomes_a_ramp_of_the_speed)
{
    settings.commands = (uint32_t)INPUT_COMMANDS_TORQUE;
    power_up();
    run_at_half();
    throttle(0U);
    passes(TIMEOUT + 2U);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, command_mailbox_take(&app.mailbox).mode);
    TEST_ASSERT_EQUAL_INT32(0, target());
}

/* The motor of another source does not need the input. */
TEST(test_a_lost_input_leaves_the_motor_of_a_pc_alone)
{
    TEST_ASSERT_TRUE(commander_set_speed(&app, SOURCE_LINK, 1234));
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    throttle(0U);
    passes(10U * TIMEOUT);
    TEST_ASSERT_NULL(lost);
    TEST_ASSERT_EQUAL_INT32(1234, target());
}

/* ---- the button ---- */

static void with_button(input_button_t use)
{
    settings.button = (uint32_t)use;
    power_up();
}

/* For longer than its bounces. */
static void press(void)
{
    button(true);
    passes(300U);
}

static void release(void)
{
    button(false);
    passes(300U);
}

TEST(test_with_an_enable_the_motor_runs_only_while_it_is_pressed)
{
    with_button(INPUT_BUTTON_ENABLE);
    arm();
    press();
    TEST_ASSERT_FALSE(runs());
    throttle(HALF_COUNT);
    passes(500U);
    TEST_ASSERT_TRUE(runs());
    release();
    TEST_ASSERT_FALSE(runs());
    press(); /* the throttle is still high */
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

TEST(test_with_an_enable_a_throttle_that_leaves_its_rest_first_starts_nothing)
{
    with_button(INPUT_BUTTON_ENABLE);
    arm();
    throttle(HALF_COUNT);
    passes(500U);
    press();
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* As a man who holds his lever through a halt. */
TEST(test_with_an_enable_that_is_held_the_throttle_starts_again_after_a_halt)
{
    with_button(INPUT_BUTTON_ENABLE);
    arm();
    press();
    throttle(HALF_COUNT);
    passes(5000U);
    throttle(REST_COUNT);
    passes(STOP_TICKS + ARM + 500U);
    TEST_ASSERT_FALSE(runs());
    throttle(HALF_COUNT);
    passes(500U);
    TEST_ASSERT_TRUE(runs());
}

TEST(test_an_enable_that_is_pressed_at_power_up_counts_once_it_was_released)
{
    with_button(INPUT_BUTTON_ENABLE);
    button(true);
    passes(ARM + 500U);
    throttle(HALF_COUNT);
    passes(ARM);
    TEST_ASSERT_FALSE(runs());
    throttle(REST_COUNT);
    release();
    arm();
    press();
    throttle(HALF_COUNT);
    passes(500U);
    TEST_ASSERT_TRUE(runs());
}

TEST(test_a_press_starts_at_the_set_point_and_the_next_one_stops)
{
    with_button(INPUT_BUTTON_START_STOP);
    throttle(HALF_COUNT);
    passes(ARM + 500U);
    TEST_ASSERT_EQUAL_STRING("armed", input_text(&input));
    TEST_ASSERT_FALSE(runs());
    press();
    TEST_ASSERT_TRUE(runs());
    release();
    passes(5000U);
    TEST_ASSERT_TRUE(target() > (EXAMPLE_SPEED_STEP / 2));
    press();
    TEST_ASSERT_FALSE(runs());
    release();
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    press();
    TEST_ASSERT_TRUE(runs());
}

/* Other than with an enable, which says that it is wanted as long as it is held. */
TEST(test_a_run_that_was_started_by_a_press_and_ended_by_the_throttle_needs_another_press)
{
    with_button(INPUT_BUTTON_START_STOP);
    arm();
    press();
    release();
    throttle(HALF_COUNT);
    passes(5000U);
    TEST_ASSERT_TRUE(runs());
    throttle(REST_COUNT);
    passes(STOP_TICKS + 500U);
    TEST_ASSERT_FALSE(runs());
    arm();
    throttle(HALF_COUNT);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    press();
    TEST_ASSERT_TRUE(runs());
}

TEST(test_a_second_press_before_the_throttle_moves_takes_the_first_one_back)
{
    with_button(INPUT_BUTTON_START_STOP);
    arm();
    press();
    release();
    press();
    release();
    throttle(HALF_COUNT);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    press(); /* a third one starts */
    TEST_ASSERT_TRUE(runs());
}

TEST(test_a_press_before_the_input_is_armed_starts_nothing_later)
{
    with_button(INPUT_BUTTON_START_STOP);
    throttle(HALF_COUNT);
    release();
    press();
    release();
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

TEST(test_a_start_button_that_is_pressed_at_power_up_starts_nothing)
{
    with_button(INPUT_BUTTON_START_STOP);
    throttle(HALF_COUNT);
    button(true);
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
    release();
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

TEST(test_the_button_stops_a_motor_that_a_pc_runs)
{
    for (uint32_t k = 0U; k < 2U; k++) {
        with_button((k == 0U) ? INPUT_BUTTON_START_STOP : INPUT_BUTTON_ENABLE);
        arm();
        TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
        press();
        release(); /* with an enable this is the stop */
        TEST_ASSERT_FALSE(runs());
    }
}

/* It waits for the winding to cool, so it has asked nothing of the drive, and would turn it later.
 */
TEST(test_the_button_ends_a_measurement_that_has_not_begun_to_turn_the_motor)
{
    for (uint32_t k = 0U; k < 2U; k++) {
        with_button((k == 0U) ? INPUT_BUTTON_START_STOP : INPUT_BUTTON_ENABLE);
        arm();
        TEST_ASSERT_NULL(identify_start(&identify));
        commander_measures(&app, SOURCE_CONSOLE);
        TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
        press();
        release(); /* with an enable this is the stop */
        TEST_ASSERT_FALSE(identify_is_busy(&identify));
        TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
        TEST_ASSERT_FALSE(runs());
    }
}

TEST(test_a_button_that_is_not_used_does_nothing)
{
    button(true);
    passes(300U);
    run_at_half();
    release();
    press();
    TEST_ASSERT_TRUE(runs());
}

TEST(test_a_press_clears_a_fault_and_starts_nothing)
{
    with_button(INPUT_BUTTON_START_STOP);
    throttle(HALF_COUNT);
    passes(ARM + 500U);
    app.drive.state = DRIVE_STATE_FAULT;
    passes(10U);
    press();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    release();
    passes(10U * ARM);
    TEST_ASSERT_FALSE(runs());
}

/* ---- pulses ---- */

static void servo_pulses(uint32_t count, uint32_t width)
{
    for (uint32_t k = 0U; k < count; k++) {
        hardware.pulses[hardware.pulse_end % EXAMPLE_PULSES] =
            (hal_pulse_t){.start = hardware.now - width, .width = width};
        hardware.pulse_end++;
        passes(200U); /* 50 Hz */
    }
}

TEST(test_servo_pulses_arm_command_and_are_lost)
{
    settings.kind = (uint32_t)INPUT_KIND_RC_PULSE;
    settings.least = 8000;
    settings.low = 10000;
    settings.middle = 10000;
    settings.high = 20000;
    settings.most = 22000;
    power_up();
    servo_pulses(50U, 10000U);
    TEST_ASSERT_EQUAL_STRING("armed", input_text(&input));
    servo_pulses(100U, 20000U);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_INT32_WITHIN(2000, EXAMPLE_SPEED_STEP, target());
    passes(TIMEOUT + 2U);
    TEST_ASSERT_EQUAL_STRING("no signal", lost);
    passes(STOP_TICKS);
    TEST_ASSERT_FALSE(runs());
}

/* A frame of DShot300 that begins now. */
static void dshot_frame(uint32_t value)
{
    const uint32_t v = value << 1U;
    const uint32_t bits = (v << 4U) | ((v ^ (v >> 4U) ^ (v >> 8U)) & 15U);

    for (uint32_t at = 0U; at < DSHOT_BITS; at++) {
        const bool one = ((bits >> (15U - at)) & 1U) != 0U;

        hardware.pulses[hardware.pulse_end % EXAMPLE_PULSES] =
            (hal_pulse_t){.start = hardware.now + ((at * 100U) / 3U), .width = one ? 25U : 12U};
        hardware.pulse_end++;
    }
}

/* A frame in the tick. */
static void dshot_frames(uint32_t count, uint32_t value)
{
    for (uint32_t k = 0U; k < count; k++) {
        dshot_frame(value);
        pass();
    }
}

static void with_dshot(int32_t middle)
{
    settings.kind = (uint32_t)INPUT_KIND_DSHOT;
    settings.least = 0;
    settings.low = 0;
    settings.middle = middle;
    settings.high = 2000;
    settings.most = 2000;
    power_up();
}

TEST(test_dshot_arms_by_its_stop_commands_and_takes_a_command_for_a_stop)
{
    with_dshot(0);
    dshot_frames(ARM + 300U, 0U);
    TEST_ASSERT_EQUAL_STRING("armed", input_text(&input));
    dshot_frames(10000U, 2047U);
    TEST_ASSERT_TRUE(runs());
    TEST_ASSERT_INT32_WITHIN(2000, EXAMPLE_SPEED_STEP, target());
    dshot_frames(2U * STOP_TICKS, 7U); /* a change of the direction, which is not carried out */
    TEST_ASSERT_NOT_EQUAL(SOURCE_INPUT, commander_source(&app));
    TEST_ASSERT_FALSE(runs());
    TEST_ASSERT_NULL(lost);
}

/* Zero is a stop there too, and not full speed backwards. */
TEST(test_dshot_both_ways_is_at_rest_at_its_stop)
{
    with_dshot(1000);
    dshot_frames(ARM + 300U, 0U);
    TEST_ASSERT_EQUAL_STRING("armed", input_text(&input));
    dshot_frames(10000U, 48U);
    TEST_ASSERT_INT32_WITHIN(EXAMPLE_SPEED_STEP / 500, -EXAMPLE_SPEED_STEP, target());
}

/*
 * The background has been late for four ticks, a frame in each. As the last frame is the last that
 * the pass takes, its pulses may go on in those that still wait, and it is judged in the next pass.
 */
TEST(test_of_more_pulses_than_a_pass_takes_the_rest_is_judged_in_the_next_pass_and_once)
{
    const uint32_t frames = EXAMPLE_PULSES / DSHOT_BITS;

    with_dshot(0);
    pass(); /* in which the input begins */
    for (uint32_t k = 0U; k < frames; k++) {
        hardware.now += TICK_UNITS;
        dshot_frame(0U);
    }
    pass();
    TEST_ASSERT_EQUAL_UINT32(hardware.pulse_end, hardware.pulse_first);
    TEST_ASSERT_EQUAL_UINT8(frames - 1U, input.signal.count);
    pass();
    TEST_ASSERT_EQUAL_UINT8(frames, input.signal.count);
    pass();
    TEST_ASSERT_EQUAL_UINT8(frames, input.signal.count);
}
