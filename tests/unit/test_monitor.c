/* SPDX-License-Identifier: MIT */
/* What the checks look at in each state, and what they excuse. */
#include "testing.h"

#include "placed_drive.h"

#define SETTLED_TICKS (10000U)
#define SWING_TICKS (7000U)  /* 20 half-waves of 250, and those before the first one that counts */
#define STALE_CURRENT (8000) /* 9.8 A, above the continuous current */

/* The check of this number, of those that take turns. */
static void look(uint32_t check)
{
    drive.watch.supervision.step = check;
    slot(SLOT_CHECKS);
}

/* Held at rest with an imposed current of 5000: what one look adds to the sum of the errors. */
static dq_t held_error_with(int32_t d, int32_t q)
{
    stand_in(HOLD, 0);
    supervision_reset(&drive.watch.supervision);
    drive.control.current_ref = (dq_t){5000, 0};
    now.along_vector = (dq_t){d, q};
    look(2U);
    return drive.watch.supervision.off_current;
}

TEST(test_at_rest_half_of_what_the_imposed_current_lacks_counts_and_nothing_of_what_a_swing_adds)
{
    TEST_ASSERT_EQUAL_INT32(500, held_error_with(4000, 0).d);
    TEST_ASSERT_EQUAL_INT32(0, held_error_with(6000, 0).d);
    TEST_ASSERT_EQUAL_INT32(-500, held_error_with(5000, 1000).q);
    TEST_ASSERT_EQUAL_INT32(500, held_error_with(5000, -1000).q);
}

/* What one look at these phases adds to the heat. */
static int32_t warmth(drive_state_t state, int32_t a, int32_t b)
{
    stand_in(state, 0);
    drive_warm(&drive, 1000000);
    now.sample.phase_a = a;
    now.sample.phase_b = b;
    look(0U);
    return drive.derating.heat_q24 - 1000000;
}

/* As in a short circuit, or through the diodes. */
TEST(test_a_current_that_nothing_controls_heats_as_one_that_is_controlled)
{
    int32_t controlled;

    now.along_rotor = (dq_t){0, STALE_CURRENT};
    controlled = warmth(RUN, 0, 0);
    TEST_ASSERT_TRUE(controlled > 0);
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(HOLD, 0, 0));
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(DRIVE_STATE_ALIGN, 0, 0));
    TEST_ASSERT_TRUE(warmth(DRIVE_STATE_READY, 0, 0) < 0);
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(DRIVE_STATE_READY, 8000, -4000));
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(FAULT, -8000, 4000));
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(DRIVE_STATE_FLYING_START, 8000, -4000));
    TEST_ASSERT_EQUAL_INT32(controlled, warmth(DRIVE_STATE_OFFSET_CAL, 8000, -4000));
}

/* With open gates it is the sensor that reads so. */
TEST(test_a_current_beyond_the_range_of_its_converter_heats_a_shorted_motor_as_the_largest)
{
    const int32_t measured = warmth(FAULT, 16000, -8000);

    for (uint32_t k = 0U; k < 4U; k++) {
        const uint16_t end = ((k % 2U) == 0U) ? 0U : 4095U;

        in.adc_ia = (k < 2U) ? end : MID_COUNTS;
        in.adc_ib = (k < 2U) ? MID_COUNTS : end;
        drive.safe_state.phase = SAFE_STATE_SHORT;
        TEST_ASSERT_TRUE(warmth(FAULT, 100, 100) > measured);
        drive.safe_state.phase = SAFE_STATE_OPEN;
        TEST_ASSERT_TRUE(warmth(DRIVE_STATE_READY, 16000, -8000) < 0);
    }
}

/*
 * Phase a stands still and b swings for four half turns of the rotor, of the vector, or of both. A
 * half turn has ten samples, an arc 8 at least.
 */
static fault_id_t dead_phase_in(drive_state_t state, int32_t of_rotor, int32_t of_vector)
{
    const int64_t tenth = (2LL * QUARTER) / 10;

    begin();
    stand_in(state, 0);
    for (int32_t k = 0; k < 40; k++) {
        now.sample.phase_b = ((k % 2) == 0) ? STALE_CURRENT : -STALE_CURRENT;
        slot(SLOT_PHASES);
        drive.rotor.position.turns_q32 += of_rotor * tenth;
        drive.vector.position.turns_q32 += of_vector * tenth;
    }
    return drive.fault.id;
}

/* In RUN the rotor's angle counts, below it that of the vector, which the other has not to follow.
 */
TEST(test_phases_are_watched_over_the_turns_of_what_turns_in_this_state)
{
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, dead_phase_in(RUN, 1, 0));
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, dead_phase_in(RUN, -1, 0));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, dead_phase_in(RUN, 0, 1));
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, dead_phase_in(IF_RAMP, 0, 1));
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, dead_phase_in(IF_RAMP, 0, -1));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, dead_phase_in(IF_RAMP, 1, 0));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, dead_phase_in(DRIVE_STATE_READY, 1, 1));
}

/* Looks so often at this voltage in the integrals, of a frame at this speed. */
static drive_state_t look_at_voltage(drive_state_t state, step_t speed, int32_t voltage,
                                     uint32_t periods)
{
    begin();
    stand_in(state, speed);
    pi_reset(&drive.control.current_loop.pi_q, voltage);
    slots(SLOT_PHASES, periods);
    return drive.state;
}

/* A quarter of Ω_b, 2^26 steps per tick, in either direction. */
TEST(test_the_check_of_an_imposed_current_allows_the_whole_emf_in_either_direction)
{
    const int32_t most = cfg.supervision.voltage_max;
    const int32_t with_emf = most + ((8192 * cfg.hold_loop.emf_q13) / 8192);
    const uint32_t many = cfg.supervision.swing_periods;

    TEST_ASSERT_EQUAL_INT(RUN, look_at_voltage(RUN, 0, 2 * most, 2U * many)); /* not of a run */
    TEST_ASSERT_EQUAL_INT(FAULT, look_at_voltage(IF_RAMP, 0, 2 * most, 2U * many));
    for (step_t speed = -8192 * 2048; speed <= (8192 * 2048); speed += 2 * 8192 * 2048) {
        TEST_ASSERT_EQUAL_INT(IF_RAMP, look_at_voltage(IF_RAMP, speed, with_emf, 2U * many));
        TEST_ASSERT_EQUAL_INT(IF_RAMP, look_at_voltage(IF_RAMP, speed, with_emf + 1, many));
        TEST_ASSERT_EQUAL_INT(FAULT, look_at_voltage(IF_RAMP, speed, with_emf + 1, many + 1U));
        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_IMPLAUSIBLE, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(with_emf + 1, drive.fault.value);
        TEST_ASSERT_EQUAL_INT32(with_emf, drive.fault.limit);
    }
}

/* In RUN with an integral far beyond what its voltage may be off, for longer than that may last. */
static fault_id_t run_with_a_large_voltage(oscillation_act_t act, uint32_t halves,
                                           bool voltage_drive)
{
    begin();
    stand_in(RUN, 0);
    cfg.oscillation.act = (uint32_t)act;
    drive.watch.oscillation.halves = halves;
    drive.voltage_drive.active = voltage_drive;
    pi_reset(&drive.control.current_loop.pi_q, 32000);
    for (uint32_t k = 0U; k < (2U << cfg.supervision.mean_shift); k++) {
        look(2U);
    }
    return drive.fault.id;
}

/* The voltage drive has no integrals. The check of swings names them, where there is one. */
TEST(test_a_large_voltage_of_a_run_is_a_fault_unless_the_voltage_drive_acts_or_the_motion_swings)
{
    const fault_id_t bad = FAULT_CURRENT_IMPLAUSIBLE;

    TEST_ASSERT_EQUAL_INT(bad, run_with_a_large_voltage(OSCILLATION_ACT_FAULT, 1U, false));
    TEST_ASSERT_EQUAL_INT(bad, run_with_a_large_voltage(OSCILLATION_ACT_NONE, 2U, false));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, run_with_a_large_voltage(OSCILLATION_ACT_FAULT, 2U, false));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, run_with_a_large_voltage(OSCILLATION_ACT_FAULT, 0U, true));
}

static fault_id_t stand_with(int32_t torque)
{
    begin();
    stand_in(RUN, 0);
    drive.motion.torque_range = (torque_range_t){-8192, 8192};
    drive.control.current_ref.q = torque;
    for (uint32_t k = 0U; k <= cfg.supervision.stall_periods; k++) {
        look(3U);
    }
    return drive.fault.id;
}

/* In either direction, and not with one LSB to spare. */
TEST(test_a_stall_is_told_from_either_limit_of_the_torque)
{
    TEST_ASSERT_EQUAL_INT(FAULT_STALL, stand_with(8192));
    TEST_ASSERT_EQUAL_INT(FAULT_STALL, stand_with(-8192));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, stand_with(8191));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, stand_with(-8191));
}

/* A motor at 600 rpm, and what is done about a swing. */
static void run_with(oscillation_act_t act)
{
    cfg.oscillation.act = (uint32_t)act;
    begin();
    run_to(RUN, 600.0);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.watch.oscillation.now); /* nothing is looked for below RUN */
    ticks(SETTLED_TICKS);
}

/* of the torque, once the swing is steady */
static int32_t highest;
static int32_t lowest;

/* Whether a load that swings with 20 Hz is a fault, and that of a swing, within so many ticks. */
static bool swings(uint32_t most)
{
    for (uint32_t k = 0U; (k < most) && (drive.state == RUN); k++) {
        load_nm = ((k % 500U) < 250U) ? 2.0 : -2.0;
        tick();
        highest = (k < 1000U) ? 0 : fx_max(highest, drive.control.current_ref.q);
        lowest = (k < 1000U) ? 0 : fx_min(lowest, drive.control.current_ref.q);
    }
    TEST_ASSERT_EQUAL_INT((drive.state == RUN) ? FAULT_NONE : FAULT_OSCILLATION, drive.fault.id);
    return drive.state != RUN;
}

TEST(test_a_swing_in_run_is_a_fault_with_its_amplitude_where_it_is_looked_for)
{
    run_with(OSCILLATION_ACT_NONE);
    TEST_ASSERT_FALSE(swings(2U * SWING_TICKS));
    run_with(OSCILLATION_ACT_FAULT);
    TEST_ASSERT_TRUE(swings(SWING_TICKS));
    TEST_ASSERT_EQUAL_INT32(cfg.oscillation.amplitude_max, drive.fault.limit);
    TEST_ASSERT_EQUAL_INT32((highest - lowest) / 2, drive.fault.value);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
}

TEST(test_a_swing_lowers_the_bandwidth_once_where_that_is_configured)
{
    run_with(OSCILLATION_ACT_LOWER);
    TEST_ASSERT_FALSE(swings(SWING_TICKS));
    TEST_ASSERT_EQUAL_UINT32(1U, drive.motion.speed_loop.halvings);
    TEST_ASSERT_TRUE(swings(SWING_TICKS));
}

/* Its speed loop is another one, so there is nothing to lower. */
TEST(test_a_swing_of_the_voltage_drive_is_a_fault_at_once)
{
    cfg.voltage_drive = example_voltage_drive_cfg();
    run_with(OSCILLATION_ACT_LOWER);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    TEST_ASSERT_TRUE(swings(SWING_TICKS));
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
}

/* The reference of the speed follows the measured position. Only the profile is asked for. */
TEST(test_a_swing_in_position_control_is_found_while_the_profile_rests_and_only_then)
{
    run_with(OSCILLATION_ACT_FAULT);
    in.command.mode = (uint8_t)DRIVE_MODE_POSITION;
    in.command.target = INT32_MAX; /* far away: at the profile's largest speed */
    ticks(SETTLED_TICKS);
    TEST_ASSERT_TRUE(swings(SWING_TICKS));
    run_with(OSCILLATION_ACT_FAULT);
    in.command.mode = (uint8_t)DRIVE_MODE_POSITION;
    for (uint32_t k = 0U; k < 20U; k++) {
        in.command.target = ((k % 2U) == 0U) ? INT32_MAX : INT32_MIN; /* on its ramp all the time */
        TEST_ASSERT_FALSE(swings(1000U));
    }
}
