/* SPDX-License-Identifier: MIT */
/* Looking for a rotor that turns: shorted windings of a turning motor, a standing one, noise. */
#include "example_cfg.h"
#include "figure.h"
#include "flying_start.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define TWO_PI (6.283185307179586)
#define TURN (4294967296.0)

/* Motor A and the bases of example_cfg.h. */
#define PERIOD_S (1e-4)
#define RESISTANCE (2.125)
#define INDUCTANCE (0.0116)
#define FLUX (0.387)
#define CURRENT_LSB_A (40.0 / 32768.0)

/* Preload, two pulses of 8, a pause of 64. */
#define PRELOAD_TICKS (2U)
#define LONGEST_TICKS (PRELOAD_TICKS + (8U * (cfg.gap_factor + 2U)))
#define TELLING_GAP (40U) /* pulses: the rotor turns by 0.6 to 1.7 rad at the speeds below */

static double inductance;
static flying_start_cfg_t cfg;
static flying_start_t start;
static seeded_t seed;

void setUp(void)
{
    cfg = example_flying_start_cfg();
    inductance = INDUCTANCE;
    cfg.pause_max = 256U; /* the pulse's length alone sets the pause */
    flying_start_reset(&start);
    seed = (seeded_t){0x5917U};
}

static flying_start_result_t step(int32_t alpha, int32_t beta)
{
    return flying_start_step(&start, &cfg, (ab_t){alpha, beta});
}

/* noise: the largest, Q15 of I_b. */
static flying_start_result_t step_noisy(double alpha, double beta, int32_t noise)
{
    const int32_t noise_alpha = seeded_in(&seed, -noise, noise);
    const int32_t noise_beta = seeded_in(&seed, -noise, noise);

    return step((int32_t)lround(alpha) + noise_alpha, (int32_t)lround(beta) + noise_beta);
}

/* ---- a motor at constant speed ---- */

typedef struct {
    double speed; /* electrical, rad/s */
    double angle;
    double alpha_a;
    double beta_a;
} motor_t;

/* Shorted: L·di/dt = −R·i − e, e = ωφ·(−sin θ, cos θ). Open: the diodes have ended the current. */
static void motor_tick(motor_t *m, bool shorted)
{
    const double h = PERIOD_S / 100.0;

    for (int32_t i = 0; i < 100; i++) {
        const double middle = m->angle + (m->speed * h / 2.0);
        const double alpha = (-RESISTANCE * m->alpha_a) + (m->speed * FLUX * sin(middle));
        const double beta = (-RESISTANCE * m->beta_a) - (m->speed * FLUX * cos(middle));

        m->alpha_a = shorted ? (m->alpha_a + (alpha * h / inductance)) : 0.0;
        m->beta_a = shorted ? (m->beta_a + (beta * h / inductance)) : 0.0;
        m->angle += m->speed * h;
    }
}

/* Until the result, at which the motor is left. */
static flying_start_result_t look(motor_t *m, int32_t noise)
{
    flying_start_result_t result = FLYING_START_BUSY;
    uint32_t ticks = 0U;

    flying_start_reset(&start);
    while (result == FLYING_START_BUSY) {
        result = step_noisy(m->alpha_a / CURRENT_LSB_A, m->beta_a / CURRENT_LSB_A, noise);
        ticks++;
        TEST_ASSERT_TRUE(ticks <= LONGEST_TICKS);
        if (result == FLYING_START_BUSY) {
            motor_tick(m, start.gates);
        }
    }
    return result;
}

static flying_start_result_t look_from(double speed, double angle, int32_t noise)
{
    motor_t m = {.speed = speed, .angle = angle};

    return look(&m, noise);
}

/*
 * Of a current of so many LSB rounding and noise turn the direction by (½ + noise)·√2 of it; atan2
 * 2^-17 turn.
 */
static double direction_error(double current, double noise)
{
    return (((0.5 + noise) * 1.4143) / current) + (TWO_PI / 131072.0);
}

/*
 * Least current at the end of a pulse: that at which it ends, or what 8 ticks give, less R·t/L/2 of
 * it.
 */
static double least_current(double speed)
{
    const double per_tick = fabs(speed) * FLUX / INDUCTANCE * PERIOD_S / CURRENT_LSB_A;

    return fmin(cfg.current, 8.0 * per_tick * 0.92);
}

/* As shares of their bounds. */
typedef struct {
    double speed;
    double angle;
} worst_t;

/*
 * Speed: two directions, over the time between both pulses. Angle: one direction, and the mean of
 * the EMF lies R·t²/(12·L)·ω behind the middle of the pulse, t ≤ 0.8 ms; the speed's error times
 * half the pulse.
 */
static void look_at(double speed, double angle, int32_t noise, worst_t *worst)
{
    motor_t m = {.speed = speed, .angle = angle};
    const flying_start_result_t result = look(&m, noise);
    const double error = direction_error(least_current(speed), noise);
    const double pulse_s = start.length * PERIOD_S;
    const double late = fabs(speed) * RESISTANCE / INDUCTANCE * pulse_s * pulse_s / 12.0;
    const double speed_error = (start.speed / TURN * TWO_PI / PERIOD_S) - speed;
    const double angle_error = remainder(((double)start.angle / TURN * TWO_PI) - m.angle, TWO_PI);

    TEST_ASSERT_EQUAL_INT(FLYING_START_TURNING, result);
    worst->speed = fmax(worst->speed, fabs(speed_error) / (2.0 * error / (9.0 * pulse_s)));
    worst->angle = fmax(worst->angle, fabs(angle_error) / (late + error + (error / 9.0)));
}

static void assert_found(const double speeds[], uint32_t count, int32_t angles, int32_t noise)
{
    worst_t worst = {0.0, 0.0};

    for (uint32_t i = 0U; i < count; i++) {
        for (int32_t k = 0; k < angles; k++) {
            look_at(speeds[i], TWO_PI * k / angles, noise, &worst);
            look_at(-speeds[i], TWO_PI * k / angles, noise, &worst);
        }
    }
    figure_check("speed, as a share of its bound", worst.speed, 1.0, 0.2);
    figure_check("angle, as a share of its bound", worst.angle, 1.0, 0.2);
}

TEST(test_speed_and_angle_of_a_turning_rotor_are_found_in_both_directions)
{
    static const double speeds[] = {10.0, 20.0, 40.0, 90.0, 150.0, 251.0, 377.0, 419.0};

    assert_found(speeds, 8U, 24, 0);
}

TEST(test_noise_of_a_count_turns_the_directions_and_nothing_else)
{
    static const double speeds[] = {20.0, 90.0, 377.0};

    assert_found(speeds, 3U, 100, 8);
}

/*
 * Two directions give the speed and two magnitudes the current; each magnitude is off by half a
 * count in both axes. While the current rises the EMF turns: of a pulse that turns by x the sum of
 * the EMF is 1 − x²/24 of that of a rotor that rests, x ≤ 0.1 here. R is written as that of L = 1:
 * of a pulse of t it takes R·t/(2·L), 0.075 at most, which another L makes 0.7 to 1.5 times that.
 */
static double inductance_tolerance(double speed, double ratio)
{
    const double current = least_current(speed) / ratio;
    const double direction = 2.0 * direction_error(current, 0.0) /
                             (start.length * (1.0 + cfg.gap_factor) * PERIOD_S * fabs(speed));
    const double pulse_s = start.length * PERIOD_S;
    const double turned = fabs(speed) * pulse_s;
    const double taken = RESISTANCE * pulse_s / (2.0 * INDUCTANCE);

    return direction + (0.7072 / current) + (turned * turned / 24.0) +
           (taken * fabs(1.0 - (1.0 / ratio))) + 1e-3;
}

TEST(test_the_current_of_the_pulses_tells_the_inductance)
{
    static const double speeds[] = {90.0, -150.0, 251.0, -419.0};
    static const double ratios[] = {0.7, 1.0, 1.25, 1.5};
    double worst = 0.0;

    cfg.gap_factor = TELLING_GAP;
    for (uint32_t i = 0U; i < 16U; i++) {
        const double speed = speeds[i % 4U];
        const double ratio = ratios[i / 4U];

        inductance = ratio * INDUCTANCE;
        for (int32_t k = 0; k < 24; k++) {
            TEST_ASSERT_EQUAL_INT(FLYING_START_TURNING, look_from(speed, TWO_PI * k / 24.0, 0));
            worst = fmax(worst, fabs((start.inductance_q14 / 16384.0 / ratio) - 1.0) /
                                    inductance_tolerance(speed, ratio));
        }
    }
    figure_check("inductance, as a share of its bound", worst, 1.0, 0.2);
}

/* 9 ticks of 41.9 mrad from one pulse of one tick to the other, and 16 of 9 mrad: 22° and 8°. */
TEST(test_a_rotor_that_turns_little_between_the_pulses_does_not_tell_the_inductance)
{
    cfg.pause_max = 8U;
    inductance = 1.25 * INDUCTANCE;
    for (int32_t k = 0; k < 24; k++) {
        const double speed = ((k % 2) == 0) ? 419.0 : -90.0;

        TEST_ASSERT_EQUAL_INT(FLYING_START_TURNING, look_from(speed, TWO_PI * k / 24.0, 0));
        TEST_ASSERT_EQUAL_INT32(0, start.inductance_q14);
    }
}

TEST(test_a_standing_rotor_is_standing_with_and_without_noise)
{
    /* Up to a quarter of the threshold, 102.5, in both axes: √2·72 = 101.8. */
    for (int32_t k = 0; k < 2000; k++) {
        TEST_ASSERT_EQUAL_INT(FLYING_START_STANDING, look_from(0.0, k, (k % 4) * 24));
    }
}

/* 8 ticks at 3 rad/s give 64 LSB: below a quarter of the threshold. */
TEST(test_a_rotor_too_slow_to_tell_is_standing)
{
    for (int32_t k = 0; k < 24; k++) {
        TEST_ASSERT_EQUAL_INT(FLYING_START_STANDING, look_from(((k % 2) == 0) ? 3.0 : -3.0, k, 0));
    }
}

/* ---- sequence ---- */

TEST(test_a_long_pulse_is_followed_by_the_longest_pause_allowed)
{
    uint32_t off = 0U;

    cfg.pause_max = 20U;
    for (uint32_t tick = 0U; tick < (PRELOAD_TICKS + 8U + 20U + 7U); tick++) {
        (void)step(0, 0);
        off += (start.phase == FLYING_START_PAUSE) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(20U, off);
    TEST_ASSERT_EQUAL_INT(FLYING_START_STANDING, step(0, 0));
}

TEST(test_gates_are_on_in_the_pulses_and_off_in_the_pause)
{
    TEST_ASSERT_FALSE(start.gates);
    for (uint32_t tick = 1U; tick <= LONGEST_TICKS; tick++) {
        const flying_start_result_t result = step(0, 0);
        const bool preload = tick < PRELOAD_TICKS;
        const bool pause = (tick >= (PRELOAD_TICKS + 8U)) && (tick < (PRELOAD_TICKS + 72U));

        TEST_ASSERT_EQUAL_INT(!preload && !pause, start.gates);
        TEST_ASSERT_EQUAL_INT((tick == LONGEST_TICKS) ? FLYING_START_STANDING : FLYING_START_BUSY,
                              result);
    }
}

TEST(test_first_pulse_ends_above_the_current_and_the_second_is_as_long)
{
    for (uint32_t length = 1U; length <= 8U; length++) {
        flying_start_result_t result = FLYING_START_BUSY;
        uint32_t tick = 0U;
        uint32_t on = 0U;

        flying_start_reset(&start);
        while (result == FLYING_START_BUSY) {
            /* In the preload no current flows; 410 alone is not above. */
            const bool above = (tick + 1U) >= (PRELOAD_TICKS + length);
            const int32_t current = (tick < PRELOAD_TICKS) ? 0 : (above ? 411 : 410);

            result = step(current, 0);
            tick++;
            on += (start.gates && (result == FLYING_START_BUSY)) ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL_UINT32(length, start.length);
        TEST_ASSERT_EQUAL_UINT32(2U * length, on);
        TEST_ASSERT_EQUAL_UINT32(PRELOAD_TICKS + (length * 10U), tick);
    }
}

/* ---- charge of the bootstrap supplies ---- */

/* Ticks until the result; the gates are on behind the second pulse. */
static uint32_t ticks_at_rest(void)
{
    uint32_t ticks = 1U;

    flying_start_reset(&start);
    while (step(0, 0) == FLYING_START_BUSY) {
        TEST_ASSERT_TRUE(start.gates || (ticks < LONGEST_TICKS));
        ticks++;
    }
    return ticks;
}

TEST(test_at_a_standing_rotor_the_gates_stay_on_for_exactly_the_charge)
{
    static const uint32_t lengths[] = {0U, 1U, 2U, 200U, 0x100000U};

    for (uint32_t i = 0U; i < (sizeof lengths / sizeof lengths[0]); i++) {
        cfg.charge_ticks = lengths[i];
        TEST_ASSERT_EQUAL_UINT32(LONGEST_TICKS + lengths[i], ticks_at_rest());
        TEST_ASSERT_EQUAL_UINT32(LONGEST_TICKS + lengths[i], ticks_at_rest());
    }
}

TEST(test_a_turning_rotor_is_not_braked_by_a_charge)
{
    cfg.charge_ticks = 200U;
    for (int32_t k = 0; k < 24; k++) {
        const double speed = ((k % 2) == 0) ? 10.0 : -90.0;

        TEST_ASSERT_EQUAL_INT(FLYING_START_TURNING, look_from(speed, k, 0)); /* in LONGEST_TICKS */
    }
}

TEST(test_gates_stay_open_until_the_current_from_before_has_ended)
{
    const int32_t quiet = cfg.current / 4; /* 102 */

    for (uint32_t tick = 1U; tick < cfg.wait_ticks; tick++) {
        TEST_ASSERT_EQUAL_INT(FLYING_START_BUSY, step(0, -(quiet + 1)));
        TEST_ASSERT_FALSE(start.gates);
    }
    TEST_ASSERT_EQUAL_INT(FLYING_START_BUSY, step(0, -quiet));
    TEST_ASSERT_TRUE(start.gates);
}

TEST(test_without_a_current_the_gates_wait_until_the_compare_values_of_now_act)
{
    cfg.wait_ticks = 1U;
    TEST_ASSERT_EQUAL_INT(FLYING_START_BUSY, step(0, 0));
    TEST_ASSERT_FALSE(start.gates);
    TEST_ASSERT_EQUAL_INT(FLYING_START_BUSY, step(0, 0));
    TEST_ASSERT_TRUE(start.gates);
}

TEST(test_a_current_that_does_not_end_in_time_is_reported_with_open_gates)
{
    for (uint32_t tick = 1U; tick < cfg.wait_ticks; tick++) {
        TEST_ASSERT_EQUAL_INT(FLYING_START_BUSY, step(2000, 0));
    }
    TEST_ASSERT_EQUAL_INT(FLYING_START_LIVE, step(2000, 0));
    TEST_ASSERT_FALSE(start.gates);
}

/* A current of 2000 LSB that turns by `turn` in each tick, until it is reported. */
static step_t speed_of_live_current(double turn, int32_t noise)
{
    flying_start_result_t result = FLYING_START_BUSY;

    flying_start_reset(&start);
    for (uint32_t tick = 0U; (tick <= cfg.wait_ticks) && (result == FLYING_START_BUSY); tick++) {
        const double angle = TWO_PI * turn * tick;

        result = step_noisy(2000.0 * cos(angle), 2000.0 * sin(angle), noise);
    }
    TEST_ASSERT_EQUAL_INT(FLYING_START_LIVE, result);
    TEST_ASSERT_FALSE(start.gates);
    return start.speed;
}

/*
 * The directions of the first current and of the last are off by noise and rounding, which counts
 * over all ticks.
 */
TEST(test_a_current_that_does_not_end_tells_its_speed)
{
    cfg.wait_ticks = 1000U;
    for (double turn = -0.24; turn <= 0.24; turn += 0.013) {
        const double speed = turn * TURN;
        const double noise = 2.0 * 16.5 * 1.4143 / 2000.0 / TWO_PI / 998.0 * TURN;
        /* each mean is rounded by two at most */
        const double rounding = 2.0 * 1000.0;

        TEST_ASSERT_TRUE(fabs(speed_of_live_current(turn, 16) - speed) <= (noise + rounding));
    }
}

TEST(test_the_longest_wait_tells_the_speed_of_a_current_too)
{
    cfg.wait_ticks = 0x100000U;
    /* each mean is rounded by two at most, and divided by the ticks after it */
    TEST_ASSERT_TRUE(fabs(speed_of_live_current(0.125, 0) - (0.125 * TURN)) <= 4.0);
}

TEST(test_a_current_that_stands_still_has_no_speed)
{
    cfg.wait_ticks = 1000U;
    TEST_ASSERT_TRUE(abs(speed_of_live_current(0.0, 16)) <= 20000);
    TEST_ASSERT_EQUAL_INT32(0, speed_of_live_current(0.0, 0));
}

/* ---- what is believed ---- */

/* One tick of `length` and the currents at the ends of both pulses. */
static flying_start_result_t judge(double current, double turned_rad)
{
    flying_start_result_t result = FLYING_START_BUSY;

    flying_start_reset(&start);
    for (uint32_t tick = 0U; tick < PRELOAD_TICKS; tick++) {
        (void)step(0, 0);
    }
    while (result == FLYING_START_BUSY) {
        const double angle = (start.phase < FLYING_START_PAUSE) ? 0.0 : turned_rad;

        result = step_noisy(current * cos(angle), current * sin(angle), 0);
    }
    return result;
}

/*
 * A twentieth of a turn in 9 ticks: 23860929 steps, for which φ/L·ω·T, less what R takes in a tick,
 * is 945.3 LSB. A quarter of a turn: 119304647 steps, for which that is 4726 LSB, rounded down.
 */
TEST(test_a_current_that_the_speed_explains_within_a_factor_of_two_is_believed)
{
    static const struct {
        double current;
        double turns;
        flying_start_result_t result;
    } cases[] = {
        {470.0, 0.05, FLYING_START_STANDING},  {476.0, 0.05, FLYING_START_TURNING},
        {1885.0, 0.05, FLYING_START_TURNING},  {1895.0, 0.05, FLYING_START_STANDING},
        {2363.0, 0.25, FLYING_START_STANDING}, {2364.0, 0.25, FLYING_START_TURNING},
        {9451.0, 0.25, FLYING_START_TURNING},  {9452.0, 0.25, FLYING_START_STANDING},
        {500.0, 0.25, FLYING_START_STANDING},  {500.0, 1.0 / 2.1, FLYING_START_STANDING},
    };

    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            TEST_ASSERT_EQUAL_INT(cases[k].result,
                                  judge(cases[k].current, sign * TWO_PI * cases[k].turns));
            if (cases[k].result == FLYING_START_TURNING) {
                TEST_ASSERT_EQUAL_INT32(sign, (start.speed > 0) - (start.speed < 0));
            }
        }
    }
}

TEST(test_a_current_that_rests_in_space_is_no_turning_rotor)
{
    TEST_ASSERT_EQUAL_INT(FLYING_START_STANDING, judge(500.0, 0.0));
    TEST_ASSERT_EQUAL_INT(FLYING_START_STANDING, judge(20000.0, 0.0));
}

/* ---- any current ---- */

TEST(test_any_current_gives_a_result_in_time_with_a_speed_below_a_quarter_turn_a_tick)
{
    static const int32_t ends[] = {0, 1, -1, 32767, -32768, 65535, -65535, 409, 411};

    for (int32_t run = 0; run < 20000; run++) {
        flying_start_result_t result = FLYING_START_BUSY;
        uint32_t ticks = 0U;

        cfg = (flying_start_cfg_t){
            .current = seeded_in(&seed, 1, 16384),
            .wait_ticks = (uint32_t)seeded_in(&seed, 1, 100),
            .pulse_ticks = (uint32_t)seeded_in(&seed, 1, 16),
            .gap_factor = (uint32_t)seeded_in(&seed, 1, 64),
            .pause_max = 256U,
            .emf_current = seeded_in(&seed, 1, 32767),
            .emf_shift = (uint32_t)seeded_in(&seed, 0, 30),
            .decay_q15 = seeded_in(&seed, 0, 32767),
            .charge_ticks = (uint32_t)seeded_in(&seed, 0, 20),
        };
        flying_start_reset(&start);
        while (result == FLYING_START_BUSY) {
            const int32_t alpha = ends[seeded_u32(&seed) % 9U];

            result = step(alpha, ends[seeded_u32(&seed) % 9U]);
            ticks++;
            TEST_ASSERT_TRUE(ticks <=
                             (PRELOAD_TICKS + cfg.wait_ticks +
                              (cfg.pulse_ticks * (cfg.gap_factor + 2U)) + cfg.charge_ticks));
        }
        TEST_ASSERT_TRUE(abs(start.speed) <= 0x40000000);
        TEST_ASSERT_TRUE((start.inductance_q14 >= 0) && (start.inductance_q14 <= 32767));
    }
}
