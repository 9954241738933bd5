/* SPDX-License-Identifier: MIT */
#include "trip.h"

#include "board.h"
#include "clock.h"
#include "reg.h"
#include "stm32g431.h"

/* Data sheet, tables 70 and 73: wake-up of this DAC at most 3.5 µs, start-up of a comparator at most 5 µs. */
#define SETTLING_US (15U)

#define READY (DAC_SR_DAC1RDY | DAC_SR_DAC2RDY)

/* The converters whose outputs the comparators compare with. */
static bool start_thresholds(void)
{
    reg_write(DAC3_MCR, DAC_MCR_MODE1_INTERNAL | DAC_MCR_MODE2_INTERNAL | DAC_MCR_HFSEL_160MHZ);
    reg_write(DAC3_DHR12R1, BOARD.trip_count);
    reg_write(DAC3_DHR12R2, BOARD.trip_count);
    reg_write(DAC3_CR, DAC_CR_EN1 | DAC_CR_EN2);
    return reg_wait(DAC3_SR, READY, READY);
}

/* Locked, they stay as they are until the next reset. */
static void start_comparators(void)
{
    /* 10 mV of hysteresis: the edges of the PWM do not make the output chatter. */
    const uint32_t comparator = COMP_CSR_INMSEL_DAC3 | COMP_CSR_HYST_10MV | COMP_CSR_EN;

    clock_wait_us(SETTLING_US);
    reg_write(COMP1_CSR, comparator);
    reg_write(COMP2_CSR, comparator);
    reg_write(COMP4_CSR, comparator);
    clock_wait_us(SETTLING_US);
    reg_write(COMP1_CSR, comparator | COMP_CSR_LOCK);
    reg_write(COMP2_CSR, comparator | COMP_CSR_LOCK);
    reg_write(COMP4_CSR, comparator | COMP_CSR_LOCK);
}

bool trip_init(void)
{
    const bool are_ready = start_thresholds();

    if (are_ready) {
        start_comparators();
    }
    return are_ready;
}
