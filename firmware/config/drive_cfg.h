/* SPDX-License-Identifier: MIT */
/*
 * The whole configuration of a drive in per-unit integers. cfg.def has a row for each setting: its
 * range, its quantity and its meaning. config_check.h checks the settings.
 *
 * host_sim/config computes the configuration from motor, board and tuning files in SI units and
 * documents how it computes each number. docs/design.md lists bases and formats. Constant while the
 * drive runs.
 */
#ifndef DRIVE_CFG_H
#define DRIVE_CFG_H

#include "absolute.h"
#include "current_loop.h"
#include "current_reference.h"
#include "derating.h"
#include "encoder.h"
#include "fx.h"
#include "hall.h"
#include "input_cfg.h"
#include "model.h"
#include "modulator.h"
#include "motion_loop.h"
#include "nn_observer.h"
#include "oscillation.h"
#include "phase_compensator.h"
#include "protection.h"
#include "safe_state.h"
#include "startup.h"
#include "supervision.h"
#include "torque_filter.h"
#include "torque_loop.h"
#include "virtual_resistance.h"

#include <stdint.h>

typedef struct {
    uint32_t current_shift;     /* ADC counts to Q15 of I_b (twice full scale): 15 − bits, 0…7 */
    uint32_t bus_shift;         /* ADC counts to Q15 of U_b: 15 − bits, 0…7 */
    uint32_t offset_log2;       /* offset calibration averages 2^offset_log2 samples, 0…12 */
    uint32_t sensor_pole_pairs; /* electrical turns per turn of the angle sensor, 0…50; 0: none */
} sampling_cfg_t;

/* Settings of RUN, used with and without a start-up. */
typedef struct {
    /*
     * share of a change of the speed reference by which ω̂ changes at once, 0…16384; 0: the
     * published observer, without feed-forward. In torque control it is a share of the change of
     * speed that the torque causes
     */
    int32_t acceleration_q14;
} run_cfg_t;

/* The voltage drive: RUN without current regulators. */
typedef struct {
    /*
     * 0: the voltage drive is never used; 1: it is used when a speed is commanded and the
     * conditions of voltage_drive.h hold
     */
    uint32_t enabled;
    pi_cfg_t pi;      /* speed error Q15 of 2·Ω_b in, U in Q15 of U_b out; paper B (28)–(30) */
    step_t speed_min; /* current control below this speed, 0…2^29 */
    uint32_t settle_periods; /* slow periods for which the conditions must hold, 1…10000 */
    phase_compensator_cfg_t compensator;
    /* virtual resistance, damps the natural oscillation of the currents */
    virtual_resistance_cfg_t damping;
} voltage_drive_cfg_t;

/* The line between the drive and a PC. */
typedef struct {
    /*
     * the drive stops after this many ticks without a message, 0…2^30; 0: it does not stop for this
     * reason
     */
    uint32_t timeout_ticks;
} link_cfg_t;

/* The sensor that the board reads; the binding gives no more than its reading, see hal_shaft(). */
typedef enum {
    SENSOR_KIND_NONE = 0, /* with sensor_pole_pairs: the frame of the binding has an angle */
    SENSOR_KIND_HALL,
    SENSOR_KIND_ENCODER,
    SENSOR_KIND_ENCODER_INDEX,
    SENSOR_KIND_ABSOLUTE
} sensor_kind_t;

typedef struct {
    uint32_t kind; /* sensor_kind_t */
    hall_cfg_t hall;
    encoder_cfg_t encoder;
    absolute_cfg_t absolute;
    /*
     * The observer takes over above this speed, 0…2^29; 0: only when the sensor fails. The sensor
     * takes over again below sensor_below.
     */
    step_t observer_above;
    step_t sensor_below; /* 0…observer_above */
} sensor_cfg_t;

/* The parts that a tick of RUN uses come first, see drive_t. */
typedef struct {
    uint32_t speed_shift; /* speed in Q15 of Ω_b = step >> speed_shift, 1…16 */
    sampling_cfg_t sampling;
    nn_observer_cfg_t observer;
    current_loop_cfg_t current_loop;
    modulator_cfg_t modulator;
    uint32_t slow_ticks; /* N: the motion loops run every N-th tick, 6…100 */
    protection_cfg_t protection;
    derating_cfg_t derating;
    speed_loop_cfg_t speed_loop;
    position_loop_cfg_t position_loop;
    /* regulators of an imposed current: soft, so that the windings damp the rotor */
    current_loop_cfg_t hold_loop;
    startup_cfg_t startup;
    current_reference_cfg_t current_reference;
    run_cfg_t run;
    model_cfg_t model;
    supervision_cfg_t supervision;
    oscillation_cfg_t oscillation;
    voltage_drive_cfg_t voltage_drive;
    torque_filter_cfg_t torque_filter;
    torque_loop_cfg_t torque_loop;
    safe_state_cfg_t safe_state;
    link_cfg_t link;
    console_cfg_t console;
    input_cfg_t input;
    sensor_cfg_t sensor;
    uint32_t crc; /* CRC of all fields before it, see config_guard.h; must be the last field */
} drive_cfg_t;

#endif
