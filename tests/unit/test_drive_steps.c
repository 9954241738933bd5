/* SPDX-License-Identifier: MIT */
/*
 * The parts of the drive, called one by one on states put together by hand: what each begins with,
 * what it looks at and what it leaves behind. What a run shows only after long, or only together
 * with other faults, is told here at once.
 */
#include "drive.h"
#include "estimate.h"
#include "example_cfg.h"
#include "frame.h"
#include "instant.h"
#include "life.h"
#include "open_loop.h"
#include "schedule.h"
#include "state_guard.h"
#include "testing.h"

#include <math.h>
#include <string.h>

#define STALE (77U)          /* a count that something before has left */
#define STALE_CURRENT (8000) /* 9.8 A, above the continuous current */
#define NOMINAL_BUS (22573)  /* 310 V */
#define TURN_LSB (3)         /* Park and its angle: 1 LSB each, and the rounding of the sine */
#define QUARTER (0x40000000)

static drive_cfg_t cfg;
static drive_t drive;
static drive_in_t in;
static instant_t now;
static drive_out_t out;
static fault_t fault;

static void enter(drive_state_t state)
{
    drive.state = state;
    drive.limits = protection_limits(&cfg.protection, drive_is_driving(state));
}

/* A start begins. */
static void start(void)
{
    enter(DRIVE_STATE_READY);
    life_follow(&drive, DRIVE_EVENT_SEARCH, &now);
}

/* The work of one slot of the slow schedule, and what follows from it. */
static void slot(slot_t which)
{
    const drive_event_t event = schedule_step(&drive, &in, &now, which, true, &fault);

    life_follow_or_fail(&drive, event, &fault, &now);
}

/* A drive that has measured its offsets, and a frame without current at 310 V. */
static void calibrate(drive_command_t command)
{
    in = (drive_in_t){.adc_ia = 2048U, .adc_ib = 2048U, .adc_bus = 2822U, .command = command};
    drive.sensors.offset_a = 16384;
    drive.sensors.offset_b = 16384;
    state_guard_keep_measured(&drive.state_guard, &drive);
}

/* RUN at a speed that is asked for, with the whole torque allowed. */
static void run_at(step_t speed, int32_t torque)
{
    enter(DRIVE_STATE_RUN);
    speed_loop_start(&drive.motion.speed_loop, speed, torque);
    drive.motion.speed_reference = speed;
    drive.rotor.observer.speed = speed;
    drive.motion.torque_range =
        (torque_range_t){-cfg.derating.current_max, cfg.derating.current_max};
}

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
    memset(&in, 0, sizeof in);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    drive.bus = NOMINAL_BUS;
    now = (instant_t){.sample = {.bus = NOMINAL_BUS}};
    start();
    supervision_reset(&drive.watch.supervision);
}

/* ---- what a start begins with ---- */

TEST(test_a_reset_forgets_all_that_a_run_has_left_and_is_at_rest_at_angle_0)
{
    const drive_t fresh = drive;

    drive.voltage_drive.active = true;
    drive.voltage_drive.calm_periods = STALE;
    drive.start.lost_periods = STALE;
    drive.rotor.residual = STALE_CURRENT;
    drive.vector.step = 1;
    drive.motion.speed_reference = 1;
    drive.control.ratio_next = (ab_t){1, 1};
    drive.control.ratio_acting = (ab_t){1, 1};
    drive.control.current_ref = (dq_t){1, 1};
    drive.vector.current_mean = (dq_t){1, 1};
    drive.motion.torque_range = (torque_range_t){0, 0};
    drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
    drive.rotor.position.turns_q32 = QUARTER;
    drive.vector.position.turns_q32 = QUARTER;
    pi_reset(&drive.control.current_loop.pi_d, 1);
    pi_reset(&drive.control.current_loop.pi_q, 1);
    drive.rotor.observer.speed = 1;
    speed_loop_reset(&drive.motion.speed_loop, 1);
    position_loop_reset(&drive.motion.position_loop, QUARTER, 1);
    start();
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &drive, sizeof drive);
    TEST_ASSERT_EQUAL_INT64(0, drive.rotor.position.turns_q32);
    TEST_ASSERT_EQUAL_INT64(0, drive.vector.position.turns_q32);
    TEST_ASSERT_EQUAL_INT64(0, drive.motion.position_loop.profile_q32);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.position_loop.profile_speed);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_loop.reference);
    TEST_ASSERT_EQUAL_INT32(0, drive.rotor.observer.speed);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_reference);
    TEST_ASSERT_EQUAL_INT32(0, drive.vector.step);
    TEST_ASSERT_EQUAL_INT32(0, drive.control.current_ref.d);
    TEST_ASSERT_EQUAL_INT32(0, drive.control.current_ref.q);
}

TEST(test_a_run_begins_with_nothing_counted)
{
    static const struct {
        const char *name;
        uint32_t *count;
    } counts[] = {
        {"attempts", &drive.start.attempts},
        {"lost_periods", &drive.start.lost_periods},
        {"calm_periods", &drive.voltage_drive.calm_periods},
        {"late", &drive.watch.supervision.late},
        {"unexplained", &drive.watch.supervision.unexplained},
        {"absent_periods", &drive.watch.supervision.absent_periods},
        {"too_fast", &drive.watch.supervision.too_fast},
        {"stalled", &drive.watch.supervision.stalled},
        {"off_reference", &drive.watch.supervision.off_reference},
        {"runaway", &drive.watch.supervision.runaway},
        {"halves", &drive.watch.oscillation.halves},
        {"span", &drive.watch.oscillation.span},
        {"halvings", &drive.motion.speed_loop.halvings},
    };

    enter(DRIVE_STATE_READY);
    calibrate((drive_command_t){.request = DRIVE_REQUEST_RUN});
    for (uint32_t k = 0U; k < (sizeof counts / sizeof counts[0]); k++) {
        *counts[k].count = STALE;
    }
    drive_step(&drive, &in, &out);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FLYING_START, drive.state);
    for (uint32_t k = 0U; k < (sizeof counts / sizeof counts[0]); k++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0U, *counts[k].count, counts[k].name);
    }
}

/*
 * Whatever slot falls on the tick of the start: it has measured nothing that a motion loop could
 * use.
 */
TEST(test_a_start_moves_nothing_in_its_own_tick)
{
    cfg.startup.current_hold = 0;
    cfg.crc = config_guard_crc(&cfg);
    for (uint32_t slot_count = 1U; slot_count <= cfg.slow_ticks; slot_count++) {
        int32_t flux;

        TEST_ASSERT_NULL(drive_init(&drive, &cfg));
        enter(DRIVE_STATE_READY);
        calibrate((drive_command_t){.target = cfg.speed_loop.speed_max,
                                    .mode = (uint8_t)DRIVE_MODE_POSITION,
                                    .request = DRIVE_REQUEST_RUN});
        drive.slow_count = (uint8_t)slot_count;
        flux = drive.motor.model.flux_q30;
        drive_step(&drive, &in, &out);
        TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
        TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_reference);
        TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_loop.reference);
        TEST_ASSERT_EQUAL_INT32(0, drive.rotor.residual);
        TEST_ASSERT_EQUAL(DRIVE_MODE_SPEED, drive.motion.mode);
        TEST_ASSERT_EQUAL_UINT32(0U, drive.voltage_drive.calm_periods);
        TEST_ASSERT_EQUAL_INT32(flux, drive.motor.model.flux_q30);
    }
}

TEST(test_no_slot_moves_a_drive_without_a_motion_loop)
{
    static const drive_state_t states[] = {DRIVE_STATE_READY, DRIVE_STATE_ALIGN, DRIVE_STATE_FAULT};

    in.command.target = cfg.speed_loop.speed_max;
    for (uint32_t k = 0U; k < (sizeof states / sizeof states[0]); k++) {
        enter(states[k]);
        slot(SLOT_REFINE);
        slot(SLOT_PLAN);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL(states[k], drive.state);
        TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_reference);
        TEST_ASSERT_EQUAL_INT32(0, drive.vector.step);
    }
}

/* ---- the imposed current ---- */

static void assert_imposed(int32_t expected, int32_t thermal, step_t reference)
{
    drive.derating.thermal = thermal;
    drive.motion.speed_reference = reference;
    for (int32_t k = 0; k <= (cfg.startup.current_move / cfg.startup.current_slope); k++) {
        const int32_t before = drive.control.current_ref.d;

        frame_ask_d(&drive.control, open_loop_current(&drive));
        TEST_ASSERT_INT32_WITHIN(cfg.startup.current_slope, before, drive.control.current_ref.d);
    }
    TEST_ASSERT_EQUAL_INT32(expected, drive.control.current_ref.d);
}

TEST(test_derating_holds_for_an_imposed_current_too)
{
    enter(DRIVE_STATE_HOLD);
    assert_imposed(cfg.startup.current_hold, cfg.derating.current_max, 0);
    assert_imposed(cfg.startup.current_move, cfg.derating.current_max, 1);
    assert_imposed(1000, 1000, 1);
    assert_imposed(1000, 1000, 0);
    assert_imposed(0, 0, 1);
}

/* A slow period's end with the vector at this speed. */
static void drag(step_t speed)
{
    speed_loop_reset(&drive.motion.speed_loop, speed);
    drive.motion.speed_reference = speed;
    drive.vector.step = speed;
    slot(SLOT_SPEED);
}

/* An observer that has found the rotor turns with the vector. */
static void drag_with(step_t speed)
{
    drive.rotor.observer.speed = speed;
    drag(speed);
}

TEST(test_a_hand_over_takes_its_time_to_settle)
{
    cfg.startup.settle_periods = 3U;
    enter(DRIVE_STATE_IF_RAMP);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drag(cfg.startup.handover_speed);
    for (uint32_t k = 0U; k < 3U; k++) {
        drag_with(cfg.startup.handover_speed);
        TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, drive.state);
    }
    drag_with(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
}

static drive_state_t handed_over_with(step_t slip, int64_t load_angle)
{
    setUp();
    enter(DRIVE_STATE_HANDOVER);
    drive.rotor.position.turns_q32 = QUARTER;
    drive.vector.position.turns_q32 = QUARTER + load_angle;
    drive.rotor.observer.speed = cfg.startup.handover_speed - slip;
    drag(cfg.startup.handover_speed);
    return drive.state;
}

TEST(test_an_observer_that_turns_otherwise_than_the_vector_has_not_found_the_rotor)
{
    const step_t half = cfg.startup.handover_speed / 2;

    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, handed_over_with(half - 1, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, handed_over_with(half, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, handed_over_with(1 - half, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, handed_over_with(-half, 0));
}

/* A sixth of a turn is 2^32/6 = 715827882.7 steps. */
TEST(test_the_observer_proves_itself_within_a_sixth_of_a_turn_of_the_vector)
{
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, handed_over_with(0, 715827881));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, handed_over_with(0, 715827882));
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, handed_over_with(0, -715827882));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, handed_over_with(0, -715827883));
}

TEST(test_a_hand_over_begins_to_count_and_counts_each_period)
{
    enter(DRIVE_STATE_IF_RAMP);
    drive.start.handover_periods = STALE;
    drag(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.handover_periods);
    drive.rotor.residual = cfg.startup.residual_max;
    for (uint32_t k = 1U; k < cfg.startup.handover_periods; k++) {
        drag(cfg.startup.handover_speed);
        TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, drive.state);
        TEST_ASSERT_EQUAL_UINT32(k, drive.start.handover_periods);
    }
    drag(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.start.attempts);
}

/*
 * It may be lost again at once: failed starts count until RUN has lasted, 100 times as long as a
 * rotor is lost for.
 */
TEST(test_failed_starts_are_forgotten_when_run_has_lasted_and_not_before)
{
    const uint32_t lasting = 100U * cfg.startup.lost_periods;

    enter(DRIVE_STATE_HANDOVER);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.start.attempts = cfg.startup.attempts - 1U;
    drive.rotor.residual = cfg.startup.residual_max - 1;
    drag_with(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    for (uint32_t k = 0U; k < lasting; k++) {
        TEST_ASSERT_EQUAL_UINT32(cfg.startup.attempts - 1U, drive.start.attempts);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.attempts);
}

TEST(test_a_start_that_fails_counts_the_time_of_run_anew)
{
    enter(DRIVE_STATE_HANDOVER);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.start.held_periods = STALE;
    drive.start.handover_periods = cfg.startup.handover_periods;
    drive.rotor.residual = cfg.startup.residual_max;
    drag(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.held_periods);
}

/*
 * One period in HANDOVER, whose vector of 3000 lies 30° ahead of the rotor. Returns what the
 * vector's ramp feeds forward.
 */
static int32_t hand_over_with(step_t change)
{
    const step_t reference = cfg.startup.handover_speed + change;
    speed_loop_t before;

    enter(DRIVE_STATE_HANDOVER);
    drive.vector.position.turns_q32 = 357913941; /* 2^32/12 */
    drive.rotor.position.turns_q32 = 0;
    drive.control.current_ref.d = 3000;
    speed_loop_reset(&drive.motion.speed_loop, cfg.startup.handover_speed);
    drive.vector.step = cfg.startup.handover_speed;
    drive.motion.speed_reference = reference;
    drive.rotor.observer.speed = reference;
    before = drive.motion.speed_loop;
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    return speed_loop_accelerate(&before, &cfg.speed_loop, reference, drive.motion.torque_range);
}

TEST(test_a_hand_over_gives_the_load_to_the_integral_and_not_the_torque_of_the_ramp)
{
    const double cos_30 = 0.8660254037844387;
    int32_t of_ramp = hand_over_with(0);

    TEST_ASSERT_EQUAL_INT32(0, of_ramp);
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, 1500, pi_output(&drive.motion.speed_loop.pi));
    of_ramp = hand_over_with(cfg.startup.ramp);
    TEST_ASSERT_TRUE(of_ramp > 50);
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, lround(1500.0 - (of_ramp * (1.0 - cos_30))),
                             pi_output(&drive.motion.speed_loop.pi));
}

TEST(test_the_last_attempt_that_fails_is_a_fault)
{
    enter(DRIVE_STATE_HANDOVER);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.start.attempts = cfg.startup.attempts - 1U;
    drive.start.handover_periods = cfg.startup.handover_periods;
    drive.rotor.residual = cfg.startup.residual_max;
    drag(cfg.startup.handover_speed);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL(FAULT_STARTUP, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(cfg.startup.residual_max, drive.fault.value);
    TEST_ASSERT_EQUAL_INT32(cfg.startup.residual_max, drive.fault.limit);
}

TEST(test_a_rotor_is_lost_when_periods_above_the_limit_outweigh_those_below)
{
    enter(DRIVE_STATE_HOLD);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.rotor.residual = cfg.startup.residual_lost + 1;
    for (uint32_t k = 1U; k < cfg.startup.lost_periods; k++) {
        drag(0);
        TEST_ASSERT_EQUAL_UINT32(k, drive.start.lost_periods);
    }
    drive.rotor.residual = cfg.startup.residual_lost;
    for (uint32_t k = cfg.startup.lost_periods - 1U; k > 0U; k--) {
        drag(0);
        TEST_ASSERT_EQUAL_UINT32(k - 1U, drive.start.lost_periods);
        TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, drive.state);
    }
    drag(0);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.lost_periods);
    drive.rotor.residual = cfg.startup.residual_lost + 1;
    for (uint32_t k = 0U; k < cfg.startup.lost_periods; k++) {
        TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, drive.state);
        drag(0);
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.start.attempts);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.lost_periods);
}

/* ---- the hand-back ---- */

/*
 * From RUN, slow and with the imposed current faded in, the rotor at an eighth of a turn, all
 * currents others than before. They are as long as before, and in the frame, which has turned
 * forwards from the rotor by the angle of the reference: that of the torque current that the speed
 * loop has just set.
 */
TEST(test_the_hand_back_begins_with_what_flows_and_nothing_older)
{
    const dq_t *const current = &drive.vector.current_mean;
    int64_t ahead;

    enter(DRIVE_STATE_RUN);
    drive.rotor.position.turns_q32 = QUARTER / 2;
    drive.control.current_ref = (dq_t){cfg.startup.current_hold, 0};
    now.along_rotor = (dq_t){3000, -4000};
    drive.vector.current_mean = (dq_t){2, 2};
    drive.watch.supervision.absent = 1U;
    drive.watch.supervision.absent_periods = STALE;
    drive.watch.supervision.unexplained = STALE;
    speed_loop_reset(&drive.motion.speed_loop, 1000);
    drive.motion.speed_reference = 1000;
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_EQUAL_UINT32(SUPERVISION_PHASES, drive.watch.supervision.absent);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.watch.supervision.absent_periods);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.watch.supervision.unexplained);
    TEST_ASSERT_EQUAL_INT32(drive.motion.speed_loop.reference, drive.vector.step);
    TEST_ASSERT_INT64_WITHIN(2LL * 5000 * TURN_LSB, 25000000LL,
                             ((int64_t)current->d * current->d) +
                                 ((int64_t)current->q * current->q));
    ahead = drive.vector.position.turns_q32 - drive.rotor.position.turns_q32;
    TEST_ASSERT_TRUE((ahead > -QUARTER) && (ahead < QUARTER));
    TEST_ASSERT_INT32_WITHIN(TURN_LSB, 0, drive.control.current_ref.q);
    TEST_ASSERT_TRUE(drive.control.current_ref.d >= (cfg.startup.current_hold - TURN_LSB));
}

/* ---- what the observer does not explain ---- */

static int32_t residual_in(drive_state_t state, step_t vector_speed)
{
    enter(state);
    drive.vector.step = vector_speed;
    drive.rotor.observer.rotated_error = (dq_t){.d = -800, .q = 1600};
    drive.rotor.residual = 0;
    slot(SLOT_REFINE);
    return drive.rotor.residual;
}

/* At rest a leg without current lies along q. The filter takes an eighth of it. */
TEST(test_the_residual_is_that_across_the_flux_and_at_rest_that_along_the_vector)
{
    TEST_ASSERT_EQUAL_INT32(100, residual_in(DRIVE_STATE_HOLD, 0));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(DRIVE_STATE_HOLD, 1));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(DRIVE_STATE_IF_RAMP, 0));
    TEST_ASSERT_EQUAL_INT32(200, residual_in(DRIVE_STATE_HANDOVER, 0));
}

/* ---- the observer's static part ---- */

/*
 * rho has the sign of the speed that sets it: of the rotor's own speed `own`, or of the opposite
 * one asked for.
 */
static void assert_rho_follows(step_t own, step_t speed)
{
    enter(DRIVE_STATE_RUN);
    drive.rotor.observer.speed = own;
    speed_loop_reset(&drive.motion.speed_loop, -own);
    slot(SLOT_REFINE);
    TEST_ASSERT_TRUE(drive.rotor.observer.rho_q13 != 0);
    TEST_ASSERT_EQUAL((speed > 0), (drive.rotor.observer.rho_q13 > 0));
}

TEST(test_the_static_part_follows_the_estimate_from_twice_the_hand_over_speed_on)
{
    const step_t fast = 2 * cfg.startup.handover_speed;

    assert_rho_follows(fast, fast);
    assert_rho_follows(fast - 1, 1 - fast);
    assert_rho_follows(-fast, -fast);
    assert_rho_follows(1 - fast, fast - 1);
}

/* ---- ramp and profile under a torque that derating narrows ---- */

/*
 * One slow period in RUN, `change` of the reference asked for, the torque limited to `range`, the
 * profile elsewhere.
 */
static void ramp_under(torque_range_t range, step_t change)
{
    enter(DRIVE_STATE_RUN);
    speed_loop_start(&drive.motion.speed_loop, 0, 0);
    position_loop_reset(&drive.motion.position_loop, 0, 0);
    drive.rotor.position.turns_q32 = QUARTER;
    drive.motion.speed_reference = change;
    drive.motion.torque_range = range;
    slot(SLOT_SPEED);
}

static void assert_waits(torque_range_t range, step_t change)
{
    ramp_under(range, change);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.speed_loop.reference);
    TEST_ASSERT_TRUE(drive.motion.position_loop.profile_q32 == QUARTER);
}

static void assert_goes_on(torque_range_t range, step_t change)
{
    ramp_under(range, change);
    TEST_ASSERT_EQUAL_INT32(change, drive.motion.speed_loop.reference);
    TEST_ASSERT_TRUE(drive.motion.position_loop.profile_q32 == 0);
}

TEST(test_ramp_and_profile_wait_at_the_end_of_a_narrowed_torque_and_only_there)
{
    const int32_t full = cfg.derating.current_max;
    const torque_range_t no_braking = {0, full};
    const torque_range_t no_motoring = {-full, 0};
    const torque_range_t whole = {-full, full};
    const step_t ramp = cfg.speed_loop.ramp;
    const step_t beyond = cfg.speed_loop.speed_max; /* in one period: more than the whole torque */

    cfg.startup.current_hold = 0; /* no imposed current comes in */
    assert_waits(no_motoring, ramp);
    assert_waits(no_braking, -ramp);
    assert_goes_on(no_braking, ramp);
    assert_goes_on(no_motoring, -ramp);
    assert_goes_on(whole, beyond);
    assert_goes_on(whole, -beyond);
    TEST_ASSERT_EQUAL_INT32(-full, drive.control.current_ref.q);
}

/* ---- J ---- */

/* The estimate lags the reference of a ramp. Returns the change of J. */
static int32_t learned_under(torque_range_t range, step_t change)
{
    cfg.startup.current_hold = 0;
    cfg.speed_loop.inertia_rate = 30274;
    cfg.speed_loop.inertia_rate_shift = 4U;
    cfg.speed_loop.inertia_most_q13 = 32767;
    drive.rotor.observer.speed = -cfg.startup.handover_speed / 16;
    ramp_under(range, change);
    return drive.motion.speed_loop.inertia_q17 - 131072;
}

TEST(test_j_is_learned_on_a_ramp_and_not_at_the_end_of_the_torque)
{
    const int32_t full = cfg.derating.current_max;
    const step_t ramp = cfg.speed_loop.ramp;
    const torque_range_t whole = {-full, full};
    const torque_range_t no_motoring = {-full, 0};
    const torque_range_t narrow = {-full, 100};

    TEST_ASSERT_EQUAL_INT32(0, learned_under(no_motoring, ramp));
    TEST_ASSERT_EQUAL_INT32(0, learned_under(narrow, ramp));
    TEST_ASSERT_TRUE(learned_under(whole, ramp) > 0);
}

TEST(test_what_was_learned_of_j_is_forgotten_with_a_fault)
{
    drive.motion.speed_loop.inertia_q17 = 200000;
    enter(DRIVE_STATE_FAULT);
    in.command.request = DRIVE_REQUEST_CLEAR;
    drive_step(&drive, &in, &out);
    TEST_ASSERT_EQUAL(DRIVE_STATE_OFFSET_CAL, drive.state);
    TEST_ASSERT_EQUAL_INT32(131072, drive.motion.speed_loop.inertia_q17);
}

/* ---- the estimate on a ramp ---- */

static step_t estimate_after(step_t begun, step_t change, int32_t share_q14)
{
    const int32_t full = cfg.derating.current_max;

    cfg.run.acceleration_q14 = share_q14;
    drive.rotor.observer.speed = begun;
    ramp_under((torque_range_t){-full, full}, change);
    return drive.rotor.observer.speed;
}

/*
 * Within a quarter of the hand-over speed of the reference, which begins at 0, the rotor follows
 * it.
 */
TEST(test_the_estimate_of_a_rotor_that_is_elsewhere_is_left_alone)
{
    const step_t near = cfg.startup.handover_speed / 4;
    const step_t ramp = 4 * (cfg.speed_loop.ramp / 4);

    TEST_ASSERT_EQUAL_INT32(near + ramp, estimate_after(near, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(near + 1, estimate_after(near + 1, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(ramp - near, estimate_after(-near, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(-near - 1, estimate_after(-near - 1, ramp, 16384));
}

/* The product has 14 bits behind the point, 4 steps. */
TEST(test_the_estimate_takes_on_its_share_of_what_the_reference_changes)
{
    const step_t ramp = 4 * (cfg.speed_loop.ramp / 4);

    TEST_ASSERT_EQUAL_INT32(500000 + ramp, estimate_after(500000, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(500000 - ramp, estimate_after(500000, -ramp, 16384));
    TEST_ASSERT_INT32_WITHIN(4, 500000 + (ramp / 4), estimate_after(500000, ramp, 4096));
    TEST_ASSERT_EQUAL_INT32(500000, estimate_after(500000, ramp, 0));
    TEST_ASSERT_EQUAL_INT32(500000, estimate_after(500000, -ramp, 0));
}

TEST(test_the_estimate_waits_with_a_ramp_that_waits)
{
    cfg.run.acceleration_q14 = 16384;
    drive.rotor.observer.speed = 0;
    ramp_under((torque_range_t){-cfg.derating.current_max, 0}, cfg.speed_loop.ramp);
    TEST_ASSERT_EQUAL_INT32(0, drive.rotor.observer.speed);
}

/* ---- the least current ---- */

/* i_d* after one slow period in RUN at the speed of the hand-over, from i_d* and i_q*. */
static int32_t current_d_after(int32_t d, int32_t q)
{
    run_at(cfg.startup.handover_speed, q);
    cfg.current_reference.floor = 4000;
    cfg.current_reference.slope = 64;
    cfg.current_reference.slope_down = 2;
    drive.control.current_ref = (dq_t){d, q};
    slot(SLOT_LIMITS);
    return drive.control.current_ref.d;
}

TEST(test_the_least_current_comes_with_its_slope_and_goes_with_its_own)
{
    const int32_t slope = 64 * (int32_t)cfg.slow_ticks;
    const int32_t fall = 2 * (int32_t)cfg.slow_ticks;

    TEST_ASSERT_EQUAL_INT32(slope, current_d_after(0, 0));
    TEST_ASSERT_EQUAL_INT32(4000, current_d_after(4000 - slope + 1, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - fall, current_d_after(4000, 8000));
    TEST_ASSERT_EQUAL_INT32(2000 - fall, current_d_after(2000, -8000));
    TEST_ASSERT_EQUAL_INT32(0, current_d_after(fall - 1, 8000));
    TEST_ASSERT_EQUAL_INT32(3000, current_d_after(3000, 2000));
    /* What was imposed is above the least current, and of no use: it goes as it came. */
    TEST_ASSERT_EQUAL_INT32(8000 - slope, current_d_after(8000, 8000));
    TEST_ASSERT_EQUAL_INT32(4000 - fall, current_d_after(4000 + (slope / 2), 8000));
    cfg.current_reference.floor_shift = 0U;
    TEST_ASSERT_EQUAL_INT32(2000, current_d_after(2000, 2000));
}

/*
 * i_d* after one slow period at a speed whose EMF is a sixteenth above the bus of setUp(), with
 * this demand.
 */
static int32_t current_d_beyond_base_speed(dq_t demand)
{
    const int32_t limit = modulator_limit(&cfg.modulator, drive.bus);
    const int32_t speed_q15 = ((limit + (limit / 16)) * 8192) / cfg.current_loop.emf_q13;

    weakening_reset(&drive.motion.weakening);
    drive.control.voltage = demand;
    (void)current_d_after(0, 0);
    drive.control.current_ref = (dq_t){0, 0};
    drive.rotor.observer.speed = speed_q15 * 2048; /* 2^speed_shift */
    drive.motion.speed_reference = drive.rotor.observer.speed;
    slot(SLOT_LIMITS);
    return drive.control.current_ref.d;
}

TEST(test_the_least_current_gives_way_to_a_weakened_field_where_the_voltage_ends)
{
    const int32_t near = (15 * modulator_limit(&cfg.modulator, drive.bus)) / 16;

    TEST_ASSERT_EQUAL_INT32(64 * (int32_t)cfg.slow_ticks,
                            current_d_beyond_base_speed((dq_t){0, near}));
    TEST_ASSERT_LESS_THAN_INT32(0, current_d_beyond_base_speed((dq_t){0, near + 2}));
    TEST_ASSERT_LESS_THAN_INT32(0, current_d_beyond_base_speed((dq_t){-near - 2, 0}));
}

/* The voltage drive has neither i_d* nor a range. */
TEST(test_the_voltage_drive_leaves_the_current_reference_alone)
{
    drive.voltage_drive.active = true;
    TEST_ASSERT_EQUAL_INT32(0, current_d_after(0, 0));
    TEST_ASSERT_EQUAL_INT32(-8000, current_d_after(-8000, 0));
    TEST_ASSERT_EQUAL_INT32(8192, drive.motion.torque_range.upper);
}

/* ---- the alignment ---- */

static void align(void)
{
    const drive_event_t event = open_loop_align(&drive.start, &drive, now.along_vector, &fault);

    life_follow_or_fail(&drive, event, &fault, &now);
}

/* The tick that ends a measurement of the alignment, with a largest current across the vector. */
static void end_measurement(align_phase_t phase, int32_t swing, int32_t step_fall)
{
    const int32_t before = (1 << cfg.startup.align.measure_log2) - 1;
    const bool first = phase == ALIGN_MEASURE_HIGH;

    fault_clear(&fault);
    enter(DRIVE_STATE_ALIGN);
    drive.start.align = (align_t){.phase = phase,
                                  .tick = (uint32_t)before,
                                  .swing = swing,
                                  .current_ref = 3000,
                                  .inductance = {.step = {.change = {.d = step_fall}}},
                                  .high = {.voltage = 64 * 1000, .current = 64 * 2500},
                                  .low = {.voltage = 800 * before, .current = 1500 * before}};
    if (first) {
        drive.start.align.high =
            (align_point_t){.voltage = 1000 * before, .current = 2500 * before};
    }
    now.along_vector = (dq_t){first ? 2500 : 1500, 0};
    drive.control.voltage.d = first ? 1000 : 800;
    align();
}

/* The next tick evaluates what was measured, and the one after it acts on that. */
static void end_alignment(int32_t swing, int32_t step_fall)
{
    end_measurement(ALIGN_MEASURE_LOW, swing, step_fall);
    for (uint32_t k = 0U; (k < 2U) && (drive.state == DRIVE_STATE_ALIGN); k++) {
        align();
    }
}

TEST(test_an_alignment_without_an_inductance_leaves_the_model_and_is_not_repeated)
{
    const int32_t resistance = drive.motor.model.resistance_q14;

    speed_loop_lower(&drive.motion.speed_loop); /* a rotor was caught */
    end_alignment(0, 0);
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_TRUE(drive.motor.identified);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
    TEST_ASSERT_EQUAL_INT32(resistance, drive.motor.model.resistance_q14);
}

TEST(test_the_second_measurement_follows_when_the_rotor_rested_in_the_first)
{
    end_measurement(ALIGN_MEASURE_HIGH, cfg.startup.align.swing_max, 2000);
    TEST_ASSERT_EQUAL(DRIVE_STATE_ALIGN, drive.state);
    TEST_ASSERT_EQUAL(ALIGN_INDUCTANCE, drive.start.align.phase);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.attempts);
}

TEST(test_a_rotor_that_does_not_rest_is_looked_for_after_the_measurement_that_shows_it)
{
    static const align_phase_t PHASES[] = {ALIGN_MEASURE_HIGH, ALIGN_MEASURE_LOW};

    for (uint32_t k = 0; k < 2U; k++) {
        drive.start.attempts = 0U;
        end_measurement(PHASES[k], cfg.startup.align.swing_max + 1, 2000);
        TEST_ASSERT_EQUAL(DRIVE_STATE_FLYING_START, drive.state);
        TEST_ASSERT_EQUAL_UINT32(1U, drive.start.attempts);
        TEST_ASSERT_FALSE(drive.motor.identified);
    }
}

TEST(test_the_last_alignment_without_rest_is_a_fault_that_names_the_current_across)
{
    drive.start.attempts = cfg.startup.attempts - 1U;
    end_alignment(cfg.startup.align.swing_max + 1, 2000);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL(FAULT_STARTUP, fault.id);
    TEST_ASSERT_EQUAL_INT32(cfg.startup.align.swing_max + 1, fault.value);
    TEST_ASSERT_EQUAL_INT32(cfg.startup.align.swing_max, fault.limit);
}

/* ---- a rotor that slipped ---- */

/* The next reference of a vector at `present`, when 4·ramp is asked for. */
static step_t reference_from(step_t present, uint32_t attempts, bool identified)
{
    enter(DRIVE_STATE_IF_RAMP);
    drive.start.attempts = attempts;
    drive.motor.identified = identified;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.vector.step = present;
    drive.motion.speed_loop.reference = present;
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

static drive_state_t state_of_fast_vector(uint32_t attempts, bool identified)
{
    enter(DRIVE_STATE_IF_RAMP);
    drive.start.attempts = attempts;
    drive.motor.identified = identified;
    state_guard_keep_measured(&drive.state_guard, &drive);
    drive.vector.step = cfg.startup.handover_speed;
    drive.motion.speed_loop.reference = cfg.startup.handover_speed;
    drive.motion.speed_reference = cfg.startup.handover_speed;
    slot(SLOT_SPEED);
    return drive.state;
}

TEST(test_a_rotor_that_slipped_is_not_handed_over_before_it_has_stood)
{
    TEST_ASSERT_EQUAL(DRIVE_STATE_IF_RAMP, state_of_fast_vector(1U, false));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, state_of_fast_vector(0U, false));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HANDOVER, state_of_fast_vector(1U, true));
}

/* ---- the limits of an imposed current ---- */

static dq_t voltage_of_imposed(dq_t current)
{
    frame_t frame;

    enter(DRIVE_STATE_HOLD);
    current_loop_reset(&drive.control.current_loop);
    drive.control.current_ref = (dq_t){0, 0};
    frame = frame_of_vector(&drive, current);
    return frame_impose_current(&drive.control, &drive, &frame, 22576); /* 310 V */
}

/* What K_p of RUN makes of 500 beyond each limit, on top of the soft control; roundings of both. */
TEST(test_an_imposed_current_is_controlled_firmly_beyond_its_limits_alone)
{
    const current_loop_cfg_t *const firm = &cfg.current_loop;
    const int32_t d =
        ((500 * firm->pi_d.kp) >> firm->pi_d.kp_shift) / 2; /* half of L_d, 3/4 of L_q */
    const int32_t q = ((500 * firm->pi_q.kp) >> firm->pi_q.kp_shift) * 3 / 4;
    const dq_t limit = {cfg.startup.along_max, cfg.startup.across_max};

    drive.motor.model.inductance_q14 = 8192;
    drive.motor.model.saliency_q14 = 24576;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const dq_t beyond = {sign * (limit.d + 500), sign * (limit.q + 500)};
        dq_t held;
        dq_t soft;

        held = voltage_of_imposed(beyond);
        cfg.startup.along_max = 16384;
        cfg.startup.across_max = 16384;
        soft = voltage_of_imposed(beyond);
        cfg.startup.along_max = limit.d;
        cfg.startup.across_max = limit.q;
        TEST_ASSERT_INT32_WITHIN(2, sign * d, soft.d - held.d);
        TEST_ASSERT_INT32_WITHIN(2, sign * q, soft.q - held.q);
    }
}

/* ---- the current vector near a hand-over ---- */

/* i_q* after a slow period with a large error of the speed, beside i_d*. */
static int32_t torque_beside(int32_t current_d, int32_t sign)
{
    const step_t speed = 2 * cfg.startup.handover_speed;

    cfg.current_reference.floor = 1000;
    cfg.current_reference.slope = 1;
    cfg.current_reference.slope_down = 1;
    cfg.speed_loop.inertia = 0;
    run_at(speed, sign * cfg.derating.current_max);
    drive.rotor.observer.speed -= sign * (speed / 2);
    drive.control.current_ref = (dq_t){current_d, 0};
    slot(SLOT_LIMITS);
    slot(SLOT_SPEED);
    return drive.control.current_ref.q;
}

TEST(test_the_torque_leaves_an_imposed_current_its_part_of_the_largest_one)
{
    const int32_t most = cfg.derating.current_max;
    const int32_t slope = (int32_t)cfg.slow_ticks;
    const int32_t d = (most * 3) / 5;
    const double room = sqrt(((double)most * most) - ((double)(d - slope) * (d - slope)));

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_INT32_WITHIN(1, sign * (int32_t)room, torque_beside(d, sign));
        TEST_ASSERT_EQUAL_INT32(0, torque_beside(most + slope, sign));
        TEST_ASSERT_EQUAL_INT32(sign * most, torque_beside(1000, sign));
    }
}

static int32_t dead_time_after_an_alignment_at(int64_t angle)
{
    cfg.modulator = example_modulator_cfg_with_dead_time();
    cfg.modulator.dead_time_band_q15 = 245;
    drive.modulator.dead_time_q15 = 655;
    drive.vector.position.turns_q32 = angle;
    end_alignment(cfg.startup.align.swing_max, 2000);
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_TRUE(drive.motor.identified);
    return drive.modulator.dead_time_q15;
}

/*
 * R = 512·(v_h − v_l)/(i_h − i_l) says 800 − 0.2·1500 = 500 of 1000 at zero current: far above the
 * compensation. A vector off the axis of phase a loads the legs otherwise: after a catch the rotor
 * is held where it came to rest.
 */
TEST(test_what_the_alignment_finds_lost_corrects_the_dead_time_within_its_limits)
{
    TEST_ASSERT_EQUAL_INT32(900, dead_time_after_an_alignment_at(0));
    TEST_ASSERT_EQUAL_INT32(655, dead_time_after_an_alignment_at(QUARTER));
}

/* A standing rotor is found by the second pulse without a current. */
static bool sweeps_backwards(uint32_t attempts)
{
    enter(DRIVE_STATE_FLYING_START);
    flying_start_reset(&drive.start.flying_start);
    drive.start.attempts = attempts;
    drive.start.align.backwards = false;
    for (int32_t k = 0; (k < 100000) && (drive.state == DRIVE_STATE_FLYING_START); k++) {
        const drive_event_t event =
            open_loop_search(&drive.start, &drive, &in, now.sample, &out, &fault);

        life_follow_or_fail(&drive, event, &fault, &now);
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_ALIGN, drive.state);
    return drive.start.align.backwards;
}

TEST(test_each_further_attempt_sweeps_the_other_way)
{
    in.command.target = 1000;
    TEST_ASSERT_FALSE(sweeps_backwards(0U));
    TEST_ASSERT_TRUE(sweeps_backwards(1U));
    TEST_ASSERT_FALSE(sweeps_backwards(2U));
    in.command.target = -1000;
    TEST_ASSERT_TRUE(sweeps_backwards(0U));
    TEST_ASSERT_FALSE(sweeps_backwards(1U));
}

/* ---- the compensation of an imposed current ---- */

/*
 * Counts by which the leg of phase a is driven longer, without a voltage. Half a period is
 * timer_counts / 2.
 */
static int32_t compensated_a(int32_t reference, int32_t mean)
{
    frame_t frame;
    compare_t compare;

    enter(DRIVE_STATE_HOLD);
    drive.control.current_ref = (dq_t){reference, 0};
    drive.vector.current_mean = (dq_t){mean, 0};
    frame = frame_of_vector(&drive, (dq_t){0, 0});
    frame_modulate(&drive.control, &drive, &frame, (dq_t){0, 0}, &compare);
    return (int32_t)compare.phase[0] - (cfg.modulator.timer_counts / 2);
}

/* Else the dead time would keep the current at zero, and zero current the compensation. */
TEST(test_an_imposed_current_is_compensated_before_it_flows_and_follows_a_swing)
{
    cfg.modulator = example_modulator_cfg_with_dead_time();
    modulator_reset(&drive.modulator, &cfg.modulator);
    for (int32_t k = 0; k < 8; k++) {
        modulator_track_bus(&drive.modulator, NOMINAL_BUS);
    }
    TEST_ASSERT_TRUE(compensated_a(4000, 0) > 0);
    TEST_ASSERT_EQUAL_INT32(compensated_a(4000, 4000), compensated_a(4000, 0));
    TEST_ASSERT_TRUE(compensated_a(4000, -8000) < 0);
    TEST_ASSERT_INT32_WITHIN(1, 0, compensated_a(4000, -4000));
}

/* ---- towards standstill ---- */

static step_t planned_from(step_t reference, step_t target)
{
    enter(DRIVE_STATE_RUN);
    in.command.target = target;
    drive.motion.speed_loop.reference = reference;
    slot(SLOT_PLAN);
    return drive.motion.speed_reference;
}

TEST(test_below_the_hold_speed_run_follows_the_ramp_of_an_imposed_vector)
{
    const step_t hold = cfg.startup.hold_speed;

    TEST_ASSERT_TRUE(cfg.startup.ramp < cfg.speed_loop.ramp);
    TEST_ASSERT_EQUAL_INT32(hold - cfg.speed_loop.ramp, planned_from(hold, 0));
    TEST_ASSERT_EQUAL_INT32(hold - 1 - cfg.startup.ramp, planned_from(hold - 1, 0));
    TEST_ASSERT_EQUAL_INT32(-hold + cfg.speed_loop.ramp, planned_from(-hold, 0));
    TEST_ASSERT_EQUAL_INT32(1 - hold + cfg.startup.ramp, planned_from(1 - hold, 0));
    cfg.startup.current_hold = 0; /* no start-up: nothing is imposed at standstill */
    TEST_ASSERT_EQUAL_INT32(hold - 1 - cfg.speed_loop.ramp, planned_from(hold - 1, 0));
}

/* After a slow period in RUN with an imposed current, and under a load. */
static drive_state_t after_a_period_at(step_t reference, int32_t load)
{
    run_at(reference, load);
    drive.control.current_ref = (dq_t){cfg.startup.current_hold, 0};
    slot(SLOT_LIMITS);
    slot(SLOT_SPEED);
    return drive.state;
}

/* Half of it, and half of that: rounded down, as hold_speed is no multiple of four. */
TEST(test_the_hand_back_waits_for_three_quarters_of_the_hold_speed)
{
    const step_t settled = (cfg.startup.hold_speed / 2) + (cfg.startup.hold_speed / 4);

    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, after_a_period_at(settled + 1, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, after_a_period_at(-settled - 1, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(settled, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(-settled, 0));
}

/* The period's own change of the integral is below one LSB. */
TEST(test_with_a_load_run_goes_down_to_the_loaded_speed)
{
    const step_t loaded = cfg.startup.hold_speed / 4;
    const step_t settled = (loaded / 2) + (loaded / 4); /* loaded_speed is odd: rounded down */
    const int32_t load = cfg.startup.load_current;

    cfg.startup.loaded_speed = loaded;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, after_a_period_at(sign * loaded, sign * load));
        TEST_ASSERT_TRUE(drive.control.current_ref.d < cfg.startup.current_hold);
        /* A load that drives needs the imposed current. */
        TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(sign * loaded, -sign * 2 * load));
        TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(sign * settled, sign * load));
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(loaded, load - 1));
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, after_a_period_at(settled + 1, load));
}

/*
 * A position profile still brakes at three quarters. Below half a load angle holds the position,
 * whatever the load.
 */
TEST(test_the_hand_back_of_a_position_profile_waits_for_half_of_the_hold_speed)
{
    const step_t half = cfg.startup.hold_speed / 2;

    cfg.startup.loaded_speed = half / 2;
    drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, after_a_period_at(half + 1, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(half, 0));
    TEST_ASSERT_EQUAL(DRIVE_STATE_HOLD, after_a_period_at(half, 2000));
}

/* ---- the voltage drive's periods ---- */

static void offer_voltage_drive(void)
{
    cfg.voltage_drive = example_voltage_drive_cfg();
    run_at(2 * cfg.voltage_drive.speed_min, 1000);
    in.command.target = drive.motion.speed_reference;
    now.along_rotor = (dq_t){0, 1000};
    drive.control.current_ref = (dq_t){0, 1000};
    drive.control.voltage = (dq_t){0, 8000};
}

TEST(test_the_voltage_drive_takes_over_after_its_periods_and_counts_anew)
{
    offer_voltage_drive();
    drive.voltage_drive.end_periods = STALE;
    for (uint32_t k = 1U; k < cfg.voltage_drive.settle_periods; k++) {
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_UINT32(k, drive.voltage_drive.calm_periods);
        TEST_ASSERT_FALSE(drive.voltage_drive.active);
    }
    slot(SLOT_SPEED);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.voltage_drive.end_periods);
}

/*
 * A fiftieth of the speed is missing: 113 LSB of proportional part; 1 of integral a period, and 1
 * for each of four roundings.
 */
TEST(test_the_voltage_drive_begins_with_the_voltage_that_acts_whatever_speed_is_missing)
{
    int32_t begun;

    offer_voltage_drive();
    pi_reset(&drive.control.current_loop.pi_q, 8000);
    drive.rotor.observer.speed -= drive.rotor.observer.speed / 50;
    for (uint32_t k = 0U; k < cfg.voltage_drive.settle_periods; k++) {
        now.along_rotor = drive.control.current_ref;
        slot(SLOT_SPEED);
    }
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    begun = drive.voltage_drive.magnitude;
    TEST_ASSERT_TRUE(begun >= 8000);
    slot(SLOT_SPEED);
    TEST_ASSERT_INT32_WITHIN(5, begun, drive.voltage_drive.magnitude);
}

/* Also while the rotor is already as fast as the command asks. */
TEST(test_the_voltage_drive_waits_for_the_speed_that_its_loop_is_asked_for)
{
    step_t least;

    offer_voltage_drive();
    least = cfg.voltage_drive.speed_min;
    in.command.target = least;
    run_at(least, 1000);
    drive.motion.speed_reference = least - 1;
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.voltage_drive.calm_periods);
    drive.motion.speed_reference = least;
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.voltage_drive.calm_periods);
}

TEST(test_the_voltage_drive_gives_back_after_its_periods_and_current_control_counts_anew)
{
    offer_voltage_drive();
    drive.voltage_drive.active = true;
    drive.voltage_drive.calm_periods = STALE;
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
}

/* ---- the torque filter ---- */

/*
 * A speed loop that asks for `current`, and a low-pass at `begun` that takes over half of a change
 * in a period.
 */
static void filter_torque(int32_t current, int32_t begun, int32_t limit)
{
    cfg.torque_filter = (torque_filter_cfg_t){.smooth_rate_q15 = 16384};
    run_at(0, current);
    torque_filter_start(&drive.motion.torque_filter, begun);
    drive.motion.torque_range = (torque_range_t){-limit, limit};
}

TEST(test_the_torque_filter_stands_behind_the_speed_loop)
{
    filter_torque(4000, 1000, 6000);
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(2500, drive.control.current_ref.q);
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(3250, drive.control.current_ref.q);
    cfg.torque_filter = (torque_filter_cfg_t){.smooth_rate_q15 = 0};
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(4000, drive.control.current_ref.q);
}

/* A low-pass that is still above a range that has just become narrow. */
TEST(test_behind_the_torque_filter_the_torque_keeps_its_limits)
{
    static const int32_t asked[] = {6000, 2000, -6000, -2000}; /* half of the way is 4000 or more */

    for (uint32_t k = 0U; k < 4U; k++) {
        const int32_t sign = (asked[k] > 0) ? 1 : -1;

        filter_torque(asked[k], sign * 6000, 3001);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_INT32(sign * 3001, drive.control.current_ref.q);
    }
}

/* However long a rotor is too slow for the whole torque. */
TEST(test_at_the_end_of_its_range_the_torque_winds_up_no_more_than_without_a_filter)
{
    int32_t integral[2];

    for (uint32_t k = 0U; k < 2U; k++) {
        filter_torque(5000, 5000, 6000);
        if (k == 0U) {
            cfg.torque_filter = (torque_filter_cfg_t){.smooth_rate_q15 = 0};
        }
        drive.rotor.observer.speed = -cfg.startup.handover_speed;
        for (uint32_t n = 0U; n < 500U; n++) {
            slot(SLOT_SPEED);
        }
        TEST_ASSERT_EQUAL_INT32(6000, drive.control.current_ref.q);
        integral[k] = drive.motion.speed_loop.pi.integral_q26;
    }
    TEST_ASSERT_EQUAL_INT32(integral[0], integral[1]);
}

/* Sine and cosine are rounded, so the gain of a notch at rest is not quite 1. */
TEST(test_behind_a_notch_the_limit_of_the_torque_is_reached_in_the_end)
{
    static const double notches_hz[] = {4.0, 10.0, 23.4, 120.0, 495.0}; /* at 1 kHz */

    for (uint32_t k = 0U; k < 10U; k++) {
        const int32_t sign = (k < 5U) ? 1 : -1;
        const double turn = 6.283185307179586 * notches_hz[k % 5U] / 1000.0;

        filter_torque(sign * 12002, 0, 6001);
        cfg.torque_filter = (torque_filter_cfg_t){
            .notch_share_q15 = 1000,
            .notch_turn = {.sin = (int16_t)lround(32767.0 * sin(turn)),
                           .cos = (int16_t)lround(32767.0 * cos(turn))},
        };
        drive.rotor.observer.speed = -sign * cfg.startup.handover_speed;
        for (uint32_t n = 0U; n < 3000U; n++) {
            slot(SLOT_SPEED);
        }
        TEST_ASSERT_EQUAL_INT32(sign * 6001, drive.control.current_ref.q);
    }
}

static void assert_filter_begins_with(int32_t current)
{
    TEST_ASSERT_EQUAL_INT32(current, drive.motion.torque_filter.origin);
    TEST_ASSERT_EQUAL_INT32(current * 2048, drive.motion.torque_filter.smooth_q26);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_filter.swing_q26.d);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_filter.swing_q26.q);
}

static void leave_a_swing_in_the_filter(void)
{
    drive.motion.torque_filter =
        (torque_filter_t){.origin = 1, .smooth_q26 = 2, .swing_q26 = {3, 4}};
}

/* A twelfth of a turn of load angle leaves half of the imposed current as torque. */
TEST(test_run_begins_with_the_torque_filter_at_the_torque_that_acts)
{
    leave_a_swing_in_the_filter();
    calibrate(
        (drive_command_t){.target = 2 * cfg.startup.handover_speed, .request = DRIVE_REQUEST_RUN});
    run_at(cfg.startup.handover_speed, 0);
    enter(DRIVE_STATE_HANDOVER);
    drive.slow_count = 1U;
    drive.control.current_ref = (dq_t){4000, 0};
    drive.rotor.position.turns_q32 = -(QUARTER / 3);
    drive.vector.step = cfg.startup.handover_speed;
    drive_step(&drive, &in, &out);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_INT32_WITHIN(4000 / 16, 2000, drive.control.current_ref.q);
    assert_filter_begins_with(drive.control.current_ref.q);
}

TEST(test_current_control_is_given_back_with_the_torque_filter_at_the_torque_that_acts)
{
    offer_voltage_drive();
    leave_a_swing_in_the_filter();
    drive.voltage_drive.active = true;
    virtual_resistance_start(&drive.voltage_drive.damping, (dq_t){0, 1000});
    drive.motion.speed_reference = 0; /* too slow for a voltage drive */
    slot(SLOT_SPEED);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_EQUAL_INT32(1000, drive.control.current_ref.q);
    assert_filter_begins_with(1000);
}

/* ---- the monitor ---- */

static int32_t heat_after_one_look(drive_state_t state)
{
    enter(state);
    drive.derating.heat_q24 = 1000000;
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    drive.watch.supervision.step = 0U;
    now.along_rotor = (dq_t){STALE_CURRENT, 0};
    now.sample.phase_a = 0;
    now.sample.phase_b = 0;
    slot(SLOT_CHECKS);
    return drive.derating.heat_q24;
}

/* The same with these phase currents: as in a short circuit, or through the diodes. */
static int32_t heat_of_phases(drive_state_t state, int32_t a, int32_t b)
{
    enter(state);
    drive.derating.heat_q24 = 1000000;
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    drive.watch.supervision.step = 0U;
    now.along_rotor = (dq_t){0, 0};
    now.sample.phase_a = a;
    now.sample.phase_b = b;
    slot(SLOT_CHECKS);
    return drive.derating.heat_q24;
}

/* Held at rest with an imposed current of 5000: what one look adds to the sum of the errors. */
static dq_t held_error_with(dq_t current)
{
    enter(DRIVE_STATE_HOLD);
    drive.vector.step = 0;
    supervision_reset(&drive.watch.supervision);
    drive.control.current_ref = (dq_t){5000, 0};
    now.along_vector = current;
    drive.watch.supervision.step = 2U; /* the check of the current */
    slot(SLOT_CHECKS);
    return drive.watch.supervision.off_current;
}

TEST(test_at_rest_half_of_what_the_imposed_current_lacks_counts_and_nothing_of_what_a_swing_adds)
{
    TEST_ASSERT_EQUAL_INT32(500, held_error_with((dq_t){4000, 0}).d);
    TEST_ASSERT_EQUAL_INT32(0, held_error_with((dq_t){6000, 0}).d);
    TEST_ASSERT_EQUAL_INT32(-500, held_error_with((dq_t){5000, 1000}).q);
    TEST_ASSERT_EQUAL_INT32(500, held_error_with((dq_t){5000, -1000}).q);
}

TEST(test_at_rest_the_motor_cools_whatever_current_was_measured_last)
{
    calibrate((drive_command_t){0});
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_RUN) > 1000000);
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_HOLD) > 1000000);
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_ALIGN) > 1000000);
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_READY) < 1000000);
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_FAULT) < 1000000);
    TEST_ASSERT_TRUE(heat_after_one_look(DRIVE_STATE_OFFSET_CAL) < 1000000);
}

TEST(test_a_current_that_nothing_controls_heats_as_one_that_is_controlled)
{
    calibrate((drive_command_t){0});
    enter(DRIVE_STATE_RUN);
    drive.derating.heat_q24 = 1000000;
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    drive.watch.supervision.step = 0U;
    now.along_rotor = (dq_t){0, 8000};
    slot(SLOT_CHECKS);
    const int32_t controlled = drive.derating.heat_q24;

    TEST_ASSERT_EQUAL_INT32(controlled, heat_of_phases(DRIVE_STATE_READY, 8000, -4000));
    TEST_ASSERT_EQUAL_INT32(controlled, heat_of_phases(DRIVE_STATE_FAULT, -8000, 4000));
    TEST_ASSERT_EQUAL_INT32(controlled, heat_of_phases(DRIVE_STATE_FLYING_START, 8000, -4000));
    TEST_ASSERT_EQUAL_INT32(controlled, heat_of_phases(DRIVE_STATE_OFFSET_CAL, 8000, -4000));
}

/* With open gates it is the sensor that reads so. */
TEST(test_a_current_beyond_the_range_of_its_converter_heats_a_shorted_motor_as_the_largest)
{
    static const uint16_t ends[] = {0U, 4095U};

    calibrate((drive_command_t){0});
    const int32_t measured = heat_of_phases(DRIVE_STATE_FAULT, 16000, -8000);

    for (uint32_t k = 0U; k < 2U; k++) {
        drive.safe_state.phase = SAFE_STATE_SHORT;
        in.adc_ia = ends[k];
        in.adc_ib = 2048U;
        TEST_ASSERT_TRUE(heat_of_phases(DRIVE_STATE_FAULT, 100, 100) > measured);
        in.adc_ia = 2048U;
        in.adc_ib = ends[k];
        TEST_ASSERT_TRUE(heat_of_phases(DRIVE_STATE_READY, 100, 100) > measured);
        drive.safe_state.phase = SAFE_STATE_OPEN;
        TEST_ASSERT_TRUE(heat_of_phases(DRIVE_STATE_READY, 16000, -8000) < 1000000);
    }
}

static void look_at_phases(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        slot(SLOT_PHASES);
    }
}

/*
 * Phase a stands still and b swings for this many half turns of the rotor, and of the imposed
 * vector.
 */
static void turn_with_a_dead_phase(int32_t of_rotor, int32_t of_vector)
{
    const int32_t samples = 10; /* a half turn; an arc is of 8 at least */

    drive.rotor.position.turns_q32 = 0;
    drive.vector.position.turns_q32 = 0;
    for (int32_t k = 0; k < (samples * 4); k++) {
        now.sample.phase_a = 0;
        now.sample.phase_b = ((k % 2) == 0) ? STALE_CURRENT : -STALE_CURRENT;
        look_at_phases(1U);
        drive.rotor.position.turns_q32 += of_rotor * (((int64_t)2 * QUARTER) / samples);
        drive.vector.position.turns_q32 += of_vector * (((int64_t)2 * QUARTER) / samples);
    }
}

/*
 * In RUN the rotor's angle counts, below it that of the imposed vector, which the other has not to
 * follow.
 */
TEST(test_phases_are_watched_over_the_turns_of_what_turns_in_this_state)
{
    const struct {
        drive_state_t state;
        int32_t of_rotor;
        int32_t of_vector;
        fault_id_t id;
    } turns[] = {{DRIVE_STATE_RUN, 1, 0, FAULT_LOST_PHASE},
                 {DRIVE_STATE_RUN, -1, 0, FAULT_LOST_PHASE},
                 {DRIVE_STATE_RUN, 0, 1, FAULT_NONE},
                 {DRIVE_STATE_IF_RAMP, 0, 1, FAULT_LOST_PHASE},
                 {DRIVE_STATE_IF_RAMP, 0, -1, FAULT_LOST_PHASE},
                 {DRIVE_STATE_IF_RAMP, 1, 0, FAULT_NONE},
                 {DRIVE_STATE_READY, 1, 1, FAULT_NONE}};

    for (uint32_t k = 0U; k < (sizeof turns / sizeof turns[0]); k++) {
        setUp();
        enter(turns[k].state);
        turn_with_a_dead_phase(turns[k].of_rotor, turns[k].of_vector);
        TEST_ASSERT_EQUAL(turns[k].id, drive.fault.id);
    }
}

/* What a current control's integrals cannot need is a fault of an imposed current, not of a run. */
TEST(test_a_run_is_not_judged_by_the_voltage_of_its_current_control)
{
    enter(DRIVE_STATE_RUN);
    pi_reset(&drive.control.current_loop.pi_q, 2 * cfg.supervision.voltage_max);
    look_at_phases(2U * cfg.supervision.swing_periods);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    enter(DRIVE_STATE_IF_RAMP);
    look_at_phases(2U * cfg.supervision.swing_periods);
    TEST_ASSERT_EQUAL(FAULT_CURRENT_IMPLAUSIBLE, drive.fault.id);
}

/* In RUN with an integral far beyond what its voltage may be off, for longer than that may last. */
static fault_id_t run_with_a_large_voltage(void)
{
    enter(DRIVE_STATE_RUN);
    pi_reset(&drive.control.current_loop.pi_q, 32000);
    for (uint32_t k = 0U; k < (2U << cfg.supervision.mean_shift); k++) {
        drive.watch.supervision.step = 2U;
        slot(SLOT_CHECKS);
    }
    return drive.fault.id;
}

TEST(test_a_large_voltage_of_a_run_is_a_fault_unless_the_voltage_drive_acts)
{
    TEST_ASSERT_EQUAL(FAULT_CURRENT_IMPLAUSIBLE, run_with_a_large_voltage());
    setUp();
    drive.voltage_drive.active = true;
    TEST_ASSERT_EQUAL(FAULT_NONE, run_with_a_large_voltage());
}

/* The check of swings names them, where there is one. */
TEST(test_a_large_voltage_of_a_swing_is_left_to_the_check_of_swings)
{
    const struct {
        oscillation_act_t act;
        uint32_t halves;
        fault_id_t id;
    } swings[] = {{OSCILLATION_ACT_FAULT, 2U, FAULT_NONE},
                  {OSCILLATION_ACT_FAULT, 1U, FAULT_CURRENT_IMPLAUSIBLE},
                  {OSCILLATION_ACT_NONE, 2U, FAULT_CURRENT_IMPLAUSIBLE}};

    for (uint32_t k = 0U; k < (sizeof swings / sizeof swings[0]); k++) {
        setUp();
        cfg.oscillation.act = (uint32_t)swings[k].act;
        drive.watch.oscillation.halves = swings[k].halves;
        TEST_ASSERT_EQUAL(swings[k].id, run_with_a_large_voltage());
    }
}

/* The vector turns at 2^26 steps per tick / 2^11 = 32768, Q15 of Ω_b; a quarter of that here. */
TEST(test_the_check_of_an_imposed_current_allows_the_whole_emf_in_either_direction)
{
    const step_t speeds[] = {8192 * 2048, -8192 * 2048};
    const int32_t emf = (8192 * cfg.hold_loop.emf_q13) / 8192;

    for (uint32_t k = 0U; k < 2U; k++) {
        setUp();
        enter(DRIVE_STATE_IF_RAMP);
        drive.vector.step = speeds[k];
        pi_reset(&drive.control.current_loop.pi_q, cfg.supervision.voltage_max + emf);
        look_at_phases(2U * cfg.supervision.swing_periods);
        TEST_ASSERT_EQUAL(DRIVE_STATE_IF_RAMP, drive.state);
        pi_reset(&drive.control.current_loop.pi_q, cfg.supervision.voltage_max + emf + 1);
        look_at_phases(cfg.supervision.swing_periods);
        TEST_ASSERT_EQUAL(DRIVE_STATE_IF_RAMP, drive.state);
        look_at_phases(1U);
        TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL(FAULT_CURRENT_IMPLAUSIBLE, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(cfg.supervision.voltage_max + emf + 1, drive.fault.value);
        TEST_ASSERT_EQUAL_INT32(cfg.supervision.voltage_max + emf, drive.fault.limit);
    }
}

TEST(test_the_torques_limits_follow_the_rotor_where_it_runs_and_the_vector_where_it_is_dragged)
{
    cfg.startup.current_hold = 0;                /* no imposed current comes in */
    now.sample.bus = cfg.derating.bus_high.zero; /* no braking */
    drive.rotor.observer.speed = 2 * cfg.derating.regeneration_speed;
    drive.vector.step = -2 * cfg.derating.regeneration_speed;
    enter(DRIVE_STATE_RUN);
    slot(SLOT_LIMITS);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_range.lower);
    TEST_ASSERT_EQUAL_INT32(cfg.derating.current_max, drive.motion.torque_range.upper);
    enter(DRIVE_STATE_IF_RAMP);
    slot(SLOT_LIMITS);
    TEST_ASSERT_EQUAL_INT32(-cfg.derating.current_max, drive.motion.torque_range.lower);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_range.upper);
}

/*
 * A rotor that stands at full torque is stalled in either direction, and not with one LSB to spare.
 */
TEST(test_a_stall_is_told_from_either_limit_of_the_torque)
{
    const int32_t torques[] = {8192, -8192, 8191, -8191};

    for (uint32_t k = 0U; k < 4U; k++) {
        const drive_state_t expected = (k < 2U) ? DRIVE_STATE_FAULT : DRIVE_STATE_RUN;

        setUp();
        enter(DRIVE_STATE_RUN);
        drive.motion.torque_range = (torque_range_t){-8192, 8192};
        drive.control.current_ref.q = torques[k];
        for (uint32_t turn = 0U; turn <= cfg.supervision.stall_periods; turn++) {
            drive.watch.supervision.step = SUPERVISION_STEPS - 1U;
            slot(SLOT_CHECKS);
        }
        TEST_ASSERT_EQUAL(expected, drive.state);
    }
    TEST_ASSERT_EQUAL(FAULT_NONE, drive.fault.id);
}

/* 20 Hz at 1 kHz. */
static int32_t wave(uint32_t k)
{
    return ((k % 50U) < 25U) ? 1 : -1;
}

static void swing_for(uint32_t periods)
{
    for (uint32_t k = 0U; k < periods; k++) {
        drive.control.current_ref.q = 4000 * wave(k);
        slot(SLOT_PHASES);
    }
}

/* 20 half-waves of 25, three more to begin with, and the end of the last */
#define SWING_FOUND (650U)

TEST(test_a_swing_in_run_is_a_fault_with_its_amplitude)
{
    enter(DRIVE_STATE_RUN);
    swing_for(SWING_FOUND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL(FAULT_OSCILLATION, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(4000, drive.fault.value);
    TEST_ASSERT_EQUAL_INT32(cfg.oscillation.amplitude_max, drive.fault.limit);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
}

TEST(test_a_swing_lowers_the_bandwidth_once_where_that_is_configured)
{
    cfg.oscillation.act = (uint32_t)OSCILLATION_ACT_LOWER;
    enter(DRIVE_STATE_RUN);
    swing_for(SWING_FOUND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.motion.speed_loop.halvings);
    swing_for(SWING_FOUND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL(FAULT_OSCILLATION, drive.fault.id);
}

TEST(test_no_swing_is_looked_for_where_that_is_configured_nor_below_run)
{
    cfg.oscillation.act = (uint32_t)OSCILLATION_ACT_NONE;
    enter(DRIVE_STATE_RUN);
    swing_for(2U * SWING_FOUND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    cfg.oscillation.act = (uint32_t)OSCILLATION_ACT_FAULT;
    enter(DRIVE_STATE_HANDOVER);
    swing_for(2U * SWING_FOUND);
    TEST_ASSERT_EQUAL(0U, drive.watch.oscillation.now);
}

/* Its speed loop is another one, so there is nothing to lower. */
TEST(test_a_swing_of_the_voltage_drive_is_a_fault_at_once)
{
    cfg.oscillation.act = (uint32_t)OSCILLATION_ACT_LOWER;
    enter(DRIVE_STATE_RUN);
    drive.voltage_drive.active = true;
    for (uint32_t k = 0U; k < SWING_FOUND; k++) {
        virtual_resistance_start(&drive.voltage_drive.damping, (dq_t){0, 4000 * wave(k)});
        slot(SLOT_PHASES);
    }
    TEST_ASSERT_EQUAL(FAULT_OSCILLATION, drive.fault.id);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
}

/*
 * In position control the reference of the speed follows the measured position: a swing of it is
 * none that is asked for.
 */
TEST(test_a_swing_in_position_control_is_found_while_the_profile_rests_and_only_then)
{
    for (int32_t profile = 0; profile <= 100; profile += 100) {
        setUp();
        enter(DRIVE_STATE_RUN);
        drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
        for (uint32_t k = 0U; k < ((profile == 0) ? SWING_FOUND : (4U * SWING_FOUND)); k++) {
            drive.control.current_ref.q = 4000 * wave(k);
            drive.motion.speed_loop.reference = (int32_t)(k % 50U) * 1000;
            drive.motion.position_loop.profile_speed += profile * wave(k);
            slot(SLOT_PHASES);
        }
        TEST_ASSERT_EQUAL((profile == 0) ? FAULT_OSCILLATION : FAULT_NONE, drive.fault.id);
    }
}
