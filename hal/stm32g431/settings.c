/* SPDX-License-Identifier: MIT */
#include "settings.h"

#include "board.h"
#include "codes.h"
#include "hal_config.h"
#include "reg.h"
#include "sensing.h"
#include "stm32g431.h"

#define ALL (0xFFFFFFFFUL)
#define NAME_ROOM (14U)

/* The part of a row's value that made() computes from the board's numbers. */
typedef enum {
    MADE_OF_NOTHING,
    MADE_OF_DEAD_TIME,
    MADE_OF_GAIN,
    MADE_OF_SAMPLING_LOW, /* sampling times of the channels up to 9; HIGH: of the others */
    MADE_OF_SAMPLING_HIGH
} made_of_t;

typedef struct {
    uint32_t address;
    uint32_t mask; /* the bits that are compared */
    uint32_t value;
    uint8_t group;   /* settings_group_t */
    uint8_t made_of; /* made_of_t */
    char name[NAME_ROOM];
} setting_t;

#define TWO_CHANNELS (TIM_CCMR_PWM1_PRELOAD | (TIM_CCMR_PWM1_PRELOAD << 8))
#define ALL_OUTPUTS (TIM_CCER_CH1_AND_N | (TIM_CCER_CH1_AND_N << 4) | (TIM_CCER_CH1_AND_N << 8))
#define BREAK_SOURCES (TIM_AF1_BKCMP1E | TIM_AF1_BKCMP2E | TIM_AF1_BKCMP4E)
#define BREAK_INVERTED (TIM_AF1_BKCMP1P | TIM_AF1_BKCMP2P | TIM_AF1_BKCMP4P)
/*
 * The filter of the break input. At turn-on the gate's charge and the diode's reverse recovery flow
 * through the shunt, and cause a spike of some tens of ns at its inductance. A filter of 47 ns
 * would let the spike through, a filter of 141 ns does not. In a real short the current rises
 * further during these 141 ns: with 1 µH at 24 V by 3.4 A.
 */
#define BREAK_AND_LOCK \
    (TIM_BDTR_OSSI | TIM_BDTR_OSSR | TIM_BDTR_BKE | TIM_BDTR_BKP | TIM_BDTR_BKF_6_OF_4 | \
     TIM_BDTR_LOCK_1)
/* With 10 mV of hysteresis the edges of the PWM do not make the output chatter. */
#define COMPARATOR (COMP_CSR_INMSEL_DAC3 | COMP_CSR_HYST_10MV | COMP_CSR_EN | COMP_CSR_LOCK)
#define AMPLIFIER (OPAMP_CSR_EN | OPAMP_CSR_HIGHSPEED)
#define SEQUENCE \
    (ADC_JSQR_TWO | ADC_JSQR_EXTSEL_TIM1_TRGO2 | ADC_JSQR_EXTEN_RISING | \
     (SENSING_CHANNEL_SHUNT << ADC_JSQR_SQ1_SHIFT))

static const setting_t SETTINGS[] = {
    {PWR_CR1, PWR_CR1_DBP, PWR_CR1_DBP, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "PWR_CR1"},
    {PWR_CR2, PWR_CR2_COUNTED, PWR_CR2_PVDE | PWR_CR2_PLS_2_8V, SETTINGS_TIMER, MADE_OF_NOTHING,
     "PWR_CR2"},
    {PWR_CR5, PWR_CR5_R1MODE, 0U, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "PWR_CR5"},
    {FLASH_ACR, FLASH_ACR_COUNTED, FLASH_ACR_AT_170MHZ, SETTINGS_READ_ONLY, MADE_OF_NOTHING,
     "FLASH_ACR"},
    {RCC_CR, RCC_CR_COUNTED, RCC_CR_COUNTED, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "RCC_CR"},
    {RCC_PLLCFGR, ALL, RCC_PLLCFGR_170MHZ, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "RCC_PLLCFGR"},
    {RCC_CFGR, RCC_CFGR_COUNTED, RCC_CFGR_SW_PLL | RCC_CFGR_SWS_PLL, SETTINGS_READ_ONLY,
     MADE_OF_NOTHING, "RCC_CFGR"},
    {RCC_AHB2ENR, RCC_AHB2ENR_USED, RCC_AHB2ENR_USED, SETTINGS_READ_ONLY, MADE_OF_NOTHING,
     "RCC_AHB2ENR"},
    {RCC_APB1ENR1, RCC_APB1ENR1_USED, RCC_APB1ENR1_USED, SETTINGS_READ_ONLY, MADE_OF_NOTHING,
     "RCC_APB1ENR1"},
    {RCC_APB2ENR, RCC_APB2ENR_USED, RCC_APB2ENR_USED, SETTINGS_READ_ONLY, MADE_OF_NOTHING,
     "RCC_APB2ENR"},

    {DAC3_MCR, ALL, DAC_MCR_MODE1_INTERNAL | DAC_MCR_MODE2_INTERNAL | DAC_MCR_HFSEL_160MHZ,
     SETTINGS_LEVEL, MADE_OF_NOTHING, "DAC3_MCR"},
    {DAC3_DHR12R1, ALL, HAL_TRIP_COUNT, SETTINGS_LEVEL, MADE_OF_NOTHING, "DAC3_DHR12R1"},
    {DAC3_DHR12R2, ALL, HAL_TRIP_COUNT, SETTINGS_LEVEL, MADE_OF_NOTHING, "DAC3_DHR12R2"},
    {DAC3_CR, ALL, DAC_CR_EN1 | DAC_CR_EN2, SETTINGS_LEVEL, MADE_OF_NOTHING, "DAC3_CR"},
    {COMP1_CSR, ~COMP_CSR_VALUE, COMPARATOR, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "COMP1_CSR"},
    {COMP2_CSR, ~COMP_CSR_VALUE, COMPARATOR, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "COMP2_CSR"},
    {COMP4_CSR, ~COMP_CSR_VALUE, COMPARATOR, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "COMP4_CSR"},

    {TIM1_CR1, ~(TIM_CR1_CEN | TIM_CR1_DIR), TIM_CR1_CMS_1 | TIM_CR1_ARPE, SETTINGS_TIMER,
     MADE_OF_NOTHING, "TIM1_CR1"},
    {TIM1_CR2, ALL, TIM_CR2_MMS2_UPDATE, SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_CR2"},
    {TIM1_CCMR1, ALL, TWO_CHANNELS, SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_CCMR1"},
    {TIM1_CCMR2, ALL, TIM_CCMR_PWM1_PRELOAD, SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_CCMR2"},
    {TIM1_PSC, ALL, 0U, SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_PSC"},
    {TIM1_ARR, ALL, HAL_TIMER_COUNTS, SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_ARR"},
    {TIM1_RCR, ALL, TIM_RCR_EACH_PEAK, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "TIM1_RCR"},
    {SYSCFG_CFGR2, SYSCFG_CFGR2_BREAKS, SYSCFG_CFGR2_BREAKS, SETTINGS_TIMER, MADE_OF_NOTHING,
     "SYSCFG_CFGR2"},
    {TIM1_AF1, ALL, HAL_TRIP_BELOW ? (BREAK_SOURCES | BREAK_INVERTED) : BREAK_SOURCES,
     SETTINGS_TIMER, MADE_OF_NOTHING, "TIM1_AF1"},
    {TIM1_BDTR, ~TIM_BDTR_MOE, BREAK_AND_LOCK, SETTINGS_TIMER, MADE_OF_DEAD_TIME, "TIM1_BDTR"},
    {TIM1_CCER, ALL, ALL_OUTPUTS, SETTINGS_OUTPUTS, MADE_OF_NOTHING, "TIM1_CCER"},

    {OPAMP1_CSR, OPAMP_CSR_COUNTED, AMPLIFIER, SETTINGS_AMPLIFIERS, MADE_OF_GAIN, "OPAMP1_CSR"},
    {OPAMP2_CSR, OPAMP_CSR_COUNTED, AMPLIFIER, SETTINGS_AMPLIFIERS, MADE_OF_GAIN, "OPAMP2_CSR"},
    {OPAMP3_CSR, OPAMP_CSR_COUNTED, AMPLIFIER | OPAMP_CSR_INTEN, SETTINGS_AMPLIFIERS, MADE_OF_GAIN,
     "OPAMP3_CSR"},
    {ADC12_CCR, ALL, ADC12_CCR_HCLK_4, SETTINGS_AMPLIFIERS, MADE_OF_NOTHING, "ADC12_CCR"},
    {ADC1 + ADC_CFGR, ALL, ADC_CFGR_JQDIS | ADC_CFGR_OVRMOD, SETTINGS_SEQUENCES, MADE_OF_NOTHING,
     "ADC1_CFGR"},
    {ADC1 + ADC_SMPR1, ALL, 0U, SETTINGS_SEQUENCES, MADE_OF_SAMPLING_LOW, "ADC1_SMPR1"},
    {ADC1 + ADC_SMPR2, ALL, 0U, SETTINGS_SEQUENCES, MADE_OF_SAMPLING_HIGH, "ADC1_SMPR2"},
    {ADC1 + ADC_SQR1, ALL, SENSING_CHANNEL_TEMPERATURE << ADC_SQR1_SQ1_SHIFT, SETTINGS_SEQUENCES,
     MADE_OF_NOTHING, "ADC1_SQR1"},
    {ADC1 + ADC_JSQR, ALL, SEQUENCE | (SENSING_CHANNEL_BUS << ADC_JSQR_SQ2_SHIFT),
     SETTINGS_SEQUENCES, MADE_OF_NOTHING, "ADC1_JSQR"},
    {ADC2 + ADC_CFGR, ALL, ADC_CFGR_JQDIS | ADC_CFGR_OVRMOD, SETTINGS_SEQUENCES, MADE_OF_NOTHING,
     "ADC2_CFGR"},
    {ADC2 + ADC_SMPR1, ALL, 0U, SETTINGS_SEQUENCES, MADE_OF_SAMPLING_LOW, "ADC2_SMPR1"},
    {ADC2 + ADC_SMPR2, ALL, 0U, SETTINGS_SEQUENCES, MADE_OF_SAMPLING_HIGH, "ADC2_SMPR2"},
    {ADC2 + ADC_SQR1, ALL, SENSING_CHANNEL_SHUNT << ADC_SQR1_SQ1_SHIFT, SETTINGS_SEQUENCES,
     MADE_OF_NOTHING, "ADC2_SQR1"},
    {ADC2 + ADC_JSQR, ALL, SEQUENCE | (SENSING_CHANNEL_AMPLIFIER_3 << ADC_JSQR_SQ2_SHIFT),
     SETTINGS_SEQUENCES, MADE_OF_NOTHING, "ADC2_JSQR"},

    {USART2_BRR, ALL, (BOARD_CLOCK_HZ + (HAL_BAUD / 2U)) / HAL_BAUD, SETTINGS_LINE, MADE_OF_NOTHING,
     "USART2_BRR"},
    {TIM16_TISEL, ALL, TIM16_TISEL_LSI, SETTINGS_PACE, MADE_OF_NOTHING, "TIM16_TISEL"},
    {TIM16_CCMR1, ALL, TIM_CCMR_CAPTURE_EIGHTH, SETTINGS_PACE, MADE_OF_NOTHING, "TIM16_CCMR1"},
    {TIM16_CCER, ALL, TIM_CCER_CC1E, SETTINGS_PACE, MADE_OF_NOTHING, "TIM16_CCER"},
    {TIM16_CR1, ALL, TIM_CR1_CEN, SETTINGS_PACE, MADE_OF_NOTHING, "TIM16_CR1"},
    {IWDG_PR, ALL, 0U, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "IWDG_PR"},
    {IWDG_RLR, ALL, IWDG_RLR_STRICT, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "IWDG_RLR"},
    {SCB_VTOR, ALL, SCB_VTOR_IMAGE, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "SCB_VTOR"},
    {SCB_SHPR3, ALL, 0U, SETTINGS_GUARD, MADE_OF_NOTHING, "SCB_SHPR3"},
    {NVIC_IPR4, NVIC_ADC1_2_PRIORITY, NVIC_ADC1_2_PRIORITY_1, SETTINGS_GUARD, MADE_OF_NOTHING,
     "NVIC_IPR4"},
    {SYST_RVR, ALL, (3U * HAL_TIMER_COUNTS) - 1U, SETTINGS_GUARD, MADE_OF_NOTHING, "SYST_RVR"},
    {SYST_CSR, SYST_CSR_RUN, SYST_CSR_RUN, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "SYST_CSR"},
    {NVIC_ISER0, ALL, 1UL << NVIC_ADC1_2, SETTINGS_READ_ONLY, MADE_OF_NOTHING, "NVIC_ISER0"},
};

#define ROWS (sizeof(SETTINGS) / sizeof(SETTINGS[0]))

static uint32_t log2_of(uint32_t power)
{
    uint32_t log2 = 0U;

    while ((power >> (log2 + 1U)) != 0U) {
        log2++;
    }
    return log2;
}

/*
 * The mode bits of the amplifiers. A gain of 1 means that the board has external amplifiers. Then
 * the amplifiers of the chip follow the plus pin. The comparators are at that pin too, so they see
 * the same voltage as the converters, on the same paths inside the chip as with any other gain.
 * With a larger gain the amplifiers take the difference between plus and minus pin, so that the
 * ground at the shunt is the reference.
 */
static uint32_t amplifier_mode(uint32_t gain)
{
    const uint32_t log2 = log2_of(gain);

    return (log2 == 0U) ? OPAMP_CSR_VMSEL_FOLLOWER
                        : (OPAMP_CSR_VMSEL_PGA | OPAMP_CSR_PGA_MINUS_PIN |
                           ((log2 - 1U) << OPAMP_CSR_PGA_GAIN_SHIFT));
}

static uint32_t made(uint8_t made_of)
{
    const uint32_t shunt_code = codes_sampling(BOARD.adc_sampling_ns);
    uint32_t bits = 0U;

    switch (made_of) {
    case MADE_OF_DEAD_TIME:
        bits = codes_dead_time(BOARD.dead_time_ticks);
        break;
    case MADE_OF_GAIN:
        bits = amplifier_mode(BOARD.pga_gain);
        break;
    case MADE_OF_SAMPLING_LOW:
        bits = (CODES_SAMPLING_MAX << (3U * SENSING_CHANNEL_BUS)) |
               (shunt_code << (3U * SENSING_CHANNEL_SHUNT)) |
               (CODES_SAMPLING_MAX << (3U * SENSING_CHANNEL_TEMPERATURE));
        break;
    case MADE_OF_SAMPLING_HIGH:
        bits = shunt_code << (3U * (SENSING_CHANNEL_AMPLIFIER_3 - 10U));
        break;
    default: /* the row has the whole value */
        break;
    }
    return bits;
}

static uint32_t value_of_row(const setting_t *setting)
{
    return setting->value | made(setting->made_of);
}

void settings_write(settings_group_t group)
{
    for (uint32_t row = 0U; row < ROWS; row++) {
        const setting_t *const setting = &SETTINGS[row];

        if (setting->group == (uint8_t)group) {
            reg_write(setting->address, value_of_row(setting));
        }
    }
}

uint32_t settings_value(uint32_t address)
{
    uint32_t value = 0U;

    for (uint32_t row = 0U; row < ROWS; row++) {
        if (SETTINGS[row].address == address) {
            value = value_of_row(&SETTINGS[row]);
        }
    }
    return value;
}

uint32_t settings_count(void)
{
    return ROWS;
}

bool settings_hold(uint32_t row)
{
    const setting_t *const setting = &SETTINGS[row];

    return ((reg_read(setting->address) ^ value_of_row(setting)) & setting->mask) == 0U;
}

const char *settings_name(uint32_t row)
{
    return SETTINGS[row].name;
}
