/* SPDX-License-Identifier: MIT */
#include "identify.h"

#include "commander.h"

#include "trig.h"

#include <stddef.h>
#include <stdint.h>

#define MS_PS (1000000000U)
#define WINDOW_MS (40U)   /* two periods of a rectified mains of 100 Hz */
#define AXES (3U)
#define THIRD_TURN (0x55555555U)
#define HALF_TURN (0x80000000U)
#define LEVELS (14U)
#define LOOP_SHARE (8)    /* the bandwidth of the current control is 1/8 a tick */
#define PULSE_QUARTERS (4U)

static int32_t *word(identify_t *identify, probe_word_t which)
{
    return &identify->aim.words[(uint32_t)which - (uint32_t)PROBE_CURRENT];
}

static const drive_cfg_t *cfg_of(const identify_t *identify)
{
    return identify->app->drive.cfg;
}

static const probe_sums_t *sums_of(const identify_t *identify)
{
    return &identify->app->drive.probe.sums;
}

static int32_t continuous(const identify_t *identify)
{
    return cfg_of(identify)->derating.current_continuous;
}

/* ---- what an experiment is ---- */

static void aim_current(identify_t *identify, int32_t current)
{
    *word(identify, PROBE_CURRENT) = current;
    *word(identify, PROBE_PULSE_D) = 0;
    *word(identify, PROBE_PULSE_Q) = 0;
}

static void aim_window(identify_t *identify, const char *kind, uint32_t settle, uint32_t ticks)
{
    identify->aim.kind = kind;
    identify->aim.settle = settle;
    identify->aim.ticks = ticks;
}

/* value / 2^shift as a word of PROBE_GAIN or PROBE_INTEGRAL: value_q32 in Q32. */
static int32_t gain_word(uint64_t value_q32)
{
    uint64_t mantissa = value_q32;
    uint32_t shift = 32U;

    while (mantissa > 32767U) {
        mantissa >>= 1U;
        shift--;
    }
    while (shift > 30U) {
        mantissa >>= 1U;
        shift--;
    }
    return (int32_t)((shift << 16U) | (uint32_t)mantissa);
}

/* Stiff along the current. Across, a soft control leaves it to R to damp the swings of a rotor at rest. */
static void aim_gains(identify_t *identify, bool soft)
{
    const uint64_t kp_q32 = ((uint64_t)(uint32_t)identify->inductance_q16 << 16U) / (uint64_t)LOOP_SHARE;
    const uint64_t ki_q32 = kp_q32 / (5U * (uint64_t)LOOP_SHARE);

    *word(identify, PROBE_GAIN_D) = gain_word(kp_q32);
    *word(identify, PROBE_INTEGRAL_D) = gain_word(ki_q32 << 11U);
    *word(identify, PROBE_GAIN_Q) = soft ? 0x10000 : gain_word(kp_q32);
    *word(identify, PROBE_INTEGRAL_Q) = soft ? gain_word((ki_q32 << 11U) / 256U) : gain_word(ki_q32 << 11U);
}

static void next_phase(identify_t *identify, identify_phase_t phase)
{
    identify->phase = phase;
    identify->step = 0U;
}

static void refuse(identify_t *identify, const char *why)
{
    identify->why = why;
    next_phase(identify, IDENTIFY_REFUSED);
}

/* ---- PULSE ---- */

#define PULSE_PATTERNS (16U)
#define PULSE_TICKS_MOST (64U)

static void aim_pulse(identify_t *identify)
{
    aim_current(identify, 0);
    *word(identify, PROBE_ANGLE) = (int32_t)(identify->axis * THIRD_TURN);
    *word(identify, PROBE_PULSE_D) = identify->pulse;
    *word(identify, PROBE_PULSE_TICKS) = (int32_t)identify->quarter;
    aim_window(identify, "pulse", identify->ms_ticks, PULSE_QUARTERS * identify->quarter * PULSE_PATTERNS);
}

static void begin_pulse(identify_t *identify)
{
    identify->pulse = fx_max(fx_asr(identify->app->drive.signals.bus, 8U), 1);
    identify->quarter = 1U;
    identify->response = 0;
    *word(identify, PROBE_RATE) = 0x20000000;
    aim_pulse(identify);
}

/* The current at the peak of a pulse. */
static int32_t pulse_peak(const identify_t *identify)
{
    return sums_of(identify)->change.d / (int32_t)(PULSE_QUARTERS * PULSE_PATTERNS);
}

/* What the legs lose is the same in two pulses: it cancels in their difference. The last one was 5/4 of the one before. */
static void find_inductance(identify_t *identify, int32_t peak)
{
    const int64_t more = fx_max(peak - identify->response, 1);
    const int64_t volts = ((int64_t)identify->pulse * (int64_t)identify->quarter) / 5;
    const int64_t ratio = (volts * 65536) / more;

    identify->inductance_q16 = (int32_t)((ratio < INT32_MAX) ? ratio : INT32_MAX);
    identify->along_q16 = identify->inductance_q16;
    identify->across_q16 = identify->inductance_q16;
}

/* In small steps once a current shows; twice as much before, first of the voltage, then of the time. */
static void enlarge_pulse(identify_t *identify, int32_t peak)
{
    const int32_t most = fx_asr(identify->app->drive.signals.bus, 2U);
    const int32_t quarter_more = identify->pulse + (identify->pulse / 4);

    identify->response = peak;
    identify->fine = (peak >= (continuous(identify) / 16)) && (quarter_more <= most);
    if (identify->fine) {
        identify->pulse = quarter_more;
    } else if ((2 * identify->pulse) <= most) {
        identify->pulse *= 2;
    } else {
        identify->pulse = (identify->pulse * 5) / 8;
        identify->quarter *= 2U;
    }
}

/* The first axis until the current flows, then the others with the same pulse. */
static void plan_pulse(identify_t *identify)
{
    const int32_t peak = pulse_peak(identify);

    if (identify->axis > 0U) {
        identify->axis++;
    } else if (identify->fine && (peak >= (continuous(identify) / 4))) {
        find_inductance(identify, peak);
        identify->axis = 1U;
    } else {
        enlarge_pulse(identify, peak);
    }
    if (identify->axis >= AXES) {
        identify->axis = 0U;
        next_phase(identify, IDENTIFY_CATCH);
    } else if (identify->quarter > PULSE_TICKS_MOST) {
        refuse(identify, "no current flows: are the phases connected?");
    } else {
        aim_pulse(identify);
    }
}

/* ---- CATCH ---- */

#define CATCH_STEPS (8U)
#define CATCH_ENDS (40U)

static step_t turn_rate(const identify_t *identify, uint32_t half_turn_ms)
{
    return (step_t)(HALF_TURN / (half_turn_ms * identify->ms_ticks));
}

static bool is_calm(const identify_t *identify)
{
    return sums_of(identify)->across < (identify->aim.words[0] / 16);
}

static void plan_catch(identify_t *identify)
{
    const int32_t share = fx_min((int32_t)identify->step + 1, (int32_t)CATCH_STEPS);

    if ((identify->step > (CATCH_STEPS + 2U)) && (is_calm(identify) || (identify->step >= CATCH_ENDS))) {
        next_phase(identify, IDENTIFY_STILL);
    } else {
        aim_current(identify, (continuous(identify) * share) / (int32_t)CATCH_STEPS);
        aim_gains(identify, true);
        *word(identify, PROBE_ANGLE) = (int32_t)HALF_TURN;
        aim_window(identify, "catch", 5U * identify->ms_ticks, identify->ms_ticks);
        if (identify->step == CATCH_STEPS) {
            *word(identify, PROBE_RATE) = turn_rate(identify, 400U);
            *word(identify, PROBE_ANGLE) = (int32_t)(HALF_TURN / 2U);
        } else if (identify->step > CATCH_STEPS) {
            *word(identify, PROBE_ANGLE) = 0;
            aim_window(identify, "catch", identify->ms_ticks, 100U * identify->ms_ticks);
        } else {
            /* the current rises */
        }
        identify->step++;
    }
}

/* ---- STILL ---- */

/* In 1/256 of the largest current of the measurement; down, and up again in between. */
static const uint8_t levels[LEVELS] = {255, 205, 164, 131, 105, 84, 67, 54, 43, 34, 27, 54, 105, 205};

static int32_t largest_still(const identify_t *identify)
{
    const int32_t most = (cfg_of(identify)->derating.current_max * 9) / 10;

    return fx_min(most, 2 * continuous(identify));
}

typedef struct {
    uint8_t bias;   /* in 1/16 of the continuous current */
    uint8_t along;
    uint8_t across;
} burst_t;

#define BURSTS (7U)
static const burst_t bursts[BURSTS] = {
    {8, 3, 0}, {8, 6, 0}, {16, 6, 0}, {2, 6, 0}, {2, 0, 6}, {2, 0, 11}, {2, 0, 16},
};

/* Pulses of so much current, as short as the voltage allows. */
static void aim_burst(identify_t *identify, const burst_t *burst)
{
    const int32_t share = (int32_t)burst->along + (int32_t)burst->across;
    const int64_t current = ((int64_t)continuous(identify) * share) / 16;
    const int64_t volts = (current * ((burst->along > 0U) ? identify->along_q16 : identify->across_q16)) >> 16U;
    const int64_t most = (int64_t)fx_asr(identify->app->drive.signals.bus * 3, 3U);
    const int64_t needed = 1 + (volts / most);
    const int64_t quarter = (needed < 64) ? needed : 64;
    const int64_t each = volts / quarter;
    const int32_t voltage = (int32_t)((each < most) ? each : most);
    const uint32_t patterns = (uint32_t)fx_max(1, 256 / (4 * (int32_t)quarter));

    aim_current(identify, (continuous(identify) * (int32_t)burst->bias) / 16);
    *word(identify, (burst->along > 0U) ? PROBE_PULSE_D : PROBE_PULSE_Q) = voltage;
    *word(identify, PROBE_PULSE_TICKS) = (int32_t)quarter;
    aim_window(identify, "burst", 20U * identify->ms_ticks, patterns * 4U * (uint32_t)quarter);
}

/* L along and across, as the last pulses show it: it falls with the current. */
static void note_burst(identify_t *identify)
{
    const int64_t along = sums_of(identify)->change.d;
    const int64_t across = sums_of(identify)->change.q;
    const int64_t ticks = (int64_t)identify->aim.ticks;

    if ((*word(identify, PROBE_PULSE_D) > 0) && (along > 0)) {
        identify->along_q16 = (int32_t)((ticks * *word(identify, PROBE_PULSE_D) * 65536) / along);
    }
    if ((*word(identify, PROBE_PULSE_Q) > 0) && (across > 0)) {
        identify->across_q16 = (int32_t)((ticks * *word(identify, PROBE_PULSE_Q) * 65536) / across);
    }
}

/* R of the first and the fifth level. */
static void note_level(identify_t *identify)
{
    const int32_t ticks = (int32_t)identify->aim.ticks;
    const int32_t voltage = sums_of(identify)->voltage.d / ticks;
    const int32_t current = sums_of(identify)->current.d / ticks;

    if ((identify->axis == 0U) && (identify->step == 1U)) {
        identify->high_voltage = voltage;
        identify->high_current = current;
    }
    if ((identify->axis == 0U) && (identify->step == 5U)) {
        const int32_t apart = fx_max(identify->high_current - current, 1);

        identify->resistance_q13 = ((identify->high_voltage - voltage) * 8192) / apart;
        identify->loss = fx_max(voltage - ((identify->resistance_q13 * current) / 8192), 0);
    }
}

static void plan_still(identify_t *identify)
{
    if ((identify->step > 0U) && (identify->step <= LEVELS)) {
        note_level(identify);
    } else if (identify->step > LEVELS) {
        note_burst(identify);
    } else {
        /* nothing is measured yet */
    }
    if (identify->step < LEVELS) {
        aim_current(identify, (largest_still(identify) * (int32_t)levels[identify->step]) / 256);
        aim_window(identify, "still", 20U * identify->ms_ticks, WINDOW_MS * identify->ms_ticks);
        identify->step++;
    } else if (identify->step < (LEVELS + (2U * BURSTS))) {
        aim_burst(identify, &bursts[(identify->step - LEVELS) % BURSTS]);
        identify->step++;
    } else if ((identify->axis + 1U) < AXES) {
        identify->axis++;
        identify->step = 0U;
        aim_current(identify, continuous(identify));
        *word(identify, PROBE_ANGLE) = (int32_t)(identify->axis * THIRD_TURN);
        aim_window(identify, "catch", 200U * identify->ms_ticks, identify->ms_ticks);
    } else {
        next_phase(identify, IDENTIFY_SPIN);
        aim_current(identify, continuous(identify));
        aim_window(identify, "catch", identify->ms_ticks, identify->ms_ticks);
    }
}

/* ---- SPIN ---- */

#define RAMP_MS_FIRST (1250U)
#define RAMP_EDGE_TICKS (2048U)
#define COAST_MS_FIRST (5U)
#define COAST_MS_MOST (80U)

static int32_t spin_current(const identify_t *identify)
{
    return (continuous(identify) * 3) / 4;
}

/* Ω_b·L in Q13 of U_b/I_b: L in ticks times 2π/2^32 times 2^speed_shift. */
static int32_t reactance_q13(const identify_t *identify)
{
    const uint32_t shift = cfg_of(identify)->speed_shift;
    const int64_t per_turn = ((int64_t)identify->inductance_q16 * 411775) >> 16U; /* 2π, Q16 */

    return (int32_t)fx_min((int32_t)((per_turn << shift) >> 20U), 32767);
}

static void aim_speed(identify_t *identify, step_t speed, step_t ramp)
{
    *word(identify, PROBE_SPEED) = speed;
    *word(identify, PROBE_RAMP) = ramp;
}

/* ---- RAMP ---- */

#define RAMP_MS_ALL (3000U)
#define RAMP_TICKS_LEAST (64)
#define RAMP_TICKS_MOST (50000)
#define DAMPING_MOST (41000000)
#define PULL_ENOUGH (4915) /* 0.3 of what the current can pull, Q14 */

/* Up and down between half of the speed and the whole. The window begins before the ramp and ends behind it. */
static uint32_t edge_ticks(const identify_t *identify)
{
    return (uint32_t)fx_clamp(6 * (int32_t)identify->swing_ticks, (int32_t)RAMP_EDGE_TICKS, 4 * (int32_t)RAMP_EDGE_TICKS) - 0U;
}

static void aim_ramp(identify_t *identify, bool down)
{
    const step_t half = identify->top / 2;

    aim_speed(identify, down ? half : identify->top, fx_max(half / (step_t)identify->ramp_ticks, 1));
    aim_window(identify, "ramp", (identify->ramp_ticks / 2U) + edge_ticks(identify), 2U * (identify->ramp_ticks + edge_ticks(identify)));
    identify->leads = true;
}

/* Mean of e_d/ω over φ in a window, Q14, as much larger as the window is longer than the ramp. */
static int32_t mean_pull(const identify_t *identify)
{
    const probe_sums_t *const s = sums_of(identify);
    const uint32_t shift = cfg_of(identify)->speed_shift;
    const int64_t speed_q15 = ((int64_t)s->turn_q16 << 16U) >> shift; /* sum, as the others are */
    const int64_t flux_q14 = ((int64_t)s->voltage.q * 16384) / ((speed_q15 == 0) ? 1 : speed_q15);
    const int64_t current = fx_max(s->current.d / (int32_t)identify->aim.ticks, 1);
    const int64_t each = ((int64_t)s->pull * 16384) / current / (int64_t)identify->ramp_ticks * 16384;

    return (int32_t)(each / ((flux_q14 > 0) ? flux_q14 : 1));
}

/*
 * The EMF of a ramp drives a current across that the current control answers in proportion: the sum of it is the same in
 * every ramp. It is to stay below 1/8 of the current.
 */
static int32_t shortest_ramp(const identify_t *identify)
{
    const int32_t each = fx_max(identify->aim.words[0] / 8, 1);

    return fx_max(fx_abs(sums_of(identify)->current.q) / each, RAMP_TICKS_LEAST);
}

/*
 * The next ramps are as steep as lets the rotor lag by PULL_ENOUGH. The frame damps the rotor's swing, of ω_n² = α/sin δ,
 * with K = ω_n: more would hold the speed of the frame back by the lag.
 */
static void steepen(identify_t *identify, int32_t pull)
{
    const int32_t shown = fx_max(pull, PULL_ENOUGH / 4);
    const uint64_t ticks = ((uint64_t)identify->ramp_ticks * (uint64_t)(uint32_t)shown) >> 14U;
    const uint64_t square = (ticks * 683565276U) / (uint64_t)(uint32_t)(identify->top / 2);

    identify->swing_ticks = (uint32_t)fx_max((int32_t)trig_sqrt((square < 0xFFFFFFFFU) ? (uint32_t)square : 0xFFFFFFFFU), 8);
    *word(identify, PROBE_DAMPING) = fx_min((int32_t)(1367130551U / identify->swing_ticks), DAMPING_MOST);
    identify->ramp_ticks = (uint32_t)fx_clamp(((int32_t)identify->ramp_ticks * (shown / 16)) / (PULL_ENOUGH / 16), shortest_ramp(identify), RAMP_TICKS_MOST);
}

static void begin_ramps(identify_t *identify)
{
    identify->ramp_ticks = (uint32_t)fx_min((int32_t)(RAMP_MS_FIRST * identify->ms_ticks), RAMP_TICKS_MOST);
    identify->swing_ticks = 0U;
}

static bool shows_torque(const identify_t *identify, int32_t pull)
{
    return (pull >= ((PULL_ENOUGH * 2) / 3)) || ((int32_t)identify->ramp_ticks <= ((shortest_ramp(identify) * 5) / 4));
}

/* What friction and R do is the same up and down. */
static void judge_ramp(identify_t *identify)
{
    const int32_t pull = (identify->pull_up - identify->pull_down) / 2;

    if (shows_torque(identify, pull)) {
        const int32_t most = (int32_t)((RAMP_MS_ALL * identify->ms_ticks) / (2U * (identify->ramp_ticks + edge_ticks(identify) + (80U * identify->ms_ticks))));

        identify->pairs_left = (identify->pairs_left == 0U) ? (uint32_t)fx_clamp(most, 3, 9) : (identify->pairs_left - 1U);
    } else {
        steepen(identify, pull);
    }
}

/* At a constant speed: what friction pulls there. */
static void aim_steady(identify_t *identify)
{
    aim_window(identify, "hold", 0U, 2U * WINDOW_MS * identify->ms_ticks);
    identify->leads = false;
}

static void begin_spin(identify_t *identify)
{
    const uint32_t ramp_ticks = 2500U * identify->ms_ticks;

    identify->top = (cfg_of(identify)->speed_loop.speed_max / 10) * 5;
    identify->ramp = fx_max(identify->top / (step_t)ramp_ticks, 1);
    *word(identify, PROBE_RESISTANCE) = identify->resistance_q13;
    *word(identify, PROBE_REACTANCE) = reactance_q13(identify);
    *word(identify, PROBE_LOSS) = identify->loss;
    *word(identify, PROBE_EMF) = fx_max(2 * identify->loss, (identify->resistance_q13 * spin_current(identify)) / 16384);
    *word(identify, PROBE_DAMPING) = DAMPING_MOST;
    aim_gains(identify, false);
    aim_current(identify, spin_current(identify));
}

/*
 * A quarter of the speed, half of it, the whole, and there half of the current. The way from half to whole is a first ramp:
 * its torque, with that of friction, says how steep the next ones may be.
 */
static void plan_spin(identify_t *identify)
{
    const int32_t pull = (identify->step == 3U) ? mean_pull(identify) : 0;

    aim_window(identify, "spin", 150U * identify->ms_ticks, 2U * WINDOW_MS * identify->ms_ticks);
    switch (identify->step) {
    case 0U:
        begin_spin(identify);
        aim_speed(identify, identify->top / 4, identify->ramp);
        break;
    case 1U:
        aim_speed(identify, identify->top / 2, identify->ramp);
        break;
    case 2U:
        begin_ramps(identify);
        aim_ramp(identify, false);
        break;
    case 3U:
        identify->leads = false;
        steepen(identify, pull);
        aim_steady(identify);
        break;
    case 4U:
        aim_current(identify, spin_current(identify) / 2);
        break;
    default:
        aim_current(identify, spin_current(identify));
        next_phase(identify, IDENTIFY_RAMP);
        break;
    }
    if (identify->phase == IDENTIFY_SPIN) {
        identify->step++;
    }
}

static void plan_ramp(identify_t *identify)
{
    const uint32_t part = identify->step % 4U;

    if (part == 1U) {
        identify->pull_down = mean_pull(identify);
    } else if (part == 3U) {
        identify->pull_up = mean_pull(identify);
        judge_ramp(identify);
    } else {
        /* nothing is measured yet */
    }
    if ((part == 0U) && (identify->pairs_left == 1U)) {
        next_phase(identify, IDENTIFY_COAST);
        identify->leads = false;
        identify->coast_ticks = (uint32_t)fx_max((int32_t)(COAST_MS_FIRST * identify->ms_ticks), (int32_t)(0x7FFFFFFF / (identify->top / 2)));
    } else if ((part % 2U) == 0U) {
        aim_ramp(identify, part == 0U);
        identify->step++;
    } else {
        aim_steady(identify);
        identify->step++;
    }
}

/* ---- COAST ---- */

#define COAST_WINDOWS (24U)

/* Windows grow while the speed falls slowly; it ends at half of the speed. */
static void plan_coast(identify_t *identify)
{
    const int64_t ticks = (int64_t)fx_max((int32_t)identify->aim.ticks, 1);
    const int32_t speed = (int32_t)(((int64_t)sums_of(identify)->turn_q16 * 4096) / ticks);

    if (identify->step == 2U) {
        identify->coast_speed = speed;
    }
    if ((identify->step > 2U) && (speed > (identify->coast_speed - (identify->coast_speed / 64))) && (identify->coast_ticks < (COAST_MS_MOST * identify->ms_ticks))) {
        identify->coast_ticks *= 2U;
    }
    if ((identify->step > 2U) && ((speed < (identify->coast_speed / 2)) || (identify->step > COAST_WINDOWS))) {
        next_phase(identify, IDENTIFY_DONE);
    } else {
        aim_current(identify, 0);
        *word(identify, PROBE_TRACKING) = 300000;
        *word(identify, PROBE_RAMP) = 0;
        aim_window(identify, "coast", (identify->step == 0U) ? 60U : 0U, identify->coast_ticks);
        identify->rushes = true;
        identify->step++;
    }
}

/* ---- the run of an experiment ---- */

static uint32_t passed(const identify_t *identify)
{
    return identify->app->drive.tick - identify->since;
}

static void wait_for(identify_t *identify, identify_wait_t wait)
{
    identify->wait = wait;
    identify->since = identify->app->drive.tick;
}

static void post(identify_t *identify, uint32_t which)
{
    const drive_command_t command = {
        .target = identify->aim.words[which],
        .mode = (uint8_t)(which + (uint32_t)PROBE_CURRENT),
        .request = DRIVE_REQUEST_PROBE,
    };

    command_mailbox_post(&identify->app->mailbox, &command);
    identify->in_force[which] = command.target;
}

/* The word that was posted last has reached the drive, and a tick has gone by. */
static bool is_taken(const identify_t *identify)
{
    const drive_command_t asked = command_mailbox_take(&identify->app->mailbox);
    const drive_command_t *const now = &identify->app->in.command;

    return (now->mode == asked.mode) && (now->target == asked.target) && (now->request == asked.request);
}

/* Posts the next word that is not in force. Returns whether there was none. */
static bool ask(identify_t *identify)
{
    bool done = true;

    for (uint32_t k = 0U; (k < (IDENTIFY_WORDS - 1U)) && done; k++) {
        if (identify->aim.words[k] != identify->in_force[k]) {
            post(identify, k);
            done = false;
        }
    }
    return done;
}

static bool has_arrived(const identify_t *identify)
{
    const probe_t *const probe = &identify->app->drive.probe;
    const angle_t angle = rotor_position_angle(&identify->app->drive.vector.position);

    return identify->rushes || ((probe->own_speed == probe->speed) && ((probe->speed != 0) || (angle == probe->angle)));
}

static void open_window(identify_t *identify)
{
    identify->windows++;
    identify->aim.words[IDENTIFY_WORDS - 1U] = (int32_t)(((identify->windows & 0x7FFU) << 20U) | identify->aim.ticks);
    post(identify, IDENTIFY_WORDS - 1U);
    wait_for(identify, IDENTIFY_MEASURING);
}

static void plan(identify_t *identify)
{
    switch (identify->phase) {
    case IDENTIFY_PULSE:
        plan_pulse(identify);
        break;
    case IDENTIFY_CATCH:
        plan_catch(identify);
        break;
    case IDENTIFY_STILL:
        plan_still(identify);
        break;
    case IDENTIFY_SPIN:
        plan_spin(identify);
        break;
    case IDENTIFY_RAMP:
        plan_ramp(identify);
        break;
    case IDENTIFY_COAST:
        plan_coast(identify);
        break;
    default:
        break;
    }
    if (identify->leads) {
        open_window(identify);
        wait_for(identify, IDENTIFY_LEADING);
    } else {
        identify->wait = IDENTIFY_ASKING;
    }
}

static void add(text_t *text, int32_t value)
{
    text_add(text, " ");
    text_number(text, value, 0U);
}

/* What the numbers of the records are: tick, full scales of current and bus, pole pairs, 2^this steps in Q15 of Ω_b. */
static void report_scales(const identify_t *identify, text_t *text)
{
    const about_t *const about = identify->about;

    text_add(text, "identify 1");
    add(text, (int32_t)about->rotation.tick_ps);
    add(text, (int32_t)about->current_full_scale_ua);
    add(text, (int32_t)about->bus_full_scale_uv);
    add(text, (int32_t)about->rotation.pole_pairs);
    add(text, (int32_t)cfg_of(identify)->speed_shift);
    text_end_line(text);
}

static void report(const identify_t *identify, text_t *text)
{
    const probe_sums_t *const s = sums_of(identify);
    const int32_t *const words = identify->aim.words;

    text_add(text, "= ");
    text_add(text, identify->aim.kind);
    add(text, (int32_t)identify->axis);
    add(text, words[0]);
    add(text, words[(uint32_t)PROBE_SPEED - (uint32_t)PROBE_CURRENT]);
    add(text, words[(uint32_t)PROBE_PULSE_D - (uint32_t)PROBE_CURRENT]);
    add(text, words[(uint32_t)PROBE_PULSE_Q - (uint32_t)PROBE_CURRENT]);
    add(text, words[(uint32_t)PROBE_PULSE_TICKS - (uint32_t)PROBE_CURRENT]);
    add(text, (int32_t)identify->aim.ticks);
    add(text, s->voltage.d);
    add(text, s->voltage.q);
    add(text, s->current.d);
    add(text, s->current.q);
    add(text, s->bus);
    add(text, s->noise_a);
    add(text, s->noise_b);
    add(text, s->change.d);
    add(text, s->change.q);
    add(text, s->carried);
    add(text, s->turn_q16);
    add(text, s->across);
    add(text, s->pull);
    text_end_line(text);
}

void identify_init(identify_t *identify, app_t *app, const about_t *about)
{
    *identify = (identify_t){.app = app, .about = about};
}

const char *identify_start(identify_t *identify)
{
    const uint32_t tick_ps = identify->about->rotation.tick_ps;

    identify_init(identify, identify->app, identify->about);
    identify->ms_ticks = (uint32_t)fx_max((int32_t)(MS_PS / tick_ps), 1);
    identify->phase = IDENTIFY_BEGINS;
    identify->in_force[(uint32_t)PROBE_PULSE_TICKS - (uint32_t)PROBE_CURRENT] = 1;
    begin_pulse(identify);
    post(identify, 0U);
    return NULL;
}

void identify_stop(identify_t *identify)
{
    commander_stop(identify->app);
    identify->phase = IDENTIFY_IDLE;
}

/* All words are in force. */
static void end_asking(identify_t *identify)
{
    if (identify->leads) {
        wait_for(identify, IDENTIFY_MEASURING);
    } else {
        wait_for(identify, IDENTIFY_MOVING);
    }
}

static void go_on(identify_t *identify, text_t *text)
{
    switch (identify->wait) {
    case IDENTIFY_ASKING:
        if (is_taken(identify) && ask(identify)) {
            end_asking(identify);
        }
        break;
    case IDENTIFY_LEADING:
        if (passed(identify) >= identify->aim.settle) {
            identify->wait = IDENTIFY_ASKING;
        }
        break;
    case IDENTIFY_MOVING:
        if ((passed(identify) > 2U) && has_arrived(identify)) {
            wait_for(identify, IDENTIFY_SETTLING);
        }
        break;
    case IDENTIFY_SETTLING:
        if (passed(identify) >= identify->aim.settle) {
            open_window(identify);
        }
        break;
    default: /* MEASURING */
        if (is_taken(identify) && probe_is_done(&identify->app->drive.probe, identify->in_force[IDENTIFY_WORDS - 1U])) {
            report(identify, text);
            plan(identify);
        }
        break;
    }
}

void identify_step(identify_t *identify, text_t *text)
{
    const drive_state_t state = identify->app->drive.state;

    if (identify->phase == IDENTIFY_BEGINS) {
        report_scales(identify, text);
        identify->phase = IDENTIFY_PULSE;
    } else if ((identify->phase == IDENTIFY_IDLE) || (state < DRIVE_STATE_PROBE)) {
        /* nothing is asked, or the drive is not there yet */
    } else if (state != DRIVE_STATE_PROBE) {
        refuse(identify, "a fault has ended it");
    } else if (identify->phase >= IDENTIFY_DONE) {
        identify_stop(identify);
    } else {
        go_on(identify, text);
    }
}
