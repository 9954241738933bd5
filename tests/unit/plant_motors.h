/* SPDX-License-Identifier: MIT */
/* Motors of the plant's tests. */
#ifndef PLANT_MOTORS_H
#define PLANT_MOTORS_H

#include "motor.h"

static const plant_motor_cfg_t ROUND_ROTOR = {
    .pole_pairs = 2,
    .resistance_ohm = 2.125,
    .inductance_d_h = 0.0116,
    .inductance_q_h = 0.0116,
    .flux_linkage_wb = 0.387,
    .inertia_kg_m2 = 0.003,
    .viscous_friction_nm_s = 0.001,
};

static const plant_motor_cfg_t SALIENT = {
    .pole_pairs = 2,
    .resistance_ohm = 0.405,
    .inductance_d_h = 0.0135,
    .inductance_q_h = 0.0235,
    .flux_linkage_wb = 0.375,
    .inertia_kg_m2 = 0.011,
};

/* 7 pole pairs, time constant 0.4 ms, 12 000 rpm. */
static const plant_motor_cfg_t DRONE = {
    .pole_pairs = 7,
    .resistance_ohm = 0.05,
    .inductance_d_h = 20.0e-6,
    .inductance_q_h = 26.0e-6,
    .flux_linkage_wb = 0.9e-3,
    .inertia_kg_m2 = 2.0e-6,
    .viscous_friction_nm_s = 1.0e-6,
    .initial_speed_mech_rad_s = 1256.0,
};

/* Holds the speed in a test of the currents: one second of 100 N m changes it by 1e-7 rad/s. */
#define INERTIA_OF_A_WALL 1.0e9

/* No resistance, no magnet, too heavy to turn: its current is the integral of the voltage. */
static inline plant_motor_cfg_t coil(double inductance_h)
{
    return (plant_motor_cfg_t){
        .pole_pairs = 1,
        .inductance_d_h = inductance_h,
        .inductance_q_h = inductance_h,
        .inertia_kg_m2 = INERTIA_OF_A_WALL,
    };
}

#endif
