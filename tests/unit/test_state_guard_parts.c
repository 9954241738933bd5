/* SPDX-License-Identifier: MIT */
/*
 * What the guard of the state finds, part by part: a word that has changed by itself, and the part
 * that the fault names. test_state_guard flips each bit of a running drive.
 */
#include "driven_motor.h"
#include "schedule.h"
#include "state_guard.h"
#include "transitions.h"

/* 0.3 s: longer than a round of the parts (32 ms), shorter than the CRC's (2 s) */
#define LONG_TICKS (3000U)
#define STEP (1000000) /* of a vector that turns */

static fault_t fault;

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
}

void tearDown(void)
{
}

/* Looks at the next part. */
static fault_id_t look(void)
{
    return state_guard_step(&drive.state_guard, &drive.motor, &drive, &fault);
}

/* Looks at each part once, or until one is found. */
static fault_id_t look_at_all(void)
{
    fault_id_t id = FAULT_NONE;

    for (uint32_t k = 0U; (k < (uint32_t)STATE_GUARD_PARTS) && (id == FAULT_NONE); k++) {
        id = look();
    }
    return id;
}

/* A drive in this state, in which nothing is found. */
static void begin_in(drive_state_t state, drive_mode_t mode)
{
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    drive.state = state;
    drive.motion.mode = (uint8_t)mode;
    drive.limits = protection_limits(&cfg.protection, drive_is_driving(state));
    drive.vector.step = (state == DRIVE_STATE_IF_RAMP) ? STEP : 0;
    drive.motion.speed_loop.reference = drive.vector.step;
    drive.motion.speed_reference = drive.vector.step;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look_at_all());
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look_at_all());
}

static void assert_finds(state_guard_part_t part)
{
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, look_at_all());
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, fault.id);
    TEST_ASSERT_EQUAL_INT32(part, fault.value);
}

TEST(test_each_limit_in_force_is_that_of_the_configuration)
{
    int32_t *const limits[] = {&drive.limits.current_max, &drive.limits.bus_max,
                               &drive.limits.bus_min};

    for (uint32_t k = 0U; k < COUNT(limits); k++) {
        begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
        *limits[k] ^= 1;
        assert_finds(STATE_GUARD_LIMITS);
    }
}

TEST(test_a_phase_or_a_count_that_cannot_be_is_found)
{
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.start.align.phase = (align_phase_t)(ALIGN_DONE + 1);
    assert_finds(STATE_GUARD_CHOICES);
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.start.flying_start.phase = (flying_start_phase_t)(FLYING_START_CHARGE + 1);
    assert_finds(STATE_GUARD_CHOICES);
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.safe_state.phase = (safe_state_phase_t)(SAFE_STATE_BROKEN + 1);
    assert_finds(STATE_GUARD_CHOICES);
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.motion.speed_loop.halvings = 2U;
    assert_finds(STATE_GUARD_CHOICES);
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.start.attempts = cfg.startup.attempts + 1U;
    assert_finds(STATE_GUARD_START);
}

/* J as a ratio to that of the file, Q17 against limits of Q13. */
TEST(test_an_inertia_that_was_never_learned_is_found)
{
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.motion.speed_loop.inertia_q17 = (cfg.speed_loop.inertia_least_q13 << 4U) - 1;
    assert_finds(STATE_GUARD_CHOICES);
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive.motion.speed_loop.inertia_q17 = (cfg.speed_loop.inertia_most_q13 + 1) << 4U;
    assert_finds(STATE_GUARD_CHOICES);
}

TEST(test_a_voltage_drive_is_found_where_the_configuration_has_none)
{
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
    drive.voltage_drive.active = true;
    assert_finds(STATE_GUARD_CHOICES);
    cfg.voltage_drive = example_voltage_drive_cfg();
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
    drive.voltage_drive.active = true;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look_at_all());
}

/* Until the slot that looks at it has come, at the end of a supervision period at the latest. */
static void run_until_heat_is_looked_at(void)
{
    drive.watch.supervision.step = 0U;
    ticks(cfg.slow_ticks + 1U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(STATE_GUARD_HEAT, drive.fault.value);
}

/* Of the heat and its copy one is true, and nobody knows which. */
TEST(test_a_winding_whose_heat_has_flipped_counts_as_the_hotter_one)
{
    const int32_t heat = 0x800000;

    for (uint32_t bit = 0U; bit < 32U; bit++) {
        const int32_t flipped = (int32_t)((uint32_t)heat ^ (1UL << bit));
        const int32_t hotter = fx_clamp(flipped, heat, DERATING_HEAT_MAX_Q24);

        power_on();
        drive_warm(&drive, heat);
        drive.derating.heat_q24 = flipped;
        run_until_heat_is_looked_at();
        TEST_ASSERT_EQUAL_INT32(hotter, drive.derating.heat_q24);
        power_on();
        drive_warm(&drive, flipped);
        drive.derating.heat_q24 = heat;
        run_until_heat_is_looked_at();
        TEST_ASSERT_EQUAL_INT32(hotter, drive.derating.heat_q24);
    }
}

TEST(test_in_run_a_jump_of_what_moves_slowly_is_found)
{
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
    drive.motion.speed_loop.reference += 0x1000000;
    assert_finds(STATE_GUARD_REFERENCE);
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_TORQUE); /* has no ramp */
    drive.motion.speed_loop.reference += 0x1000000;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look_at_all());
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
    drive.motor.model.flux_q30 += 0x8000000;
    assert_finds(STATE_GUARD_FLUX);
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_SPEED);
    drive.motion.weakening.check ^= 1U;
    assert_finds(STATE_GUARD_WEAKENING);
}

TEST(test_in_position_control_another_profile_or_a_way_that_no_rotor_goes_is_found)
{
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_POSITION);
    drive.motion.position_loop.check ^= 1U;
    assert_finds(STATE_GUARD_PROFILE);
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_POSITION);
    drive.rotor.position.turns_q32 += (int64_t)1 << 40;
    assert_finds(STATE_GUARD_TURNS);
    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_POSITION);
    drive.rotor.position.turns_q32 -= (int64_t)1 << 40;
    assert_finds(STATE_GUARD_TURNS);
}

/* The rotor is faster than it was asked to be: a load drives it. */
TEST(test_a_way_at_the_speed_that_the_rotor_had_is_none_that_no_rotor_goes)
{
    const int64_t ticks_of_a_look = (int64_t)SUPERVISION_STEPS * (int64_t)cfg.slow_ticks;

    begin_in(DRIVE_STATE_RUN, DRIVE_MODE_POSITION);
    drive.rotor.observer.speed = 0x10000000; /* 1/16 turn a tick */
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look());
    drive.rotor.position.turns_q32 += ticks_of_a_look * drive.rotor.observer.speed;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, look());
    drive.rotor.position.turns_q32 += ticks_of_a_look * 2 * drive.rotor.observer.speed;
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, look());
    TEST_ASSERT_EQUAL_INT32(STATE_GUARD_TURNS, fault.value);
}

TEST(test_a_vector_at_rest_keeps_its_angle_and_its_integrals)
{
    begin_in(DRIVE_STATE_HOLD, DRIVE_MODE_SPEED);
    drive.vector.position.turns_q32 += 1;
    assert_finds(STATE_GUARD_ANGLE);
    begin_in(DRIVE_STATE_HOLD, DRIVE_MODE_SPEED);
    drive.control.current_loop.pi_d.integral_q26 += 0x2000000;
    assert_finds(STATE_GUARD_INTEGRALS);
    begin_in(DRIVE_STATE_HOLD, DRIVE_MODE_SPEED);
    drive.control.current_loop.pi_q.integral_q26 -= 0x2000000;
    assert_finds(STATE_GUARD_INTEGRALS);
}

static void assert_moves(fault_id_t id)
{
    TEST_ASSERT_EQUAL_INT(id, state_guard_check_vector(&drive, &fault));
    if (id != FAULT_NONE) {
        TEST_ASSERT_EQUAL_INT32(STATE_GUARD_VECTOR, fault.value);
    }
}

TEST(test_a_vector_moves_by_the_step_that_it_was_given)
{
    begin_in(DRIVE_STATE_IF_RAMP, DRIVE_MODE_SPEED);
    assert_moves(FAULT_NONE);
    drive.vector.step ^= 1;
    assert_moves(FAULT_MEMORY);
}

/* Half a turn more would reverse the torque: it is found in its tick, also where nothing is driven.
 */
TEST(test_another_tracked_angle_than_the_sensor_has_led_to_is_found_in_its_tick)
{
    const drive_in_t frame = {.adc_ia = 2048U, .adc_ib = 2048U, .adc_bus = 2822U};
    drive_out_t compares;

    cfg = example_drive_cfg();
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.observer.eta = 0;
    cfg.observer.kappa_p = 0;
    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    drive_step(&drive, &frame, &compares);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    drive.rotor.angle_sensor.position.turns_q32 ^= 0x80000000LL;
    drive_step(&drive, &frame, &compares);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(STATE_GUARD_TURNS, drive.fault.value);
}

TEST(test_a_tracked_angle_that_the_sensor_has_led_to_is_sound)
{
    fault_t none;

    begin_in(DRIVE_STATE_READY, DRIVE_MODE_SPEED);
    fault_clear(&none);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, state_guard_check_sensor(&drive, &none));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, none.id);
}

/* In the tick that moves it. */
TEST(test_a_drive_with_a_vector_of_another_step_stops)
{
    const instant_t now = {.sample = {.bus = drive.bus}};

    begin_in(DRIVE_STATE_IF_RAMP, DRIVE_MODE_SPEED);
    drive.vector.step ^= 1;
    TEST_ASSERT_EQUAL_INT(DRIVE_EVENT_FAULT,
                          schedule_step(&drive, &in, &now, SLOT_SPEED, true, &fault));
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, fault.id);
    TEST_ASSERT_EQUAL_INT32(STATE_GUARD_VECTOR, fault.value);
}

TEST(test_a_vector_does_not_move_with_another_zero_of_a_sensor)
{
    begin_in(DRIVE_STATE_IF_RAMP, DRIVE_MODE_SPEED);
    drive.sensors.offset_a ^= 1;
    assert_moves(FAULT_MEMORY);
}

/* A position asks for any speed. */
TEST(test_a_speed_asked_of_a_vector_is_no_further_than_a_ramp_leads)
{
    begin_in(DRIVE_STATE_IF_RAMP, DRIVE_MODE_SPEED);
    drive.motion.speed_reference = STEP + cfg.startup.ramp;
    assert_moves(FAULT_NONE);
    drive.motion.speed_reference = STEP - cfg.startup.ramp;
    assert_moves(FAULT_NONE);
    drive.motion.speed_reference = STEP + cfg.startup.ramp + 1;
    assert_moves(FAULT_MEMORY);
    drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
    assert_moves(FAULT_NONE);
}

TEST(test_a_rotor_is_lost_for_no_longer_than_it_may_be)
{
    begin_in(DRIVE_STATE_IF_RAMP, DRIVE_MODE_SPEED);
    drive.start.lost_periods = cfg.startup.lost_periods;
    assert_moves(FAULT_NONE);
    drive.start.lost_periods++;
    assert_moves(FAULT_MEMORY);
}

/* The schedule goes on by itself after a count that is too long: a byte of ticks, and no more. */
TEST(test_no_flip_of_its_count_stops_the_slow_schedule)
{
    drive_t moment;

    power_on();
    moment = drive;
    for (uint32_t bit = 0U; bit < 8U; bit++) {
        uint32_t waited = 0U;

        drive = moment;
        drive.slow_count = (uint8_t)(drive.slow_count ^ (1U << bit));
        do {
            tick();
            waited++;
        } while ((drive.slow_count != cfg.slow_ticks) && (waited < LONG_TICKS));
        TEST_ASSERT_TRUE(waited <= 256U);
        ticks(1U);
        TEST_ASSERT_EQUAL_UINT8(cfg.slow_ticks - 1U, drive.slow_count);
    }
}

TEST(test_a_code_that_is_no_state_is_a_fault_in_its_tick_whatever_is_asked_for)
{
    for (uint32_t number = 0U; number < DRIVE_STATES; number++) {
        for (uint32_t bit = 0U; bit < 32U; bit++) {
            power_on();
            drive.state = (drive_state_t)((uint32_t)transitions_state(number) ^ (1UL << bit));
            in.command.request = DRIVE_REQUEST_RUN;
            tick();
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, drive.fault.id);
            assert_gates_open();
        }
    }
}

/* Also one that leaves no room for the slot that looks at it. */
TEST(test_each_flip_of_the_slow_period_itself_is_found)
{
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        cfg = example_drive_cfg_with_startup();
        power_on();
        cfg.slow_ticks ^= 1UL << bit;
        ticks(LONG_TICKS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, drive.fault.id);
    }
}
