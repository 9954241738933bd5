/* SPDX-License-Identifier: MIT */
/*
 * On the PC the plant is the board: power stage, motor and sensors; and a person types at the
 * console, whose answers are printed. The program ends with 0 if the shaft turns at the speed asked
 * for when the time is up, else with 1.
 */
#include "board.h"
#include "plant.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define PERIODS (60000U) /* 3 s */
#define TARGET_RPM (2000)
#define TYPED "speed 2000\rrun\r"
#define RPM_PER_RAD_S (9.549296585513721)
/* a start that failed is at 0, one that goes on is below */
#define TOLERANCE_RPM (0.01 * TARGET_RPM)

volatile board_registers_t board_registers;

/* The real motor and board; what the drive believes of them is in motor.toml and board.toml. */
static const plant_cfg_t REALITY = {
    .motor = {.pole_pairs = 4U,
              .resistance_ohm = 0.4,
              .inductance_d_h = 0.25e-3,
              .inductance_q_h = 0.25e-3,
              .flux_linkage_wb = 0.0065,
              .inertia_kg_m2 = 1.5e-5,
              .viscous_friction_nm_s = 3.0e-6,
              .initial_angle_el_rad = 2.0},
    .inverter = {.pwm_frequency_hz = 20000.0, .timer_counts = 4200U},
    .supply = {.voltage_v = 24.0},
    .sensor = {.adc_bits = 12U, .current_full_scale_a = 10.0, .bus_full_scale_v = 50.0},
};

static plant_t plant;

static void power_on(void)
{
    const char *bad_field;

    if (!plant_init(&plant, &REALITY, &bad_field)) {
        (void)fprintf(stderr, "own_board: REALITY.%s is out of range\n", bad_field);
        exit(EXIT_FAILURE);
    }
}

static void convert(void)
{
    plant_adc_t adc;

    plant_sample(&plant, &adc);
    board_registers.current_a = adc.ia;
    board_registers.current_b = adc.ib;
    board_registers.bus = adc.bus;
}

static void switch_legs(void)
{
    const uint32_t compare[PLANT_LEGS] = {board_registers.compare[0], board_registers.compare[1],
                                          board_registers.compare[2]};

    plant_write_compare(&plant, compare);
    plant_set_gates(&plant, board_registers.gates != 0U);
    plant_step(&plant);
}

/* A byte a period at most, either way: 200 kbaud. */
static void use_console(void)
{
    static const char *typed = TYPED;

    if ((board_registers.received == 0U) && (*typed != '\0')) {
        board_registers.received = BOARD_BYTE | (uint32_t)*typed;
        typed++;
    }
    if (board_registers.sent != 0U) {
        (void)putchar((int)(board_registers.sent & 0xFFU));
        board_registers.sent = 0U;
    }
}

static _Noreturn void finish(void)
{
    plant_view_t view;

    plant_view(&plant, &view);
    const double rpm = view.omega_mech_rad_s * RPM_PER_RAD_S;
    (void)printf("own_board: %d rpm asked for, %.0f rpm turned\n", TARGET_RPM, rpm);
    exit((fabs(rpm - TARGET_RPM) <= TOLERANCE_RPM) ? EXIT_SUCCESS : EXIT_FAILURE);
}

void board_wait(void)
{
    static uint32_t periods;

    if (periods == 0U) {
        power_on();
    }
    if (board_registers.run != 0U) {
        convert();
        board_conversions_complete();
        switch_legs();
    }
    use_console();
    periods++;
    if (periods == PERIODS) {
        finish();
    }
}
