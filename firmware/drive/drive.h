/* SPDX-License-Identifier: MIT */
/*
 * The drive: one pure control step from an input frame to an output frame.
 *
 *     drive_step(&drive, &in, &out)
 *
 * reads its state and one frame of raw measurements and command. It writes its state and one frame
 * of compare values. It has no clock, no hardware, no globals and no allocation. The same inputs give the
 * same outputs on every machine. drive_t is a plain value: to copy it is to take a snapshot.
 *
 * Timing. The frame of tick k is sampled at t_k, the start of PWM period k. Its compare values act
 * from t_k+1 to t_k+2; gate_enable acts at once.
 *
 * States
 *     INIT → OFFSET_CAL → READY → CATCH_SPIN → ALIGN → HOLD ⇄ IF_RAMP → HANDOVER → RUN → HOLD
 *     CATCH_SPIN → RUN when the rotor turns already; HANDOVER → CATCH_SPIN when the hand-over fails
 *     any but INIT, OFFSET_CAL, FAULT → READY without DRIVE_REQUEST_RUN
 *     any → FAULT, latched, gates off in the same tick; FAULT → OFFSET_CAL on DRIVE_REQUEST_CLEAR without
 *     DRIVE_REQUEST_RUN
 * The frame is the angle in which the currents are controlled. In RUN it is the angle of the observer. In ALIGN, HOLD,
 * IF_RAMP and HANDOVER the drive sets it and imposes a current vector on it. When the configuration has no start-up
 * (startup.current_hold is 0), READY goes to RUN: the rotor is then taken to be at angle 0, or at the angle of the sensor.
 */
#ifndef DRIVE_H
#define DRIVE_H

#include "align.h"
#include "catch_spin.h"
#include "config_guard.h"
#include "derating.h"
#include "drive_cfg.h"
#include "model.h"
#include "phase_compensator.h"
#include "protection.h"
#include "rotor_position.h"
#include "supervision.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    DRIVE_STATE_INIT = 0,
    DRIVE_STATE_OFFSET_CAL,
    DRIVE_STATE_READY,
    DRIVE_STATE_CATCH_SPIN, /* flying start: does the rotor turn already? */
    DRIVE_STATE_ALIGN,      /* pulls the rotor to a known angle, measures R and L */
    DRIVE_STATE_HOLD,       /* an imposed current holds the rotor at standstill */
    DRIVE_STATE_IF_RAMP,    /* an imposed current turns the rotor: open-loop I/f */
    DRIVE_STATE_HANDOVER,   /* as IF_RAMP, while the observer's residual is checked */
    DRIVE_STATE_RUN,        /* closed loop on the angle of the observer or the sensor */
    DRIVE_STATE_FAULT
} drive_state_t;

typedef enum {
    DRIVE_MODE_SPEED = 0,
    DRIVE_MODE_POSITION
} drive_mode_t;

#define DRIVE_REQUEST_RUN (0x01U)   /* level: run while set */
#define DRIVE_REQUEST_CLEAR (0x02U) /* acknowledge a fault, only without RUN */

#define DRIVE_FLAG_BREAK (0x0001U) /* the power stage opened the gates by itself */
/* The tick before ended too late: no voltage acted in place of its demand. */
#define DRIVE_FLAG_LATE (0x0002U)

/* The user's command. */
typedef struct {
    int32_t target; /* SPEED: step_t, + turns α towards β; POSITION: Q16 electrical turns */
    uint8_t mode;   /* drive_mode_t; any other value counts as SPEED */
    uint8_t request;
} drive_command_t;

/*
 * One input frame: raw ADC counts (straight binary, currents with zero at mid-scale) and command. The
 * temperature is that of the power stage and may be some ticks old. The angle is that of a sensor on the shaft:
 * 2^16 = one turn, 0 where the magnet flux is along phase a, positive from a towards b. Without a sensor it is 0.
 */
typedef struct {
    uint16_t adc_ia;
    uint16_t adc_ib;
    uint16_t adc_bus;
    uint16_t flags;
    drive_command_t command;
    /* Behind the command: in front of it this field would cost a Cortex-M0+ 57 instructions. */
    uint16_t adc_temperature;
    uint16_t angle;
} drive_in_t;

/* One output frame. */
typedef struct {
    compare_t compare;
    bool gate_enable;
} drive_out_t;

/* Intermediate values of the last tick, in the order of computation. For traces and probes. */
typedef struct {
    int32_t phase_a; /* Q15 of I_b, offset removed, ±16383 */
    int32_t phase_b;
    int32_t bus;          /* Q15 of U_b */
    ab_t current_ab;      /* Q15 of I_b */
    dq_t current;         /* turned with θ̂ */
    dq_t current_frame;   /* turned with the frame's angle; in RUN as above */
    dq_t current_mean;    /* of current_frame while a current is imposed, over some 32 ticks */
    ab_t voltage_applied; /* Q15 of U_b, over the last period: the observer's input */
    int32_t speed;        /* ω̂, Q15 of Ω_b */
    /* i_d*, i_q* in the frame, Q15 of I_b; without current regulators: a mean of `current` */
    dq_t current_ref;
    int32_t voltage_limit; /* radius of the voltage circle, Q15 of U_b */
    dq_t voltage;          /* demand */
    ab_t ratio_ab;
} drive_signals_t;

/* Fields that every tick uses come first: a Cortex-M0+ reaches the first 128 bytes in one instruction. */
typedef struct {
    rotor_position_t position;
    const drive_cfg_t *cfg;
    drive_state_t state;
    protection_limits_t limits; /* in force in this state */
    int32_t offset_a;           /* sensor zero, Q15 of I_b, mid-scale = 16384; OFFSET_CAL: sum */
    int32_t offset_b;
    int32_t bus_before; /* bus voltage at the last instant, Q15 of U_b */
    nn_observer_t observer;
    uint32_t slow_count; /* N…1: ticks to the end of the slow period */
    bool voltage_driven; /* RUN without current regulators, see voltage_drive.h */
    /* slow periods in which the change to it was allowed; voltage-driven: periods at the lower limit */
    uint32_t voltage_periods;
    current_loop_t current_loop;
    modulator_t modulator;
    ab_t ratio_acting; /* demand / bus, Q15, that acted since the last instant */
    drive_signals_t signals;
    uint32_t tick; /* since drive_init, wraps */
    step_t speed_reference;
    speed_loop_t speed_loop; /* voltage-driven: its output is U, Q15 of U_b */
    position_loop_t position_loop;
    uint8_t mode; /* of the running motion loops */
    uint32_t offset_samples;
    model_t model;             /* motor model in force; kept from run to run */
    bool identified;           /* R and L of the model were measured */
    rotor_position_t frame;    /* angle of the imposed current */
    step_t frame_speed;        /* with a sensor: speed of the rotor */
    int32_t residual;          /* |e'_q|, filtered over slow periods, Q15 of I_b */
    uint32_t lost_periods;     /* slow periods with a residual too large for a held rotor */
    uint32_t handover_periods; /* slow periods in HANDOVER */
    uint32_t attempts;         /* starts that failed since READY */
    catch_spin_t catch_spin;
    align_t align;
    torque_range_t torque_range; /* allowed range of i_q* in this slow period */
    derating_t derating;
    supervision_t supervision;
    config_guard_t guard;
    phase_compensator_t compensator;
    int32_t voltage_magnitude; /* U, Q15 of U_b, + forwards; may be above a limit that has sunk */
    fault_t fault;             /* the last fault */
} drive_t;

/*
 * Bring the drive to INIT with this configuration, which must outlive the drive. Call before the first
 * tick, never from the interrupt. Returns NULL when the configuration is accepted. Otherwise it returns the name of the
 * field that config_check refuses, or "crc" when the checksum does not match; the drive must not be stepped then.
 */
const char *drive_init(drive_t *drive, const drive_cfg_t *cfg);

/* One control tick. Total: every input frame is allowed. Context: control interrupt only. */
void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out);

/*
 * Speed estimate in steps per tick: in RUN that of the observer (22), else that of the imposed vector. With a sensor it
 * is always that of the sensor.
 * Position estimate in Q32 electrical turns.
 */
static inline step_t drive_speed(const drive_t *drive)
{
    return (drive->state == DRIVE_STATE_RUN) ? drive->observer.speed : drive->frame_speed;
}

static inline int64_t drive_position_q32(const drive_t *drive)
{
    return drive->position.turns_q32;
}

#endif
