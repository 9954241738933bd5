/* SPDX-License-Identifier: MIT */
#include "sensing.h"

#include "clock.h"
#include "settings.h"

/*
 * Data sheet, tables 60 and 74: converter regulator at most 20 µs, wake-up of an amplifier at most
 * 6 µs.
 */
#define WAKE_US (30U)

/* RM0440 21.4.6, 21.4.8: leaves deep power down and calibrates. */
static bool calibrate_converter(uint32_t adc)
{
    reg_write(adc + ADC_CR, 0U);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN);
    clock_wait_us(WAKE_US);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADCAL);
    return reg_wait(adc + ADC_CR, ADC_CR_ADCAL, 0U);
}

/* RM0440 21.4.9. */
static bool enable_converter(uint32_t adc)
{
    /* at least four cycles of the converter between calibration and enabling */
    clock_wait_us(1U);
    reg_write(adc + ADC_ISR, ADC_ISR_ADRDY);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN);
    return reg_wait(adc + ADC_ISR, ADC_ISR_ADRDY, ADC_ISR_ADRDY);
}

/* One regular conversion, before arm() starts the injected ones. False when it does not end. */
static bool convert_once(uint32_t adc)
{
    reg_write(adc + ADC_ISR, ADC_ISR_EOC);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADSTART);
    return reg_wait(adc + ADC_ISR, ADC_ISR_EOC, ADC_ISR_EOC);
}

/*
 * ES0431, "ADC channel 0 converted instead of the required ADC channel" (2.5.8, in later revisions
 * 2.5.10). This can happen to the first conversion after the enabling, and to a conversion of one
 * group, regular or injected, that starts while the other group converts. So each converter makes
 * one conversion whose result is not used. A conversion that follows within 1 ms is right (2.5.9).
 */
static bool forget_first(void)
{
    return convert_once(ADC1) && convert_once(ADC2);
}

static bool wake_converter(uint32_t adc)
{
    return calibrate_converter(adc) && enable_converter(adc);
}

/* Makes both converters wait for the timer's triggers. */
static void arm(void)
{
    reg_write(ADC2 + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN | ADC_CR_JADSTART);
    reg_write(ADC1 + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN | ADC_CR_JADSTART);
}

static bool measure_throttle(uint16_t *throttle)
{
    bool is_ready;

    reg_write(HAL_ADC_THROTTLE + ADC_SQR1, HAL_THROTTLE_CHANNEL << ADC_SQR1_SQ1_SHIFT);
    is_ready = convert_once(HAL_ADC_THROTTLE);
    *throttle = sensing_throttle();
    return is_ready;
}

bool sensing_init(uint16_t *temperature, uint16_t *throttle)
{
    bool is_ready = false;

    settings_write(SETTINGS_AMPLIFIERS);
    if (wake_converter(ADC1) && wake_converter(ADC2)) {
        settings_write(SETTINGS_SEQUENCES);
        is_ready = forget_first() && convert_once(HAL_ADC_TEMPERATURE);
    }
    if (is_ready) {
        *temperature = sensing_temperature();
        is_ready = !BOARD.has_throttle || measure_throttle(throttle);
    }
    if (is_ready) {
        arm();
    }
    return is_ready;
}

void sensing_start(void)
{
    reg_write(HAL_ADC_LAST + ADC_ISR, ADC_ISR_JEOS | ADC_ISR_JEOC);
    reg_write(HAL_ADC_LAST + ADC_IER, ADC_IER_JEOSIE);
}
