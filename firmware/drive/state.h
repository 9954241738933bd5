/* SPDX-License-Identifier: MIT */
/*
 * The whole state of a drive, its states and the events that change them.
 *
 * drive_t is a plain value: a copy of it is a snapshot. state.def holds the range of each field.
 * Two fields describe the rotor: `position` (θ̂) and `observer.speed` (ω̂). estimate.h says which
 * source they come from. The currents are controlled in a frame (frame.h): in RUN the frame of this
 * rotor, otherwise the frame of `vector`.
 */
#ifndef STATE_H
#define STATE_H

#include "align.h"
#include "angle_sensor.h"
#include "config_guard.h"
#include "derating.h"
#include "drive_cfg.h"
#include "flying_start.h"
#include "io.h"
#include "model.h"
#include "oscillation.h"
#include "phase_compensator.h"
#include "probe.h"
#include "protection.h"
#include "rotor_position.h"
#include "safe_state.h"
#include "supervision.h"
#include "torque_filter.h"
#include "torque_loop.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * The upper four bits are the number of the state, the lower four its check bits: the extended code
 * of Hamming. Any two codes differ in four bits or more, so up to three bits that flip by
 * themselves never turn one state into another. The codes ascend in the order of the states. Each
 * code fits into a byte, which a comparison instruction can hold as its constant.
 */
typedef enum {
    DRIVE_STATE_INIT = 0x00,
    DRIVE_STATE_OFFSET_CAL = 0x17,
    DRIVE_STATE_READY = 0x2B,
    DRIVE_STATE_FLYING_START = 0x3C, /* does the rotor turn already? */
    DRIVE_STATE_PROBE = 0x4D,        /* measures an unknown motor with an imposed current */
    DRIVE_STATE_ALIGN = 0x5A,        /* pulls the rotor to a known angle, measures R and L */
    DRIVE_STATE_HOLD = 0x66,         /* an imposed current holds the rotor at standstill */
    DRIVE_STATE_IF_RAMP = 0x71,      /* an imposed current turns the rotor: open-loop I/f */
    DRIVE_STATE_HANDOVER = 0x8E,     /* as IF_RAMP; the residual of the observer is checked too */
    DRIVE_STATE_RUN = 0x99,          /* closed loop on the angle of the observer or the sensor */
    DRIVE_STATE_FAULT = 0xA5
} drive_state_t;

#define DRIVE_STATES (11U)

/* Events that the parts of the drive return. transitions.c says which state follows. */
typedef enum {
    DRIVE_EVENT_NONE = 0,
    DRIVE_EVENT_CALIBRATE,  /* power has come on, or the user has acknowledged a fault */
    DRIVE_EVENT_CALIBRATED, /* the zeros of the current sensors are known */
    DRIVE_EVENT_STOP,       /* the user no longer asks to run */
    DRIVE_EVENT_SEARCH,     /* a start begins, the first or one more */
    DRIVE_EVENT_PROBE,      /* the user asks to measure the motor */
    DRIVE_EVENT_STANDS,  /* an alignment begins: the rotor is slow, or R and L are not measured */
    DRIVE_EVENT_HELD,    /* the imposed vector is at rest */
    DRIVE_EVENT_SLOW,    /* RUN is so slow that a current has to be imposed */
    DRIVE_EVENT_DRAGGED, /* the imposed vector turns, more slowly than handover_speed */
    DRIVE_EVENT_FAST,    /* the imposed vector has reached handover_speed */
    DRIVE_EVENT_TRACKED, /* the angle is known, or taken to be 0 where nothing can find it */
    DRIVE_EVENT_FAULT,   /* a fault_t holds its value and limit */
    DRIVE_EVENTS         /* number of events, not an event */
} drive_event_t;

/* Sums that OFFSET_CAL forms to measure the zeros of the current sensors. */
typedef struct {
    int32_t sum_a; /* sum of the raw counts of sensor a, 0…2^28; sum_b: of sensor b */
    int32_t sum_b;
    uint32_t samples;
    uint32_t before_a; /* raw counts of the last sample */
    uint32_t before_b;
    int32_t noise; /* sum of |change from sample to sample| of both sensors, counts, 0…2^28 */
} calibration_t;

/*
 * Values at the moment of a fault, kept for the diagnosis: they tell its possible causes apart.
 * After the fault the variables themselves change.
 */
typedef struct {
    drive_state_t state;
    uint32_t limits; /* DERATING_… in force */
    step_t speed;    /* drive_speed() */
    int32_t torque;  /* i_q*, Q15 of I_b */
    int32_t phase_a; /* measured, Q15 of I_b */
    int32_t phase_b;
    int32_t motoring; /* limit of the motoring current, Q15 of I_b */
} fault_scene_t;

/* The values with which state_guard.c compares the state. */
typedef struct {
    uint32_t at;       /* part that is checked next */
    uint32_t measured; /* check word of offset_a, offset_b and identified */
    /* state of the drive at the last look; INIT: there are no values to compare with */
    drive_state_t state;
    step_t reference; /* speed reference at the last look, in RUN */
    int32_t flux_q30; /* φ̂ at the last look, in RUN */
    /* integrals of the current control at the last look, with a vector at rest */
    int32_t integral_d_q26;
    int32_t integral_q_q26;
    angle_t angle;    /* angle of the vector at the last look, at rest */
    int32_t heat_q24; /* copy of derating.heat_q24 after its last intended change */
    uint32_t config;  /* check word of settings that act at once */
    uint32_t turns;   /* whole turns of the rotor at the last look, in RUN */
    angle_t turned;   /* angle θ̂ at the last look, in RUN */
    step_t speed;     /* ω̂ at the last look, in RUN */
} state_guard_t;

/* voltage_drive.c: RUN without current regulators, see voltage_drive.h. A start begins it anew. */
typedef struct {
    bool active;
    /* slow periods in a row in which the conditions for the voltage drive held */
    uint32_t calm_periods;
    uint32_t end_periods; /* slow periods in a row with lead or current at their lower limit */
    pi_t pi;              /* speed PI */
    /* U, Q15 of U_b, + forwards; may exceed the voltage limit when the bus has fallen since */
    int32_t magnitude;
    phase_compensator_t compensator;
    /* the virtual resistance; it also holds the mean of the current in the frame of θ̂ */
    virtual_resistance_t damping;
} voltage_drive_t;

/*
 * The groups of the state. Each names the file whose functions begin it anew and write it; the
 * others read it.
 */

/* calibration.c: the current sensors. A calibration begins them anew. */
typedef struct {
    int32_t offset_a; /* sensor zero, Q15 of I_b, nominal 16384 */
    int32_t offset_b;
    calibration_t sums;
} sensors_t;

/* motor.c: what is known of the motor. It is kept from run to run. */
typedef struct {
    model_t model;   /* motor model in force */
    bool identified; /* R and L of the model were measured */
} motor_t;

/* Where θ̂ and ω̂ come from. */
typedef enum {
    ESTIMATE_OBSERVER = 0, /* the network, or below it the imposed vector */
    ESTIMATE_SENSOR
} estimate_source_t;

/* estimate.c: what is known of the rotor. A start begins it anew, all but the sensor. */
typedef struct {
    rotor_position_t position; /* θ̂ and whole turns, (23) */
    nn_observer_t observer;    /* ω̂, (22) */
    /*
     * current that the model does not explain: |e'_q|, or |e'_d| while the vector holds the rotor
     * at rest; filtered over slow periods, Q15 of I_b
     */
    int32_t residual;
    angle_sensor_t angle_sensor;
    uint8_t source; /* estimate_source_t */
    bool followed;  /* the sensor tells an angle, and angle_sensor follows it */
    bool aligned;   /* the electrical angle of the sensor's zero is known */
    bool failed;    /* the sensor has failed in this run, so it is not used any more */
} rotor_t;

/* vector.c: the current vector that is imposed below RUN. A start begins it anew. */
typedef struct {
    rotor_position_t position; /* angle and whole turns of the vector */
    step_t step;               /* turn of the vector per tick */
    dq_t current_mean;         /* mean of the measured current over some 32 ticks, in its frame */
} current_vector_t;

/* frame.c: the current control. A start begins it anew. */
typedef struct {
    ab_t ratio_acting; /* demand / bus, Q15, that has acted from the last instant to this one */
    ab_t ratio_next;   /* demand / bus, Q15, of the last tick: it acts from this instant on */
    current_loop_t current_loop;
    dq_t current_ref; /* i_d*, i_q* in the frame of the current control, Q15 of I_b */
    dq_t voltage;     /* voltage demanded last, in the same frame, Q15 of U_b */
} control_t;

/*
 * run.c: the motion loops. A start begins them anew, all but the learned inertia, the bandwidth,
 * the zero of position targets, and with a sensor the mode of position control.
 */
typedef struct {
    position_loop_t position_loop;
    step_t speed_reference;
    speed_loop_t speed_loop;
    uint8_t mode;                  /* drive_mode_t in which the motion loops run */
    torque_range_t torque_range;   /* allowed range of i_q* in this slow period */
    weakening_t weakening;         /* field weakening, in RUN with current control */
    torque_filter_t torque_filter; /* filter of i_q*, in RUN with current control */
    torque_loop_t torque_loop;     /* torque control in RUN; its bridge is used in every mode */
} motion_t;

/*
 * open_loop.c: the start of a motor without a sensor. Each attempt begins it anew, all but the
 * number of attempts.
 */
typedef struct {
    flying_start_t flying_start;
    align_t align;
    /* slow periods with a residual above residual_lost, minus those without; at least 0 */
    uint32_t lost_periods;
    uint32_t handover_periods; /* slow periods in HANDOVER */
    uint32_t attempts;         /* failed starts since READY, or since RUN has lasted long enough */
    /* slow periods of RUN since a start failed; counted while attempts > 0 */
    uint32_t held_periods;
} start_t;

/* monitor.c: counts and means of the checks. They begin anew when the user asks to run. */
typedef struct {
    supervision_t supervision;
    oscillation_t oscillation;
} watch_t;

/*
 * Members that every tick uses come first: a Cortex-M0+ reaches the first 128 bytes in one
 * instruction. Where a member's type is of a module, that module writes it.
 */
typedef struct {
    const drive_cfg_t *cfg; /* adopt.c */
    drive_state_t state;    /* life.c */
    /*
     * tick.c: ticks to the end of the slow period, N…1. It is a byte, so that a flipped bit cannot
     * make the period very long
     */
    uint8_t slow_count;
    protection_limits_t limits; /* life.c: limits in force in this state */
    int32_t bus;   /* tick.c: bus voltage of the last tick that has ended, Q15 of U_b */
    uint32_t tick; /* tick.c: ticks since drive_init(), wraps */
    modulator_t modulator;
    control_t control;
    rotor_t rotor;
    sensors_t sensors;
    voltage_drive_t voltage_drive;
    motion_t motion;
    motor_t motor;
    current_vector_t vector;
    start_t start;
    probe_t probe;
    derating_t derating;
    watch_t watch;
    safe_state_t safe_state; /* state of the gates while nothing is driven */
    config_guard_t guard;
    state_guard_t state_guard;
    fault_t fault;       /* life.c: the last fault */
    fault_scene_t scene; /* life.c: scene of the last fault */
} drive_t;

/* FLYING_START to RUN: current may flow. */
static inline bool drive_is_driving(drive_state_t state)
{
    return (state > DRIVE_STATE_READY) && (state < DRIVE_STATE_FAULT);
}

/* PROBE to RUN: the current is controlled. */
static inline bool drive_is_controlled(drive_state_t state)
{
    return (state > DRIVE_STATE_FLYING_START) && (state < DRIVE_STATE_FAULT);
}

/* ALIGN to HANDOVER: the drive imposes a current vector. */
static inline bool drive_is_imposed(drive_state_t state)
{
    return (state > DRIVE_STATE_PROBE) && (state < DRIVE_STATE_RUN);
}

/* Whether the vector rests and holds a rotor that has been aligned or stopped. */
static inline bool drive_is_held(const drive_t *drive)
{
    return (drive->state == DRIVE_STATE_HOLD) && (drive->vector.step == 0);
}

static inline bool drive_has_sensor(const drive_t *drive)
{
    return drive->cfg->sampling.sensor_pole_pairs != 0U;
}

/* Whether θ̂ and ω̂ are those of the sensor. A bit that flips makes no sensor. */
static inline bool drive_is_sensed(const drive_t *drive)
{
    return (drive->rotor.source != (uint8_t)ESTIMATE_OBSERVER) && drive_has_sensor(drive);
}

/* Whether a start imposes a current, and RUN hands back to it at low speed without a sensor. */
static inline bool drive_may_impose(const drive_t *drive)
{
    return (drive->cfg->startup.current_hold != 0) && !drive_is_sensed(drive);
}

/*
 * Whether θ̂ and ω̂ are values of this tick. With open gates only a sensor knows the rotor; without
 * one the fields keep the values that they had when driving ended. The voltage is a value of this
 * tick only when drive_is_controlled() is true.
 */
static inline bool drive_knows_rotor(const drive_t *drive)
{
    return drive_is_sensed(drive) || drive_is_controlled(drive->state);
}

/*
 * Speed in steps per tick. In RUN, and with a sensor in every state, it is the speed ω̂ of the
 * rotor; otherwise the speed of the imposed vector. It is a value of this tick only when
 * drive_knows_rotor() is true.
 */
static inline step_t drive_speed(const drive_t *drive)
{
    const bool known = (drive->state == DRIVE_STATE_RUN) || drive_is_sensed(drive);

    return known ? drive->rotor.observer.speed : drive->vector.step;
}

/* Position of the frame in which the currents are controlled: of the rotor in RUN, else the vector.
 */
static inline const rotor_position_t *drive_frame_position(const drive_t *drive)
{
    return (drive->state == DRIVE_STATE_RUN) ? &drive->rotor.position : &drive->vector.position;
}

/* Position estimate in Q32 electrical turns. */
static inline int64_t drive_position_q32(const drive_t *drive)
{
    return drive->rotor.position.turns_q32;
}

/* Position estimate relative to the zero of position targets, Q32 electrical turns. */
static inline int64_t drive_position_from_zero_q32(const drive_t *drive)
{
    const uint64_t zero = fx_unsigned64(drive->motion.position_loop.zero_q32);

    return fx_signed64(fx_unsigned64(drive->rotor.position.turns_q32) - zero);
}

/*
 * i_d, i_q that the motor should have now: the reference of the current control. Under the voltage
 * drive, which has none, it is the mean of the measured current.
 */
static inline dq_t drive_current_in_force(const drive_t *drive)
{
    return drive->voltage_drive.active ? virtual_resistance_mean(&drive->voltage_drive.damping)
                                       : drive->control.current_ref;
}

/*
 * Whether the drive is in torque control, and only the commanded torque or an end of the window of
 * speeds decides i_q*.
 */
static inline bool drive_torque_is_free(const drive_t *drive)
{
    return (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) && !drive->motion.torque_loop.bound;
}

/* Returns ψ, the flux with which i_q* makes torque. */
static inline int32_t drive_flux(const drive_t *drive)
{
    return current_reference_flux(&drive->motor.model.run_loop, drive_current_in_force(drive).d);
}

/* A speed in Q15 of Ω_b, saturated, rounded down. */
static inline int32_t drive_speed_q15(const drive_t *drive, step_t speed)
{
    return fx_sat16(fx_asr(speed, drive->cfg->speed_shift));
}

#endif
