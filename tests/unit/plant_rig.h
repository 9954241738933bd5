/* SPDX-License-Identifier: MIT */
/* A coupled plant, period by period. */
#ifndef PLANT_RIG_H
#define PLANT_RIG_H

#include "plant.h"
#include "plant_motors.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

#define COUNTS 4250U
#define PERIOD_S 1.0e-4
#define BUS_V 310.0

static plant_t plant;
static plant_view_t view;
static plant_cfg_t cfg; /* of the plant that start() makes */

/* That motor on a bus of BUS_V: ideal switches, sensors of 102.4 counts per ampere. */
static inline void bench(plant_motor_cfg_t motor)
{
    cfg = (plant_cfg_t){
        .motor = motor,
        .inverter = {.pwm_frequency_hz = 1.0 / PERIOD_S, .timer_counts = COUNTS},
        .supply = {.voltage_v = BUS_V},
        .sensor = {.adc_bits = 12,
                   .current_full_scale_a = 20.0,
                   .bus_full_scale_v = 400.0,
                   .temperature = {{-50.0, 0.0}, {154.8, 1.0}},
                   .temperature_points = 2,
                   .seed = 1},
    };
}

static inline void look(void)
{
    plant_view(&plant, &view);
}

static inline void start(void)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_init(&plant, &cfg, &bad), bad);
    plant_set_gates(&plant, true);
    look();
}

static inline void write_compare(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t compare[PLANT_LEGS] = {a, b, c};

    plant_write_compare(&plant, compare);
}

static inline void run(int periods)
{
    for (int k = 0; k < periods; k++) {
        plant_step(&plant);
    }
    look();
}

/* The init function refuses the configuration and names the field. */
static inline void check_refused(const plant_cfg_t *wrong, const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_init(&plant, wrong, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

/* It does so for cfg with that value in the field. */
#define CHECK_REFUSED(field, value) \
    do { \
        plant_cfg_t wrong = cfg; \
        wrong.field = (value); \
        check_refused(&wrong, #field); \
    } while (false)

#endif
