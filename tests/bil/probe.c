/* SPDX-License-Identifier: MIT */
/*
 * An image of the binding alone, without a drive: it writes down what the inputs and the sensor of
 * the shaft measure, for test_inputs.py and test_shaft.py. The gates stay open.
 */
#include "board.h"
#include "clock.h"
#include "cpu.h"
#include "guard.h"
#include "hal_g4.h"
#include "pins.h"
#include "stm32g4.h"
#include "uart.h"
#include "vectors.h"

#include <stddef.h>

#define PULSES_KEPT (512U)

/* The tests read it by its name. */
typedef struct {
    uint32_t ticks;
    uint32_t readings; /* the reading of the sensor, its index behind it */
    uint32_t indexes;
    uint32_t inputs; /* throttle, button, conversions from bit 24 on */
    uint32_t temperature;
    uint32_t now;
    uint32_t paused; /* not 0: the background fetches no pulses */
    uint32_t pulses; /* number of those that were fetched */
    hal_pulse_t kept[PULSES_KEPT];
    const char *why; /* the start has failed */
} probe_t;

volatile probe_t probe;

static hal_t hardware;

void board_safe_state(void)
{
    reg_clear(TIM1_BDTR, TIM_BDTR_MOE);
}

void ADC1_2_IRQHandler(void)
{
    const drive_out_t open = {.gate_enable = false};
    drive_in_t in = {0};
    hal_shaft_t shaft;

    hal_sample(&hardware, &in);
    shaft = hal_shaft(&hardware);
    /* a board tells one of both, or none */
    probe.readings = shaft.reading | ((uint32_t)(shaft.index | shaft.age_q8) << 16U);
    probe.indexes += shaft.indexed ? 1U : 0U;
    hal_apply(&hardware, &open);
    probe.temperature = in.adc_temperature;
    probe.ticks++;
}

void NMI_Handler(void)
{
    board_safe_state();
}

void SysTick_Handler(void)
{
    hal_g4_tick_lost(&hardware);
}

static void fetch(void)
{
    hal_inputs_t inputs = hal_inputs(&hardware);
    hal_pulse_t pulse;

    while ((probe.paused == 0U) && hal_pulse(&hardware, &pulse)) {
        probe.kept[probe.pulses % PULSES_KEPT].start = pulse.start;
        probe.kept[probe.pulses % PULSES_KEPT].width = pulse.width;
        probe.pulses++;
    }
    probe.inputs =
        inputs.throttle | (inputs.button ? 0x10000U : 0U) | ((uint32_t)inputs.conversions << 24U);
    probe.now = hal_pulse_now(&hardware);
}

int main(void)
{
    reg_write(SCB_VTOR, SCB_VTOR_IMAGE);
    clock_peripherals();
    pins_init();
    uart_init();
    probe.why = clock_is_up() ? hal_g4_init(&hardware) : "clock";
    if (probe.why == NULL) {
        probe.why = hal_g4_start();
    }
    for (;;) {
        guard_feed();
        fetch();
        cpu_wait();
    }
    return 0;
}
