/* SPDX-License-Identifier: MIT */
#include "settings.h"

#include "board.h"
#include "hal_config.h"
#include "pulses.h"
#include "reg.h"
#include "sensing.h"
#include "stm32g4.h"

#define ALL (0xFFFFFFFFUL)
#define NAME_ROOM (14U)

typedef struct {
    uint32_t address;
    uint32_t mask; /* the bits that are compared */
    uint32_t value;
    uint8_t group; /* settings_group_t */
    char name[NAME_ROOM];
} setting_t;

#define TWO_CHANNELS (TIM_CCMR_PWM1_PRELOAD | (TIM_CCMR_PWM1_PRELOAD << 8))
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
/*
 * The amplifiers take the difference between plus and minus pin, so that the ground at the shunt is
 * the reference.
 */
#define AMPLIFIER \
    (OPAMP_CSR_EN | OPAMP_CSR_HIGHSPEED | OPAMP_CSR_VMSEL_PGA | OPAMP_CSR_PGA_MINUS_PIN | \
     ((uint32_t)HAL_AMPLIFIER_GAIN << OPAMP_CSR_PGA_GAIN_SHIFT))

static const setting_t SETTINGS[] = {
    {PWR_CR1, PWR_CR1_DBP, PWR_CR1_DBP, SETTINGS_READ_ONLY, "PWR_CR1"},
    {PWR_CR2, PWR_CR2_COUNTED, PWR_CR2_PVDE | PWR_CR2_PLS_2_8V, SETTINGS_TIMER, "PWR_CR2"},
    {PWR_CR5, PWR_CR5_R1MODE, 0U, SETTINGS_READ_ONLY, "PWR_CR5"},
    {FLASH_ACR, FLASH_ACR_COUNTED, FLASH_ACR_AT_170MHZ, SETTINGS_READ_ONLY, "FLASH_ACR"},
    {RCC_CR, RCC_CR_INSIDE | RCC_CR_CRYSTAL, HAL_CR, SETTINGS_READ_ONLY, "RCC_CR"},
    {RCC_PLLCFGR, ALL, HAL_PLL, SETTINGS_READ_ONLY, "RCC_PLLCFGR"},
    {RCC_CFGR, RCC_CFGR_COUNTED, RCC_CFGR_SW_PLL | RCC_CFGR_SWS_PLL, SETTINGS_READ_ONLY,
     "RCC_CFGR"},
    {RCC_AHB1ENR, HAL_AHB1, HAL_AHB1, SETTINGS_READ_ONLY, "RCC_AHB1ENR"},
    {RCC_AHB2ENR, HAL_AHB2, HAL_AHB2, SETTINGS_READ_ONLY, "RCC_AHB2ENR"},
    {RCC_APB1ENR1, HAL_APB1, HAL_APB1, SETTINGS_READ_ONLY, "RCC_APB1ENR1"},
    {RCC_APB2ENR, HAL_APB2, HAL_APB2, SETTINGS_READ_ONLY, "RCC_APB2ENR"},

    /* rows of which the board file says how many there are */
    HAL_LEVELS HAL_COMPARATORS HAL_AMPLIFIERS

    {TIM1_CR1, ~(TIM_CR1_CEN | TIM_CR1_DIR), TIM_CR1_CMS_1 | TIM_CR1_ARPE, SETTINGS_TIMER,
     "TIM1_CR1"},
    {TIM1_CR2, ALL, TIM_CR2_MMS2_UPDATE | HAL_IDLE_LEVELS, SETTINGS_TIMER, "TIM1_CR2"},
    {TIM1_CCMR1, ALL, TWO_CHANNELS, SETTINGS_TIMER, "TIM1_CCMR1"},
    {TIM1_CCMR2, ALL, TIM_CCMR_PWM1_PRELOAD, SETTINGS_TIMER, "TIM1_CCMR2"},
    {TIM1_PSC, ALL, 0U, SETTINGS_TIMER, "TIM1_PSC"},
    {TIM1_ARR, ALL, HAL_TIMER_COUNTS, SETTINGS_TIMER, "TIM1_ARR"},
    {TIM1_RCR, ALL, TIM_RCR_EACH_PEAK, SETTINGS_READ_ONLY, "TIM1_RCR"},
    {SYSCFG_CFGR2, SYSCFG_CFGR2_BREAKS, SYSCFG_CFGR2_BREAKS, SETTINGS_TIMER, "SYSCFG_CFGR2"},
    {TIM1_AF1, ALL, HAL_BREAK_SOURCES, SETTINGS_TIMER, "TIM1_AF1"},
    {TIM1_BDTR, ~TIM_BDTR_MOE, BREAK_AND_LOCK | HAL_DEAD_TIME_CODE, SETTINGS_READ_ONLY,
     "TIM1_BDTR"},
    {TIM1_CCER, ALL, HAL_OUTPUTS, SETTINGS_OUTPUTS, "TIM1_CCER"},

    {ADC12_CCR, ALL, ADC12_CCR_HCLK_4, SETTINGS_AMPLIFIERS, "ADC12_CCR"},
    {ADC1 + ADC_CFGR, ALL, ADC_CFGR_JQDIS | ADC_CFGR_OVRMOD, SETTINGS_SEQUENCES, "ADC1_CFGR"},
    {ADC1 + ADC_SMPR1, ALL, HAL_ADC1_SMPR1, SETTINGS_SEQUENCES, "ADC1_SMPR1"},
    {ADC1 + ADC_SMPR2, ALL, HAL_ADC1_SMPR2, SETTINGS_SEQUENCES, "ADC1_SMPR2"},
    {ADC1 + ADC_SQR1, HAL_ADC1_REGULAR_HELD, (uint32_t)HAL_ADC1_REGULAR << ADC_SQR1_SQ1_SHIFT,
     SETTINGS_SEQUENCES, "ADC1_SQR1"},
    {ADC1 + ADC_JSQR, ALL, HAL_ADC1_JSQR, SETTINGS_SEQUENCES, "ADC1_JSQR"},
    {ADC2 + ADC_CFGR, ALL, ADC_CFGR_JQDIS | ADC_CFGR_OVRMOD, SETTINGS_SEQUENCES, "ADC2_CFGR"},
    {ADC2 + ADC_SMPR1, ALL, HAL_ADC2_SMPR1, SETTINGS_SEQUENCES, "ADC2_SMPR1"},
    {ADC2 + ADC_SMPR2, ALL, HAL_ADC2_SMPR2, SETTINGS_SEQUENCES, "ADC2_SMPR2"},
    {ADC2 + ADC_SQR1, HAL_ADC2_REGULAR_HELD, (uint32_t)HAL_ADC2_REGULAR << ADC_SQR1_SQ1_SHIFT,
     SETTINGS_SEQUENCES, "ADC2_SQR1"},
    {ADC2 + ADC_JSQR, ALL, HAL_ADC2_JSQR, SETTINGS_SEQUENCES, "ADC2_JSQR"},

    {HAL_USART + USART_BRR, ALL, (BOARD_CLOCK_HZ + (HAL_BAUD / 2U)) / HAL_BAUD, SETTINGS_LINE,
     HAL_USART_BRR_NAME},

    /* rows of inputs and of a sensor of the shaft, of those that the board has */
    // cppcheck-suppress misra-c2012-11.4 ; D7: the DMA takes the address of its ring as a number
    HAL_PULSE_SETTINGS HAL_SHAFT_SETTINGS

    {TIM16_TISEL, ALL, TIM16_TISEL_LSI, SETTINGS_PACE, "TIM16_TISEL"},
    {TIM16_CCMR1, ALL, TIM_CCMR_CAPTURE_EIGHTH, SETTINGS_PACE, "TIM16_CCMR1"},
    {TIM16_CCER, ALL, TIM_CCER_CC1E, SETTINGS_PACE, "TIM16_CCER"},
    {TIM16_CR1, ALL, TIM_CR1_CEN, SETTINGS_PACE, "TIM16_CR1"},
    {IWDG_PR, ALL, 0U, SETTINGS_READ_ONLY, "IWDG_PR"},
    {IWDG_RLR, ALL, IWDG_RLR_STRICT, SETTINGS_READ_ONLY, "IWDG_RLR"},
    {SCB_VTOR, ALL, SCB_VTOR_IMAGE, SETTINGS_READ_ONLY, "SCB_VTOR"},
    {SCB_SHPR3, ALL, 0U, SETTINGS_GUARD, "SCB_SHPR3"},
    {NVIC_IPR4, NVIC_ADC1_2_PRIORITY, NVIC_ADC1_2_PRIORITY_1, SETTINGS_GUARD, "NVIC_IPR4"},
    {SYST_RVR, ALL, (3U * HAL_TIMER_COUNTS) - 1U, SETTINGS_GUARD, "SYST_RVR"},
    {SYST_CSR, SYST_CSR_RUN, SYST_CSR_RUN, SETTINGS_READ_ONLY, "SYST_CSR"},
    {NVIC_ISER0, ALL, 1UL << NVIC_ADC1_2, SETTINGS_READ_ONLY, "NVIC_ISER0"},
};

#define ROWS (sizeof(SETTINGS) / sizeof(SETTINGS[0]))

void settings_write(settings_group_t group)
{
    for (uint32_t row = 0U; row < ROWS; row++) {
        const setting_t *const setting = &SETTINGS[row];

        if (setting->group == (uint8_t)group) {
            reg_write(setting->address, setting->value);
        }
    }
}

uint32_t settings_value(uint32_t address)
{
    uint32_t value = 0U;

    for (uint32_t row = 0U; row < ROWS; row++) {
        if (SETTINGS[row].address == address) {
            value = SETTINGS[row].value;
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

    return ((reg_read(setting->address) ^ setting->value) & setting->mask) == 0U;
}

const char *settings_name(uint32_t row)
{
    return SETTINGS[row].name;
}
