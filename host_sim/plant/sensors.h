/* SPDX-License-Identifier: MIT */
/*
 * Current and bus sensing with an analogue-to-digital converter.
 *
 *   count = clip(round(x / lsb * (1 + gain_error) + zero + offset + noise), 0, 2^bits - 1)
 *
 * Current channels: lsb = current_full_scale_a / 2^(bits-1), zero = 2^(bits-1). Phase c has no
 * offset and a noise of its own.
 *                   Without a sensor of its own it reads zero.
 * Bus channel:      lsb = bus_full_scale_v / 2^bits,         zero = 0, no gain error, no offset.
 * Temperature:      linear from each of its points to the next, beyond the ends as the divider of a
 *                   thermistor, no noise: it is slow and filtered.
 * Bandwidth:        a first-order low pass in front of each current channel, corner
 *                   current_bandwidth_hz. Between two instants the current runs straight, for which
 *                   plant_sensors_follow is exact.
 * Angle:            the shaft's, 2^16 to a turn, in steps of 1 / angle_counts of a turn; no offset.
 * Full scale is the reference of the converter, one LSB above its largest count: what the
 * firmware's bases take it for, which turn counts into per unit by a shift.
 * Rounding is to nearest, halves upwards. Both saturate at the ends of the range.
 * The conversion takes no time: both currents, the bus and the angle are taken at the same instant.
 */
#ifndef PLANT_SENSORS_H
#define PLANT_SENSORS_H

#include "random.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Most points of a sensor's line. */
#define PLANT_SENSOR_POINTS_MAX 16

typedef struct {
    double celsius; /* above that of the point before */
    double share;   /* of full scale that the converter reads there */
} plant_sensor_point_t;

typedef struct {
    unsigned adc_bits;           /* 6 ... 16 */
    double current_full_scale_a; /* A, > 0: range is -full scale ... +full scale - 1 LSB */
    double bus_full_scale_v;     /* V, > 0: range is 0 ... full scale - 1 LSB */
    double noise_lsb_rms;        /* LSB, >= 0, currents and bus; 0 switches the source off */
    double offset_lsb[2];        /* LSB, phases a and b, finite */
    double drift_lsb_s[2];       /* LSB/s, phases a and b, finite: change of the offset */
    bool measures_c;             /* a third sensor, of phase c */
    double gain_error[3];        /* fraction, phases a, b, c, > -1; 0.01 reads 1 % too high */
    double current_bandwidth_hz; /* Hz, >= 0, of the current sensors; 0: without a low pass */
    plant_sensor_point_t temperature[PLANT_SENSOR_POINTS_MAX];
    unsigned temperature_points; /* of them in use, 2 ... 16; 0: no sensor, reads 0 */
    unsigned
        angle_counts; /* of the angle sensor in a turn, 0 ... 65536; 0: as fine as it is told */
    uint64_t seed;    /* of the noise */
} plant_sensor_cfg_t;

/* Straight binary. Zero current reads half scale, 2^(bits-1). */
typedef struct {
    uint16_t ia;
    uint16_t ib;
    uint16_t ic;
    uint16_t bus;
    uint16_t temperature;
    uint16_t angle; /* of the shaft, 2^16 = one turn */
} plant_adc_t;

typedef struct {
    double healthy_gain[3]; /* counts per ampere, gain error included */
    double current_gain[3]; /* in force: of a sensor that may have failed */
    bool measures_c;
    double current_zero[2]; /* counts, offset included */
    double drift_lsb_s[2];
    double healthy_bus_gain;                                      /* counts per volt */
    double bus_gain;                                              /* in force */
    plant_sensor_point_t temperature_at[PLANT_SENSOR_POINTS_MAX]; /* as configured */
    unsigned temperature_points;
    double count_max;
    double angle_counts; /* in a turn */
    double noise_lsb_rms;
    double lag_rate;  /* 1/s, of the low pass; 0: none */
    double seen_a[2]; /* behind the low pass, A */
    plant_random_t random;
    plant_random_t random_c; /* of phase c: whether it is measured changes no other noise */
    uint16_t temperature;    /* what its channel converts to */
} plant_sensors_t;

/* Returns false and names the offending field in *bad_field when a value is out of range. */
bool plant_sensors_init(plant_sensors_t *sensors, const plant_sensor_cfg_t *cfg,
                        const char **bad_field);

/* The temperature that the conversions to come see, degrees C. */
void plant_sensors_set_temperature(plant_sensors_t *sensors, double temperature_c);

/*
 * The sensors of the phases a, b, c and of the bus read so many times as much from now on; 1 is
 * healthy.
 */
void plant_sensors_scale(plant_sensors_t *sensors, const double current[3], double bus);

/* What the angle sensor tells of a shaft at an angle, rad, multi-turn. */
uint16_t plant_sensors_angle(const plant_sensors_t *sensors, double angle_mech_rad);

/* Whether the current sensors have a low pass. Without one nothing has to be followed. */
static inline bool plant_sensors_lag(const plant_sensors_t *sensors)
{
    return sensors->lag_rate > 0.0;
}

/*
 * Both currents, A, have gone from one pair of values to another in a time: the low passes follow.
 */
void plant_sensors_follow(plant_sensors_t *sensors, double duration_s, const double from_a[2],
                          const double to_a[2]);

/* Time goes by: the offsets drift. */
void plant_sensors_drift(plant_sensors_t *sensors, double duration_s);

/*
 * One conversion of the currents [A] of a and b, of c where it is measured, of the bus [V] and the
 * temperature. With a low pass the currents are those behind it, not the arguments. With noise it
 * draws three deviates, and one of another source for c.
 */
void plant_sensors_convert(plant_sensors_t *sensors, double i_a, double i_b, double bus_v,
                           plant_adc_t *adc);

#ifdef __cplusplus
}
#endif

#endif
