/* SPDX-License-Identifier: MIT */
/* Simulated conversion: rounding, clipping, offset, gain error and noise. */
#include "decay.h"
#include "random.h"
#include "rotation.h"
#include "sensors.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define SAMPLES 100000

/* As decay.h states it. */
#define DECAY_ERROR 2.0e-13

static plant_sensors_t sensors;
static plant_sensor_cfg_t cfg;
static plant_adc_t adc;

static void start(void)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_sensors_init(&sensors, &cfg, &bad), bad);
}

/* 12 bits over +-20 A: 102.4 counts per ampere. */
void setUp(void)
{
    cfg = (plant_sensor_cfg_t){
        .adc_bits = 12,
        .current_full_scale_a = 20.0,
        .bus_full_scale_v = 409.6,                   /* 0.1 V per count */
        .temperature = {{-50.0, 0.0}, {154.8, 1.0}}, /* 0.05 degrees per count */
        .temperature_points = 2,
        .seed = 1,
    };
    start();
}

static void convert(double i_a, double i_b, double bus_v)
{
    plant_sensors_convert(&sensors, i_a, i_b, bus_v, &adc);
}

static void check_counts(double i_a, double i_b, double bus_v, uint16_t ia, uint16_t ib,
                         uint16_t bus)
{
    convert(i_a, i_b, bus_v);
    TEST_ASSERT_EQUAL_UINT16(ia, adc.ia);
    TEST_ASSERT_EQUAL_UINT16(ib, adc.ib);
    TEST_ASSERT_EQUAL_UINT16(bus, adc.bus);
}

TEST(test_counts_are_rounded_to_nearest_from_half_scale_and_clipped_at_both_ends)
{
    const double lsb = 20.0 / 2048.0;

    check_counts(0.0, 0.0, 0.0, 2048, 2048, 0);
    check_counts(0.49 * lsb, -0.49 * lsb, 0.049, 2048, 2048, 0);
    check_counts(0.51 * lsb, -0.51 * lsb, 0.051, 2049, 2047, 1);
    check_counts(19.99, -20.0, 409.5, 4095, 0, 4095);
    check_counts(1.0e6, -1.0e6, 1.0e6, 4095, 0, 4095);
    check_counts(0.0, 0.0, -5.0, 2048, 2048, 0);
}

TEST(test_sixteen_bits_use_the_whole_word)
{
    cfg.adc_bits = 16;
    start();
    check_counts(100.0, 0.0, 1000.0, 65535, 32768, 65535);
}

TEST(test_offset_shifts_each_phase_on_its_own)
{
    cfg.offset_lsb[0] = 5.0;
    cfg.offset_lsb[1] = -7.0;
    start();
    check_counts(0.0, 0.0, 100.0, 2053, 2041, 1000);
}

TEST(test_the_offset_drifts_with_the_time_that_has_gone_by)
{
    cfg.offset_lsb[0] = 5.0;
    cfg.drift_lsb_s[0] = 100.0;
    cfg.drift_lsb_s[1] = -40.0;
    start();
    for (int k = 0; k < 1000; k++) {
        plant_sensors_drift(&sensors, 1.0e-4);
    }
    check_counts(0.0, 0.0, 100.0, 2063, 2044, 1000);
}

TEST(test_gain_error_scales_the_current_and_not_the_zero)
{
    cfg.gain_error[0] = 0.01;
    cfg.gain_error[1] = -0.01;
    start();
    check_counts(10.0, 10.0, 0.0, 2048 + 1034, 2048 + 1014, 0); /* 1024 counts +-10.24 */
    check_counts(0.0, 0.0, 0.0, 2048, 2048, 0);
}

TEST(test_noise_has_no_mean_and_the_stated_rms)
{
    double sum[3] = {0.0, 0.0, 0.0};
    double squares[3] = {0.0, 0.0, 0.0};
    double cross_sum = 0.0;

    cfg.noise_lsb_rms = 3.0;
    start();
    for (int k = 0; k < SAMPLES; k++) {
        convert(0.0, 0.0, 200.0);
        const double error[3] = {adc.ia - 2048.0, adc.ib - 2048.0, adc.bus - 2000.0};
        for (int c = 0; c < 3; c++) {
            sum[c] += error[c];
            squares[c] += error[c] * error[c];
        }
        cross_sum += error[0] * error[1];
    }
    const double variance = 9.0 + 1.0 / 12.0; /* noise and rounding */
    const double root_n = sqrt((double)SAMPLES);
    /* Four standard errors of a mean, of a variance and of a covariance. */
    const double mean_tolerance = 4.0 * sqrt(variance) / root_n;
    const double variance_tolerance = 4.0 * variance * sqrt(2.0) / root_n;
    for (int c = 0; c < 3; c++) {
        TEST_ASSERT_DOUBLE_WITHIN(mean_tolerance, 0.0, sum[c] / SAMPLES);
        TEST_ASSERT_DOUBLE_WITHIN(variance_tolerance, variance, squares[c] / SAMPLES);
    }
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * variance / root_n, 0.0, cross_sum / SAMPLES);
}

TEST(test_without_noise_the_generator_stands_still)
{
    const plant_random_t before = sensors.random;

    convert(1.0, 2.0, 3.0);
    TEST_ASSERT_TRUE(before.state == sensors.random.state);
}

TEST(test_deviates_are_bell_shaped)
{
    plant_random_t random;
    double fourth = 0.0;
    double largest = 0.0;
    int beyond_one = 0;

    plant_random_init(&random, 42);
    for (int k = 0; k < SAMPLES; k++) {
        const double x = plant_random_gaussian(&random);
        fourth += x * x * x * x;
        largest = fmax(largest, fabs(x));
        beyond_one += (fabs(x) > 1.0) ? 1 : 0;
    }
    /* The fourth moment of a sum of twelve is 2.9, its own variance 96 at most. */
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * sqrt(96.0 / SAMPLES), 2.9, fourth / SAMPLES);
    /* Beyond one sigma lie 0.317 of a normal distribution, 0.32 of a sum of twelve. */
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.32, (double)beyond_one / SAMPLES);
    TEST_ASSERT_TRUE(largest > 3.5);
    TEST_ASSERT_TRUE(largest < 6.0);
}

TEST(test_same_seed_repeats_and_another_does_not)
{
    uint16_t run[3][64];

    cfg.noise_lsb_rms = 2.0;
    for (int r = 0; r < 3; r++) {
        cfg.seed = (r == 2) ? 8U : 7U;
        start();
        for (int k = 0; k < 64; k++) {
            convert(0.0, 0.0, 0.0);
            run[r][k] = adc.ia;
        }
    }
    TEST_ASSERT_EQUAL_MEMORY(run[0], run[1], sizeof run[0]);
    TEST_ASSERT_TRUE(memcmp(run[0], run[2], sizeof run[0]) != 0);
}

TEST(test_decay_agrees_with_the_library)
{
    for (int k = 0; k <= 50000; k++) {
        const double x = 1.0e-3 * k;
        TEST_ASSERT_DOUBLE_WITHIN(DECAY_ERROR, exp(-x), plant_decay(x));
    }
}

/* Of slope s, from rest: behind by s tau (1 - e^(-t/tau)), in whatever steps it is followed. */
TEST(test_low_pass_lags_behind_a_ramp_by_its_time_constant)
{
    const double tau_s = 1.0 / (PLANT_TWO_PI * 20.0e3);
    const double slope_a_s[2] = {1.0e5, -3.0e4};
    const double whole_s = 30.0e-6;

    for (int parts = 1; parts <= 100; parts *= 10) {
        cfg.current_bandwidth_hz = 20.0e3;
        start();
        for (int k = 0; k < parts; k++) {
            const double t0 = whole_s * k / parts;
            const double t1 = whole_s * (k + 1) / parts;
            const double from[2] = {slope_a_s[0] * t0, slope_a_s[1] * t0};
            const double to[2] = {slope_a_s[0] * t1, slope_a_s[1] * t1};
            plant_sensors_follow(&sensors, t1 - t0, from, to);
        }
        for (int phase = 0; phase < 2; phase++) {
            const double lag_a = slope_a_s[phase] * tau_s * -expm1(-whole_s / tau_s);
            const double end_a = slope_a_s[phase] * whole_s;
            /* Each part's error of the decay is divided by its length over tau. */
            const double tolerance = 3.0 * DECAY_ERROR * parts * parts * tau_s / whole_s;
            TEST_ASSERT_DOUBLE_WITHIN(tolerance * fabs(end_a), end_a - lag_a,
                                      sensors.seen_a[phase]);
        }
    }
}

TEST(test_conversion_takes_what_the_low_pass_shows)
{
    const double from[2] = {0.0, 0.0};
    const double to[2] = {10.0, -10.0};
    const double never[2] = {5.0, 5.0};

    cfg.current_bandwidth_hz = 1.0e3;
    start();
    plant_sensors_follow(&sensors, 1.0, to, to);
    plant_sensors_follow(&sensors, 0.0, from, never);
    check_counts(0.0, 0.0, 0.0, 2048 + 1024, 2048 - 1024, 0);
}

static void check_temperature(double temperature_c, uint16_t expected)
{
    plant_sensors_set_temperature(&sensors, temperature_c);
    convert(0.0, 0.0, 0.0);
    TEST_ASSERT_EQUAL_UINT16(expected, adc.temperature);
}

TEST(test_temperature_is_linear_between_its_ends_and_clipped_beyond)
{
    check_temperature(-50.0, 0);
    check_temperature(25.0, 1500);
    check_temperature(25.024, 1500); /* just below half a count more */
    check_temperature(25.026, 1501);
    check_temperature(-60.0, 0);
    check_temperature(200.0, 4095);
}

/*
 * 10 kOhm and 3380 K above 4.7 kOhm, as a line of two points: 5.9 % at -20, 27.92 % at 20 degrees.
 */
TEST(test_beyond_its_line_a_thermistor_reads_as_its_divider_and_an_open_one_an_end)
{
    cfg.temperature[0] = (plant_sensor_point_t){-20.0, 0.059};
    cfg.temperature[1] = (plant_sensor_point_t){20.0, 0.2792};
    start();
    check_temperature(-20.0, 242);
    /* p/(1 - p) is 0.0627 at -20 and 6.178 times that 40 degrees on: 0.01015 at -60. */
    check_temperature(-60.0, 41);
    check_temperature(-250.0, 0);
    check_temperature(250.0, 4095);
}

TEST(test_temperature_may_count_down_and_reads_0_without_a_sensor)
{
    cfg.temperature[0].share = 1.0;
    cfg.temperature[1].share = 0.0;
    start();
    check_temperature(154.8, 0);
    check_temperature(79.8, 1500);
    check_temperature(-50.0, 4095);
    cfg.temperature_points = 0;
    start();
    check_temperature(25.0, 0);
}

TEST(test_a_bent_line_is_linear_from_each_point_to_the_next_and_a_divider_beyond_the_ends)
{
    cfg.temperature[0] = (plant_sensor_point_t){0.0, 0.125};
    cfg.temperature[1] = (plant_sensor_point_t){50.0, 0.5};
    cfg.temperature[2] = (plant_sensor_point_t){100.0, 0.75};
    cfg.temperature_points = 3;
    start();
    check_temperature(0.0, 512);
    check_temperature(25.0, 1280);
    check_temperature(50.0, 2048);
    check_temperature(75.0, 2560);
    check_temperature(100.0, 3072);
    check_temperature(-10.0, 362);  /* p/(1 - p): 1/7 over 7^0.2 */
    check_temperature(110.0, 3231); /* 3 times 3^0.2 */
}

static void check_angle(uint16_t expected, double turns)
{
    TEST_ASSERT_EQUAL_UINT16(expected, plant_sensors_angle(&sensors, turns * PLANT_TWO_PI));
}

TEST(test_the_angle_is_told_in_65536_of_a_turn_and_wraps)
{
    check_angle(0, 0.0);
    check_angle(0x4000, 0.25);
    check_angle(0xC000, -0.25);
    check_angle(1, 5.0 + 1.4 / 65536);
    check_angle(2, 5.0 + 1.6 / 65536);
    check_angle(0, 65535.6 / 65536);
}

TEST(test_the_angle_has_the_steps_of_its_sensor)
{
    cfg.angle_counts = 4096;
    start();
    check_angle(16, 0.51 / 4096);
    check_angle(16, 1.49 / 4096);
    check_angle(0, 4095.6 / 4096);
    cfg.angle_counts = 3; /* a third of a turn, rounded */
    start();
    check_angle(21845, 0.3);
}

static void check_refused(const plant_sensor_cfg_t *wrong, const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_sensors_init(&sensors, wrong, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

/* For cfg with that value in the field. */
#define CHECK_REFUSED(field, value, name) \
    do { \
        plant_sensor_cfg_t wrong = cfg; \
        wrong.field = (value); \
        check_refused(&wrong, "sensor." name); \
    } while (false)

TEST(test_init_names_the_field_that_is_out_of_range)
{
    CHECK_REFUSED(adc_bits, 17, "adc_bits");
    CHECK_REFUSED(current_full_scale_a, 0.0, "current_full_scale_a");
    CHECK_REFUSED(noise_lsb_rms, -1.0, "noise_lsb_rms");
    CHECK_REFUSED(current_bandwidth_hz, -1.0, "current_bandwidth_hz");
    CHECK_REFUSED(drift_lsb_s[0], HUGE_VAL, "drift_lsb_s[0]");
    CHECK_REFUSED(drift_lsb_s[1], HUGE_VAL, "drift_lsb_s[1]");
    CHECK_REFUSED(gain_error[1], -1.0, "gain_error[1]");
    CHECK_REFUSED(temperature[0].celsius, -HUGE_VAL, "temperature");
    CHECK_REFUSED(temperature[1].share, HUGE_VAL, "temperature");
    CHECK_REFUSED(temperature[1].celsius, cfg.temperature[0].celsius, "temperature");
    CHECK_REFUSED(temperature_points, 1, "temperature");
    CHECK_REFUSED(temperature_points, PLANT_SENSOR_POINTS_MAX + 1, "temperature");
    CHECK_REFUSED(angle_counts, 65537, "angle_counts");
}
