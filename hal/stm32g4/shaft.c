/* SPDX-License-Identifier: MIT */
#include "shaft.h"

#include "clock.h"
#include "settings.h"

#include <stdbool.h>

#define AGE_SHIFT (16U)  /* Q24 to Q8 */
#define FRAMES_KEPT (2U) /* by the SPI, received and not read */

static bool selected; /* the absolute encoder waits for the clock */

static void select_encoder(void)
{
    selected = true;
    reg_write(HAL_SPI_CS_PORT + GPIO_BSRR, 1UL << (HAL_SPI_CS_BIT + GPIO_BSRR_BR0_SHIFT));
}

void shaft_start(void)
{
    if ((BOARD.shaft == BOARD_SHAFT_ABSOLUTE) && selected) {
        selected = false;
        reg_write(HAL_SPI + SPI_DR, SHAFT_ONES);
    }
}

/* The answer to the very first frame is no angle. */
static void ask_first(void)
{
    select_encoder();
    clock_wait_us(1U);
    shaft_start();
    (void)reg_wait(HAL_SPI + SPI_SR, SPI_SR_RXNE | SPI_SR_BSY, SPI_SR_RXNE);
    (void)reg_read(HAL_SPI + SPI_DR);
    shaft_sample();
}

void shaft_init(void)
{
    settings_write(SETTINGS_SHAFT);
    if (BOARD.shaft == BOARD_SHAFT_ABSOLUTE) {
        ask_first();
    }
}

static uint32_t level(uint32_t port, uint32_t bit)
{
    return (reg_read(port + GPIO_IDR) >> bit) & 1U;
}

/* Read after the levels: an edge between both counts in the next tick, with its age then. */
static uint16_t read_age(void)
{
    uint32_t age_q8 = 0U;

    if (BOARD.hall_age_q24 != 0U) {
        age_q8 = ((reg_read(HAL_SHAFT_TIMER + TIM_CNT) * BOARD.hall_age_q24) >> AGE_SHIFT) + 1U;
    }
    return (uint16_t)age_q8;
}

static hal_shaft_t read_hall(void)
{
    const uint32_t first = level(HAL_HALL_1_PORT, HAL_HALL_1_BIT);
    const uint32_t second = level(HAL_HALL_2_PORT, HAL_HALL_2_BIT);
    const uint32_t third = level(HAL_HALL_3_PORT, HAL_HALL_3_BIT);

    return (hal_shaft_t){.reading = (uint16_t)(first | (second << 1U) | (third << 2U)),
                         .age_q8 = read_age()};
}

/* Reading the capture clears its flag. */
static hal_shaft_t read_encoder(void)
{
    hal_shaft_t shaft = {.reading = (uint16_t)reg_read(HAL_SHAFT_TIMER + TIM_CNT)};

    if (BOARD.has_index) {
        shaft.indexed = reg_any(HAL_SHAFT_TIMER + TIM_SR, HAL_INDEX_SEEN);
        shaft.index = (uint16_t)reg_read(HAL_SHAFT_TIMER + HAL_INDEX_AT);
    }
    return shaft;
}

/* The newest frame counts. Without its select the encoder has not sampled, so nothing is started.
 */
static hal_shaft_t read_absolute(void)
{
    hal_shaft_t shaft = {.reading = SHAFT_ONES};

    for (uint32_t k = 0U; (k < FRAMES_KEPT) && reg_any(HAL_SPI + SPI_SR, SPI_SR_RXNE); k++) {
        shaft.reading = (uint16_t)reg_read(HAL_SPI + SPI_DR);
    }
    if (level(HAL_SPI_CS_PORT, HAL_SPI_CS_BIT) != 0U) {
        select_encoder();
    }
    return shaft;
}

hal_shaft_t shaft_read(void)
{
    hal_shaft_t shaft = {0};

    if (BOARD.shaft == BOARD_SHAFT_HALL) {
        shaft = read_hall();
    } else if (BOARD.shaft == BOARD_SHAFT_ENCODER) {
        shaft = read_encoder();
    } else if (BOARD.shaft == BOARD_SHAFT_ABSOLUTE) {
        shaft = read_absolute();
    } else {
        /* there is none */
    }
    return shaft;
}
