/* SPDX-License-Identifier: MIT */
#include "sensing.h"

#include "clock.h"
#include "codes.h"

/* RM0440 table 163 and data sheet table 4: inputs of the converters. */
#define CHANNEL_BUS (1UL)          /* ADC1, PA0 */
#define CHANNEL_SHUNT (3UL)        /* ADC1: PA2, first amplifier; ADC2: PA6, second */
#define CHANNEL_TEMPERATURE (5UL)  /* ADC1, PB14 */
#define CHANNEL_AMPLIFIER_3 (18UL) /* ADC2, inside */

/* Data sheet, tables 60 and 74: converter regulator at most 20 µs, wake-up of an amplifier at most 6 µs. */
#define WAKE_US (30U)

static uint32_t log2_of(uint32_t power)
{
    uint32_t log2 = 0U;

    while ((power >> (log2 + 1U)) != 0U) {
        log2++;
    }
    return log2;
}

/*
 * What the amplifiers make of their pins. Behind an external amplifier they follow the plus pin: the comparators, which
 * look there, and the converters then see the same voltage, by the same ways inside the chip as with any other gain.
 * Else the gain is from the difference between plus and minus pin, so that the ground at the shunt counts.
 */
static uint32_t amplifier_mode(uint32_t gain)
{
    const uint32_t log2 = log2_of(gain);

    return (log2 == 0U) ? OPAMP_CSR_VMSEL_FOLLOWER
                        : (OPAMP_CSR_VMSEL_PGA | OPAMP_CSR_PGA_MINUS_PIN |
                           ((log2 - 1U) << OPAMP_CSR_PGA_GAIN_SHIFT));
}

static void start_amplifiers(void)
{
    const uint32_t amplifier = OPAMP_CSR_EN | OPAMP_CSR_HIGHSPEED | amplifier_mode(BOARD.pga_gain);

    reg_write(OPAMP1_CSR, amplifier);
    reg_write(OPAMP2_CSR, amplifier);
    reg_write(OPAMP3_CSR, amplifier | OPAMP_CSR_INTEN);
}

/* RM0440 21.4.6, 21.4.8: out of deep power down, and calibrated. */
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
    clock_wait_us(1U); /* four of its cycles between calibration and enabling */
    reg_write(adc + ADC_ISR, ADC_ISR_ADRDY);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN);
    return reg_wait(adc + ADC_ISR, ADC_ISR_ADRDY, ADC_ISR_ADRDY);
}

/* `second` behind the shunt at each peak; `regular` when it is asked for. */
static void set_sequence(uint32_t adc, uint32_t second, uint32_t regular, uint32_t shunt_code)
{
    reg_write(adc + ADC_CFGR, ADC_CFGR_JQDIS | ADC_CFGR_OVRMOD);
    reg_write(adc + ADC_SMPR1, (CODES_SAMPLING_MAX << (3U * CHANNEL_BUS)) |
                                   (shunt_code << (3U * CHANNEL_SHUNT)) |
                                   (CODES_SAMPLING_MAX << (3U * CHANNEL_TEMPERATURE)));
    reg_write(adc + ADC_SMPR2, shunt_code << (3U * (CHANNEL_AMPLIFIER_3 - 10U)));
    reg_write(adc + ADC_SQR1, regular << ADC_SQR1_SQ1_SHIFT);
    reg_write(adc + ADC_JSQR, ADC_JSQR_TWO | ADC_JSQR_EXTSEL_TIM1_TRGO2 | ADC_JSQR_EXTEN_RISING |
                                  (CHANNEL_SHUNT << ADC_JSQR_SQ1_SHIFT) |
                                  (second << ADC_JSQR_SQ2_SHIFT));
}

/* A regular conversion, before the injected ones are awaited. False when it does not end. */
static bool convert_once(uint32_t adc)
{
    reg_write(adc + ADC_ISR, ADC_ISR_EOC);
    reg_write(adc + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADSTART);
    return reg_wait(adc + ADC_ISR, ADC_ISR_EOC, ADC_ISR_EOC);
}

/*
 * ES0431, "ADC channel 0 converted instead of the required ADC channel" (2.5.8, in later revisions 2.5.10): so can the first
 * conversion behind the enabling, and one of a group that starts while the other group converts. Each converter makes one
 * whose result nobody takes; a later one that follows within 1 ms is right (2.5.9).
 */
static bool forget_first(void)
{
    return convert_once(ADC1) && convert_once(ADC2);
}

static bool wake_converter(uint32_t adc)
{
    return calibrate_converter(adc) && enable_converter(adc);
}

static void set_sequences(void)
{
    const uint32_t shunt_code = codes_sampling(BOARD.adc_sampling_ns);

    set_sequence(ADC1, CHANNEL_BUS, CHANNEL_TEMPERATURE, shunt_code);
    set_sequence(ADC2, CHANNEL_AMPLIFIER_3, CHANNEL_SHUNT, shunt_code);
}

/* Both converters wait for the timer's triggers. */
static void arm(void)
{
    reg_write(ADC2 + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN | ADC_CR_JADSTART);
    reg_write(ADC1 + ADC_CR, ADC_CR_ADVREGEN | ADC_CR_ADEN | ADC_CR_JADSTART);
}

bool sensing_init(uint16_t *temperature)
{
    bool is_ready = false;

    start_amplifiers();
    reg_write(ADC12_CCR, ADC12_CCR_HCLK_4);
    if (wake_converter(ADC1) && wake_converter(ADC2)) {
        set_sequences();
        is_ready = forget_first() && convert_once(ADC1);
    }
    if (is_ready) {
        *temperature = sensing_temperature();
        arm();
    }
    return is_ready;
}

void sensing_start(void)
{
    reg_write(ADC1 + ADC_ISR, ADC_ISR_JEOS | ADC_ISR_JEOC);
    reg_write(ADC1 + ADC_IER, ADC_IER_JEOSIE);
}
