/* SPDX-License-Identifier: MIT */
#include "hal_g4.h"

#include "barrier.h"
#include "check.h"
#include "clock.h"
#include "guard.h"
#include "pace.h"
#include "pins.h"
#include "pulses.h"
#include "pwm.h"
#include "sensing.h"
#include "shaft.h"
#include "trip.h"
#include "uart.h"

#include <stddef.h>

/* Timer ticks for writing the three compare registers, with a margin: 0.4 µs. */
#define WRITE_TICKS (64U)

/*
 * Control ticks from one regular conversion to the next; a power of two, as the number of
 * conversions from one of the temperature to the next. The others are of the throttle.
 */
#define REGULAR_TICKS (128U)
#define TEMPERATURE_SHARE (8U)

/* The comparators come first: the timer's break input must not see them start. */
const char *hal_g4_init(hal_t *hal)
{
    const char *why = NULL;

    if (BOARD.wake_us > 0U) {
        clock_wait_us(BOARD.wake_us);
    }
    if (BOARD.has_pulses) {
        pulses_init();
    }
    shaft_init();
    if (!trip_init()) {
        why = "the trip level's DAC does not become ready";
    } else {
        pace_init();
        pwm_init();
        why = trip_try();
        pwm_connect();
    }
    hal->throttle = HAL_NO_THROTTLE;
    if ((why == NULL) && !sensing_init(&hal->temperature, &hal->throttle)) {
        why = "a converter does not become ready";
    }
    return why;
}

const char *hal_g4_start(void)
{
    const char *why = NULL;

    if (!pwm_start()) {
        why = "the timer does not update at its peak";
    } else if (!guard_start()) {
        why = "the watchdog does not start";
    } else {
        why = check_all();
    }
    if (why == NULL) {
        barrier_compiler(); /* all that the first tick reads is in memory */
        guard_restart();
        sensing_start();
    }
    return why;
}

/*
 * Acknowledges the update, and the break if there was one; an active break input sets its flag
 * again. Only the flags that were seen are cleared, so that a break in between is not lost.
 */
static uint16_t take_flags(hal_t *hal)
{
    const uint32_t seen = reg_read(TIM1_SR) & (TIM_SR_UIF | PWM_BREAK_FLAGS);
    const bool broken = (seen & PWM_BREAK_FLAGS) != 0U;
    const uint32_t late = hal->late ? DRIVE_FLAG_LATE : 0U;

    reg_write(TIM1_SR, ~seen);
    if (broken) {
        hal->gates_on = false;
    }
    return (uint16_t)((broken || hal->barred) ? (late | DRIVE_FLAG_BREAK) : late);
}

/* Whether the present group of ticks converts the temperature, and not the throttle. */
static bool is_for_temperature(uint32_t tick)
{
    return ((tick / REGULAR_TICKS) % TEMPERATURE_SHARE) == 0U;
}

static void start_regular(uint32_t tick)
{
    if (is_for_temperature(tick)) {
        sensing_start_temperature();
    } else if (BOARD.has_throttle) {
        sensing_start_throttle();
    } else {
        /* there is none */
    }
}

static void read_regular(hal_t *hal)
{
    if (is_for_temperature(hal->ticks)) {
        hal->temperature = sensing_temperature();
    } else if (BOARD.has_throttle && sensing_has_throttle()) {
        hal->throttle = sensing_throttle();
        hal->conversions++;
    } else {
        /* there is none, or its conversion has not ended */
    }
}

/*
 * A regular conversion is started only here, right after the injected sequence, so it ends long
 * before the next one. If the two met, channel 0 could be converted in place of a shunt
 * (sensing.c). After a late tick the next sequence may be near, so the conversion is left out.
 * hal->ticks counts each control interrupt, so no phase is skipped.
 */
static void follow_regular(hal_t *hal)
{
    const uint32_t phase = hal->ticks % REGULAR_TICKS;

    if (phase == 0U) {
        hal->asked = !hal->late;
        if (hal->asked) {
            start_regular(hal->ticks);
        }
    } else if ((phase == 1U) && hal->asked) {
        read_regular(hal);
    } else {
        /* both change slowly */
    }
}

/* A third phase that is not measured takes what the others leave. */
static uint16_t third_of(const drive_in_t *in)
{
    const uint32_t others = (uint32_t)in->adc_ia + (uint32_t)in->adc_ib;
    const uint32_t lifted = 3U * SENSING_MIDDLE;

    return (uint16_t)((lifted > others) ? (lifted - others) : 0U);
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    shaft_sample();
    guard_restart();
    reg_write(HAL_ADC_LAST + ADC_ISR, ADC_ISR_JEOS | ADC_ISR_JEOC);
    in->flags = take_flags(hal);
    pwm_write_rest();
    follow_regular(hal);
    in->adc_ia = sensing_current(reg_read(HAL_RESULT_A));
    in->adc_ib = sensing_current(reg_read(HAL_RESULT_B));
    in->adc_bus = (uint16_t)reg_read(HAL_RESULT_BUS);
    in->adc_temperature = hal->temperature;
    in->angle = 0U; /* no sensor */
    hal->phase_c = BOARD.measures_c ? sensing_current(reg_read(HAL_RESULT_C)) : third_of(in);
}

hal_shaft_t hal_shaft(hal_t *hal)
{
    (void)hal;
    return shaft_read();
}

/*
 * The output is enabled only once for a request of the drive. If a break opens the gates later,
 * they stay open until the drive has seen the break and asks again.
 */
static void set_gates(hal_t *hal, bool enable)
{
    if (!enable) {
        hal_open_gates(hal);
    } else if (!hal->gates_on && !hal->barred && !reg_any(TIM1_SR, PWM_BREAK_FLAGS)) {
        reg_set(TIM1_BDTR, TIM_BDTR_MOE);
        hal->gates_on = true;
        /* Break or tick guard may have come between the look above and the output's enabling. */
        if (hal->barred || reg_any(TIM1_SR, PWM_BREAK_FLAGS)) {
            hal_open_gates(hal);
        }
    } else {
        /* nothing to change */
    }
}

/*
 * Whether the tick ends too late: the next update has come, or it is so close that it might load
 * only some of the three values.
 */
static bool is_late(uint32_t elapsed)
{
    const bool close = elapsed > ((2U * BOARD.timer_counts) - WRITE_TICKS);

    return close || reg_any(TIM1_SR, TIM_SR_UIF);
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    const uint32_t elapsed = pwm_elapsed();

    hal->late = is_late(elapsed);
    if (hal->late) {
        hal->overruns++;
    } else {
        pwm_write(out->compare.phase[0], out->compare.phase[1], out->compare.phase[2]);
        hal->longest = (elapsed > hal->longest) ? elapsed : hal->longest;
    }
    set_gates(hal, out->gate_enable);
    shaft_start();
    hal->ticks++;
}

void hal_open_gates(hal_t *hal)
{
    reg_clear(TIM1_BDTR, TIM_BDTR_MOE);
    hal->gates_on = false;
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    (void)hal;
    return uart_get(byte);
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    (void)hal;
    return uart_put(byte);
}

bool hal_pulse(hal_t *hal, hal_pulse_t *pulse)
{
    (void)hal;
    return BOARD.has_pulses && pulses_take(pulse);
}

uint32_t hal_pulse_now(const hal_t *hal)
{
    (void)hal;
    return BOARD.has_pulses ? pulses_now() : 0U;
}

static bool is_pressed(void)
{
    const bool high = reg_any(HAL_BUTTON_PORT + GPIO_IDR, 1UL << HAL_BUTTON_BIT);

    return high != BOARD.button_low;
}

hal_inputs_t hal_inputs(const hal_t *hal)
{
    return (hal_inputs_t){
        .throttle = hal->throttle,
        .conversions = hal->conversions,
        .button = BOARD.has_button && is_pressed(),
    };
}

hal_health_t hal_health(const hal_t *hal)
{
    return (hal_health_t){
        .adc_ic = hal->phase_c,
        .late_ticks = hal->overruns,
        .load_pct = (hal->longest * 50U) / BOARD.timer_counts,
        .tick_lost = hal->tick_lost,
        .why_barred = hal->why_barred,
    };
}

void hal_g4_bar(hal_t *hal, const char *why)
{
    hal->why_barred = (hal->why_barred == NULL) ? why : hal->why_barred;
    hal->barred = true;
    hal_open_gates(hal);
    pins_release_gates();
}

void hal_g4_tick_lost(hal_t *hal)
{
    hal->tick_lost = true;
    hal->barred = true;
    hal_open_gates(hal);
}

/* The flag of the pin is set after each reset, so it is looked at last. */
static hal_reset_reason_t reset_reason(uint32_t flags)
{
    hal_reset_reason_t reason = HAL_RESET_UNKNOWN;

    if ((flags & RCC_CSR_BORRSTF) != 0U) {
        reason = HAL_RESET_SUPPLY;
    } else if ((flags & RCC_CSR_IWDGRSTF) != 0U) {
        reason = HAL_RESET_WATCHDOG;
    } else if ((flags & RCC_CSR_SFTRSTF) != 0U) {
        reason = HAL_RESET_SOFTWARE;
    } else if ((flags & RCC_CSR_OTHERS) != 0U) {
        reason = HAL_RESET_OTHER;
    } else if ((flags & RCC_CSR_PINRSTF) != 0U) {
        reason = HAL_RESET_PIN;
    } else {
        /* no flag is set */
    }
    return reason;
}

void hal_g4_note_reset(hal_t *hal)
{
    hal->reset = (hal_reset_t){.reason = reset_reason(reg_read(RCC_CSR)),
                               .exception = reg_read(HAL_G4_EXCEPTION) & SCB_ICSR_VECTACTIVE};
    reg_set(RCC_CSR, RCC_CSR_RMVF);
    reg_write(HAL_G4_EXCEPTION, 0U);
}

hal_reset_t hal_reset(const hal_t *hal)
{
    return hal->reset;
}

/* Backup registers, because the RAM test of the start-up overwrites the whole RAM. */
void hal_keep(hal_t *hal, uint32_t index, uint32_t word)
{
    (void)hal;
    reg_write(TAMP_BKP0R + (4U * index), word);
}

uint32_t hal_kept(const hal_t *hal, uint32_t index)
{
    (void)hal;
    return reg_read(TAMP_BKP0R + (4U * index));
}
