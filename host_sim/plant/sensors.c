/* SPDX-License-Identifier: MIT */
#include "sensors.h"

#include "check.h"
#include "decay.h"
#include "rotation.h"

#include <math.h>

#define ADC_BITS_MIN 6U
#define ADC_BITS_MAX 16U
#define ANGLE_COUNTS_MAX 65536U

static bool is_a_line(const plant_sensor_cfg_t *cfg)
{
    const plant_sensor_point_t *const at = cfg->temperature;
    bool good = cfg->temperature_points != 1U && cfg->temperature_points <= PLANT_SENSOR_POINTS_MAX;
    for (unsigned k = 0; good && k < cfg->temperature_points; k++) {
        good = isfinite(at[k].celsius) && isfinite(at[k].share) &&
               (k == 0U || at[k].celsius > at[k - 1U].celsius);
    }
    return good;
}

static const char *sensors_bad_field(const plant_sensor_cfg_t *cfg)
{
    const plant_check_t checks[] = {
        {"sensor.adc_bits", cfg->adc_bits >= ADC_BITS_MIN && cfg->adc_bits <= ADC_BITS_MAX},
        {"sensor.current_full_scale_a", plant_is_positive(cfg->current_full_scale_a)},
        {"sensor.bus_full_scale_v", plant_is_positive(cfg->bus_full_scale_v)},
        {"sensor.noise_lsb_rms", plant_is_not_negative(cfg->noise_lsb_rms)},
        {"sensor.offset_lsb[0]", isfinite(cfg->offset_lsb[0])},
        {"sensor.offset_lsb[1]", isfinite(cfg->offset_lsb[1])},
        {"sensor.drift_lsb_s[0]", isfinite(cfg->drift_lsb_s[0])},
        {"sensor.drift_lsb_s[1]", isfinite(cfg->drift_lsb_s[1])},
        {"sensor.gain_error[0]", plant_is_positive(1.0 + cfg->gain_error[0])},
        {"sensor.gain_error[1]", plant_is_positive(1.0 + cfg->gain_error[1])},
        {"sensor.gain_error[2]", plant_is_positive(1.0 + cfg->gain_error[2])},
        {"sensor.current_bandwidth_hz", plant_is_not_negative(cfg->current_bandwidth_hz)},
        {"sensor.temperature", is_a_line(cfg)},
        {"sensor.angle_counts", cfg->angle_counts <= ANGLE_COUNTS_MAX},
    };
    return plant_first_bad(checks, sizeof checks / sizeof checks[0]);
}

bool plant_sensors_init(plant_sensors_t *sensors, const plant_sensor_cfg_t *cfg,
                        const char **bad_field)
{
    *bad_field = sensors_bad_field(cfg);
    if (*bad_field != NULL) {
        return false;
    }
    static const double healthy[3] = {1.0, 1.0, 1.0};
    const double half_scale = (double)(1UL << (cfg->adc_bits - 1U));
    sensors->count_max = 2.0 * half_scale - 1.0;
    for (int phase = 0; phase < 3; phase++) {
        sensors->healthy_gain[phase] =
            half_scale / cfg->current_full_scale_a * (1.0 + cfg->gain_error[phase]);
    }
    for (int phase = 0; phase < 2; phase++) {
        sensors->current_zero[phase] = half_scale + cfg->offset_lsb[phase];
        sensors->drift_lsb_s[phase] = cfg->drift_lsb_s[phase];
    }
    sensors->measures_c = cfg->measures_c;
    sensors->healthy_bus_gain = 2.0 * half_scale / cfg->bus_full_scale_v;
    plant_sensors_scale(sensors, healthy, 1.0);
    sensors->temperature_points = cfg->temperature_points;
    for (unsigned k = 0; k < cfg->temperature_points; k++) {
        sensors->temperature_at[k] = cfg->temperature[k];
    }
    sensors->angle_counts = (double)(cfg->angle_counts > 0U ? cfg->angle_counts : ANGLE_COUNTS_MAX);
    sensors->noise_lsb_rms = cfg->noise_lsb_rms;
    sensors->lag_rate = PLANT_TWO_PI * cfg->current_bandwidth_hz;
    sensors->seen_a[0] = 0.0;
    sensors->seen_a[1] = 0.0;
    plant_random_init(&sensors->random, cfg->seed);
    plant_random_init(&sensors->random_c, ~cfg->seed);
    return true;
}

void plant_sensors_scale(plant_sensors_t *sensors, const double current[3], double bus)
{
    for (int phase = 0; phase < 3; phase++) {
        sensors->current_gain[phase] = sensors->healthy_gain[phase] * current[phase];
    }
    sensors->bus_gain = sensors->healthy_bus_gain * bus;
}

static uint16_t quantise(double counts, double count_max)
{
    if (!(counts > 0.0)) {
        return 0;
    }
    if (counts >= count_max) {
        return (uint16_t)count_max;
    }
    return (uint16_t)(counts + 0.5);
}

static double logit(double share)
{
    return log(share / (1.0 - share));
}

/*
 * What a thermistor's divider reads beyond an end of its line: its ratio p/(1 - p) goes on as it
 * did between the last two points, so an NTC that is far too cold reads 0 or full scale. A line
 * that ends at an end of the converter stays there.
 */
static double beyond(const plant_sensor_point_t *from, const plant_sensor_point_t *to, double way)
{
    const plant_sensor_point_t *const end = way < 0.0 ? from : to;
    const double least = fmin(from->share, to->share);
    const double most = fmax(from->share, to->share);
    if (least <= 0.0 || most >= 1.0) {
        return end->share;
    }
    const double x = logit(from->share) + way * (logit(to->share) - logit(from->share));
    return 1.0 / (1.0 + exp(-x));
}

void plant_sensors_set_temperature(plant_sensors_t *sensors, double temperature_c)
{
    const plant_sensor_point_t *to = &sensors->temperature_at[1];
    double share = 0.0;
    if (sensors->temperature_points > 0U) {
        const plant_sensor_point_t *const last =
            &sensors->temperature_at[sensors->temperature_points - 1U];
        while (to < last && to->celsius < temperature_c) {
            to++;
        }
        const plant_sensor_point_t *const from = to - 1;
        const double way = (temperature_c - from->celsius) / (to->celsius - from->celsius);
        share = way < 0.0 || way > 1.0 ? beyond(from, to, way)
                                       : from->share + way * (to->share - from->share);
    }
    sensors->temperature = quantise(share * (sensors->count_max + 1.0), sensors->count_max);
}

uint16_t plant_sensors_angle(const plant_sensors_t *sensors, double angle_mech_rad)
{
    const double turns = angle_mech_rad / PLANT_TWO_PI;
    const double count = floor((turns - floor(turns)) * sensors->angle_counts + 0.5);
    const double told = floor(count / sensors->angle_counts * ANGLE_COUNTS_MAX + 0.5);
    return (uint16_t)((uint32_t)told % ANGLE_COUNTS_MAX);
}

/*
 * y' = rate (u - y) with u from from_a to to_a along a line: y = e y + (1 - e) from + (1 - m) (to -
 * from), with e = exp(-rate t) and its mean m over the time.
 */
void plant_sensors_follow(plant_sensors_t *sensors, double duration_s, const double from_a[2],
                          const double to_a[2])
{
    const double way = sensors->lag_rate * duration_s;
    if (!(way > 0.0)) {
        return;
    }
    const double kept = plant_decay(way);
    const double rise = 1.0 - (1.0 - kept) / way;
    for (int phase = 0; phase < 2; phase++) {
        sensors->seen_a[phase] = kept * sensors->seen_a[phase] + (1.0 - kept) * from_a[phase] +
                                 rise * (to_a[phase] - from_a[phase]);
    }
}

void plant_sensors_drift(plant_sensors_t *sensors, double duration_s)
{
    for (int phase = 0; phase < 2; phase++) {
        sensors->current_zero[phase] += sensors->drift_lsb_s[phase] * duration_s;
    }
}

/* Phase c: without a sensor no current is seen. */
static double counts_of_c(plant_sensors_t *sensors, double i_c)
{
    double counts = 0.5 * (sensors->count_max + 1.0);
    if (sensors->measures_c) {
        counts += i_c * sensors->current_gain[2];
        if (sensors->noise_lsb_rms > 0.0) {
            counts += sensors->noise_lsb_rms * plant_random_gaussian(&sensors->random_c);
        }
    }
    return counts;
}

void plant_sensors_convert(plant_sensors_t *sensors, double i_a, double i_b, double bus_v,
                           plant_adc_t *adc)
{
    const bool lag = plant_sensors_lag(sensors);
    const double seen_a = lag ? sensors->seen_a[0] : i_a;
    const double seen_b = lag ? sensors->seen_a[1] : i_b;
    double counts_a = seen_a * sensors->current_gain[0] + sensors->current_zero[0];
    double counts_b = seen_b * sensors->current_gain[1] + sensors->current_zero[1];
    double counts_bus = bus_v * sensors->bus_gain;
    if (sensors->noise_lsb_rms > 0.0) {
        counts_a += sensors->noise_lsb_rms * plant_random_gaussian(&sensors->random);
        counts_b += sensors->noise_lsb_rms * plant_random_gaussian(&sensors->random);
        counts_bus += sensors->noise_lsb_rms * plant_random_gaussian(&sensors->random);
    }
    adc->ia = quantise(counts_a, sensors->count_max);
    adc->ib = quantise(counts_b, sensors->count_max);
    adc->ic = quantise(counts_of_c(sensors, -seen_a - seen_b), sensors->count_max);
    adc->bus = quantise(counts_bus, sensors->count_max);
    adc->temperature = sensors->temperature;
}
