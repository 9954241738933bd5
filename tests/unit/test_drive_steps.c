/* SPDX-License-Identifier: MIT */
/*
 * What a drive begins with: a start with anything left of the run before, an imposed current, the
 * change from one control to another and back.
 */
#include "seeded.h"
#include "testing.h"
#include "trig.h"

#include "any_state.h"
#include "placed_drive.h"

#include <math.h>

#define STALE (77U)        /* a count that something before has left */
#define TURN_LSB (3)       /* Park and its angle: 1 LSB each, and the rounding of the sine */
#define CONTROL_LSB (2)    /* the roundings of the soft control and of the firm one */
#define COMPARE_COUNTS (1) /* the rounding of a compare value */
/*
 * A fiftieth of the speed is missing: 113 LSB of proportional part; 1 of integral a period, and 1
 * for each of four roundings.
 */
#define MAGNITUDE_LSB (5)

/* ---- what a start begins with ---- */

/* READY, with anything in what no run keeps for the next one. */
static drive_t ready_with_anything_left(const drive_t *ready, seeded_t *seed)
{
    const drive_t any = any_state(seed, &cfg);
    const position_loop_t *const profile = &any.motion.position_loop;
    drive_t left = *ready;

    left.rotor = any.rotor;
    left.rotor.angle_sensor = ready->rotor.angle_sensor;
    left.rotor.source = ready->rotor.source;
    left.rotor.followed = ready->rotor.followed;
    left.rotor.aligned = ready->rotor.aligned;
    left.control = any.control;
    left.voltage_drive = any.voltage_drive;
    if (cfg.startup.current_hold != 0) { /* else these are never used */
        left.vector = any.vector;
        left.start = any.start;
    }
    left.watch = any.watch;
    left.watch.supervision.step = ready->watch.supervision.step;
    left.motion = any.motion;
    left.motion.mode = (uint8_t)seeded_in(seed, DRIVE_MODE_SPEED, DRIVE_MODE_TORQUE);
    left.motion.speed_loop.inertia_q17 = ready->motion.speed_loop.inertia_q17;
    left.motion.position_loop = ready->motion.position_loop; /* has a check word */
    position_loop_reset(&left.motion.position_loop, profile->profile_q32, profile->profile_speed);
    position_loop_set_zero(&left.motion.position_loop, profile->zero_q32);
    return left;
}

/* Without current, and its motion loops have measured nothing yet, whatever slot falls on its tick.
 */
static void assert_at_rest(const drive_t *started)
{
    static const control_t nothing = {.current_ref = {0, 0}};
    const int32_t most = cfg.derating.current_max;

    TEST_ASSERT_EQUAL_MEMORY(&nothing.ratio_acting, &started->control.ratio_acting, sizeof(ab_t));
    TEST_ASSERT_EQUAL_MEMORY(&nothing.ratio_next, &started->control.ratio_next, sizeof(ab_t));
    TEST_ASSERT_EQUAL_MEMORY(&nothing.current_ref, &started->control.current_ref, sizeof(dq_t));
    TEST_ASSERT_EQUAL_INT64(0, drive_position_q32(started));
    TEST_ASSERT_EQUAL_INT64(0, started->motion.position_loop.profile_q32);
    TEST_ASSERT_EQUAL_INT32(0, started->motion.position_loop.profile_speed);
    TEST_ASSERT_EQUAL_INT(DRIVE_MODE_SPEED, started->motion.mode);
    TEST_ASSERT_EQUAL_INT32(0, started->motion.speed_reference);
    TEST_ASSERT_EQUAL_INT32(0, started->motion.speed_loop.reference);
    TEST_ASSERT_EQUAL_UINT32(0U, started->motion.speed_loop.halvings);
    TEST_ASSERT_EQUAL_INT32(-most, started->motion.torque_range.lower);
    TEST_ASSERT_EQUAL_INT32(most, started->motion.torque_range.upper);
    TEST_ASSERT_EQUAL_INT32(0, started->rotor.observer.speed);
    TEST_ASSERT_EQUAL_INT32(0, started->rotor.residual);
    TEST_ASSERT_EQUAL_INT32(0, started->vector.step);
    TEST_ASSERT_EQUAL_INT32(drive.motor.model.flux_q30, started->motor.model.flux_q30);
}

static void assert_starts_afresh(drive_state_t state)
{
    seeded_t seed = {1U};

    power_on();
    in.command = (drive_command_t){.target = cfg.speed_loop.speed_max,
                                   .mode = (uint8_t)DRIVE_MODE_POSITION,
                                   .request = DRIVE_REQUEST_RUN};
    for (uint32_t k = 0U; k < (20U * cfg.slow_ticks); k++) {
        drive_t fresh = drive;
        drive_t other;

        fresh.slow_count = (uint8_t)(1U + (k % cfg.slow_ticks));
        other = ready_with_anything_left(&fresh, &seed);
        drive_step(&fresh, &in, &out);
        drive_step(&other, &in, &out);
        TEST_ASSERT_EQUAL_INT(state, fresh.state);
        assert_at_rest(&fresh);
        for (size_t i = 0U; i < STATE_WORDS_COUNT; i++) {
            const state_word_t *const word = &STATE_WORDS[i];

            TEST_ASSERT_EQUAL_MEMORY_MESSAGE((const char *)&fresh + word->offset,
                                             (const char *)&other + word->offset, word->size,
                                             word->name);
        }
    }
}

TEST(test_a_start_begins_at_rest_with_nothing_that_a_run_has_left)
{
    assert_starts_afresh(SEARCH);
    cfg.startup.current_hold = 0; /* nothing is imposed: RUN at once */
    assert_starts_afresh(RUN);
}

TEST(test_what_was_learned_of_j_is_forgotten_with_a_fault)
{
    drive.motion.speed_loop.inertia_q17 = 200000;
    stand_in(FAULT, 0);
    in.command.request = DRIVE_REQUEST_CLEAR;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
    TEST_ASSERT_EQUAL_INT32(131072, drive.motion.speed_loop.inertia_q17); /* that of the file */
}

TEST(test_no_slot_moves_a_drive_without_a_motion_loop)
{
    static const drive_state_t states[] = {DRIVE_STATE_READY, DRIVE_STATE_ALIGN, FAULT};

    in.command.target = cfg.speed_loop.speed_max;
    for (uint32_t k = 0U; k < COUNT(states); k++) {
        stand_in(states[k], 0);
        slot(SLOT_REFINE);
        slot(SLOT_PLAN);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_INT(states[k], drive.state);
        TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_reference);
        TEST_ASSERT_EQUAL_INT32(0, drive.vector.step);
    }
}

/* ---- the imposed current ---- */

/* One tick of a vector at rest at angle 0, with this current in its frame. */
static drive_t imposed(drive_t from, int32_t along, int32_t across)
{
    const double q = across * sqrt(3.0) / 2.0;

    in.adc_ia = (uint16_t)lround(2048.0 + (along / 8.0));
    in.adc_ib = (uint16_t)lround(2048.0 + ((q - (along / 2.0)) / 8.0));
    drive_step(&from, &in, &out);
    TEST_ASSERT_EQUAL_INT(HOLD, from.state);
    return from;
}

static dq_t voltage_with(int32_t along_max, int32_t across_max, int32_t sign)
{
    cfg.startup.along_max = along_max;
    cfg.startup.across_max = across_max;
    return imposed(drive, sign * 12800, sign * 7200).control.voltage;
}

/* What K_p of RUN makes of 500 beyond each limit, on top of the soft control. */
TEST(test_an_imposed_current_is_controlled_firmly_beyond_its_limits_alone)
{
    const pi_cfg_t *const firm = &cfg.current_loop.pi_d; /* pi_q is the same */

    stand_in(HOLD, 0);
    drive.motor.model.inductance_q14 = 8192;
    drive.motor.model.saliency_q14 = 24576;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const dq_t soft = voltage_with(16384, 16384, sign);
        const sample_t i = instant_sample(&drive, &in);
        const dq_t frame = transforms_park(transforms_clarke(i.phase_a, i.phase_b), trig_sincos(0));
        const dq_t held = voltage_with(fx_abs(frame.d) - 500, fx_abs(frame.q) - 500, sign);
        const int32_t whole = sign * ((500 * firm->kp) >> firm->kp_shift);

        TEST_ASSERT_INT32_WITHIN(CONTROL_LSB, whole / 2,
                                 soft.d - held.d); /* half of L_d, 3/4 of L_q */
        TEST_ASSERT_INT32_WITHIN(CONTROL_LSB, (whole * 3) / 4, soft.q - held.q);
    }
}

/* Counts by which the compensation drives the leg of phase a longer. */
static int32_t compensated_a(int32_t reference, int32_t measured)
{
    drive_t from = drive;
    int32_t plain;

    from.control.current_ref.d = reference - cfg.startup.current_slope; /* of the tick */
    from.vector.current_mean.d = measured;
    cfg.modulator = example_modulator_cfg();
    (void)imposed(from, measured, 0);
    plain = out.compare.phase[0];
    cfg.modulator = example_modulator_cfg_with_dead_time();
    from.modulator.dead_time_q15 = cfg.modulator.dead_time_q15;
    (void)imposed(from, measured, 0);
    return out.compare.phase[0] - plain;
}

/* Else the dead time would keep the current at zero, and zero current the compensation. */
TEST(test_an_imposed_current_is_compensated_before_it_flows_and_follows_a_swing)
{
    stand_in(HOLD, 0);
    TEST_ASSERT_TRUE(compensated_a(4000, 0) > 0);
    TEST_ASSERT_INT32_WITHIN(COMPARE_COUNTS, compensated_a(4000, 4000), compensated_a(4000, 0));
    TEST_ASSERT_TRUE(compensated_a(4000, -8000) < 0);
    TEST_ASSERT_INT32_WITHIN(COMPARE_COUNTS, 0, compensated_a(4000, -4000));
}

/* ---- from the vector to the rotor and back ---- */

static void leave_a_swing_in_the_filter(void)
{
    drive.motion.torque_filter =
        (torque_filter_t){.origin = 1, .smooth_q26 = 2, .swing_q26 = {3, 4}};
}

static void assert_filter_begins_with(int32_t current)
{
    TEST_ASSERT_EQUAL_INT32(current, drive.motion.torque_filter.origin);
    TEST_ASSERT_EQUAL_INT32(current * 2048, drive.motion.torque_filter.smooth_q26);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_filter.swing_q26.d);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_filter.swing_q26.q);
}

/*
 * The tick of a hand-over under a ramp. The vector of 3000 lies 30° ahead of the rotor. Returns the
 * torque of the ramp.
 */
static int32_t hand_over_with(step_t ramp)
{
    speed_loop_t before;

    begin();
    stand_in(HANDOVER, cfg.startup.handover_speed);
    drive.motion.speed_reference += ramp;
    drive.vector.position.turns_q32 = 357913941; /* 2^32/12 */
    drive.rotor.position.turns_q32 = 0;
    drive.control.current_ref.d = 3000 - cfg.startup.current_slope; /* of the tick */
    drive.motion.torque_loop.bridging = true;
    leave_a_swing_in_the_filter();
    before = drive.motion.speed_loop;
    drive.slow_count = 1U; /* SPEED */
    tick();
    TEST_ASSERT_EQUAL_INT(RUN, drive.state);
    return speed_loop_accelerate(&before, &cfg.speed_loop, drive.motion.speed_reference,
                                 drive.motion.torque_range);
}

TEST(test_run_begins_with_the_torque_that_acts_and_takes_what_is_not_the_ramps_for_a_load)
{
    const double cos_30 = 0.8660254037844387;

    for (int32_t k = 0; k < 2; k++) {
        const int32_t of_ramp = hand_over_with(k * cfg.startup.ramp);
        const dq_t current = drive.control.current_ref;

        TEST_ASSERT_EQUAL((k > 0), (of_ramp > 50));
        TEST_ASSERT_INT32_WITHIN(TURN_LSB, lround(1500.0 + (of_ramp * cos_30)), current.q);
        TEST_ASSERT_INT32_WITHIN(TURN_LSB, lround((3000.0 * cos_30) - (of_ramp / 2.0)), current.d);
        TEST_ASSERT_EQUAL_INT32(current.q - of_ramp, pi_output(&drive.motion.speed_loop.pi));
        TEST_ASSERT_FALSE(drive.motion.torque_loop.bridging);
        assert_filter_begins_with(current.q);
    }
}

/* To the tick before the one that hands back. */
static void run_to_the_eve_of_the_hand_back(void)
{
    drive_t drive_before;
    example_motor_t motor_before;

    run_to(RUN, 600.0);
    in.command.target = 0;
    load_nm = 2.0;
    do {
        drive_before = drive;
        motor_before = motor;
        tick();
    } while ((drive.tick < PATIENCE_TICKS) && (drive.state == RUN));
    TEST_ASSERT_EQUAL_INT(HOLD, drive.state);
    drive = drive_before;
    motor = motor_before;
}

/* The imposed current has faded in. In space it stays where it is, ahead of the rotor. */
TEST(test_the_hand_back_begins_with_what_flows_and_nothing_older)
{
    supervision_t *const supervision = &drive.watch.supervision;
    const dq_t *const mean = &drive.vector.current_mean;
    sample_t i;
    dq_t flows;
    int64_t turned;
    double ahead;

    run_to_the_eve_of_the_hand_back();
    drive.vector.current_mean = (dq_t){2, 2};
    supervision->absent = 1U;
    supervision->absent_periods = STALE;
    supervision->unexplained = STALE;
    turned = -drive.rotor.position.turns_q32;
    tick();
    TEST_ASSERT_EQUAL_INT(HOLD, drive.state);
    turned += drive.vector.position.turns_q32 - drive.vector.step; /* at the instant of the tick */
    ahead = 2.0 * EXAMPLE_PI * (double)turned / 4294967296.0;
    TEST_ASSERT_TRUE((ahead > 0.05) && (ahead < 0.5)); /* 2 N·m take 1.7 A of 8 A */
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, cfg.startup.current_hold,
                             lround(drive.control.current_ref.d * cos(ahead)));
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, 0, drive.control.current_ref.q);
    i = instant_sample(&drive, &in);
    flows = transforms_park(
        transforms_clarke(i.phase_a, i.phase_b),
        trig_sincos(rotor_position_angle(&drive.vector.position) - fx_unsigned(drive.vector.step)));
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, flows.d, mean->d);
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, flows.q, mean->q);
    TEST_ASSERT_EQUAL_INT32(drive.motion.speed_loop.reference, drive.vector.step);
    TEST_ASSERT_EQUAL_UINT32(SUPERVISION_PHASES, supervision->absent);
    TEST_ASSERT_EQUAL_UINT32(0U, supervision->absent_periods);
    TEST_ASSERT_EQUAL_UINT32(0U, supervision->unexplained);
}

/* ---- what the observer is told ---- */

static int32_t residual_in(drive_state_t state, step_t vector)
{
    stand_in(state, vector);
    drive.rotor.observer.rotated_error = (dq_t){.d = -800, .q = 1600};
    drive.rotor.residual = 0;
    slot(SLOT_REFINE);
    return drive.rotor.residual;
}

/* At rest a leg without current lies along q. The filter takes an eighth of it. */
TEST(test_the_residual_is_that_across_the_flux_and_at_rest_that_along_the_vector)
{
    TEST_ASSERT_EQUAL_INT32(100, residual_in(HOLD, 0));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(HOLD, 1));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(IF_RAMP, 0));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(HANDOVER, 0));
}

/* The sign of rho, which is that of the speed that sets it. The opposite speed is asked for. */
static int32_t sign_of_rho(step_t own)
{
    stand_in(RUN, own);
    speed_loop_reset(&drive.motion.speed_loop, -own);
    slot(SLOT_REFINE);
    return (drive.rotor.observer.rho_q13 > 0) - (drive.rotor.observer.rho_q13 < 0);
}

TEST(test_the_static_part_follows_the_estimate_from_twice_the_hand_over_speed_on)
{
    const step_t fast = 2 * cfg.startup.handover_speed;

    TEST_ASSERT_EQUAL_INT32(1, sign_of_rho(fast));
    TEST_ASSERT_EQUAL_INT32(-1, sign_of_rho(fast - 1));
    TEST_ASSERT_EQUAL_INT32(-1, sign_of_rho(-fast));
    TEST_ASSERT_EQUAL_INT32(1, sign_of_rho(1 - fast));
}

/* ---- the voltage drive's periods ---- */

static void offer_voltage_drive(step_t speed)
{
    cfg.voltage_drive = example_voltage_drive_cfg();
    stand_in(RUN, speed);
    speed_loop_start(&drive.motion.speed_loop, speed, 1000);
    in.command.target = speed;
    drive.control.current_ref = (dq_t){0, 1000};
    now.along_rotor = drive.control.current_ref;
}

/* With the rotor a fiftieth too slow. */
TEST(test_the_voltage_drive_takes_over_after_its_periods_with_the_voltage_that_acts)
{
    int32_t begun;

    offer_voltage_drive(2 * example_voltage_drive_cfg().speed_min);
    pi_reset(&drive.control.current_loop.pi_q, 8000);
    drive.rotor.observer.speed -= drive.rotor.observer.speed / 50;
    drive.voltage_drive.end_periods = STALE;
    for (uint32_t k = 1U; k < cfg.voltage_drive.settle_periods; k++) {
        slot(SLOT_SPEED);
        now.along_rotor = drive.control.current_ref;
        TEST_ASSERT_EQUAL_UINT32(k, drive.voltage_drive.calm_periods);
        TEST_ASSERT_FALSE(drive.voltage_drive.active);
    }
    slot(SLOT_SPEED);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.voltage_drive.end_periods);
    begun = drive.voltage_drive.magnitude;
    TEST_ASSERT_TRUE(begun >= 8000);
    slot(SLOT_SPEED);
    TEST_ASSERT_INT32_WITHIN(MAGNITUDE_LSB, begun, drive.voltage_drive.magnitude);
}

/* Also while the rotor is already as fast as the command asks. */
TEST(test_the_voltage_drive_waits_for_the_speed_that_its_loop_is_asked_for)
{
    const step_t least = example_voltage_drive_cfg().speed_min;

    for (uint32_t k = 0U; k < 2U; k++) {
        offer_voltage_drive(least);
        drive.motion.speed_reference = least - ((k == 0U) ? 1 : 0);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_UINT32(k, drive.voltage_drive.calm_periods);
    }
}

TEST(test_the_voltage_drive_gives_back_after_its_periods_with_the_torque_that_acts)
{
    offer_voltage_drive(2 * example_voltage_drive_cfg().speed_min);
    leave_a_swing_in_the_filter();
    drive.voltage_drive.active = true;
    drive.voltage_drive.calm_periods = STALE;
    drive.control.current_ref = (dq_t){0, 0};
    virtual_resistance_start(&drive.voltage_drive.damping, (dq_t){0, 1000});
    drive.control.voltage = (dq_t){8000, 100}; /* the lead is at its end towards braking */
    for (uint32_t k = 1U; k < cfg.voltage_drive.settle_periods; k++) {
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_UINT32(k, drive.voltage_drive.end_periods);
        TEST_ASSERT_TRUE(drive.voltage_drive.active);
    }
    slot(SLOT_SPEED);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.voltage_drive.calm_periods);
    TEST_ASSERT_EQUAL_INT32(1000, drive.control.current_ref.q);
    assert_filter_begins_with(1000);
    drive.voltage_drive.active = true;
    drive.motion.speed_reference = 0; /* too slow: at once */
    slot(SLOT_SPEED);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
}
