/* SPDX-License-Identifier: MIT */
/*
 * Timing of a three-leg bridge: compare values in, leg states over one PWM period out.
 *
 * The counter runs peak -> 0 -> peak in 2 * timer_counts ticks. A leg commands high while
 * counter < compare, so it goes high at tick counts - compare and low at counts + compare: the
 * pulse lies symmetric about mid-period, its duty is compare / counts, 0 and 1 included, and the
 * period starts and ends in the middle of the low side's on-time. Times are multiples of a tick.
 *
 * Dead time: each command edge opens both switches of its leg at once and closes the commanded
 * one dead_time_s later. An edge inside a running dead time restarts it, so a command pulse
 * shorter than the dead time leaves the leg open throughout and never closes its switch. A dead
 * time may reach into the next period.
 *
 * Which device conducts in an open leg is the business of bridge.h.
 */
#ifndef PLANT_INVERTER_H
#define PLANT_INVERTER_H

#include "legs.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PLANT_ALL_LEGS 7U

/*
 * A leg changes at most six times in a period: an inherited dead time ends; edge at the start and
 * its dead time; rising edge, falling edge and their dead times, less what they swallow.
 */
#define PLANT_SEGMENTS_MAX 19

typedef struct {
    double pwm_frequency_hz; /* Hz, > 0 */
    uint32_t timer_counts;   /* ticks of half a period (reload value), 2 ... 65536 */
    double dead_time_s;      /* s, 0 ... a quarter of the period; 0: ideal edges */
} plant_inverter_cfg_t;

/* A time during which no switch changes. Bit k of a mask is leg k (a, b, c). */
typedef struct {
    double duration_s; /* s, > 0 */
    uint8_t high;      /* legs whose high-side switch is closed */
    uint8_t low;       /* legs whose low-side switch is closed; in neither mask: open */
} plant_segment_t;

typedef struct {
    unsigned count;
    plant_segment_t segment[PLANT_SEGMENTS_MAX];
} plant_pattern_t;

typedef struct {
    double period_s; /* this and the next two go with the clock */
    double tick_s;
    double dead_time_s;
    double configured_period_s;
    double configured_dead_time_s;
    double dead_left_s[PLANT_LEGS]; /* dead time still to run at the start of the period */
    uint32_t timer_counts;
    uint32_t commanded; /* mask of the legs commanded high at the end of the last period */
} plant_inverter_t;

/*
 * Returns false and names the offending field in *bad_field when a value is out of range.
 * All legs start low, no dead time running.
 */
bool plant_inverter_init(plant_inverter_t *inverter, const plant_inverter_cfg_t *cfg,
                         const char **bad_field);

/*
 * One period with the given compare values, larger ones taken as timer_counts. The segments cover
 * the period without gaps, none is empty. Advances the dead-time state.
 */
void plant_inverter_pattern(plant_inverter_t *inverter, const uint32_t compare[PLANT_LEGS],
                            plant_pattern_t *pattern);

/*
 * The timer's clock runs so many times as fast as configured, > 0. The dead time, which it counts
 * too, goes along.
 */
void plant_inverter_set_clock(plant_inverter_t *inverter, double ratio);

/* All six switches open from now on: the legs come back from the low command, no dead time runs. */
void plant_inverter_forget(plant_inverter_t *inverter);

/* One period with all six switches open. */
void plant_inverter_off(plant_inverter_t *inverter, plant_pattern_t *pattern);

#ifdef __cplusplus
}
#endif

#endif
