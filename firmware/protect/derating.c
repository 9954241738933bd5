/* SPDX-License-Identifier: MIT */
#include "derating.h"

#define HEAT_BITS (10U) /* the heat has this many more fractional bits in Q24 than in Q14 */
#define HEAT_MAX ((uint32_t)DERATING_HEAT_MAX_Q24)
#define HEAT_MAX_BITS (30U)
/* largest change of the heat in a period, so that the sum fits into a word */
#define STEP_MAX (0x3FFFFFFFU)
#define RATIO_BITS (16U)
#define SPLIT_BITS (15U)
#define SPLIT_MASK (0x7FFFU)
#define VOLTAGE_SHIFT (2U) /* the filter of the voltage has a time constant of 2^2 slow periods */
/* an x further beyond the zero of a fade counts as this far; a heat is up to 2^20 */
#define DISTANCE_MAX (65535)

void derating_reset(derating_t *derating, const derating_cfg_t *cfg)
{
    *derating = (derating_t){
        .thermal = cfg->current_max,
        .motoring = cfg->current_max,
        .braking = cfg->current_max,
    };
}

/* Returns (top + rest / 2^15) · 2^up, with rest below 2^15, saturated, rounded down. */
static int32_t heat_shifted_up(uint32_t top, uint32_t rest, uint32_t up)
{
    uint32_t heat = HEAT_MAX;

    if ((top | rest) == 0U) {
        heat = 0U;
    } else if ((up < HEAT_MAX_BITS) && (top <= (HEAT_MAX >> up))) {
        const uint32_t lower =
            (up <= SPLIT_BITS) ? (rest >> (SPLIT_BITS - up)) : (rest << (up - SPLIT_BITS));

        heat = (top << up) + lower;
    } else {
        /* saturated */
    }
    return (int32_t)((heat < HEAT_MAX) ? heat : HEAT_MAX);
}

void derating_start(derating_t *derating)
{
    derating->voltage = (dq_t){0, 0};
}

void derating_warm(derating_t *derating, int32_t heat_q24)
{
    derating->heat_q24 = heat_q24;
}

/*
 * Converts the heat to the other scale: heat · ratio · 2^(shift − SPLIT_BITS), with a ratio below
 * 2^15. The product heat · ratio is computed as two products of 32 bits, because a Cortex-M0+ has
 * no multiplication with a longer result. Rounded down. If the scales are equal, no bit of the heat
 * changes.
 */
void derating_change(derating_t *derating, const derating_cfg_t *from, const derating_cfg_t *to)
{
    const uint32_t heat = fx_unsigned(derating->heat_q24);
    const uint32_t gain = (uint32_t)from->heat_gain;
    uint32_t ratio = (((uint32_t)to->heat_gain << RATIO_BITS) + (gain / 2U)) / gain;
    int32_t shift = ((int32_t)to->heat_shift - (int32_t)from->heat_shift) - 1;
    int32_t halvings = 0;
    uint32_t low;
    uint32_t top;

    for (int32_t k = 1; k <= (int32_t)RATIO_BITS; k++) {
        if (ratio > SPLIT_MASK) {
            ratio >>= 1U;
            halvings = k;
        }
    }
    ratio &= SPLIT_MASK; /* changes nothing, but tells the proof the range */
    shift += halvings;
    low = (heat & SPLIT_MASK) * ratio;
    top = ((heat >> SPLIT_BITS) * ratio) + (low >> SPLIT_BITS);
    if (shift >= 0) {
        derating->heat_q24 = heat_shifted_up(top, low & SPLIT_MASK, (uint32_t)shift);
    } else {
        const uint32_t down = (uint32_t)(-shift); /* 1…28 */
        const uint32_t less = top >> down;

        derating->heat_q24 = (int32_t)less;
    }
}

int32_t derating_share(const fade_t *fade, int32_t x)
{
    int32_t share = FX_Q15_MAX;

    if (fade->gain != 0) {
        const int32_t left = fx_max(fade->zero - x, -DISTANCE_MAX);

        share = fx_usat15(fx_asr(left * fade->gain, fade->shift));
    }
    return share;
}

/* Returns `current` · share. The largest share is one LSB below 1 and gives all of `current`. */
static int32_t scaled(int32_t current, int32_t share)
{
    return fx_asr((current * share) + FX_Q15_MAX, 15U);
}

/* Returns change · 2^up / 2^down, limited to ±STEP_MAX. */
static int32_t scaled_by(int32_t change, uint32_t up, uint32_t down)
{
    int32_t result;

    if (up <= down) {
        result = fx_asr(change, down - up);
    } else {
        const uint32_t size = fx_unsigned(fx_abs(change));
        const uint32_t more = up - down;
        const uint32_t larger = (size > (STEP_MAX >> more)) ? STEP_MAX : (size << more);
        const int32_t step = (int32_t)((larger < STEP_MAX) ? larger : STEP_MAX);

        result = (change < 0) ? -step : step;
    }
    return result;
}

/*
 * Updates the heat: a low-pass of the squared current. The scale of the heat has no room for the
 * squares of very large currents, beyond at least four times the continuous current. Then the heat
 * is shifted into the scale of the square instead. Returns whether the heat is above its limit and
 * this current would keep it there.
 */
static bool heat_up(derating_t *derating, const derating_cfg_t *cfg, dq_t current)
{
    /*@ split cfg->heat_shift; */
    const uint32_t largest = (uint32_t)INT32_MAX >> cfg->heat_shift;
    const int32_t d = fx_min(fx_abs(current.d), FX_Q15_MAX);
    const int32_t q = fx_min(fx_abs(current.q), FX_Q15_MAX);
    const int32_t square = (d * d) + (q * q);
    uint32_t kept = (uint32_t)fx_min(square, (int32_t)largest) << cfg->heat_shift;
    uint32_t up = 0U;
    int32_t made;
    int32_t change;

    if (square > (int32_t)largest) {
        kept = (uint32_t)square;
        up = cfg->heat_shift;
    }
    made = fx_mul_32x16((int32_t)kept, cfg->heat_gain);
    change = fx_mul_32x16(made - fx_asr(derating->heat_q24, up), cfg->heat_rate);
    derating->heat_q24 = fx_clamp(derating->heat_q24 + scaled_by(change, up, cfg->heat_rate_shift),
                                  0, DERATING_HEAT_MAX_Q24);
    return (fx_asr(derating->heat_q24, HEAT_BITS) > cfg->heat_max_q14) &&
           (made > fx_asr(derating_limit_q24(cfg), up));
}

static uint32_t flag(uint32_t name, int32_t share)
{
    return (share < FX_Q15_MAX) ? name : 0U;
}

/*
 * Returns TEMPERATURE_SENSOR if a working sensor cannot have this count, otherwise OVERTEMPERATURE.
 * The limit of the fault is the bound that the count has passed.
 */
static fault_t temperature_fault(const derating_cfg_t *cfg, int32_t raw)
{
    fault_t fault = {
        .id = FAULT_TEMPERATURE_SENSOR, .value = raw, .limit = cfg->temperature_lowest};

    if (raw > cfg->temperature_highest) {
        fault.limit = cfg->temperature_highest;
    } else if (raw >= cfg->temperature_lowest) {
        fault.id = FAULT_OVERTEMPERATURE;
        fault.limit = cfg->temperature.zero;
    } else {
        /* below the lowest count of a working sensor */
    }
    return fault;
}

/*
 * Returns the share of the current that the temperature allows; 0 if the temperature is not known.
 */
static int32_t share_by_temperature(const derating_cfg_t *cfg, int32_t raw)
{
    const bool known = (raw >= cfg->temperature_lowest) && (raw <= cfg->temperature_highest);

    return known ? derating_share(&cfg->temperature, raw) : 0;
}

fault_id_t derating_step(derating_t *derating, const derating_cfg_t *cfg, dq_t current,
                         uint16_t adc_temperature, fault_t *fault)
{
    const int32_t raw = (int32_t)adc_temperature;
    const int32_t by_temperature = share_by_temperature(cfg, raw);
    const bool overloads = heat_up(derating, cfg, current);
    const int32_t heat_q14 = fx_asr(derating->heat_q24, HEAT_BITS);
    const int32_t by_heat = derating_share(&cfg->heat, heat_q14);
    fault_id_t id = FAULT_NONE;

    derating->thermal =
        fx_min(cfg->current_continuous +
                   scaled(fx_max(cfg->current_max - cfg->current_continuous, 0), by_heat),
               scaled(cfg->current_max, by_temperature));
    derating->flags_slow =
        flag(DERATING_HEAT, by_heat) | flag(DERATING_TEMPERATURE, by_temperature);
    if (by_temperature > 0) {
        derating->too_hot = 0U;
    } else {
        derating->too_hot++;
    }
    if (overloads) {
        id = FAULT_OVERLOAD;
        *fault = (fault_t){.id = id, .value = heat_q14, .limit = cfg->heat_max_q14};
    } else if (derating->too_hot > cfg->temperature_periods) {
        *fault = temperature_fault(cfg, raw);
        id = fault->id;
    } else {
        /* no fault */
    }
    return id;
}

/* Returns the |i_q| that makes `power`, Q30 of I_b·U_b, at this v_q; at most current_max. */
static int32_t current_of(const derating_cfg_t *cfg, int32_t power, int32_t voltage_q)
{
    const uint32_t voltage = fx_unsigned(fx_max(fx_abs(voltage_q), 1));
    const uint32_t current = fx_unsigned(fx_max(power, 0)) / voltage;

    return fx_min(fx_signed(current), cfg->current_max);
}

/*
 * Returns the limit of |i_q|: the power that the bus may supply or absorb, minus the power of i_d,
 * divided by v_q.
 */
static int32_t limit_by_power(const derating_cfg_t *cfg, int32_t largest, int32_t bus,
                              int32_t power_d, int32_t voltage_q)
{
    int32_t limit = cfg->current_max;

    if ((largest != 0) && (voltage_q != 0)) {
        limit = current_of(cfg, (largest * bus) - power_d, voltage_q);
    }
    return limit;
}

/*
 * Narrows the range of i_q to the limits of the bus current. i_q with the sign of v_q takes power
 * from the bus, with the other sign it feeds power back.
 */
static torque_range_t limit_bus_current(derating_t *derating, const derating_cfg_t *cfg,
                                        const derating_motion_t *motion, torque_range_t range)
{
    const dq_t v = derating->voltage;
    const int32_t power_d = v.d * motion->current_d;
    const int32_t with = limit_by_power(cfg, cfg->bus_current_max, motion->bus, power_d, v.q);
    const int32_t against =
        limit_by_power(cfg, cfg->bus_regeneration_max, motion->bus, -power_d, v.q);
    const int32_t lower = (v.q < 0) ? with : against;
    const int32_t upper = (v.q < 0) ? against : with;

    if (fx_min(with, against) < cfg->current_max) {
        derating->flags |= DERATING_BUS_CURRENT;
    }
    return (torque_range_t){.lower = fx_max(range.lower, -lower),
                            .upper = fx_min(range.upper, upper)};
}

torque_range_t derating_range(derating_t *derating, const derating_cfg_t *cfg,
                              const derating_motion_t *motion)
{
    const int32_t high = derating_share(&cfg->bus_high, motion->bus);
    const int32_t low = derating_share(&cfg->bus_low, motion->bus);
    const step_t speed = motion->speed;
    torque_range_t range;

    derating->voltage.d = fx_approach(derating->voltage.d, motion->voltage.d, VOLTAGE_SHIFT);
    derating->voltage.q = fx_approach(derating->voltage.q, motion->voltage.q, VOLTAGE_SHIFT);
    derating->braking = fx_min(derating->thermal, scaled(cfg->current_max, high));
    derating->motoring = fx_min(derating->thermal, scaled(cfg->current_max, low));
    derating->flags =
        derating->flags_slow | flag(DERATING_BUS_HIGH, high) | flag(DERATING_BUS_LOW, low);
    range = (torque_range_t){.lower = -derating->motoring, .upper = derating->motoring};
    if (speed > cfg->regeneration_speed) {
        range.lower = -derating->braking;
    } else if (speed < -cfg->regeneration_speed) {
        range.upper = derating->braking;
    } else {
        /* too slow to feed anything back */
    }
    return limit_bus_current(derating, cfg, motion, range);
}
