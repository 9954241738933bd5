/* SPDX-License-Identifier: MIT */
#include "trip.h"

#include "board.h"
#include "clock.h"
#include "hal_config.h"
#include "pwm.h"
#include "reg.h"
#include "settings.h"
#include "stm32g4.h"

#include <stddef.h>

/*
 * Data sheet, tables 70 and 73: wake-up of this DAC at most 3.5 µs, start-up of a comparator at
 * most 5 µs.
 */
#define SETTLING_US (15U)

#define READY (DAC_SR_DAC1RDY | DAC_SR_DAC2RDY)

/* The path of a phase. */
typedef struct {
    uint32_t comparator; /* its control register; 0: the end of the table */
    uint32_t source;     /* its bits in TIM1_AF1 */
    uint32_t level;      /* register of the DAC channel that sets its level */
    const char *fails;
} path_t;

/* Empty where a line of the gate driver trips. */
static const path_t paths[] = {HAL_PATHS{0U, 0U, 0U, NULL}};

#define LEVEL_MAX (4095U)

static void enable_comparator(const path_t *path)
{
    reg_write(path->comparator, settings_value(path->comparator) & ~COMP_CSR_LOCK);
}

static bool start_comparators(void)
{
    bool are_ready;

    settings_write(SETTINGS_LEVEL);
    are_ready = reg_wait(DAC3_SR, READY, READY);
    if (are_ready) {
        clock_wait_us(SETTLING_US);
        for (uint32_t k = 0U; paths[k].comparator != 0U; k++) {
            enable_comparator(&paths[k]);
        }
        clock_wait_us(SETTLING_US);
    }
    return are_ready;
}

bool trip_init(void)
{
    return !BOARD.has_comparators || start_comparators();
}

/* Enables the main output. This reaches no gate, because the outputs are not connected yet. */
static bool output_stays_on(void)
{
    reg_write(TIM1_SR, ~PWM_BREAK_FLAGS);
    reg_set(TIM1_BDTR, TIM_BDTR_MOE);
    clock_wait_us(1U); /* the break's filter takes 0.2 µs */
    return reg_any(TIM1_BDTR, TIM_BDTR_MOE) && !reg_any(TIM1_SR, PWM_BREAK_FLAGS);
}

static void move_level(const path_t *path, uint32_t level)
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

    move_level(path, BOARD.trip_below ? LEVEL_MAX : 0U);
    opens = !reg_any(TIM1_BDTR, TIM_BDTR_MOE) && reg_any(TIM1_SR, TIM_SR_BIF) && !output_stays_on();
    move_level(path, settings_value(path->level));
    return opens && output_stays_on();
}

static const char *try_path(const path_t *path)
{
    const char *why = NULL;

    reg_write(TIM1_AF1, path->source); /* the output of this comparator alone reaches the timer */
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

/*
 * The line of the gate driver: with the other polarity its level at rest must open the output. The
 * registers are not locked yet.
 */
static bool line_opens_output(void)
{
    const uint32_t sources = settings_value(TIM1_AF1);
    bool opens;

    reg_write(TIM1_AF1, sources ^ TIM_AF1_BKINP);
    clock_wait_us(1U);
    opens = !reg_any(TIM1_BDTR, TIM_BDTR_MOE) && !output_stays_on();
    reg_write(TIM1_AF1, sources);
    clock_wait_us(1U);
    return opens && output_stays_on();
}

static const char *try_line(void)
{
    const char *why = NULL;

    if (!output_stays_on()) {
        why = reg_any(TIM1_SR, TIM_SR_BIF) ? "the gate driver tells of a fault at rest"
                                           : "the timer does not enable its output";
    } else if (!line_opens_output()) {
        why = "the line of the gate driver does not open the gates";
    } else {
        /* it works */
    }
    reg_clear(TIM1_BDTR, TIM_BDTR_MOE);
    return why;
}

/* Locks the comparators. They stay as they are until the next reset. */
static void lock_comparators(void)
{
    for (uint32_t k = 0U; paths[k].comparator != 0U; k++) {
        reg_write(paths[k].comparator, settings_value(paths[k].comparator));
    }
}

static const char *try_comparators(void)
{
    const char *why = NULL;

    for (uint32_t k = 0U; (why == NULL) && (paths[k].comparator != 0U); k++) {
        why = try_path(&paths[k]);
    }
    reg_write(TIM1_AF1, settings_value(TIM1_AF1));
    lock_comparators();
    return why;
}

const char *trip_try(void)
{
    const char *const why = BOARD.has_comparators ? try_comparators() : try_line();

    reg_write(TIM1_SR, 0U);
    return why;
}
