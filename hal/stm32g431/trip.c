/* SPDX-License-Identifier: MIT */
#include "trip.h"

#include "board.h"
#include "clock.h"
#include "pwm.h"
#include "reg.h"
#include "settings.h"
#include "stm32g431.h"

#include <stddef.h>

/*
 * Data sheet, tables 70 and 73: wake-up of this DAC at most 3.5 µs, start-up of a comparator at
 * most 5 µs.
 */
#define SETTLING_US (15U)

#define READY (DAC_SR_DAC1RDY | DAC_SR_DAC2RDY)

/* The path of a phase: its comparator, and the register of the DAC channel that sets its level. */
typedef struct {
    uint32_t comparator;
    uint32_t level;
    const char *fails;
} path_t;

#define PATHS (3U)
static const path_t paths[PATHS] = {
    {COMP1_CSR, DAC3_DHR12R1, "the comparator of phase a does not open the gates"},
    {COMP2_CSR, DAC3_DHR12R2, "the comparator of phase b does not open the gates"},
    {COMP4_CSR, DAC3_DHR12R2, "the comparator of phase c does not open the gates"},
};

#define LEVEL_MAX (4095U)

static void enable_comparator(const path_t *path)
{
    reg_write(path->comparator, settings_value(path->comparator) & ~COMP_CSR_LOCK);
}

bool trip_init(void)
{
    bool are_ready;

    settings_write(SETTINGS_LEVEL);
    are_ready = reg_wait(DAC3_SR, READY, READY);
    if (are_ready) {
        clock_wait_us(SETTLING_US);
        for (uint32_t k = 0U; k < PATHS; k++) {
            enable_comparator(&paths[k]);
        }
        clock_wait_us(SETTLING_US);
    }
    return are_ready;
}

/*
 * Switches the other comparators off, so that only the output of this one reaches the timer. If a
 * low output means a trip, a comparator that is off would trip, so then all stay on.
 */
static void isolate(const path_t *path)
{
    for (uint32_t k = 0U; k < PATHS; k++) {
        if (!BOARD.trip_below) {
            reg_write(paths[k].comparator, 0U);
        }
    }
    enable_comparator(path);
    clock_wait_us(SETTLING_US);
}

/* Enables the main output. This reaches no gate, because the outputs are not connected yet. */
static bool output_stays_on(void)
{
    reg_write(TIM1_SR, ~PWM_BREAK_FLAGS);
    reg_set(TIM1_BDTR, TIM_BDTR_MOE);
    clock_wait_us(1U); /* the break's filter takes 0.2 µs */
    return reg_any(TIM1_BDTR, TIM_BDTR_MOE) && !reg_any(TIM1_SR, PWM_BREAK_FLAGS);
}

static void set_level(const path_t *path, uint32_t level)
{
    reg_write(path->level, level);
    clock_wait_us(SETTLING_US);
}

/*
 * At rest the shunt's signal lies between the level and the end of the DAC's range to which the
 * level is moved. So the comparator must trip with the moved level, and must not trip with the
 * right one.
 */
static bool opens_output(const path_t *path)
{
    bool opens;

    set_level(path, BOARD.trip_below ? LEVEL_MAX : 0U);
    opens = !reg_any(TIM1_BDTR, TIM_BDTR_MOE) && reg_any(TIM1_SR, TIM_SR_BIF) && !output_stays_on();
    set_level(path, settings_value(path->level));
    return opens && output_stays_on();
}

static const char *try_path(const path_t *path)
{
    const char *why = NULL;

    isolate(path);
    if (!output_stays_on()) {
        why = reg_any(TIM1_SR, TIM_SR_BIF) ? "a phase trips at rest"
                                           : "the timer does not enable its output";
    } else if (!opens_output(path)) {
        why = path->fails;
    } else {
        /* it works */
    }
    reg_clear(TIM1_BDTR, TIM_BDTR_MOE);
    return why;
}

/* Locks the comparators. They stay as they are until the next reset. */
static void lock_comparators(void)
{
    for (uint32_t k = 0U; k < PATHS; k++) {
        enable_comparator(&paths[k]);
    }
    clock_wait_us(SETTLING_US);
    for (uint32_t k = 0U; k < PATHS; k++) {
        reg_write(paths[k].comparator, settings_value(paths[k].comparator));
    }
}

const char *trip_try(void)
{
    const char *why = NULL;

    for (uint32_t k = 0U; (why == NULL) && (k < PATHS); k++) {
        why = try_path(&paths[k]);
    }
    lock_comparators();
    reg_write(TIM1_SR, 0U);
    return why;
}
