/* SPDX-License-Identifier: MIT */
/*
 * Supervision: each fault at its limit and in its time, not just short of either, nor in what is
 * normal.
 */
#include "example_cfg.h"
#include "seeded.h"
#include "supervision.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>

#define TWO_PI (6.283185307179586)
#define TURN_Q16 (65536)
#define NOISE_Q15 (8 * 4) /* ±4 LSB of a 12-bit converter, as 1 LSB rms goes over a turn */

static supervision_cfg_t cfg;
static supervision_t state;
static fault_t fault;

void setUp(void)
{
    cfg = example_supervision_cfg();
    supervision_reset(&state);
    fault = (fault_t){.id = FAULT_NONE};
}

static void assert_fault(fault_id_t id, int32_t value, int32_t limit)
{
    TEST_ASSERT_EQUAL_INT(id, fault.id);
    TEST_ASSERT_EQUAL_INT32(value, fault.value);
    TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
}

#define LONG (2000U) /* more periods than any fault takes */
#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

/* ---- voltage in RUN ---- */

#define EMF (8000)

static uint32_t voltage_rounds(supervision_voltage_t in, uint32_t most)
{
    uint32_t rounds = 0U;

    while ((rounds < most) &&
           (supervision_check_voltage(&state, &cfg, &in, &fault) == FAULT_NONE)) {
        rounds++;
    }
    return rounds;
}

/* Twice the largest voltage and a quarter of the EMF, for half of a mean over 2^4 periods. */
TEST(test_a_voltage_beyond_its_limit_is_implausible_unless_excused_or_far_from_the_reference)
{
    const int32_t most = (2 * cfg.voltage_max) + (EMF / 4);
    const step_t far = cfg.speed_error_max / 2;
    supervision_voltage_t in = {.voltage = {most, -most}, .emf = EMF};

    TEST_ASSERT_EQUAL_UINT32(LONG, voltage_rounds(in, LONG));
    in.voltage = (dq_t){0, -most - 1};
    TEST_ASSERT_EQUAL_UINT32(8U, voltage_rounds(in, LONG));
    assert_fault(FAULT_CURRENT_IMPLAUSIBLE, most + 1, most);
    setUp();
    in = (supervision_voltage_t){.voltage = {32767, 32767}, .excused = true};
    TEST_ASSERT_EQUAL_UINT32(LONG, voltage_rounds(in, LONG));
    in = (supervision_voltage_t){.voltage = {32767, 32767}, .off_reference = far};
    TEST_ASSERT_EQUAL_UINT32(LONG, voltage_rounds(in, LONG));
    in.off_reference = far - 1;
    TEST_ASSERT_EQUAL_UINT32(8U, voltage_rounds(in, LONG));
}

TEST(test_a_voltage_of_either_axis_and_sign_is_large_beyond_twice_the_largest)
{
    const int32_t most = 2 * cfg.voltage_max;

    TEST_ASSERT_FALSE(supervision_is_large(&cfg, (dq_t){most, -most}));
    TEST_ASSERT_TRUE(supervision_is_large(&cfg, (dq_t){most + 1, 0}));
    TEST_ASSERT_TRUE(supervision_is_large(&cfg, (dq_t){-most - 1, 0}));
    TEST_ASSERT_TRUE(supervision_is_large(&cfg, (dq_t){0, most + 1}));
    TEST_ASSERT_TRUE(supervision_is_large(&cfg, (dq_t){0, -most - 1}));
}

/* What is at its limit neither counts nor is forgotten. */
TEST(test_a_voltage_between_two_that_are_at_the_limit_counts)
{
    const supervision_voltage_t wrong = {.voltage = {32767, 0}};
    const supervision_voltage_t excused = {.voltage = {32767, 0}, .excused = true};

    for (uint32_t k = 0U; k < 8U; k++) {
        TEST_ASSERT_EQUAL_UINT32(1U, voltage_rounds(wrong, 1U));
        TEST_ASSERT_EQUAL_UINT32(5U, voltage_rounds(excused, 5U));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, voltage_rounds(wrong, 1U));
}

/* ---- flux ---- */

#define FLUX_ONE (0x40000000)
#define FLUX_EMF (16384)
#define FLUX_UNIT (FLUX_ONE / FLUX_EMF) /* of φ̂ in one of the EMF */
#define FLUX_SETTLES (256U)             /* 2^(4 + 4) periods */

static fault_id_t flux(int32_t flux_q30, uint32_t periods)
{
    fault_id_t id = FAULT_NONE;

    for (uint32_t k = 0U; (k < periods) && (id == FAULT_NONE); k++) {
        id = supervision_check_flux(&state, &cfg, flux_q30, FLUX_EMF, &fault);
    }
    return id;
}

static void settle(void)
{
    supervision_reset(&state);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(FLUX_ONE, FLUX_SETTLES));
}

/* 5/64 of the EMF and a quarter of the largest voltage. */
static int32_t flux_limit(void)
{
    return (FLUX_EMF / 64 * 5) + (cfg.voltage_max / 4);
}

TEST(test_a_flux_may_settle_anywhere_and_is_judged_from_then_on)
{
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(FLUX_ONE, FLUX_SETTLES - 1U));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux((FLUX_ONE / 4) * 5, 1000U));
    TEST_ASSERT_EQUAL_INT(FAULT_FLUX_IMPLAUSIBLE, flux(FLUX_ONE, 1000U));
}

/* Either way; LSBs are those of the rounding. */
TEST(test_an_emf_that_jumps_beyond_its_limit_is_implausible)
{
    const int32_t limit = flux_limit();

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t twice = FLUX_ONE + (sign * 2 * limit * FLUX_UNIT);

        settle();
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(FLUX_ONE + (sign * (limit - 1) * FLUX_UNIT), 1000U));
        settle();
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(twice, 4U));
        TEST_ASSERT_EQUAL_INT(FAULT_FLUX_IMPLAUSIBLE, flux(twice, 1U));
        TEST_ASSERT_INT32_WITHIN(2 * limit * 5 / 256, 2 * limit,
                                 fault.value); /* the mean follows */
        TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
    }
}

/* A flux that goes ahead of its mean by as much as it may. */
TEST(test_a_flux_at_its_limit_is_no_fault_however_long)
{
    settle();
    for (uint32_t k = 0U; k < 20U; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(state.flux_q30 + (flux_limit() * FLUX_UNIT), 1U));
    }
}

/* The dead time takes as much at each speed, so a slow rotor's φ̂ may change by more. */
TEST(test_a_slow_rotor_has_a_flux_that_may_change_by_more)
{
    const int32_t slow = FLUX_EMF / 8;

    for (uint32_t k = 0U; k < 1000U; k++) {
        const int32_t now = (k < FLUX_SETTLES) ? FLUX_ONE : ((FLUX_ONE / 16) * 19);

        TEST_ASSERT_EQUAL_INT(FAULT_NONE, supervision_check_flux(&state, &cfg, now, slow, &fault));
    }
}

/* By 4/64 a second, to the end of its range: the mean follows. */
TEST(test_a_flux_that_creeps_is_no_fault)
{
    int32_t now = FLUX_ONE;

    settle();
    while (now < ((FLUX_ONE / 4) * 5)) {
        now += (FLUX_ONE / 16) / (int32_t)FLUX_SETTLES;
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux(now, 1U));
    }
}

TEST(test_another_flux_in_the_file_settles_anew)
{
    settle();
    supervision_forget_flux(&state);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, flux((FLUX_ONE / 4) * 5, 1000U));
}

TEST(test_the_fault_of_a_weak_phase_comes_in_place_of_a_voltage_or_a_flux)
{
    const supervision_voltage_t wrong = {.voltage = {32767, 0}};

    state.suspect = (fault_t){.id = FAULT_LOST_PHASE, .value = 3, .limit = 9};
    TEST_ASSERT_EQUAL_UINT32(8U, voltage_rounds(wrong, 1000U));
    assert_fault(FAULT_LOST_PHASE, 3, 9);
    settle();
    state.suspect = (fault_t){.id = FAULT_ADC_STUCK, .value = 4, .limit = 8};
    TEST_ASSERT_EQUAL_INT(FAULT_ADC_STUCK, flux((FLUX_ONE / 4) * 3, 1000U));
    assert_fault(FAULT_ADC_STUCK, 4, 8);
}

/* ---- phases ---- */

typedef struct {
    double amplitude;
    double advance; /* turns a slow period */
    double gain_a;
    int32_t noise;
    int32_t lost;  /* 0…2, or −1 */
    int32_t stuck; /* 0, 1, or −1 */
    int32_t stuck_at;
    uint32_t start_q16; /* turns at the first sample */
    step_t speed;
} phases_t;

static const phases_t HEALTHY = {4000.0, 0.05, 1.0, NOISE_Q15, -1, -1, 0, 0U, 1000000};

/* A turning current vector through what is broken. */
static supervision_phases_t sample(const phases_t *p, double turns, seeded_t *seed)
{
    double phase[3];
    supervision_phases_t in;

    for (int32_t k = 0; k < 3; k++) {
        phase[k] = p->amplitude * cos(TWO_PI * (turns - (k / 3.0)));
    }
    if (p->lost >= 0) { /* what the others have in common is gone */
        const double left = phase[(p->lost + 1) % 3] - phase[(p->lost + 2) % 3];

        phase[(p->lost + 1) % 3] = left / 2.0;
        phase[(p->lost + 2) % 3] = -left / 2.0;
        phase[p->lost] = 0.0;
    }
    in.a = (int32_t)(phase[0] * p->gain_a) + seeded_in(seed, -p->noise, p->noise);
    in.b = (int32_t)phase[1] + seeded_in(seed, -p->noise, p->noise);
    in.a = (p->stuck == 0) ? p->stuck_at : in.a;
    in.b = (p->stuck == 1) ? p->stuck_at : in.b;
    in.turns_q16 = (int32_t)(p->start_q16 + (uint32_t)(int64_t)(turns * TURN_Q16));
    in.speed = p->speed;
    return in;
}

/* Turns until the fault, at most `most`. */
static double turns_to_fault(const phases_t *p, double most)
{
    seeded_t seed = {0x9A5EU};
    double turns = 0.0;

    while (fabs(turns) < most) {
        const supervision_phases_t in = sample(p, turns, &seed);

        if (supervision_check_phases(&state, &cfg, &in, &fault) != FAULT_NONE) {
            break;
        }
        turns += p->advance;
    }
    return fabs(turns);
}

static void assert_no_fault(const phases_t *p)
{
    (void)turns_to_fault(p, 40.0);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, fault.id);
}

TEST(test_healthy_phases_are_no_fault_with_noise_and_gain_error_at_any_speed)
{
    /* Up to the advance from which on nothing is judged. */
    for (double advance = -0.4; advance <= 0.4; advance += 0.0123) {
        phases_t p = HEALTHY;

        p.advance = advance;
        for (int32_t k = 0; k < 3; k++) {
            setUp();
            p.gain_a = 0.99 + (0.01 * k);
            p.amplitude = (k == 2) ? 200.0 : 4000.0;
            assert_no_fault(&p);
        }
    }
}

TEST(test_each_lost_phase_is_found_in_three_half_turns)
{
    for (int32_t k = 0; k < 3; k++) {
        phases_t p = HEALTHY;
        double turns;

        setUp();
        p.lost = k;
        turns = turns_to_fault(&p, 40.0);
        TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, fault.id);
        TEST_ASSERT_TRUE(fault.value < fault.limit);
        /* An arc ends at most a sample late, and the next begins a sample after. */
        TEST_ASSERT_TRUE((turns >= 1.5) && (turns <= 1.5 + (5.0 * p.advance)));
    }
}

TEST(test_a_stuck_channel_is_found_in_three_half_turns_and_told_from_a_lost_phase)
{
    for (int32_t k = 0; k < 4; k++) {
        phases_t p = HEALTHY;

        setUp();
        p.stuck = k % 2;
        p.stuck_at = (k < 2) ? 3000 : -3000;
        TEST_ASSERT_TRUE(turns_to_fault(&p, 40.0) <= 1.5 + (5.0 * p.advance));
        TEST_ASSERT_EQUAL_INT(FAULT_ADC_STUCK, fault.id);
        TEST_ASSERT_EQUAL_INT32(0, fault.value);
    }
}

/* It has no channel that could be stuck: what stands still there is what both others make of it. */
TEST(test_a_third_phase_that_stands_still_is_lost_whatever_its_current)
{
    static const int32_t current[] = {0, 1500, -1500}; /* at most 275 is zero */

    for (uint32_t k = 0U; k < 3U; k++) {
        double turns = 0.0;

        setUp();
        while ((fault.id == FAULT_NONE) && (turns < 40.0)) {
            const int32_t swing = (int32_t)(2000.0 * cos(TWO_PI * turns));
            const supervision_phases_t in = {swing, -swing - current[k],
                                             (int32_t)(turns * TURN_Q16), 1000000};

            (void)supervision_check_phases(&state, &cfg, &in, &fault);
            turns += 0.05;
        }
        TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, fault.id);
        TEST_ASSERT_EQUAL_INT32(0, fault.value);
    }
}

/*
 * Sample by sample between 20 and −10, and ±4000: ranges of 30 and 8000, of which an eighth is
 * 1000.
 */
TEST(test_a_weak_phase_is_said_with_the_range_it_moved_in_and_what_it_should_have)
{
    for (int32_t k = 0; (k < 40) && (fault.id == FAULT_NONE); k++) {
        const bool even = (k % 2) == 0;
        const supervision_phases_t in = {even ? 20 : -10, even ? -4000 : 4000, k * (TURN_Q16 / 16),
                                         1000000};

        (void)supervision_check_phases(&state, &cfg, &in, &fault);
    }
    assert_fault(FAULT_LOST_PHASE, 30, 1000);
}

static fault_id_t found_without_noise(double amplitude, double gain_a, int32_t lost)
{
    phases_t p = HEALTHY;

    setUp();
    p.noise = 0;
    p.amplitude = amplitude;
    p.gain_a = gain_a;
    p.lost = lost;
    (void)turns_to_fault(&p, 40.0);
    return fault.id;
}

/*
 * In half a turn a moves by 1 to 2 of its amplitude, b by up to 2, c = −a − b by at most 1.07 of
 * that.
 */
TEST(test_a_phase_that_moves_an_eighth_of_the_strongest_is_weak_enough_to_live)
{
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, found_without_noise(4000.0, 0.28, -1));
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, found_without_noise(4000.0, 0.1, -1));
}

TEST(test_phases_are_not_compared_below_the_least_current)
{
    /* b and c: ±√3/2 of it, range at most 1100, limit 1101 */
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, found_without_noise(635.0, 1.0, 0));
    /* at least 1160, less what half a sample at each end takes */
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, found_without_noise(1340.0, 1.0, 0));
}

TEST(test_constant_currents_at_standstill_are_never_a_stuck_channel)
{
    seeded_t seed = {0x57A4DU};

    for (int32_t k = 0; k < 100000; k++) {
        /* One phase at zero, the others loaded and released; the rotor rocks within a turn. */
        const int32_t load = ((k / 1000) % 2) * 6000;
        const supervision_phases_t in = {seeded_in(&seed, -8, 8), load,
                                         seeded_in(&seed, -20000, 20000), 0};

        TEST_ASSERT_EQUAL_INT(FAULT_NONE, supervision_check_phases(&state, &cfg, &in, &fault));
    }
}

TEST(test_load_steps_within_a_turn_are_no_fault)
{
    seeded_t seed = {0x10ADU};
    double turns = 0.0;

    for (int32_t k = 0; k < 200000; k++) {
        phases_t p = HEALTHY;
        supervision_phases_t in;

        p.amplitude = ((seeded_u32(&seed) % 64U) == 0U) ? 6000.0 : 60.0;
        p.advance = 0.01;
        in = sample(&p, turns, &seed);
        turns += p.advance;
        (void)supervision_check_phases(&state, &cfg, &in, &fault);
    }
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, fault.id);
}

TEST(test_too_fast_a_turn_is_not_judged)
{
    phases_t p = HEALTHY;

    p.lost = 0;
    p.speed = cfg.phase_speed_max + 1;
    assert_no_fault(&p);
    p.speed = cfg.phase_speed_max;
    (void)turns_to_fault(&p, 40.0);
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, fault.id);
}

TEST(test_turns_are_counted_across_the_end_of_their_word)
{
    phases_t p = HEALTHY;

    p.lost = 1;
    p.start_q16 = 0x7FFFF000U;
    (void)turns_to_fault(&p, 10.0);
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, fault.id);
}

/* ---- an imposed current ---- */

/* A current vector of this length at an angle, in αβ. */
static ab_t vector(double length, double turns)
{
    return (ab_t){(int32_t)lround(length * cos(TWO_PI * turns)),
                  (int32_t)lround(length * sin(TWO_PI * turns))};
}

static supervision_imposed_t imposed(double length, double turns)
{
    supervision_imposed_t in = {.expected = vector(length, turns), .emf = 500};

    in.a = in.expected.alpha;
    in.b = (int32_t)lround(length * cos(TWO_PI * (turns - (1.0 / 3.0))));
    return in;
}

/* Phase a has all of the current, and none flows in it. */
static supervision_imposed_t without_a(void)
{
    supervision_imposed_t in = imposed(6554.0, 0.0);

    in.a = 0;
    in.b = 5000;
    return in;
}

/* Slow periods until the fault, or `LONG`. */
static uint32_t imposed_to_fault(const supervision_imposed_t *in)
{
    uint32_t periods = 1U;

    while ((periods < LONG) &&
           (supervision_check_imposed(&state, &cfg, in, &fault) == FAULT_NONE)) {
        periods++;
    }
    return periods;
}

TEST(test_an_imposed_current_that_flows_is_no_fault_at_any_angle)
{
    for (int32_t k = 0; k < 64; k++) {
        const supervision_imposed_t in = imposed(6554.0, k / 64.0);

        setUp();
        TEST_ASSERT_EQUAL_UINT32(LONG, imposed_to_fault(&in));
    }
}

/* The periods of the limit, one in which it is not yet the same phase, and the one beyond. */
TEST(test_each_phase_without_its_imposed_current_is_lost_after_its_time)
{
    static const int32_t measured[][2] = {{0, 5000}, {5000, 0}, {5000, -5000}};

    for (int32_t k = 0; k < 3; k++) {
        supervision_imposed_t in = imposed(6554.0, k / 3.0); /* phase k has all of it */

        setUp();
        in.a = measured[k][0];
        in.b = measured[k][1];
        TEST_ASSERT_EQUAL_UINT32(cfg.swing_periods + 2U, imposed_to_fault(&in));
        assert_fault(FAULT_LOST_PHASE, 0, cfg.phase_range_min);
    }
}

TEST(test_a_phase_is_absent_from_the_least_current_on_and_up_to_the_largest_zero)
{
    supervision_imposed_t in = imposed(cfg.phase_range_min, 0.0);

    in.a = cfg.phase_zero_max;
    in.b = 5000;
    TEST_ASSERT_EQUAL_UINT32(LONG, imposed_to_fault(&in));
    in.expected.alpha++;
    TEST_ASSERT_TRUE(imposed_to_fault(&in) < LONG);
    assert_fault(FAULT_LOST_PHASE, cfg.phase_zero_max, cfg.phase_range_min);
    setUp();
    in.a++;
    TEST_ASSERT_EQUAL_UINT32(LONG, imposed_to_fault(&in));
}

TEST(test_a_swing_that_passes_through_zero_is_no_lost_phase)
{
    const supervision_imposed_t whole = imposed(6554.0, 0.0);
    const supervision_imposed_t none = without_a();
    for (uint32_t k = 0U; k < (100U * (cfg.swing_periods + 2U)); k++) {
        const bool through = (k % (cfg.swing_periods + 2U)) <= cfg.swing_periods;

        TEST_ASSERT_EQUAL_INT(
            FAULT_NONE, supervision_check_imposed(&state, &cfg, through ? &none : &whole, &fault));
    }
}

TEST(test_voltage_that_the_current_cannot_need_is_found_in_each_axis_and_direction)
{
    for (int32_t k = 0; k < 4; k++) {
        supervision_imposed_t in = imposed(6554.0, 0.1);
        const int32_t limit = cfg.voltage_max + in.emf;
        int32_t *const axis = (k < 2) ? &in.voltage.d : &in.voltage.q;

        setUp();
        *axis = ((k % 2) == 0) ? limit : -limit;
        TEST_ASSERT_EQUAL_UINT32(LONG, imposed_to_fault(&in));
        *axis += ((k % 2) == 0) ? 1 : -1;
        TEST_ASSERT_EQUAL_UINT32(cfg.swing_periods + 1U, imposed_to_fault(&in));
        assert_fault(FAULT_CURRENT_IMPLAUSIBLE, limit + 1, limit);
    }
}

TEST(test_too_much_voltage_with_a_phase_at_zero_is_a_lost_phase)
{
    supervision_imposed_t in = without_a();

    in.voltage.d = 20000;
    TEST_ASSERT_EQUAL_UINT32(cfg.swing_periods + 1U, imposed_to_fault(&in));
    assert_fault(FAULT_LOST_PHASE, 0, cfg.phase_range_min);
}

/* ---- current and observer ---- */

static fault_id_t follow(int32_t error_d, int32_t error_q)
{
    const supervision_current_t in = {.current = {.d = 1000, .q = -2000},
                                      .reference = {.d = 1000 + error_d, .q = -2000 + error_q}};

    return supervision_check_current(&state, &cfg, &in, &fault);
}

static fault_id_t residual(int32_t d, int32_t q)
{
    return supervision_check_observer(&state, &cfg, (dq_t){d, q}, &fault);
}

/* An error of this size in each axis and direction is found when its mean is beyond the limit. */
static void assert_found(fault_id_t (*check)(int32_t d, int32_t q), int32_t size, fault_id_t id,
                         int32_t limit)
{
    static const int32_t directions[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

    for (uint32_t k = 0U; k < COUNT(directions); k++) {
        int32_t periods = 1;

        setUp();
        while (check(directions[k][0] * size, directions[k][1] * size) == FAULT_NONE) {
            periods++;
            TEST_ASSERT_TRUE(periods < 100);
        }
        TEST_ASSERT_INT32_WITHIN(1, 12, periods);
        TEST_ASSERT_EQUAL_INT(id, fault.id);
        TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
        TEST_ASSERT_TRUE(fault.value > limit);
    }
}

/* A mean over 16 crosses half of a step after 16·ln 2 = 11.1; seen one period later. */
TEST(test_a_current_that_does_not_follow_is_a_lost_phase_in_each_axis_and_direction)
{
    assert_found(follow, 2 * cfg.follow_error_max, FAULT_LOST_PHASE, cfg.follow_error_max);
}

/* A mean over 16 crosses 0.504 of a step after 16·ln(1/0.496) = 11.2; seen one later. */
TEST(test_a_large_model_error_in_either_axis_is_a_lost_observer)
{
    assert_found(residual, 8191, FAULT_OBSERVER_LOST, cfg.residual_max);
}

TEST(test_an_error_at_its_limit_or_a_short_one_is_no_fault)
{
    const int32_t most_current = cfg.follow_error_max;
    const int32_t most_residual = cfg.residual_max;
    const struct {
        const char *name;
        fault_id_t (*check)(int32_t d, int32_t q);
        dq_t error;
        int32_t on; /* so many periods of… */
        int32_t of;
        int32_t otherwise; /* times the error */
    } rows[] = {
        {"current error at its limit", follow, {most_current, -most_current}, 1, 1, 0},
        {"reference that jitters", follow, {10000, -10000}, 1, 2, -1},
        /* A period late, four times a second; the current loop needs a tenth of one. */
        {"steps of the largest current", follow, {0, 16384}, 1, 60, 0},
        {"model error at its limit", residual, {most_residual, -most_residual}, 1, 1, 0},
        {"model error for 32 ms in 160 ms", residual, {8191, 8191}, 8, 40, 0},
    };

    for (uint32_t n = 0U; n < COUNT(rows); n++) {
        setUp();
        for (int32_t k = 0; k < 10000; k++) {
            const int32_t times = ((k % rows[n].of) < rows[n].on) ? 1 : rows[n].otherwise;

            TEST_ASSERT_EQUAL_INT_MESSAGE(
                FAULT_NONE, rows[n].check(times * rows[n].error.d, times * rows[n].error.q),
                rows[n].name);
        }
    }
}

TEST(test_a_current_error_of_a_turning_rotor_is_excused)
{
    const supervision_current_t in = {.reference = {16384, 16384}, .excused = true};

    for (int32_t k = 0; k < 10000; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, supervision_check_current(&state, &cfg, &in, &fault));
    }
    /* Nor is any of it kept for later. */
    TEST_ASSERT_EQUAL_INT32(0, state.off_current.d);
    TEST_ASSERT_EQUAL_INT32(0, state.off_current.q);
}

/* ---- speed ---- */

#define WANTED (10000000)
#define FASTEST (35791394) /* that the observer allows */

/* Periods until the fault, or `most`. */
static uint32_t periods_to_fault(const supervision_speed_t *in, uint32_t most)
{
    uint32_t k = 0U;

    while ((k < most) && (supervision_check_speed(&state, &cfg, in, &fault) == FAULT_NONE)) {
        k++;
    }
    return k;
}

#define NO_FAULT ((fault_t){.id = FAULT_NONE})

/* In both directions. */
static void assert_speed(supervision_speed_t in, uint32_t periods, fault_t expected)
{
    for (int32_t k = 0; k < 2; k++) {
        setUp();
        TEST_ASSERT_EQUAL_UINT32(periods, periods_to_fault(&in, LONG));
        assert_fault(expected.id, expected.value, expected.limit);
        in.speed = -in.speed;
        in.reference = -in.reference;
        in.current_ref = -in.current_ref;
    }
}

TEST(test_a_speed_off_its_reference_with_torque_to_spare_is_implausible)
{
    const step_t most = cfg.speed_error_max;
    const step_t off = WANTED - most - 1;

    assert_speed((supervision_speed_t){off, WANTED, FASTEST, 1000, false}, cfg.speed_error_periods,
                 (fault_t){FAULT_SPEED_IMPLAUSIBLE, most + 1, most, 0U});
    assert_speed((supervision_speed_t){off + 1, WANTED, FASTEST, 1000, false}, LONG, NO_FAULT);
    /* The load is too heavy. */
    assert_speed((supervision_speed_t){off, WANTED, FASTEST, 1000, true}, LONG, NO_FAULT);
}

TEST(test_an_estimate_at_the_observers_limit_is_implausible)
{
    assert_speed((supervision_speed_t){FASTEST, WANTED, FASTEST, 1000, true}, cfg.runaway_periods,
                 (fault_t){FAULT_SPEED_IMPLAUSIBLE, FASTEST, FASTEST, 0U});
}

TEST(test_overspeed_begins_one_above_its_limit_in_either_direction)
{
    const step_t most = cfg.overspeed;

    assert_speed((supervision_speed_t){most, most, FASTEST, 1000, false}, LONG, NO_FAULT);
    assert_speed((supervision_speed_t){most + 1, most + 1, FASTEST, 1000, false},
                 cfg.overspeed_periods, (fault_t){FAULT_OVERSPEED, most + 1, most, 0U});
}

/* The torque has the sign of the current. */
static void check_stall(step_t speed, int32_t current, bool at_limit, bool stalls)
{
    const fault_t stall = {FAULT_STALL, abs(speed), cfg.stall_speed, 0U};

    assert_speed((supervision_speed_t){speed, 0, FASTEST, current, at_limit},
                 stalls ? cfg.stall_periods : LONG, stalls ? stall : NO_FAULT);
}

TEST(test_full_torque_is_a_stall_after_its_time_unless_the_rotor_turns_with_it)
{
    const step_t slow = cfg.stall_speed;
    const int32_t full = cfg.stall_current;

    check_stall(0, full, true, true);
    check_stall(slow - 1, full, true, true);
    check_stall(slow, full, true, false);
    check_stall(1 - slow, full, true, true);
    check_stall(-5 * slow, full, true, true);
    check_stall(1 - slow, full, false, false);
    check_stall(1 - slow, full - 1, true, false); /* derated: no torque to move with */
}

/* Full torque, against which a rotor creeps. */
static supervision_speed_t stalled(void)
{
    return (supervision_speed_t){cfg.stall_speed - 1, WANTED, FASTEST, -cfg.stall_current, true};
}

/*
 * The torque turns over while the rotor stands: what turns from then on against it is braked from
 * there.
 */
TEST(test_a_rotor_that_a_new_torque_brakes_is_not_stalled)
{
    supervision_speed_t in = stalled();

    in.speed = 0;
    TEST_ASSERT_EQUAL_UINT32(cfg.stall_periods / 2U, periods_to_fault(&in, cfg.stall_periods / 2U));
    in.current_ref = cfg.stall_current;
    for (int32_t times = 5; times >= 4; times--) {
        in.speed = -times * cfg.stall_speed;
        TEST_ASSERT_EQUAL(FAULT_NONE, supervision_check_speed(&state, &cfg, &in, &fault));
    }
    TEST_ASSERT_TRUE(state.stalled <= 1U);
}

/* Slower by the stall speed each time just before it would be one; at rest it is one. */
TEST(test_a_rotor_that_full_torque_brakes_is_not_stalled_until_it_stands)
{
    supervision_speed_t in = stalled();

    for (int32_t times = 40; times > 0; times--) {
        in.speed = times * cfg.stall_speed;
        TEST_ASSERT_EQUAL_UINT32(cfg.stall_periods, periods_to_fault(&in, cfg.stall_periods));
    }
    in.speed = 0;
    TEST_ASSERT_EQUAL_UINT32(cfg.stall_periods, periods_to_fault(&in, LONG));
}

/* One step of progress at most, as it is the best that counts. */
TEST(test_a_ripple_of_the_speed_brakes_nothing)
{
    supervision_speed_t in = stalled();
    uint32_t periods = 0U;
    fault_id_t id = FAULT_NONE;

    while ((id == FAULT_NONE) && (periods < LONG)) {
        in.speed = (((periods % 2U) == 0U) ? 6 : 5) * cfg.stall_speed;
        id = supervision_check_speed(&state, &cfg, &in, &fault);
        periods++;
    }
    TEST_ASSERT_EQUAL_INT(FAULT_STALL, id);
    TEST_ASSERT_TRUE(periods <= (cfg.stall_periods + 3U));
}

TEST(test_trouble_that_comes_and_goes_is_forgotten_as_it_came)
{
    for (uint32_t k = 0U; k < LONG; k++) {
        const step_t speed = ((k % 8U) < 4U) ? (cfg.overspeed + 1) : cfg.overspeed;
        const supervision_speed_t in = {speed, speed, FASTEST, 1000, false};

        TEST_ASSERT_EQUAL_INT(FAULT_NONE, supervision_check_speed(&state, &cfg, &in, &fault));
    }
}

/* ---- late ticks ---- */

TEST(test_more_late_ticks_than_allowed_in_a_window_are_a_fault)
{
    for (uint32_t k = 0U; k < cfg.late_max; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, supervision_count_late(&state, &cfg, &fault));
    }
    TEST_ASSERT_EQUAL_INT(FAULT_LATE, supervision_count_late(&state, &cfg, &fault));
    assert_fault(FAULT_LATE, (int32_t)cfg.late_max + 1, (int32_t)cfg.late_max);
}

TEST(test_late_ticks_are_forgotten_at_the_end_of_the_window)
{
    for (uint32_t k = 0U; k < (10U * cfg.late_window); k++) {
        if ((k % cfg.late_window) == 0U) {
            TEST_ASSERT_EQUAL_UINT32(0U, state.late);
            state.late = cfg.late_max;
        }
        supervision_forget_late(&state, &cfg);
    }
}

TEST(test_reset_forgets_everything)
{
    static const supervision_t fresh = {.absent = SUPERVISION_PHASES, .flux_q30 = FLUX_ONE};
    const supervision_speed_t in = stalled();
    phases_t p = HEALTHY;
    supervision_imposed_t lost = without_a();

    lost.voltage.d = 20000;
    for (uint32_t k = 0U; k < 3U; k++) {
        (void)supervision_check_imposed(&state, &cfg, &lost, &fault);
    }
    (void)periods_to_fault(&in, 10U);
    (void)turns_to_fault(&p, 1.5);
    (void)follow(500, 500);
    (void)residual(500, 500);
    (void)residual(500, 500);
    state.late = 5U;
    state.step = 3U;
    supervision_reset(&state);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &state, sizeof state);
}
