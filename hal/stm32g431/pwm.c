/* SPDX-License-Identifier: MIT */
#include "pwm.h"

#include "settings.h"

/* Looks at the update flag in pwm_start(): more than enough for one of 2 to 100 kHz. */
#define UPDATES_TO_TURN (4U)

void pwm_init(void)
{
    reg_write(TIM1_RCR, 0U);
    settings_write(SETTINGS_TIMER);
    pwm_write_rest();
    reg_write(TIM1_EGR, TIM_EGR_UG);
    reg_write(TIM1_SR, 0U);
}

void pwm_connect(void)
{
    settings_write(SETTINGS_OUTPUTS);
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
 * With a repetition count of 0 there is an update at both ends. Written behind the one at the
 * bottom, a count of 1 is taken over at the one at the peak, and from then on every second end,
 * each peak, counts.
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
    reg_write(TIM1_RCR, TIM_RCR_EACH_PEAK);
    for (uint32_t k = 0U; obeys && (k < UPDATES_TO_TURN); k++) {
        obeys = next_update() && counting_down();
    }
    return obeys;
}
