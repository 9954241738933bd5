/* SPDX-License-Identifier: MIT */
/*
 * Start-up and low speed without a sensor, where a run comes by seldom: what follows at the ends of
 * the ranges, and after starts that have failed. test_low_speed has the runs.
 */
#include "testing.h"

#include "placed_drive.h"

#include <math.h>

#define STALE (77U)           /* a count that something before has left */
#define CAUGHT_RAD_S (125.66) /* 600 rpm */

/* ---- the imposed current ---- */

/* 8192 / 65 ticks of slope, behind a look at the temperature each 40 ticks. */
static void assert_imposed_becomes(int32_t expected)
{
    for (uint32_t k = 0U; k < 200U; k++) {
        const int32_t before = drive.control.current_ref.d;

        tick();
        TEST_ASSERT_INT32_WITHIN(cfg.startup.current_slope, before, drive.control.current_ref.d);
    }
    TEST_ASSERT_EQUAL_INT32(expected, drive.control.current_ref.d);
}

TEST(test_an_imposed_current_is_that_of_rest_or_of_motion_within_what_the_winding_bears)
{
    run_to(HOLD, 0.0);
    assert_imposed_becomes(cfg.startup.current_hold);
    in.adc_temperature = 1998U; /* 50 counts below the end: 1000 of 8192 */
    assert_imposed_becomes(1000);
    in.adc_temperature = 0U;
    run_to(IF_RAMP, 100.0);
    assert_imposed_becomes(cfg.startup.current_move);
    in.adc_temperature = 1998U;
    assert_imposed_becomes(1000);
    in.adc_temperature = 2048U;
    assert_imposed_becomes(0);
}

/* ---- where a start leads ---- */

/* A slow period's end: what vector and observer are like, and what has been counted. */
typedef struct {
    drive_state_t state;
    step_t vector; /* speed of the vector */
    step_t slip;   /* the rotor is so much slower */
    int64_t ahead; /* the vector is ahead of the rotor by this angle */
    int32_t residual;
    uint32_t attempts;
    bool unknown;    /* R was not measured */
    uint32_t waited; /* periods in HANDOVER */
    uint32_t lost;   /* periods */
} period_t;

/* Returns the state that follows. */
static drive_state_t after(period_t period)
{
    bool failed;

    stand_in(period.state, period.vector);
    know_motor(!period.unknown);
    drive.rotor.observer.speed = period.vector - period.slip;
    drive.rotor.position.turns_q32 = QUARTER;
    drive.vector.position.turns_q32 = QUARTER + period.ahead;
    drive.rotor.residual = period.residual;
    drive.start.attempts = period.attempts;
    drive.start.handover_periods = period.waited;
    drive.start.lost_periods = period.lost;
    slot(SLOT_SPEED);
    failed = (drive.state == SEARCH) || (drive.state == FAULT);
    TEST_ASSERT_EQUAL_UINT32(period.attempts + (failed ? 1U : 0U), drive.start.attempts);
    return drive.state;
}

TEST(test_the_observer_takes_over_when_it_turns_with_the_vector_and_explains_the_current)
{
    const step_t fast = cfg.startup.handover_speed;
    const step_t half = fast / 2;
    const int64_t sixth = 715827882; /* 2^32/6 = 715827882.7 */
    const int32_t most = cfg.startup.residual_max;

    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .slip = half - 1}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .slip = half}));
    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .slip = 1 - half}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .slip = -half}));
    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .ahead = sixth - 1}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .ahead = sixth}));
    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .ahead = -sixth}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .ahead = -sixth - 1}));
    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .residual = most - 1}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .residual = most}));
    cfg.startup.settle_periods = 3U;
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){HANDOVER, fast, .waited = 2U}));
    TEST_ASSERT_EQUAL_UINT32(3U, drive.start.handover_periods);
    TEST_ASSERT_EQUAL_INT(RUN, after((period_t){HANDOVER, fast, .waited = 3U}));
}

TEST(test_a_vector_is_held_dragged_or_handed_over_by_its_speed)
{
    const step_t fast = cfg.startup.handover_speed;

    TEST_ASSERT_EQUAL_INT(HOLD, after((period_t){.state = HOLD}));
    TEST_ASSERT_EQUAL_INT(HOLD, after((period_t){.state = IF_RAMP}));
    TEST_ASSERT_EQUAL_INT(HOLD, after((period_t){IF_RAMP, .unknown = true}));
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, after((period_t){HOLD, .unknown = true}));
    TEST_ASSERT_EQUAL_INT(IF_RAMP, after((period_t){HOLD, .vector = -1}));
    TEST_ASSERT_EQUAL_INT(IF_RAMP, after((period_t){HANDOVER, .vector = fast - 1}));
    TEST_ASSERT_EQUAL_INT(IF_RAMP, after((period_t){IF_RAMP, .vector = 1 - fast}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){IF_RAMP, .vector = -fast}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){IF_RAMP, fast, .waited = STALE}));
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.handover_periods);
}

TEST(test_a_rotor_that_slipped_is_not_handed_over_before_it_has_stood)
{
    const step_t fast = cfg.startup.handover_speed;

    TEST_ASSERT_EQUAL_INT(IF_RAMP,
                          after((period_t){IF_RAMP, fast, .attempts = 1U, .unknown = true}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){IF_RAMP, fast, .unknown = true}));
    TEST_ASSERT_EQUAL_INT(HANDOVER, after((period_t){IF_RAMP, fast, .attempts = 1U}));
}

static void assert_start_failed(int32_t value, int32_t limit)
{
    TEST_ASSERT_EQUAL_INT(FAULT_STARTUP, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(value, drive.fault.value);
    TEST_ASSERT_EQUAL_INT32(limit, drive.fault.limit);
}

TEST(test_an_observer_that_is_late_begins_the_start_again_and_is_a_fault_in_the_end)
{
    const uint32_t last = cfg.startup.attempts - 1U;
    period_t period = {HANDOVER, .vector = cfg.startup.handover_speed};

    period.residual = cfg.startup.residual_max;
    period.waited = cfg.startup.handover_periods - 2U;
    TEST_ASSERT_EQUAL_INT(HANDOVER, after(period));
    period.waited++;
    TEST_ASSERT_EQUAL_INT(SEARCH, after(period));
    period.attempts = last - 1U;
    TEST_ASSERT_EQUAL_INT(SEARCH, after(period));
    period.attempts = last;
    TEST_ASSERT_EQUAL_INT(FAULT, after(period));
    assert_start_failed(period.residual, cfg.startup.residual_max);
}

static uint32_t lost_after(int32_t residual, uint32_t lost)
{
    TEST_ASSERT_EQUAL_INT(HOLD, after((period_t){HOLD, .residual = residual, .lost = lost}));
    return drive.start.lost_periods;
}

TEST(test_a_rotor_is_lost_when_periods_above_the_limit_outweigh_those_below)
{
    const int32_t most = cfg.startup.residual_lost;
    const uint32_t last = cfg.startup.lost_periods - 1U;
    const step_t trained = cfg.startup.track_speed;
    period_t period = {HOLD, .residual = most + 1, .lost = last};

    TEST_ASSERT_EQUAL_UINT32(last, lost_after(most + 1, last - 1U));
    TEST_ASSERT_EQUAL_UINT32(last - 1U, lost_after(most, last));
    TEST_ASSERT_EQUAL_UINT32(0U, lost_after(most, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, lost_after(most, 0U));
    TEST_ASSERT_EQUAL_INT(SEARCH, after(period));
    period.attempts = cfg.startup.attempts - 1U;
    TEST_ASSERT_EQUAL_INT(FAULT, after(period));
    assert_start_failed(most + 1, most);
    period = (period_t){IF_RAMP, .vector = trained - 1, .residual = most + 1, .lost = last};
    TEST_ASSERT_EQUAL_INT(IF_RAMP, after(period));
    period.vector = trained;
    TEST_ASSERT_EQUAL_INT(SEARCH, after(period));
    period.vector = -trained;
    TEST_ASSERT_EQUAL_INT(SEARCH, after(period));
}

/* It may be lost again at once: RUN lasts when it is 100 times as long as a rotor is lost for. */
TEST(test_failed_starts_are_forgotten_when_run_has_lasted_and_not_before)
{
    cfg.startup.lost_periods = 2U;
    stand_in(RUN, cfg.startup.handover_speed);
    slots(SLOT_SPEED, 10U); /* no start has failed: nothing is counted */
    drive.start.attempts = 4U;
    slots(SLOT_SPEED, 199U);
    TEST_ASSERT_EQUAL_UINT32(4U, drive.start.attempts);
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.attempts);
}

/* The next reference of a vector at `present`, when any speed is asked for. */
static step_t reference_from(step_t present, uint32_t attempts, bool identified)
{
    stand_in(IF_RAMP, present);
    know_motor(identified);
    drive.start.attempts = attempts;
    in.command.target = cfg.speed_loop.speed_max;
    slot(SLOT_PLAN);
    return drive.motion.speed_reference;
}

TEST(test_a_rotor_that_slipped_is_brought_to_rest_before_it_obeys)
{
    const step_t ramp = cfg.startup.ramp;
    const step_t present = 4 * ramp;

    TEST_ASSERT_EQUAL_INT32(present - ramp, reference_from(present, 1U, false));
    TEST_ASSERT_EQUAL_INT32(ramp - present, reference_from(-present, 1U, false));
    TEST_ASSERT_EQUAL_INT32(0, reference_from(0, 1U, false));
    TEST_ASSERT_EQUAL_INT32(present + ramp, reference_from(present, 0U, false));
    TEST_ASSERT_EQUAL_INT32(present + ramp, reference_from(present, 1U, true));
}

/* ---- the alignment ---- */

static void run_to_measurement(align_phase_t phase)
{
    run_to(DRIVE_STATE_ALIGN, 0.0);
    while ((drive.state == DRIVE_STATE_ALIGN) && (drive.start.align.phase != phase)) {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, drive.state);
}

/* What follows a measurement in which the largest current across the vector was this one. */
static drive_state_t after_swing(align_phase_t phase, int32_t swing, uint32_t attempts)
{
    begin();
    run_to_measurement(phase);
    drive.start.attempts = attempts;
    drive.start.align.swing = swing;
    drive.start.align.swing_bound = 0; /* it was given time to calm down */
    for (uint32_t k = 0U; k < (1UL << cfg.startup.align.measure_log2); k++) {
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, drive.state);
        TEST_ASSERT_EQUAL_INT(phase, drive.start.align.phase);
        tick();
    }
    return drive.state;
}

TEST(test_a_rotor_that_does_not_rest_is_looked_for_after_the_measurement_that_shows_it)
{
    const int32_t most = cfg.startup.align.swing_max;
    const uint32_t last = cfg.startup.attempts - 1U;

    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, after_swing(ALIGN_MEASURE_HIGH, most, last));
    TEST_ASSERT_EQUAL_INT(ALIGN_INDUCTANCE, drive.start.align.phase);
    TEST_ASSERT_EQUAL_INT(SEARCH, after_swing(ALIGN_MEASURE_HIGH, most + 1, 0U));
    TEST_ASSERT_EQUAL_UINT32(1U, drive.start.attempts);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, after_swing(ALIGN_MEASURE_LOW, most, last));
    TEST_ASSERT_EQUAL_INT(SEARCH, after_swing(ALIGN_MEASURE_LOW, most + 1, last - 1U));
    TEST_ASSERT_EQUAL_UINT32(last, drive.start.attempts);
    TEST_ASSERT_FALSE(drive.motor.identified);
    TEST_ASSERT_EQUAL_INT(FAULT, after_swing(ALIGN_MEASURE_LOW, most + 1, last));
    assert_start_failed(most + 1, most);
}

TEST(test_an_alignment_without_an_inductance_leaves_the_model_and_is_not_repeated)
{
    run_to_measurement(ALIGN_MEASURE_LOW);
    drive.start.align.inductance.step.change = (dq_t){0, 0};
    speed_loop_lower(&drive.motion.speed_loop); /* as if a rotor had been caught */
    run_to(HOLD, 0.0);
    TEST_ASSERT_TRUE(drive.motor.identified);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
    TEST_ASSERT_EQUAL_INT32(16384, drive.motor.model.resistance_q14); /* as in the file */
}

/*
 * The inverter loses nothing, so all of the compensation is too much. A vector off the axis of
 * phase a loads the legs otherwise: after a catch the rotor is held where it came to rest.
 */
TEST(test_what_the_alignment_finds_lost_corrects_the_dead_time_within_its_limits)
{
    cfg.modulator = example_modulator_cfg_with_dead_time();
    cfg.modulator.dead_time_band_q15 = 245;
    begin();
    run_to(HOLD, 0.0);
    TEST_ASSERT_EQUAL_INT32(655 - 245, drive.modulator.dead_time_q15);
    begin();
    motor = example_motor_at(1.0, CAUGHT_RAD_S);
    run_to(RUN, 600.0);
    run_to(DRIVE_STATE_ALIGN, 0.0);
    run_to(HOLD, 0.0);
    TEST_ASSERT_TRUE(drive.motor.identified);
    TEST_ASSERT_EQUAL_INT32(655, drive.modulator.dead_time_q15);
}
