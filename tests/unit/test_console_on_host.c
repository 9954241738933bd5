/* SPDX-License-Identifier: MIT */
/*
 * The whole console on another binding: the PC's, with the plant and a serial line behind it. A
 * person types, the motor turns, and a fault is told.
 */
#include "example_cfg.h"
#include "hal_host.h"
#include "link.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SAID_MAX (4096U)
#define TICKS_PER_S (10000U)
#define TICK_PS (100000000U)
#define BAUD (200000U)
#define MIDDLE (2048U)
#define RPM_PER_RAD_S (9.549296585513721)
#define TOLERANCE_RPM (10.0) /* 1 % of what is asked for: settled, and not on its way */

/* Motor A of example_cfg.h at 310 V. */
static const plant_cfg_t REALITY = {
    .motor = {.pole_pairs = 2U,
              .resistance_ohm = 2.125,
              .inductance_d_h = 0.0116,
              .inductance_q_h = 0.0116,
              .flux_linkage_wb = 0.387,
              .inertia_kg_m2 = 0.003},
    .inverter = {.pwm_frequency_hz = TICKS_PER_S, .timer_counts = 8500U},
    .supply = {.voltage_v = 310.0},
    .sensor = {.adc_bits = 12U, .current_full_scale_a = 20.0, .bus_full_scale_v = 450.0},
};

static const about_t ABOUT = {
    .name = "motor A on a PC",
    .rotation = {.pole_pairs = 2U, .tick_ps = 100000000U},
    .speed_max_rpm = 2000,
    .current_zero_count = MIDDLE,
    .current_full_scale_ua = 20000000U,
    .bus_full_scale_uv = 450000000U,
    .temperature = {.points = 2U, .at = {{0, -50000}, {4096, 150000}}},
};

static hal_host_line_t line;
static char said[SAID_MAX];
static plant_t plant;
static drive_cfg_t cfg;
static hal_t hardware;
static app_t app;
static live_config_t live;
static link_t serial;

static void listen(void)
{
    uint8_t byte = 0U;
    size_t length = 0U;

    while ((length < (SAID_MAX - 1U)) && hal_host_line_read(&line, &byte)) {
        said[length] = (char)byte;
        length++;
    }
    said[length] = '\0';
}

/* What is said while so many ticks pass. */
static const char *after(uint32_t ticks, const char *typed)
{
    for (const char *at = typed; *at != '\0'; at++) {
        TEST_ASSERT_TRUE(hal_host_line_write(&line, (uint8_t)*at));
    }
    for (uint32_t k = 0U; k < ticks; k++) {
        control_isr(&app);
        link_step(&serial);
        hal_host_step(&hardware);
    }
    listen();
    return said;
}

static void assert_has(const char *expected, const char *text)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(text, expected), text);
}

static double turned_rpm(void)
{
    plant_view_t view;

    plant_view(&plant, &view);
    return view.omega_mech_rad_s * RPM_PER_RAD_S;
}

void setUp(void)
{
    const char *bad = NULL;

    cfg = example_drive_cfg();
    memset(&app, 0, sizeof app);
    TEST_ASSERT_TRUE_MESSAGE(plant_init(&plant, &REALITY, &bad), bad);
    hal_host_init(&hardware, &plant);
    hal_host_line_init(&line, BAUD, TICK_PS);
    hardware.line = &line;
    live_config_init(&live, &app, &hardware, &ABOUT, &cfg);
    link_init(&serial, &live);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &live.in_force->cfg));
    assert_has("READY, speed unknown, asked 0 rpm, ", after(TICKS_PER_S / 10U, ""));
}

TEST(test_the_motor_turns_as_fast_as_it_is_told_and_the_status_says_so)
{
    assert_has("ok\r\nok\r\n", after(2U * TICKS_PER_S, "speed 1000\rrun\r"));
    (void)after(TICKS_PER_S / 10U, "status\r");
    TEST_ASSERT_EQUAL_STRING_LEN("RUN, speed ", said, 11U);
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE_RPM, 1000.0, strtod(&said[11], NULL));
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE_RPM, 1000.0, turned_rpm());
    assert_has(" of 1000 rpm, ", said);
}

TEST(test_it_is_stopped_and_coasts)
{
    (void)after(TICKS_PER_S, "speed -500\rrun\r");
    TEST_ASSERT_TRUE(turned_rpm() < -400.0);
    assert_has("ok\r\nREADY, speed ", after(TICKS_PER_S / 10U, "stop\r"));
    TEST_ASSERT_FALSE(app.out.gate_enable);
}

TEST(test_a_fault_is_told_and_cleared_and_the_motor_runs_again)
{
    (void)after(TICKS_PER_S, "speed 500\rrun\r");
    hardware.faults.broken = true;
    assert_has("FAULT by BREAK ", after(TICKS_PER_S / 10U, ""));
    hardware.faults.broken = false;
    assert_has("error: a fault is latched; clear it first\r\n", after(TICKS_PER_S / 10U, "run\r"));
    assert_has("ok\r\n", after(2U * TICKS_PER_S, "stop\rclear\r"));
    assert_has("RUN, speed ", after(TICKS_PER_S, "run\r"));
}
