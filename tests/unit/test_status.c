/* SPDX-License-Identifier: MIT */
/* The drive's state as a line of text: every quantity and every kind of fault in its unit. */
#include "example_app.h"
#include "flash_model.h"
#include "status.h"
#include "testing.h"

#include <string.h>

static text_t text;

static const char *status(void)
{
    text = (text_t){0};
    status_add(&text, &app, &hardware, &ABOUT);
    TEST_ASSERT_LESS_THAN_UINT32(TEXT_MAX, text.length);
    text.characters[text.length] = '\0';
    return text.characters;
}

void setUp(void)
{
    flash_new(1U);
    power_on();
}

TEST(test_it_has_every_quantity_in_its_unit)
{
    const drive_command_t asked = {.target = units_step(&ABOUT.rotation, -345)};

    calibrate();
    command_mailbox_post(&app.mailbox, &asked);
    measured.adc_ia = EXAMPLE_MIDDLE + 1024U; /* half of 20 A */
    measured.adc_ib = EXAMPLE_MIDDLE - 1U;    /* 9.765625 mA */
    measured.adc_temperature = 880U;          /* -7.03 °C */
    hardware.health = (hal_health_t){.adc_ic = 0U, .late_ticks = 12U, .load_pct = 25U};
    tick(1U);
    TEST_ASSERT_EQUAL_STRING(
        "READY, speed unknown, asked -345 rpm, phases 10.000 -0.009 -20.000 A, "
        "bus 310.034 V, -7 C, late 12, load 25 %",
        status());
}

TEST(test_it_tells_what_keeps_the_gates_open_until_a_reset)
{
    calibrate();
    TEST_ASSERT_NULL(strstr(status(), "until a reset"));
    hardware.health = (hal_health_t){.why_barred = "register TIM1_BDTR is not as it was set"};
    TEST_ASSERT_NOT_NULL(
        strstr(status(), "READY, until a reset: register TIM1_BDTR is not as it was set, speed "));
}

TEST(test_before_the_first_tick_there_is_no_temperature)
{
    TEST_ASSERT_NOT_NULL(strstr(status(), " V, 0 C, "));
    tick(1U);
    TEST_ASSERT_NOT_NULL(strstr(status(), " V, -50 C, "));
}

static void assert_state(drive_state_t state, const char *name)
{
    app.drive.state = state;
    TEST_ASSERT_EQUAL_STRING_LEN(name, status(), strlen(name));
}

TEST(test_it_begins_with_the_state)
{
    assert_state(DRIVE_STATE_INIT, "INIT, speed");
    assert_state(DRIVE_STATE_OFFSET_CAL, "OFFSET_CAL, speed");
    assert_state(DRIVE_STATE_READY, "READY, speed");
    assert_state(DRIVE_STATE_FLYING_START, "FLYING_START, speed");
    assert_state(DRIVE_STATE_PROBE, "PROBE, speed");
    assert_state(DRIVE_STATE_ALIGN, "ALIGN, speed");
    assert_state(DRIVE_STATE_HOLD, "HOLD, speed");
    assert_state(DRIVE_STATE_IF_RAMP, "IF_RAMP, speed");
    assert_state(DRIVE_STATE_HANDOVER, "HANDOVER, speed");
    assert_state(DRIVE_STATE_RUN, "RUN, speed");
    assert_state(DRIVE_STATE_FAULT, "FAULT by ");
}

TEST(test_a_motor_that_is_shorted_is_said)
{
    app.drive.safe_state.phase = SAFE_STATE_SHORT;
    assert_state(DRIVE_STATE_READY, "READY, shorting the motor, speed");
    app.drive.safe_state.phase = SAFE_STATE_BROKEN;
    assert_state(DRIVE_STATE_READY, "READY, speed");
}

TEST(test_the_speed_is_that_of_the_drive)
{
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.rotor.observer.speed = -EXAMPLE_SPEED_STEP;
    TEST_ASSERT_EQUAL_STRING_LEN("RUN, speed -2000 of 0 rpm", status(), 25U);
}

TEST(test_with_open_gates_the_speed_is_unknown_and_with_a_sensor_it_is_known)
{
    static const drive_state_t open[] = {DRIVE_STATE_READY, DRIVE_STATE_FLYING_START,
                                         DRIVE_STATE_FAULT};
    drive_cfg_t sensed = *app.drive.cfg;

    sensed.sampling.sensor_pole_pairs = 1U;
    app.drive.rotor.observer.speed = EXAMPLE_SPEED_STEP; /* what driving ended with */
    for (uint32_t k = 0U; k < (sizeof open / sizeof open[0]); k++) {
        app.drive.state = open[k];
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), ", speed unknown, asked 0 rpm, "),
                                     text.characters);
    }
    app.drive.cfg = &sensed;
    app.drive.rotor.source = (uint8_t)ESTIMATE_SENSOR;
    app.drive.state = DRIVE_STATE_READY;
    assert_state(DRIVE_STATE_READY, "READY, speed 2000 of 0 rpm, ");
}

static shaft_decoder_t shaft;
static drive_cfg_t sensed_cfg;

/* READY with Hall sensors, of which sensor 1 is high. */
static void power_on_with_hall(void)
{
    sensed_cfg = example_drive_cfg_with_startup();
    sensed_cfg.sampling.sensor_pole_pairs = 1U;
    sensed_cfg.sensor.kind = (uint32_t)SENSOR_KIND_HALL;
    sensed_cfg.crc = config_guard_crc(&sensed_cfg);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &sensed_cfg));
    app_sense(&app, &shaft);
    hardware.shaft.reading = 1U;
    calibrate();
}

static void assert_says(const char *words)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), words), text.characters);
}

TEST(test_it_tells_whether_sensor_or_observer_gives_the_angle_and_what_ails_the_sensor)
{
    power_on_with_hall();
    assert_says("load 0 %, angle by sensor");
    TEST_ASSERT_NULL(strstr(text.characters, ", sensor: "));
    hardware.shaft.reading = 7U; /* no angle has that */
    tick(10U);
    assert_says("load 0 %, sensor: hall_pattern"); /* nobody tells the angle */
    hardware.shaft.reading = 1U;
    tick(10U);
    assert_says("load 0 %, angle by sensor, sensor: hall_pattern"); /* it was so */
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.rotor.source = (uint8_t)ESTIMATE_OBSERVER;
    assert_says(", angle by observer, sensor: hall_pattern");
}

TEST(test_the_next_request_to_run_forgets_the_trouble_of_the_sensor_but_not_that_it_is_wrong)
{
    const drive_command_t run = {.request = DRIVE_REQUEST_RUN};

    power_on_with_hall();
    hardware.shaft.reading = 7U;
    tick(10U);
    hardware.shaft.reading = 1U;
    command_mailbox_post(&app.mailbox, &run);
    tick_period();
    tick_period();
    assert_says(", angle by sensor");
    TEST_ASSERT_NULL(strstr(text.characters, ", sensor: "));
    app.drive.rotor.failed = true;
    assert_says(", sensor: sensor_turned");
}

TEST(test_without_a_sensor_nothing_is_said_of_one)
{
    calibrate();
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.rotor.failed = true;
    TEST_ASSERT_NULL(strstr(status(), "angle"));
    TEST_ASSERT_NULL(strstr(status(), "sensor"));
}

/* 3 turns of the shaft with 2 pole pairs are 6 electrical ones. */
TEST(test_a_position_is_asked_for_in_turns_and_is_no_speed)
{
    const drive_command_t position = {.target = 6 * 65536, .mode = (uint8_t)DRIVE_MODE_POSITION};

    command_mailbox_post(&app.mailbox, &position);
    TEST_ASSERT_EQUAL_STRING_LEN("INIT, speed unknown, to turn 3.00, phases ", status(), 42U);
}

/* 1 000 000 turns of the shaft lie before the zero. */
TEST(test_a_rotor_is_told_in_turns_from_the_zero)
{
    const drive_command_t position = {.target = 6 * 65536, .mode = (uint8_t)DRIVE_MODE_POSITION};

    command_mailbox_post(&app.mailbox, &position);
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
    app.drive.motion.position_loop.zero_q32 = (int64_t)2000000 << 32;
    app.drive.rotor.position.turns_q32 =
        app.drive.motion.position_loop.zero_q32 - ((int64_t)11 << 31);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), " rpm, turn -2.75, to turn 3.00, phases "),
                                 text.characters);
}

/* The command is not taken yet: the count may be that of another run. */
TEST(test_a_rotor_in_another_mode_is_told_in_no_turns)
{
    const drive_command_t position = {.target = 6 * 65536, .mode = (uint8_t)DRIVE_MODE_POSITION};

    command_mailbox_post(&app.mailbox, &position);
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.motion.mode = (uint8_t)DRIVE_MODE_SPEED;
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), " rpm, to turn 3.00, phases "), text.characters);
}

TEST(test_a_torque_is_asked_for_in_newton_metres_and_is_no_speed)
{
    const drive_command_t torque = {.target = 0x8000000, .mode = (uint8_t)DRIVE_MODE_TORQUE};

    command_mailbox_post(&app.mailbox, &torque);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), "speed unknown, torque "), text.characters);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), " N m, phases "), text.characters);
}

/* T_b is of the configuration. */
TEST(test_where_the_configuration_is_refused_no_torque_is_told)
{
    const drive_command_t torque = {.target = 0x8000000, .mode = (uint8_t)DRIVE_MODE_TORQUE};

    app = (app_t){.hal = &hardware}; /* nothing has begun */
    command_mailbox_init(&app.mailbox);
    command_mailbox_post(&app.mailbox, &torque);
    TEST_ASSERT_NULL_MESSAGE(strstr(status(), " N m"), text.characters);
}

/* The command's target is a word of the probe then. */
TEST(test_while_the_motor_is_measured_no_speed_is_asked_for)
{
    const drive_command_t word = {.target = units_step(&ABOUT.rotation, 1234),
                                  .mode = (uint8_t)PROBE_SPEED,
                                  .request = DRIVE_REQUEST_PROBE};

    command_mailbox_post(&app.mailbox, &word);
    app.drive.state = DRIVE_STATE_PROBE;
    app.drive.vector.step = EXAMPLE_SPEED_STEP;
    assert_state(DRIVE_STATE_PROBE, "PROBE, speed 2000 rpm, measuring the motor, phases ");
}

static void assert_fault(const char *expected, fault_id_t id, int32_t value, int32_t limit)
{
    app.drive.fault = (fault_t){.id = id, .value = value, .limit = limit};
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(status(), expected), text.characters);
}

TEST(test_a_fault_has_value_and_limit_in_its_unit)
{
    fail();
    assert_fault(" by OVERCURRENT 20.000 A, limit -10.000 A (", FAULT_OVERCURRENT, 16384, -8192);
    assert_fault(" by OVERVOLTAGE 449.986 V, limit 225.000 V (", FAULT_OVERVOLTAGE, 32767, 16384);
    assert_fault(" by OVERSPEED -2000 rpm, limit 1 rpm (", FAULT_OVERSPEED, -EXAMPLE_SPEED_STEP,
                 14317);
    assert_fault(" by OVERLOAD 120.0 %, limit 50.0 % (", FAULT_OVERLOAD, 19661, 8192);
    assert_fault(" by OVERTEMPERATURE 105 C, limit 100 C (", FAULT_OVERTEMPERATURE, 3174, 3072);
    assert_fault(" by LATE 11, limit 10 (", FAULT_LATE, 11, 10);
}

TEST(test_a_fault_of_before_is_told_by_its_name_value_and_limit_alone)
{
    text = (text_t){0};
    status_add_fault(&text, &ABOUT, FAULT_OVERCURRENT, 16384, -8192);
    TEST_ASSERT_EQUAL_STRING("OVERCURRENT 20.000 A, limit -10.000 A", text.characters);
}

TEST(test_a_fault_has_its_advice_in_brackets)
{
    fail();
    TEST_ASSERT_NOT_NULL(strstr(status(), "), speed "));
}

TEST(test_a_swing_has_its_frequency_and_says_what_it_has_lowered)
{
    app.drive.state = DRIVE_STATE_RUN;
    app.drive.watch.oscillation.span = 400U; /* slow periods of 1 ms */
    TEST_ASSERT_EQUAL_STRING_LEN("RUN, swing 25.0 Hz, speed ", status(), 26U);
    speed_loop_lower(&app.drive.motion.speed_loop);
    TEST_ASSERT_EQUAL_STRING_LEN("RUN, swing 25.0 Hz, half the speed bandwidth, speed ", status(),
                                 52U);
}

TEST(test_a_swing_that_is_a_fault_has_its_frequency_beside_its_amplitude)
{
    fail();
    app.drive.watch.oscillation.span = 400U;
    assert_fault(" by OSCILLATION 20.000 A at 25.0 Hz, limit 2.500 A (", FAULT_OSCILLATION, 16384,
                 2048);
    TEST_ASSERT_NULL(strstr(status(), ", swing "));
    assert_fault(" by OVERCURRENT 20.000 A, limit 10.000 A (", FAULT_OVERCURRENT, 16384, 8192);
    TEST_ASSERT_NOT_NULL(strstr(status(), "), swing 25.0 Hz, speed "));
}
