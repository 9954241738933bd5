/* SPDX-License-Identifier: MIT */
/*
 * The registers of the STM32G4 that this binding uses, and no others.
 *
 * Sources: the reference manual RM0440 (STM32G4), whose chapter is given with each block, the
 * data sheets of STM32G431 and STM32G474 (pins), and the ARMv7-M architecture manual (core). The
 * names are taken from the manual; a bit is written as a mask.
 */
#ifndef STM32G4_H
#define STM32G4_H

/* --- Flash, 3.7 ------------------------------------------------------------------------------- */
#define FLASH_ACR (0x40022000U)
#define FLASH_ACR_LATENCY (0xFU)    /* wait states */
#define FLASH_ACR_PRFTEN (1UL << 8) /* prefetch */
#define FLASH_ACR_ICEN (1UL << 9)   /* instruction cache */
#define FLASH_ACR_DCEN (1UL << 10)  /* data cache */
#define FLASH_ACR_ICRST (1UL << 11) /* empties the instruction cache, while it is off */
#define FLASH_ACR_DCRST (1UL << 12) /* empties the data cache, while it is off */
#define FLASH_ACR_LATENCY_4 (4U)
#define FLASH_ACR_AT_170MHZ \
    (FLASH_ACR_LATENCY_4 | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN)
#define FLASH_ACR_COUNTED (FLASH_ACR_LATENCY | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN)
#define FLASH_KEYR (0x40022008U)
#define FLASH_KEY_1 (0x45670123U)
#define FLASH_KEY_2 (0xCDEF89ABU)
#define FLASH_SR (0x40022010U)
#define FLASH_SR_EOP (1UL << 0)
/* errors of operation, programming, protection, alignment, size, sequence, fast mode, options */
#define FLASH_SR_ERRORS (0xC3FAU)
#define FLASH_SR_BSY (1UL << 16)
#define FLASH_CR (0x40022014U)
#define FLASH_CR_PG (1UL << 0)
#define FLASH_CR_PER (1UL << 1)
#define FLASH_CR_PNB_SHIFT (3U)
#define FLASH_CR_BKER (1UL << 11) /* the second bank */
#define FLASH_CR_STRT (1UL << 16)
#define FLASH_CR_LOCK (1UL << 31)
#define FLASH_ECCR (0x40022018U)
/* more wrong bits than can be corrected were read; written as 1 to clear */
#define FLASH_ECCR_ECCD (1UL << 31)
#define FLASH_OPTR (0x40022020U)
#define FLASH_OPTR_BOR_LEV (7UL << 8) /* the chip resets below this supply; 0: 1.7 V, 4: 2.8 V */
#define FLASH_OPTR_BOR_LEV_4 (4UL << 8)
#define FLASH_OPTR_DBANK (1UL << 22)   /* 1: two banks with pages of 2 KiB; 0: pages of 4 KiB */
#define FLASH_OPTR_SRAM_PE (1UL << 24) /* 0: the parity of the RAM is checked */
#define FLASH_IMAGE (0x08000000U)

/* --- Backup registers, 36.6 ------------------------------------------------------------------- */
#define TAMP_BKP0R (0x40002500U) /* lost with the supply; no other reset changes it */

/* --- Power, 6.4 ------------------------------------------------------------------------------- */
#define PWR_CR1 (0x40007000U)
#define PWR_CR1_DBP (1UL << 8) /* the backup registers can be written */
#define PWR_CR2 (0x40007004U)
#define PWR_CR2_PVDE (1UL << 0)     /* the supply is compared with a level */
#define PWR_CR2_PLS_2_8V (5UL << 1) /* the level is 2.8 V */
#define PWR_CR2_COUNTED (0xFU)
#define PWR_CR3 (0x40007008U)
#define PWR_CR3_UCPD1_DBDIS (1UL << 14) /* no dead-battery pull-downs; one sits on PB4 */
#define PWR_SR2 (0x40007014U)
#define PWR_SR2_VOSF (1UL << 10) /* the regulator has not settled */
#define PWR_CR5 (0x40007080U)
#define PWR_CR5_R1MODE (1UL << 8) /* 0: range 1 boost, needed above 150 MHz */

/* --- Reset and clocks, 7.4 -------------------------------------------------------------------- */
#define RCC_CR (0x40021000U)
#define RCC_CR_HSION (1UL << 8)
#define RCC_CR_HSIRDY (1UL << 10)
#define RCC_CR_HSEON (1UL << 16)
#define RCC_CR_HSERDY (1UL << 17)
#define RCC_CR_CSSON (1UL << 19) /* watches the crystal; stays set until reset or failure */
#define RCC_CR_PLLON (1UL << 24)
#define RCC_CR_PLLRDY (1UL << 25)
#define RCC_CR_INSIDE (RCC_CR_HSION | RCC_CR_HSIRDY | RCC_CR_PLLON | RCC_CR_PLLRDY)
#define RCC_CR_CRYSTAL (RCC_CR_HSEON | RCC_CR_HSERDY | RCC_CR_CSSON)
#define RCC_CFGR (0x40021008U)
#define RCC_CFGR_SW (3U)
#define RCC_CFGR_SW_PLL (3U)
#define RCC_CFGR_SWS (3UL << 2)
#define RCC_CFGR_SWS_PLL (3UL << 2)
#define RCC_CFGR_SWS_HSI (1UL << 2)
#define RCC_CFGR_HPRE (0xFUL << 4)
#define RCC_CFGR_HPRE_2 (8UL << 4)  /* the core at half the system clock */
#define RCC_CFGR_PPRE (0x3FUL << 8) /* prescalers of both peripheral buses */
#define RCC_CFGR_COUNTED (RCC_CFGR_SW | RCC_CFGR_SWS | RCC_CFGR_HPRE | RCC_CFGR_PPRE)
#define RCC_PLLCFGR (0x4002100CU)
#define RCC_PLLCFGR_SRC_HSI16 (2UL)
#define RCC_PLLCFGR_SRC_HSE (3UL)
#define RCC_PLLCFGR_PLLM_SHIFT (4U) /* M − 1 */
#define RCC_PLLCFGR_PLLN_SHIFT (8U)
#define RCC_PLLCFGR_REN (1UL << 24) /* R = 2 with bits 26:25 at zero */
#define RCC_PLLCFGR_INSIDE \
    (RCC_PLLCFGR_SRC_HSI16 | (3UL << RCC_PLLCFGR_PLLM_SHIFT) | (85UL << RCC_PLLCFGR_PLLN_SHIFT) | \
     RCC_PLLCFGR_REN)
#define RCC_CIFR (0x4002101CU)
#define RCC_CIFR_CSSF (1UL << 8) /* the crystal has failed: NMI until CSSC is written */
#define RCC_CICR (0x40021020U)
#define RCC_CICR_CSSC (1UL << 8)
#define RCC_AHB1ENR (0x40021048U)
#define RCC_AHB1ENR_DMA1 (1UL << 0)
#define RCC_AHB1ENR_DMAMUX1 (1UL << 2)
#define RCC_AHB1ENR_CRC (1UL << 12)
#define RCC_AHB2ENR (0x4002104CU)
#define RCC_AHB2ENR_ADC12 (1UL << 13) /* bits 0 to 6: the ports */
#define RCC_AHB2ENR_DAC3 (1UL << 18)
#define RCC_APB1ENR1 (0x40021058U)
#define RCC_APB1ENR1_TIM2 (1UL << 0)
#define RCC_APB1ENR1_TIM3 (1UL << 1)
#define RCC_APB1ENR1_TIM4 (1UL << 2)
#define RCC_APB1ENR1_RTCAPB (1UL << 10) /* the backup registers too */
#define RCC_APB1ENR1_SPI2 (1UL << 14)
#define RCC_APB1ENR1_SPI3 (1UL << 15)
#define RCC_APB1ENR1_USART2 (1UL << 17)
#define RCC_APB1ENR1_USART3 (1UL << 18)
#define RCC_APB1ENR1_PWR (1UL << 28)
#define RCC_APB2ENR (0x40021060U)
#define RCC_APB2ENR_SYSCFG (1UL << 0) /* comparators and operational amplifiers too */
#define RCC_APB2ENR_TIM1 (1UL << 11)
#define RCC_APB2ENR_SPI1 (1UL << 12)
#define RCC_APB2ENR_USART1 (1UL << 14)
#define RCC_APB2ENR_TIM16 (1UL << 17)
#define RCC_CSR (0x40021094U)
#define RCC_CSR_RMVF (1UL << 23)     /* clears the reset causes */
#define RCC_CSR_PINRSTF (1UL << 26)  /* the pin; each other reset pulls it, too */
#define RCC_CSR_BORRSTF (1UL << 27)  /* the supply was off or too low */
#define RCC_CSR_SFTRSTF (1UL << 28)  /* the software made the last reset */
#define RCC_CSR_IWDGRSTF (1UL << 29) /* the independent watchdog made the last reset */
#define RCC_CSR_OTHERS ((1UL << 25) | (1UL << 30) | (1UL << 31)) /* OBL, WWDG, low power */

/* --- Pins, 9.4 -------------------------------------------------------------------------------- */
#define GPIOA (0x48000000U)
#define GPIOB (0x48000400U)
#define GPIOC (0x48000800U)
#define GPIOD (0x48000C00U)
#define GPIOF (0x48001400U)
#define GPIO_MODER (0x00U) /* two bits per pin */
#define GPIO_MODE_INPUT (0U)
#define GPIO_MODE_OUTPUT (1U)
#define GPIO_MODE_ALTERNATE (2U)
#define GPIO_MODE_ANALOG (3U)
#define GPIO_OSPEEDR (0x08U) /* two bits per pin */
#define GPIO_SPEED_HIGH (2U)
#define GPIO_PUPDR (0x0CU) /* two bits per pin */
#define GPIO_PULL_NONE (0U)
#define GPIO_PULL_UP (1U)
#define GPIO_PULL_DOWN (2U)
#define GPIO_IDR (0x10U)  /* levels of the pins, also of those with an alternate function */
#define GPIO_BSRR (0x18U) /* low half sets, high half resets */
#define GPIO_BSRR_BR0_SHIFT (16U)
#define GPIO_AFRL (0x20U) /* four bits per pin, pins 0 to 7; the next register: pins 8 to 15 */

/* --- System configuration, 10.2 --------------------------------------------------------------- */
#define SYSCFG_CFGR2 (0x4001001CU)
/* a lockup of the core is a break of the timers; the bit stays set until reset */
#define SYSCFG_CFGR2_CLL (1UL << 0)
/* a wrong parity of the RAM is a break of the timers; the bit stays set until reset */
#define SYSCFG_CFGR2_SPL (1UL << 1)
/* a supply below the level of PWR_CR2 is a break of the timers; the bit stays set until reset */
#define SYSCFG_CFGR2_PVDL (1UL << 2)
#define SYSCFG_CFGR2_BREAKS (SYSCFG_CFGR2_CLL | SYSCFG_CFGR2_SPL | SYSCFG_CFGR2_PVDL)
#define SYSCFG_CFGR2_SPF (1UL << 8) /* a wrong parity was read; written as 1 to clear */

/* --- DMA, 12.6; its multiplexer, 13.6 --------------------------------------------------------- */
#define DMA1_CCR1 (0x40020008U)
#define DMA1_CNDTR1 (0x4002000CU) /* transfers to the end of the ring */
#define DMA1_CPAR1 (0x40020010U)
#define DMA1_CMAR1 (0x40020014U)
#define DMA1_CCR2 (0x4002001CU)
#define DMA1_CNDTR2 (0x40020020U)
#define DMA1_CPAR2 (0x40020024U)
#define DMA1_CMAR2 (0x40020028U)
/* enabled; words from a register into a ring of words */
#define DMA_CCR_RING (0xAA1U)
#define DMAMUX1_C0CR (0x40020800U) /* the request of channel 1 of DMA1 */
#define DMAMUX1_C1CR (0x40020804U)
#define DMAMUX_TIM2_CH1 (56U)
#define DMAMUX_TIM2_CH2 (57U)
#define DMAMUX_TIM2_CH3 (58U)
#define DMAMUX_TIM2_CH4 (59U)

/* --- CRC unit, 16.4 --------------------------------------------------------------------------- */
#define CRC_DR (0x40023000U)
#define CRC_CR (0x40023008U)
#define CRC_CR_RESET (1UL << 0)
#define CRC_CR_REV_IN_WORD (3UL << 5) /* the lowest bit of a word first */
#define CRC_CR_REV_OUT (1UL << 7)

/* --- Converters, 21.6 and 21.7 ---------------------------------------------------------------- */
#define ADC1 (0x50000000U)
#define ADC2 (0x50000100U)
#define ADC_ISR (0x00U)
#define ADC_ISR_ADRDY (1UL << 0)
#define ADC_ISR_EOC (1UL << 2)
#define ADC_ISR_JEOC (1UL << 5)
#define ADC_ISR_JEOS (1UL << 6) /* injected sequence complete; written as 1 to clear */
#define ADC_IER (0x04U)
#define ADC_IER_JEOSIE (1UL << 6)
#define ADC_CR (0x08U)
#define ADC_CR_ADEN (1UL << 0)
#define ADC_CR_ADSTART (1UL << 2)
#define ADC_CR_JADSTART (1UL << 3)
#define ADC_CR_ADVREGEN (1UL << 28)
#define ADC_CR_ADCAL (1UL << 31)
#define ADC_CFGR (0x0CU)
#define ADC_CFGR_OVRMOD (1UL << 12) /* a new regular result replaces one that was not read */
#define ADC_CFGR_JQDIS (1UL << 31)  /* no queue of contexts: JSQR stays as written */
#define ADC_SMPR1 (0x14U)           /* three bits per channel, channels 0 to 9 */
#define ADC_SMPR2 (0x18U)           /* three bits per channel, channels 10 to 18 */
#define ADC_SQR1 (0x30U)
#define ADC_SQR1_SQ1_SHIFT (6U)
#define ADC_DR (0x40U)
#define ADC_JSQR (0x4CU)
#define ADC_JSQR_TWO (1UL) /* number of conversions − 1 */
#define ADC_JSQR_EXTSEL_TIM1_TRGO2 (8UL << 2)
#define ADC_JSQR_EXTEN_RISING (1UL << 7)
#define ADC_JSQR_TRIGGER (ADC_JSQR_EXTSEL_TIM1_TRGO2 | ADC_JSQR_EXTEN_RISING)
#define ADC_JSQR_SQ1_SHIFT (9U)
#define ADC_JSQR_SQ2_SHIFT (15U)
#define ADC_JDR1 (0x80U)
#define ADC_JDR2 (0x84U)
#define ADC12_CCR (0x50000308U)
#define ADC12_CCR_HCLK_4 (3UL << 16) /* clock of both converters, in step with the timer's */

/* --- Converter to analogue, 22.7 -------------------------------------------------------------- */
#define DAC3_CR (0x50001000U)
#define DAC_CR_EN1 (1UL << 0)
#define DAC_CR_EN2 (1UL << 16)
#define DAC_CR_BOTH (DAC_CR_EN1 | DAC_CR_EN2)
#define DAC3_DHR12R1 (0x50001008U)
#define DAC3_DHR12R2 (0x50001014U)
#define DAC3_SR (0x50001034U)
#define DAC_SR_DAC1RDY (1UL << 11)
#define DAC_SR_DAC2RDY (1UL << 27)
#define DAC3_MCR (0x5000103CU)
/* the output goes to on-chip peripherals only, without buffer */
#define DAC_MCR_MODE1_INTERNAL (3UL << 0)
#define DAC_MCR_MODE2_INTERNAL (3UL << 16)
#define DAC_MCR_HFSEL_160MHZ (2UL << 14) /* bus clock above 160 MHz */
#define DAC_MCR_INTERNAL (DAC_MCR_MODE1_INTERNAL | DAC_MCR_MODE2_INTERNAL | DAC_MCR_HFSEL_160MHZ)

/* --- Comparators, 24.6 ------------------------------------------------------------------------ */
#define COMP1_CSR (0x40010200U) /* at channel 1 of DAC3, as COMP3 */
#define COMP2_CSR (0x40010204U) /* at channel 2 of DAC3, as COMP4 */
#define COMP3_CSR (0x40010208U)
#define COMP4_CSR (0x4001020CU)
#define COMP_CSR_EN (1UL << 0)
#define COMP_CSR_INMSEL_DAC3 (4UL << 4)
#define COMP_CSR_INPSEL_SHIFT (8U)
#define COMP_CSR_HYST_10MV (1UL << 16)
#define COMP_CSR_VALUE (1UL << 30) /* the output, before the timer's polarity */
#define COMP_CSR_LOCK (1UL << 31)  /* read-only until reset */

/* --- Operational amplifiers, 25.5 ------------------------------------------------------------- */
#define OPAMP1_CSR (0x40010300U)
#define OPAMP2_CSR (0x40010304U)
#define OPAMP3_CSR (0x40010308U)
#define OPAMP_CSR_EN (1UL << 0)
#define OPAMP_CSR_VPSEL_SHIFT (2U)
#define OPAMP_CSR_VMSEL_PGA (2UL << 5)
#define OPAMP_CSR_HIGHSPEED (1UL << 7)
#define OPAMP_CSR_INTEN (1UL << 8)          /* output to the converter only */
#define OPAMP_CSR_PGA_GAIN_SHIFT (14U)      /* 0…5: 2, 4, 8, 16, 32, 64 */
#define OPAMP_CSR_PGA_MINUS_PIN (8UL << 14) /* the divider ends at the minus pin, not at ground */
/* the bits that check.h compares: all but the trimming bits and the calibration output */
#define OPAMP_CSR_COUNTED (0x8007FFFFU)

/* --- Timer 1, 28.6 ---------------------------------------------------------------------------- */
#define TIM1_CR1 (0x40012C00U)
#define TIM_CR1_CEN (1UL << 0)
#define TIM_CR1_DIR (1UL << 4) /* counting down */
#define TIM_CR1_CMS_1 (1UL << 5)
#define TIM_CR1_ARPE (1UL << 7)
#define TIM1_CR2 (0x40012C04U)
#define TIM_CR2_MMS2_UPDATE (2UL << 20)
#define TIM1_SR (0x40012C10U)
#define TIM_SR_UIF (1UL << 0)
#define TIM_SR_BIF (1UL << 7)
#define TIM_SR_SBIF (1UL << 13) /* break by the system: SYSCFG_CFGR2_BREAKS */
#define TIM1_EGR (0x40012C14U)
#define TIM_EGR_UG (1UL << 0)
#define TIM1_CCMR1 (0x40012C18U)
#define TIM1_CCMR2 (0x40012C1CU)
/* PWM mode 1 with preload, first channel of the register */
#define TIM_CCMR_PWM1_PRELOAD (0x68UL)
#define TIM1_CCER (0x40012C20U)
#define TIM1_CNT (0x40012C24U)
#define TIM1_PSC (0x40012C28U)
#define TIM1_ARR (0x40012C2CU)
#define TIM1_RCR (0x40012C30U)
#define TIM_RCR_EACH_PEAK (1U) /* an update at every second end of the ramp */
#define TIM1_CCR1 (0x40012C34U)
#define TIM1_CCR2 (0x40012C38U)
#define TIM1_CCR3 (0x40012C3CU)
#define TIM1_BDTR (0x40012C44U)
#define TIM_BDTR_LOCK_1 (1UL << 8) /* dead time, break and idle levels read-only until reset */
#define TIM_BDTR_OSSI (1UL << 10)  /* outputs driven to their idle level while MOE is 0 */
#define TIM_BDTR_OSSR (1UL << 11)
#define TIM_BDTR_BKE (1UL << 12)
#define TIM_BDTR_BKP (1UL << 13) /* break is active high */
#define TIM_BDTR_MOE (1UL << 15)
/* 6 equal samples, each 4 clocks apart: 141 ns at 170 MHz */
#define TIM_BDTR_BKF_6_OF_4 (6UL << 16)
#define TIM1_AF1 (0x40012C60U)
#define TIM_AF1_BKINE (1UL << 0) /* the break pin */
#define TIM_AF1_BKCMP1E (1UL << 1)
#define TIM_AF1_BKCMP2E (1UL << 2)
#define TIM_AF1_BKCMP3E (1UL << 3)
#define TIM_AF1_BKCMP4E (1UL << 4)
#define TIM_AF1_BKINP (1UL << 9)    /* the break pin is active low */
#define TIM_AF1_BKCMP1P (1UL << 10) /* the output of comparator 1 is active low */
#define TIM_AF1_BKCMP2P (1UL << 11)
#define TIM_AF1_BKCMP3P (1UL << 12)
#define TIM_AF1_BKCMP4P (1UL << 13)

/* --- Timers 2, 3, 4, 29.5 --------------------------------------------------------------------- */
#define TIM2 (0x40000000U)
#define TIM3 (0x40000400U)
#define TIM4 (0x40000800U)
#define TIM_CR1 (0x00U)
#define TIM_CR2 (0x04U)
#define TIM_CR2_TI1S (1UL << 7) /* input 1 is the exclusive or of channels 1 to 3 */
#define TIM_SMCR (0x08U)
#define TIM_SMCR_ENCODER_3 (3U)          /* each edge of both inputs counts */
#define TIM_SMCR_RESET_BY_EDGES (0x44UL) /* each edge of input 1 sets the counter to 0 */
#define TIM_DIER (0x0CU)
#define TIM_DIER_TWO (0x600UL) /* requests to the DMA by captures of channels 1 and 2 */
#define TIM_SR (0x10U)
#define TIM_SR_TWO_LOST \
    (0x600UL) /* a capture of channel 1 or 2 has replaced one that was not read */
#define TIM_EGR (0x14U)
#define TIM_CCMR1 (0x18U)
#define TIM_CCMR2 (0x1CU)
/* two channels capture one input, that of the first or of the second; 8 samples, 188 ns */
#define TIM_CCMR_BOTH_OF_FIRST (0x271UL)
#define TIM_CCMR_BOTH_OF_SECOND (0x7102UL)
/* two inputs, 8 samples, 94 ns */
#define TIM_CCMR_ENCODER (0x5151UL)
#define TIM_CCMR_INDEX (0x51UL) /* one input of that kind */
#define TIM_CCER (0x20U)
#define TIM_CCER_RISE_FALL (0x31UL) /* rising edges at channel 1, falling ones at channel 2 */
#define TIM_CNT (0x24U)
#define TIM_PSC (0x28U)
#define TIM_ARR (0x2CU)
#define TIM_CCR1 (0x34U)
#define TIM_CCR2 (0x38U)
#define TIM_CCR3 (0x3CU)
#define TIM_CCR4 (0x40U)

/* --- Timer 16, 30.6 --------------------------------------------------------------------------- */
#define TIM16_CR1 (0x40014400U)
#define TIM16_SR (0x40014410U)
#define TIM_SR_CC1IF (1UL << 1) /* there is a capture that was not read yet */
#define TIM_SR_CC1OF (1UL << 9) /* another capture came before the last one was read */
#define TIM16_CCMR1 (0x40014418U)
#define TIM_CCMR_CAPTURE_EIGHTH (0xDUL) /* input 1, each eighth edge */
#define TIM16_CCER (0x40014420U)
#define TIM_CCER_CC1E (1UL << 0)
#define TIM16_CCR1 (0x40014434U)
#define TIM16_TISEL (0x4001445CU)
#define TIM16_TISEL_HSE_32 (3U) /* input 1 is the crystal's clock divided by 32 */
#define TIM16_TISEL_LSI (6U)    /* input 1 is the watchdog's oscillator */

/* --- SPI, 39.9 -------------------------------------------------------------------------------- */
#define SPI1 (0x40013000U)
#define SPI2 (0x40003800U)
#define SPI3 (0x40003C00U)
#define SPI_CR1 (0x00U)
/* on; master without a pin for the choice; mode 1: clock low at rest, second edge; 5.3 MHz */
#define SPI_CR1_ENCODER (0x365UL)
#define SPI_CR2 (0x04U)
#define SPI_CR2_16_BITS (0xF00UL)
#define SPI_SR (0x08U)
#define SPI_SR_RXNE (1UL << 0) /* a frame was received and not read */
#define SPI_SR_BSY (1UL << 7)  /* a frame is under way */
#define SPI_DR (0x0CU)

/* --- USART, 37.8 ------------------------------------------------------------------------------ */
#define USART1 (0x40013800U)
#define USART2 (0x40004400U)
#define USART3 (0x40004800U)
#define USART_CR1 (0x00U)
#define USART_CR1_UE (1UL << 0)
#define USART_CR1_RE (1UL << 2)
#define USART_CR1_TE (1UL << 3)
#define USART_CR1_FIFOEN (1UL << 29)
#define USART_BRR (0x0CU)
#define USART_ISR (0x1CU)
#define USART_ISR_FE (1UL << 1) /* of the byte that RDR gives next, as NE */
#define USART_ISR_NE (1UL << 2)
#define USART_ISR_ORE (1UL << 3)
#define USART_ISR_RXFNE (1UL << 5)
#define USART_ISR_TXFNF (1UL << 7)
#define USART_ICR (0x20U)
#define USART_ICR_ERRORS (0xFU) /* parity, framing, noise, overrun */
#define USART_RDR (0x24U)
#define USART_TDR (0x28U)

/* --- Independent watchdog, 42.4 --------------------------------------------------------------- */
#define IWDG_KR (0x40003000U)
#define IWDG_KR_FEED (0xAAAAU)
#define IWDG_KR_UNLOCK (0x5555U)
#define IWDG_KR_START (0xCCCCU)
#define IWDG_PR (0x40003004U) /* 0: the 32 kHz oscillator divided by 4 */
#define IWDG_RLR (0x40003008U)
#define IWDG_RLR_STRICT (7U)  /* 8 counts of 125 µs */
#define IWDG_SR (0x4000300CU) /* zero when the watchdog has taken over all values */

/* --- Debug, 47.6: what stops while a debugger holds the core ---------------------------------- */
#define DBGMCU_APB1FZR1 (0xE0042008U)
#define DBGMCU_IWDG_STOP (1UL << 12)
#define DBGMCU_APB2FZ (0xE0042010U)
#define DBGMCU_TIM1_STOP (1UL << 11) /* TIM1 stops, and its outputs go inactive */

/* --- Core, ARMv7-M B3.2 to B3.4 --------------------------------------------------------------- */
#define SYST_CSR (0xE000E010U)
#define SYST_CSR_RUN (7U) /* enabled, with its exception, from the core's clock */
#define SYST_CSR_COUNT (5U)
#define SYST_CSR_COUNTFLAG (1UL << 16)
#define SYST_RVR (0xE000E014U)
#define SYST_CVR (0xE000E018U)
#define NVIC_ISER0 (0xE000E100U)
#define NVIC_ICER0 (0xE000E180U)
#define NVIC_ICPR0 (0xE000E280U)
#define NVIC_IPR4 (0xE000E410U) /* interrupts 16 to 19 */
#define NVIC_ADC1_2 (18U)
#define NVIC_ADC1_2_PRIORITY (0xFFUL << 16)
#define NVIC_ADC1_2_PRIORITY_1 (0x10UL << 16)
#define SCB_ICSR (0xE000ED04U)
#define SCB_ICSR_VECTACTIVE (0x1FFU) /* number of the exception that is being handled */
#define SCB_VTOR (0xE000ED08U)
#define SCB_VTOR_IMAGE FLASH_IMAGE
#define SCB_SHPR3 (0xE000ED20U) /* SysTick in the top byte */

#endif
