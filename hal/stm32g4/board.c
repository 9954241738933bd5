/* SPDX-License-Identifier: MIT */
#include "board.h"

#include "hal_config.h"
#include "stm32g4.h"

/*
 * The limits of these chips. nfconfig has checked them already, and names the line of the board
 * file; this is the second line of defence.
 */
_Static_assert(HAL_TIMER_CLOCK_HZ == BOARD_CLOCK_HZ,
               "board.timer_clock_hz: this chip's timer runs at 170000000 Hz");
_Static_assert(HAL_ADC_BITS == 12U, "board.adc_bits: this chip's converters have 12");
_Static_assert(HAL_DEAD_TIME_TICKS <= 1008U,
               "board.dead_time_s: this chip's timer makes 1008 of its ticks at most");
_Static_assert(HAL_ADC_SAMPLING_NS <= 1100U,
               "hal.adc_sampling_ns: 47.5 converter cycles at most, as long as the bus is sampled");
_Static_assert((HAL_BAUD >= 2594U) && (HAL_BAUD <= 10625000U),
               "board.baud: this chip's USART divides 170000000 Hz by 16 to 65535");

const board_t BOARD = {
    .timer_counts = HAL_TIMER_COUNTS,
    .amplifier_zero = HAL_AMPLIFIER_ZERO,
    .amplifier_inverts = HAL_AMPLIFIER_INVERTS,
    .measures_c = HAL_MEASURES_C,
    .has_comparators = HAL_HAS_COMPARATORS,
    .trip_below = HAL_TRIP_BELOW,
    .crystal_span = HAL_CRYSTAL_SPAN,
    .wake_us = HAL_WAKE_US,
    .led_port = HAL_LED_PORT,
    .led_on = HAL_LED_ON,
    .led_off = HAL_LED_OFF,
    .has_throttle = HAL_HAS_THROTTLE,
    .has_button = HAL_HAS_BUTTON,
    .button_low = HAL_BUTTON_LOW,
    .has_pulses = HAL_HAS_PULSES,
    .shaft = HAL_SHAFT,
    .has_index = HAL_HAS_INDEX,
    .hall_age_q24 = HAL_HALL_AGE_Q24,
};
