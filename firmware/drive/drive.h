/* SPDX-License-Identifier: MIT */
/*
 * The drive: one pure control step from an input frame to an output frame.
 *
 *     drive_step(&drive, &in, &out)
 *
 * reads its state and one frame of raw measurements and command, and writes its state and one frame
 * of compare values. It has no clock, no hardware, no globals, no allocation; the same inputs give the
 * same outputs on every machine. drive_t is a plain value: a snapshot is a copy.
 *
 * Timing. The frame of tick k is sampled at t_k, the start of PWM period k. Its compare values act
 * from t_k+1 to t_k+2; gate_enable acts at once.
 *
 * States
 *     INIT → OFFSET_CAL → READY → CATCH_SPIN → ALIGN → HOLD ⇄ IF_RAMP → HANDOVER → RUN → HOLD
 *     CATCH_SPIN → RUN when the rotor turns already; HANDOVER → CATCH_SPIN when it fails
 *     any but INIT, OFFSET_CAL, FAULT → READY without DRIVE_REQUEST_RUN
 *     any → FAULT, latched, gates off in the same tick; FAULT → OFFSET_CAL on DRIVE_REQUEST_CLEAR without
 *     DRIVE_REQUEST_RUN
 * ALIGN, HOLD, IF_RAMP and HANDOVER impose a current vector whose angle the drive sets (the frame); in RUN the
 * observer's angle is the frame. Without a hold current READY goes to RUN, the rotor taken to be at angle 0, or where the
 * angle sensor says that it is.
 */
#ifndef DRIVE_H
#define DRIVE_H

#include "align.h"
#include "catch_spin.h"
#include "config_guard.h"
#include "derating.h"
#include "model.h"
#include "params.h"
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
    DRIVE_STATE_CATCH_SPIN, /* is the rotor turning? */
    DRIVE_STATE_ALIGN,      /* pulled to a known angle; R and L measured */
    DRIVE_STATE_HOLD,       /* held at standstill by an imposed current */
    DRIVE_STATE_IF_RAMP,    /* dragged along by an imposed current */
    DRIVE_STATE_HANDOVER,   /* dragged, and the observer is judged */
    DRIVE_STATE_RUN,        /* on the observer's angle, or the sensor's */
    DRIVE_STATE_FAULT
} drive_state_t;

typedef enum {
    DRIVE_MODE_SPEED = 0,
    DRIVE_MODE_POSITION
} drive_mode_t;

#define DRIVE_REQUEST_RUN (0x01U)   /* level: run while set */
#define DRIVE_REQUEST_CLEAR (0x02U) /* acknowledge a fault, only without RUN */

#define DRIVE_FLAG_BREAK (0x0001U) /* the power stage opened the gates by itself */
#define DRIVE_FLAG_LATE \
    (0x0002U) /* the tick before ended too late: no voltage instead of its own */

/* What the user wants. */
typedef struct {
    int32_t target; /* SPEED: step_t, + turns α towards β; POSITION: Q16 electrical turns */
    uint8_t mode;   /* drive_mode_t; any other value counts as SPEED */
    uint8_t request;
} drive_command_t;

/*
 * One input frame: raw ADC counts (straight binary, currents with zero at mid-scale) and command. The
 * temperature is that of the power stage; it may be some ticks old. The angle is that of a sensor on the shaft,
 * 2^16 = one turn, 0 where the magnet flux is along phase a, + from a towards b; 0 without a sensor.
 */
typedef struct {
    uint16_t adc_ia;
    uint16_t adc_ib;
    uint16_t adc_bus;
    uint16_t flags;
    drive_command_t command;
    uint16_t
        adc_temperature; /* last: before the command it would cost a Cortex-M0+ 57 instructions */
    uint16_t angle;
} drive_in_t;

/* One output frame. */
typedef struct {
    compare_t compare;
    bool gate_enable;
} drive_out_t;

/* The intermediates of the last tick in the order in which they are computed: for traces and probes. */
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
    dq_t current_ref; /* i_d*, i_q* in the frame, Q15 of I_b; voltage-driven: a mean of `current` */
    int32_t voltage_limit; /* Q15 of U_b */
    dq_t voltage;          /* demand */
    ab_t ratio_ab;
} drive_signals_t;

/* What each tick works with comes first: a Cortex-M0+ reaches 128 bytes in one instruction. */
typedef struct {
    rotor_position_t position;
    const drive_cfg_t *cfg;
    drive_state_t state;
    protection_limits_t limits; /* in force in this state */
    int32_t offset_a; /* sensor zero, Q15 of I_b, mid-scale = 16384; sum while calibrating */
    int32_t offset_b;
    int32_t bus_before; /* bus at the last instant */
    nn_observer_t observer;
    uint32_t slow_count;      /* N…1: ticks to the end of the slow period */
    bool voltage_driven;      /* RUN is without current regulators */
    uint32_t voltage_periods; /* slow periods in which it could be; voltage-driven: at its end */
    current_loop_t current_loop;
    modulator_t modulator;
    ab_t ratio_acting; /* demand over bus, Q15: acted since the last instant */
    drive_signals_t signals;
    uint32_t tick; /* since drive_init, wraps */
    step_t speed_reference;
    speed_loop_t speed_loop; /* voltage-driven, its integral is of U, Q15 of U_b */
    position_loop_t position_loop;
    uint8_t mode; /* of the running motion loops */
    uint32_t offset_samples;
    model_t model;             /* of the motor, in force; kept from run to run */
    bool identified;           /* R and L of the model were measured */
    rotor_position_t frame;    /* of the imposed current */
    step_t frame_speed;        /* with a sensor: the rotor's */
    int32_t residual;          /* |e'_q|, filtered over slow periods, Q15 of I_b */
    uint32_t lost_periods;     /* slow periods in which it was too large for a held rotor */
    uint32_t handover_periods; /* slow periods in HANDOVER */
    uint32_t attempts;         /* starts that failed since READY */
    catch_spin_t catch_spin;
    align_t align;
    torque_range_t torque_range; /* of i_q*, in this slow period */
    derating_t derating;
    supervision_t supervision;
    config_guard_t guard;
    phase_compensator_t compensator;
    int32_t voltage_magnitude; /* U, Q15 of U_b, + forwards; its limit may have sunk below it */
    fault_t fault;             /* why FAULT was entered last */
} drive_t;

/*
 * Put the drive into INIT with this configuration, which must outlive it. Call before the first
 * tick, never from the interrupt. Returns NULL, or the name of the field that params_check refuses or
 * "crc" when the configuration is not what was built; the drive must not be stepped then.
 */
const char *drive_init(drive_t *drive, const drive_cfg_t *cfg);

/* One control tick, from the control interrupt only. Total: every input frame is allowed. */
void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out);

/*
 * Speed estimate in steps per tick: that of the imposed vector while it drags the rotor, else the observer's (22); with a
 * sensor, the sensor's.
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
