/* SPDX-License-Identifier: MIT */
/*
 * Derating: how much torque current the drive may demand, and the faults for the cases in which
 * derating is not enough.
 *
 *     i²t          current_max below 90 % heat, linearly down to the continuous current at 100 %
 *     temperature  current_max up to the warning, linearly down to 0 at the limit; at the limit
 *                  also a fault
 *     high bus     braking only: full up to bus_brake_v, linearly down to 0 before the over-voltage
 *                  fault
 *     low bus      motoring only: full from bus_low_v on, linearly down to 0 at bus_min_v
 *     bus current  one limit for the current from the supply (motoring), one for the current into
 *                  it (braking)
 *
 * The smallest limit applies. Heat is the squared current vector, low-pass filtered with the time
 * constant of the winding. Heat 1 is the steady state at the continuous current.
 *
 * Bus current: bus·i_bus = 1.5·(v_d·i_d + v_q·i_q) is the power of the motor. The losses of the
 * inverter come on top. This equation gives the limit of i_q. v is the voltage demand, low-pass
 * filtered with a time constant of four slow periods. i_q changes v_q, and v_q changes the limit of
 * i_q: without the filter, i_q and its limit would oscillate. Where v_q is 0, i_q takes no power
 * and there is no limit. This limit never reduces i_d, nor an imposed current; i_q gets the power
 * that i_d leaves. After a hand-over has turned the frame, the filter still holds the voltage of
 * the old frame for a while. The power is small at that speed.
 *
 * Currents Q15 of I_b, bus Q15 of U_b, speeds step_t. Pure, total within the ranges. Control
 * interrupt only: limits once per slow period, heat and temperature once per supervision period
 * (supervision.h).
 */
#ifndef DERATING_H
#define DERATING_H

#include "fault.h"
#include "fx.h"
#include "motion_loop.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * A share that falls linearly from 1 to 0: (zero − x)·gain / 2^shift in Q15, clamped to 0…32767.
 * With a negative gain it rises with x. Gain 0: always 1, no derating.
 */
typedef struct {
    int32_t zero;   /* x at which the share is 0, 0…65535 */
    int32_t gain;   /* −32767…32767 */
    uint32_t shift; /* 0…16 */
} fade_t;

typedef struct {
    int32_t current_max;        /* limit of |i_q*| without derating, 1…16384 */
    int32_t current_continuous; /* lowest limit by i²t, 1…current_max */
    /*
     * steady heat of a current, Q24: i² in Q30 · 2^heat_shift · heat_gain / 2^16; 0…27 and 1…32767
     */
    uint32_t heat_shift;
    int32_t heat_gain;
    int32_t heat_rate;        /* period / time constant = heat_rate / 2^(16 + heat_rate_shift) */
    uint32_t heat_rate_shift; /* 0…30 */
    int32_t heat_max_q14;     /* a heat above this may lead to OVERLOAD, Q14, 1…2^20 */
    fade_t heat;              /* share of current_max − current_continuous; x: heat, Q14 */
    fade_t temperature;       /* share of current_max; x: raw count of the sensor */
    /*
     * counts that a working sensor can have; beyond them it is broken, and the share is 0. 0…65535
     */
    int32_t temperature_lowest;
    int32_t temperature_highest;
    /* OVERTEMPERATURE or TEMPERATURE_SENSOR when the share is 0 for more periods than this */
    uint32_t temperature_periods;
    fade_t bus_high;           /* share of the braking current; x: bus */
    fade_t bus_low;            /* share of the motoring current; x: bus */
    step_t regeneration_speed; /* below this |speed| no current counts as braking, 0…2^29 */
    int32_t bus_current_max; /* limit of the bus current when motoring, Q15 of 1.5·I_b, 0…32767, 0:
                                no limit */
    int32_t bus_regeneration_max; /* limit of the bus current when braking, Q15 of 1.5·I_b, 0…32767,
                                     0: no limit */
} derating_cfg_t;

/* Flags of the limits that reduce the torque range now: motoring, braking or both. */
#define DERATING_HEAT (0x01U)
#define DERATING_TEMPERATURE (0x02U)
#define DERATING_BUS_HIGH (0x04U)
#define DERATING_BUS_LOW (0x08U)
#define DERATING_BUS_CURRENT (0x10U)

#define DERATING_HEAT_ONE_Q24 (0x1000000)  /* steady state at the continuous current */
#define DERATING_HEAT_MAX_Q24 (0x40000000) /* the largest heat that is counted: 64 */

typedef struct {
    int32_t heat_q24; /* 2^24 = steady state at the continuous current, 0…2^30 */
    int32_t thermal;  /* current limit by heat and temperature */
    /*
     * supervision periods in a row in which the temperature allows no current: it is at its limit,
     * or it is not known
     */
    uint32_t too_hot;
    /* limit of the motoring current by all but the bus current, 0…current_max */
    int32_t motoring;
    /* limit of the braking current by all but the bus current, 0…current_max */
    int32_t braking;
    /* mean of the voltage demand over some slow periods, Q15 of U_b, ±32767 */
    dq_t voltage;
    uint32_t flags_slow; /* DERATING_…, of heat and temperature only */
    uint32_t flags;      /* DERATING_…, of all limits */
} derating_t;

/* Returns the limit of the heat: heat_max_q14 as Q24. Pure. */
static inline int32_t derating_limit_q24(const derating_cfg_t *cfg)
{
    return cfg->heat_max_q14 * 1024;
}

/* Heat 0, no derating. */
void derating_reset(derating_t *derating, const derating_cfg_t *cfg);

/* A start begins: the mean of the voltage demand is 0. The heat stays. */
void derating_start(derating_t *derating);

/* Set the heat, Q24, 0…DERATING_HEAT_MAX_Q24. */
void derating_warm(derating_t *derating, int32_t heat_q24);

/*
 * Convert the heat from the scale of one configuration to the scale of another, so that it stands
 * for the same squared current. Relative error 2^-14, saturated. Control interrupt only.
 */
void derating_change(derating_t *derating, const derating_cfg_t *from, const derating_cfg_t *to);

/*
 * Returns the share at x, Q15, 0…32767. zero − x ≤ 65535; an x further than 65535 beyond the zero
 * counts as that far.
 */
int32_t derating_share(const fade_t *fade, int32_t x);

/*
 * One supervision period, gates open or not: updates the heat by `current` (each axis within
 * ±32767, in any frame) and the limit by the temperature. Finds OVERLOAD when the heat is above its
 * limit and this current would keep it there. Finds OVERTEMPERATURE. Finds TEMPERATURE_SENSOR when
 * a working sensor cannot have this count: the temperature is then unknown, and the share of the
 * current is 0 (fault.h).
 */
fault_id_t derating_step(derating_t *derating, const derating_cfg_t *cfg, dq_t current,
                         uint16_t adc_temperature, fault_t *fault);

/* Operating point of the motor in this slow period, in the frame of i_q*. */
typedef struct {
    int32_t bus; /* 0…32767 */
    step_t speed;
    dq_t voltage;      /* voltage demand, Q15 of U_b, ±32767; 0 with open gates */
    int32_t current_d; /* i_d*, ±16384 */
} derating_motion_t;

/*
 * Call once per slow period: sets limits and flags for this bus voltage. Returns the range of i_q*.
 * Torque against the speed counts as braking; for the bus current, braking means power that flows
 * back. Rounds towards less current.
 */
torque_range_t derating_range(derating_t *derating, const derating_cfg_t *cfg,
                              const derating_motion_t *motion);

#endif
