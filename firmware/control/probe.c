/* SPDX-License-Identifier: MIT */
#include "probe.h"

#include "trig.h"

#define SPEED_MAX (0x20000000)
#define CURRENT_MAX (16383)
#define PULSE_TICKS_MAX (64)
#define SUM_MAX (0x7FFE0000)
#define QUARTERS (4U)
/* A voltage that is demanded in tick k acts from k + 1 on, and its effect is measured in k + 2. */
#define DELAY_TICKS (2U)
#define MANTISSA_BITS (16U)
#define SHIFT_MAX (30)
#define TICKS_MASK (0xFFFFFU)
/* sin 45°, Q15. A ramp waits beyond this lag, because the rotor may fall out of step. */
#define LAG_MOST (23170)
#define MEAN_BITS_LEAST (8U) /* the mean lag is formed over at least 2^8 ticks */
#define MEAN_BITS_MOST (14U) /* the mean lag is formed over at most 2^14 ticks */
#define MEAN_FINER_BITS (14U)
#define LAG_FINER (16384) /* 2^14 */
#define MEAN_MOST (FX_Q15_MAX * LAG_FINER)
/*
 * With a damping (2·K) above this, the mean lag is formed over 2^8 ticks. It is formed over 8/K
 * ticks, so that it does not follow the swing that the damping acts on.
 */
#define MEAN_FAST_DAMPING (42722830)

void probe_reset(probe_t *probe)
{
    *probe = (probe_t){.pulse_ticks = 1, .emf_full = 1};
    probe->loop.pi_d = (pi_cfg_t){.kp_shift = 1U, .ki_shift = 1U};
    probe->loop.pi_q = probe->loop.pi_d;
}

static int32_t mantissa_of(int32_t word)
{
    const uint32_t mantissa = fx_unsigned(word) & (uint32_t)FX_Q15_MAX;

    return fx_signed(mantissa);
}

static uint32_t shift_of(int32_t word)
{
    return (uint32_t)fx_clamp(fx_asr(word, MANTISSA_BITS), 1, SHIFT_MAX);
}

static void set_gain(pi_cfg_t *pi, int32_t word)
{
    pi->kp = mantissa_of(word);
    pi->kp_shift = shift_of(word);
}

static void set_integral(pi_cfg_t *pi, int32_t word)
{
    pi->ki = mantissa_of(word);
    pi->ki_shift = shift_of(word);
}

static void begin_window(probe_t *probe, int32_t word)
{
    if (word != probe->window) {
        probe->window = word;
        probe->sums = (probe_sums_t){.bus = 0};
        probe->tick = 1U;
    }
}

/* Takes the words that are stored in parts, or that begin a window. */
static void set_composed(probe_t *probe, uint32_t what, int32_t value)
{
    switch (what) {
    case (uint32_t)PROBE_ANGLE:
        probe->angle = fx_unsigned(value);
        break;
    case (uint32_t)PROBE_GAIN_D:
        set_gain(&probe->loop.pi_d, value);
        break;
    case (uint32_t)PROBE_GAIN_Q:
        set_gain(&probe->loop.pi_q, value);
        break;
    case (uint32_t)PROBE_INTEGRAL_D:
        set_integral(&probe->loop.pi_d, value);
        break;
    case (uint32_t)PROBE_INTEGRAL_Q:
        set_integral(&probe->loop.pi_q, value);
        break;
    case (uint32_t)PROBE_REACTANCE:
        probe->loop.reactance_d_q13 = fx_usat15(value);
        probe->loop.reactance_q_q13 = probe->loop.reactance_d_q13;
        break;
    case (uint32_t)PROBE_WINDOW:
        begin_window(probe, value);
        break;
    default: /* no such word */
        break;
    }
}

/* Takes the words that move the vector. */
static void set_motion(probe_t *probe, uint32_t what, int32_t value)
{
    switch (what) {
    case (uint32_t)PROBE_RATE:
        probe->rate = fx_clamp(value, 0, SPEED_MAX);
        break;
    case (uint32_t)PROBE_DAMPING:
        probe->damping = fx_clamp(value, 0, SPEED_MAX);
        break;
    case (uint32_t)PROBE_TRACKING:
        probe->tracking = fx_clamp(value, 0, SPEED_MAX);
        break;
    case (uint32_t)PROBE_RAMP:
        probe->ramp = fx_clamp(value, 0, SPEED_MAX);
        break;
    case (uint32_t)PROBE_SPEED:
        probe->speed = fx_clamp(value, -SPEED_MAX, SPEED_MAX);
        break;
    default:
        set_composed(probe, what, value);
        break;
    }
}

void probe_set(probe_t *probe, uint32_t what, int32_t value)
{
    switch (what) {
    case (uint32_t)PROBE_CURRENT:
        probe->current = fx_clamp(value, 0, CURRENT_MAX);
        break;
    case (uint32_t)PROBE_RESISTANCE:
        probe->loop.resistance_q13 = fx_usat15(value);
        break;
    case (uint32_t)PROBE_LOSS:
        probe->loss = fx_usat15(value);
        break;
    case (uint32_t)PROBE_EMF:
        probe->emf_full = fx_clamp(value, 1, FX_Q15_MAX);
        break;
    case (uint32_t)PROBE_PULSE_D:
        probe->pulse.d = fx_usat15(value);
        break;
    case (uint32_t)PROBE_PULSE_Q:
        probe->pulse.q = fx_usat15(value);
        break;
    case (uint32_t)PROBE_PULSE_TICKS:
        probe->pulse_ticks = fx_clamp(value, 1, PULSE_TICKS_MAX);
        break;
    default:
        set_motion(probe, what, value);
        break;
    }
}

/* Returns the EMF along the current: emf_d less the voltage that the legs lose. */
static int32_t emf_along(const probe_t *probe, int32_t emf_d)
{
    return fx_sat16(emf_d - ((probe->current > 0) ? probe->loss : 0));
}

/* Returns sin δ, Q15, reduced where the EMF is too small to show an angle. */
static int32_t lag_of(const probe_t *probe, dq_t emf, step_t speed)
{
    const dq_t e = {emf_along(probe, emf.d), fx_sat16(emf.q)};
    const int32_t size = fx_max((int32_t)trig_sqrt(transforms_square(e)), probe->emf_full);
    const int32_t lag = fx_clamp((e.d * FX_Q15_MAX) / size, -FX_Q15_MAX, FX_Q15_MAX);

    return (speed < 0) ? -lag : lag;
}

static step_t towards_angle(const probe_t *probe, angle_t angle)
{
    return fx_clamp(fx_signed(probe->angle - angle), -probe->rate, probe->rate);
}

/*
 * Returns the speed to subtract as damping: at most half of the vector's speed, because the lag
 * would change its sign if the vector turned back.
 */
static step_t damped(const probe_t *probe, int32_t lag)
{
    const step_t most = fx_abs(probe->own_speed) / 2;

    return fx_clamp(fx_mul_32x16(probe->damping, fx_sat16(lag)), -most, most);
}

/*
 * Returns the next speed on the ramp. The ramp waits while the rotor lags too far on a ramp up, or
 * leads too far on a ramp down. A ramp down also waits while the bus can take no more energy from
 * the rotor.
 */
static step_t ramped(const probe_t *probe, int32_t lag, bool bus_bears)
{
    const bool rises = fx_abs(probe->speed) > fx_abs(probe->own_speed);
    const bool strains = (rises ? lag : -lag) > LAG_MOST;

    return (strains || (!rises && !bus_bears))
               ? probe->own_speed
               : fx_towards(probe->own_speed, probe->speed, probe->ramp);
}

static uint32_t mean_bits(const probe_t *probe)
{
    uint32_t bits = MEAN_BITS_LEAST;
    step_t enough = MEAN_FAST_DAMPING;

    while ((bits < MEAN_BITS_MOST) && (probe->damping < enough)) {
        bits++;
        enough /= 2;
    }
    return bits;
}

static void average_lag(probe_t *probe, int32_t lag)
{
    const int32_t finer = lag * LAG_FINER;

    const int32_t mean =
        probe->mean_lag_q29 + fx_asr(finer - probe->mean_lag_q29, mean_bits(probe));

    probe->mean_lag_q29 = fx_clamp(mean, -MEAN_MOST, MEAN_MOST);
}

step_t probe_turn(probe_t *probe, angle_t angle, dq_t emf, bool bus_bears)
{
    step_t step;

    probe->own_speed = ramped(probe, probe->lag_q15, bus_bears);
    if ((probe->own_speed == 0) && (probe->speed == 0)) {
        probe->lag_q15 = 0;
        probe->mean_lag_q29 = 0;
        step = towards_angle(probe, angle);
    } else {
        const int32_t lag = lag_of(probe, emf, probe->own_speed);
        const int32_t mean = (probe->tracking > 0)
                                 ? 0
                                 : fx_asr(probe->mean_lag_q29 + (LAG_FINER / 2), MEAN_FINER_BITS);

        probe->lag_q15 = lag;
        average_lag(probe, lag);
        probe->own_speed -= fx_mul_32x16(probe->tracking, lag);
        probe->own_speed = fx_clamp(probe->own_speed, -SPEED_MAX, SPEED_MAX);
        step = probe->own_speed - damped(probe, lag - mean);
        step = fx_clamp(step, -SPEED_MAX, SPEED_MAX);
    }
    return step;
}

static uint32_t window_ticks(const probe_t *probe)
{
    const uint32_t ticks = fx_unsigned(probe->window) & TICKS_MASK;

    return fx_unsigned(fx_clamp(fx_signed(ticks), 1, PROBE_WINDOW_MAX));
}

/* Returns the sign of the pulse in tick k of the window, 0 outside of the window. */
static int32_t sign_of_pulse(const probe_t *probe, uint32_t k)
{
    int32_t sign = 0;

    if (k < window_ticks(probe)) {
        const uint32_t quarter = (k / (uint32_t)probe->pulse_ticks) % QUARTERS;

        sign = ((quarter == 1U) || (quarter == 2U)) ? -1 : 1;
    }
    return sign;
}

static int32_t plus_sample(int32_t sum, int32_t value)
{
    return fx_clamp(sum, -SUM_MAX, SUM_MAX) + value;
}

static void plus_vector(dq_t *sum, dq_t value)
{
    sum->d = plus_sample(sum->d, value.d);
    sum->q = plus_sample(sum->q, value.q);
}

static void note_change(probe_t *probe, dq_t current)
{
    const int32_t sign = sign_of_pulse(probe, probe->tick - 1U - DELAY_TICKS);
    const dq_t before = probe->current_before;

    plus_vector(&probe->sums.change,
                (dq_t){sign * (current.d - before.d), sign * (current.q - before.q)});
}

/*
 * Returns x/y rounded to nearest, y > 0. The error of a quotient that is rounded towards zero would
 * not cancel between two directions.
 */
static int32_t rounded_ratio(int32_t x, int32_t y)
{
    const int32_t half = y / 2;

    return ((x < 0) ? (x - half) : (x + half)) / y;
}

/*
 * Returns the power of the EMF divided by the speed, 0 at standstill. jωL·i gives no power, so a
 * wrong L does not matter. R·i is subtracted with the current that flows, not with i* as in the EMF
 * of the sample: in a ramp the two currents differ, and the torque of a light rotor is small
 * against that difference.
 */
static int32_t torque_of(const probe_t *probe, const probe_sample_t *sample)
{
    const int32_t r_q13 = probe->loop.resistance_q13;
    const dq_t more = {fx_asr(r_q13 * fx_sat16(sample->current.d - probe->current), 13U),
                       fx_asr(r_q13 * fx_sat16(sample->current.q), 13U)};
    const int32_t along = emf_along(probe, sample->emf.d - more.d) * fx_sat15(sample->current.d);
    const int32_t across = fx_sat16(sample->emf.q - more.q) * fx_sat15(sample->current.q);
    const int32_t power = along + across;
    const int32_t speed = fx_abs(sample->speed_q15);
    const int32_t onwards = (sample->speed_q15 < 0) ? -power : power;

    return (speed > 0) ? fx_sat16(rounded_ratio(onwards, speed)) : 0;
}

static void note_means(probe_t *probe, const probe_sample_t *sample)
{
    probe_sums_t *const sums = &probe->sums;

    plus_vector(&sums->voltage, sample->voltage);
    plus_vector(&sums->current, sample->current);
    sums->bus = plus_sample(sums->bus, fx_asr(sample->bus, 2U));
    sums->noise_a = plus_sample(sums->noise_a, fx_abs(sample->phase_a - probe->before.d));
    sums->noise_b = plus_sample(sums->noise_b, fx_abs(sample->phase_b - probe->before.q));
    sums->torque = plus_sample(sums->torque, torque_of(probe, sample));
    sums->across = fx_max(sums->across, fx_abs(sample->current.q));
}

void probe_note(probe_t *probe, const probe_sample_t *sample)
{
    if (probe->tick > 0U) {
        const uint32_t ticks = window_ticks(probe);

        if (probe->tick == 1U) {
            probe->start_q16 = sample->turns_q16;
        }
        if (probe->tick <= ticks) {
            note_means(probe, sample);
        }
        note_change(probe, sample->current);
        if (probe->tick <= (ticks + 1U)) {
            probe->sums.turn_q16 =
                fx_signed(fx_unsigned(sample->turns_q16) - fx_unsigned(probe->start_q16));
        }
        probe->tick = (probe->tick < (ticks + DELAY_TICKS)) ? (probe->tick + 1U) : 0U;
    }
    probe->before = (dq_t){sample->phase_a, sample->phase_b};
    probe->current_before = sample->current;
}

bool probe_pulses(const probe_t *probe)
{
    return (probe->tick > 0U) && ((probe->pulse.d > 0) || (probe->pulse.q > 0));
}

dq_t probe_controlled(const probe_t *probe, dq_t reference, dq_t measured)
{
    return (dq_t){
        .d = (probe->pulse.d > 0) ? reference.d : measured.d,
        .q = (probe->pulse.q > 0) ? reference.q : measured.q,
    };
}

dq_t probe_voltage(const probe_t *probe, dq_t steady)
{
    const int32_t sign = sign_of_pulse(probe, probe->tick - 2U);

    return (dq_t){
        .d = fx_clamp(steady.d + (sign * probe->pulse.d), -FX_Q15_MAX, FX_Q15_MAX),
        .q = fx_clamp(steady.q + (sign * probe->pulse.q), -FX_Q15_MAX, FX_Q15_MAX),
    };
}

bool probe_is_done(const probe_t *probe, int32_t window)
{
    return (probe->window == window) && (probe->tick == 0U);
}
