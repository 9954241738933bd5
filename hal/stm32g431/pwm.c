/* SPDX-License-Identifier: MIT */
#include "pwm.h"

#include "codes.h"

/* Looks at the update flag in pwm_start(): more than enough for one of 2 to 100 kHz. */
#define UPDATES_TO_TURN (4U)

/*
 * The filter. At turn-on the gate's charge and the diode's reverse recovery go through the shunt and make a spike of some
 * tens of ns on its inductance; 47 ns would let it through, 141 ns does not. A real short rises on for as long: with
 * 1 µH at 24 V by 3.4 A.
 */
static void set_break(void)
{
    const uint32_t sources = TIM_AF1_BKCMP1E | TIM_AF1_BKCMP2E | TIM_AF1_BKCMP4E;
    const uint32_t inverted = TIM_AF1_BKCMP1P | TIM_AF1_BKCMP2P | TIM_AF1_BKCMP4P;

    reg_set(SYSCFG_CFGR2, SYSCFG_CFGR2_CLL);
    reg_write(TIM1_AF1, BOARD.trip_below ? (sources | inverted) : sources);
    reg_write(TIM1_BDTR, codes_dead_time(BOARD.dead_time_ticks) | TIM_BDTR_OSSI | TIM_BDTR_OSSR |
                             TIM_BDTR_BKE | TIM_BDTR_BKP | TIM_BDTR_BKF_6_OF_4 | TIM_BDTR_LOCK_1);
}

void pwm_init(void)
{
    const uint32_t two_channels = TIM_CCMR_PWM1_PRELOAD | (TIM_CCMR_PWM1_PRELOAD << 8);

    reg_write(TIM1_CR1, TIM_CR1_CMS_1 | TIM_CR1_ARPE);
    reg_write(TIM1_CR2, TIM_CR2_MMS2_UPDATE);
    reg_write(TIM1_CCMR1, two_channels);
    reg_write(TIM1_CCMR2, TIM_CCMR_PWM1_PRELOAD);
    reg_write(TIM1_CCER,
              TIM_CCER_CH1_AND_N | (TIM_CCER_CH1_AND_N << 4) | (TIM_CCER_CH1_AND_N << 8));
    reg_write(TIM1_PSC, 0U);
    reg_write(TIM1_ARR, BOARD.timer_counts);
    reg_write(TIM1_RCR, 0U);
    pwm_write_rest();
    set_break();
    reg_write(TIM1_EGR, TIM_EGR_UG);
    reg_write(TIM1_SR, 0U);
}

/* The next update event. */
static bool next_update(void)
{
    reg_write(TIM1_SR, ~TIM_SR_UIF);
    return reg_wait(TIM1_SR, TIM_SR_UIF, TIM_SR_UIF);
}

static bool counting_down(void)
{
    return reg_any(TIM1_CR1, TIM_CR1_DIR);
}

/*
 * With a repetition count of 0 there is an update at both ends. Written behind the one at the bottom,
 * a count of 1 is taken over at the one at the peak, and from then on every second end, each peak, counts.
 */
bool pwm_start(void)
{
    bool obeys = true;
    uint32_t left = UPDATES_TO_TURN;

    reg_set(TIM1_CR1, TIM_CR1_CEN);
    do {
        obeys = next_update();
        left--;
    } while (obeys && counting_down() && (left > 0U));
    reg_write(TIM1_RCR, 1U);
    for (uint32_t k = 0U; obeys && (k < UPDATES_TO_TURN); k++) {
        obeys = next_update() && counting_down();
    }
    return obeys;
}
