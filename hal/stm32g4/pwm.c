/* SPDX-License-Identifier: MIT */
#include "pwm.h"

#include "settings.h"

/*
 * pwm_start() waits for an update at the bottom, for at most this many updates. Then this many
 * updates have to be at the peak.
 */
#define UPDATES_TO_TURN (4U)

void pwm_init(void)
{
    reg_write(TIM1_RCR, 0U);
    settings_write(SETTINGS_TIMER);
    reg_write(TIM1_BDTR, settings_value(TIM1_BDTR) & ~TIM_BDTR_LOCK_1);
    pwm_write_rest();
    reg_write(TIM1_EGR, TIM_EGR_UG);
    reg_write(TIM1_SR, 0U);
}

void pwm_connect(void)
{
    reg_write(TIM1_BDTR, settings_value(TIM1_BDTR));
    settings_write(SETTINGS_OUTPUTS);
}

/* Waits for the next update event. */
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
 * With a repetition count of 0 the timer updates at both ends of its ramp. A repetition count of 1,
 * written after the update at the bottom, is loaded at the next update, at the peak. From then on
 * the timer updates at every second end, that is, at each peak.
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
