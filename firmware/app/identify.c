/* SPDX-License-Identifier: MIT */
#include "identify_plan.h"

#include "commander.h"

#include <stddef.h>

#define MS_PS (1000000000U)
#define LOOP_SHARE (8U)     /* bandwidth of the current control: 1/8 a tick */
#define INTEGRAL_SHARE (5U) /* its integral is 5 times slower */
#define SOFT_SHARE (256U)   /* and across a current at rest another 256 times */
#define SOFT_GAIN (0x10000) /* K_p = 0, with a shift of 1 */
#define INTEGRAL_BITS (11U) /* by which the integral is finer, pi.h */
#define CURRENT_LEAST \
    (192) /* 24 counts of a converter of 12 bits: a quarter of it is still above its noise */
#define CURRENT_ONE (32768) /* I_b in Q15 */
#define NOISE_SHARE (16)    /* of the continuous current, mean change from sample to sample */

/* ---- what plans ask for ---- */

void identify_aim_current(identify_t *identify, int32_t current)
{
    *identify_word(identify, PROBE_CURRENT) = current;
    *identify_word(identify, PROBE_PULSE_D) = 0;
    *identify_word(identify, PROBE_PULSE_Q) = 0;
}

void identify_aim_window(identify_t *identify, const char *kind, uint32_t settle, uint32_t ticks)
{
    identify->aim.kind = kind;
    identify->aim.settle = settle;
    identify->aim.ticks = ticks;
}

/* A gain in Q32 as a word of PROBE_GAIN_D. */
static int32_t gain_word(uint64_t gain_q32)
{
    uint64_t mantissa = gain_q32;
    uint32_t shift = 32U;

    while ((mantissa > (uint64_t)FX_Q15_MAX) || (shift > 30U)) {
        mantissa >>= 1U;
        shift--;
    }
    return (int32_t)((shift << 16U) | (uint32_t)mantissa);
}

void identify_aim_gains(identify_t *identify, bool soft)
{
    const uint64_t kp_q32 =
        ((uint64_t)(uint32_t)identify->rest.inductance_q16 << 16U) / (uint64_t)LOOP_SHARE;
    const uint64_t ki_q32 = (kp_q32 << INTEGRAL_BITS) / (uint64_t)(LOOP_SHARE * INTEGRAL_SHARE);

    *identify_word(identify, PROBE_GAIN_D) = gain_word(kp_q32);
    *identify_word(identify, PROBE_INTEGRAL_D) = gain_word(ki_q32);
    *identify_word(identify, PROBE_GAIN_Q) = soft ? SOFT_GAIN : gain_word(kp_q32);
    *identify_word(identify, PROBE_INTEGRAL_Q) =
        gain_word(soft ? (ki_q32 / (uint64_t)SOFT_SHARE) : ki_q32);
}

void identify_next_phase(identify_t *identify, identify_phase_t phase)
{
    identify->phase = phase;
    identify->step = 0U;
}

void identify_refuse(identify_t *identify, const char *why)
{
    identify->why = why;
    identify_next_phase(identify, IDENTIFY_ENDS);
}

/* ---- the words of an experiment ---- */

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

/* The word that was posted last has reached the drive. */
static bool is_taken(const identify_t *identify)
{
    const drive_command_t asked = command_mailbox_take(&identify->app->mailbox);
    const drive_command_t *const now = &identify->app->in.command;

    return (now->mode == asked.mode) && (now->target == asked.target) &&
           (now->request == asked.request);
}

/* Posts the next word that is not in force, the window's left out. Returns whether all are. */
static bool ask(identify_t *identify)
{
    bool all = true;

    for (uint32_t k = 0U; (k < (IDENTIFY_WORDS - 1U)) && all; k++) {
        if (identify->aim.words[k] != identify->in_force[k]) {
            post(identify, k);
            all = false;
        }
    }
    return all;
}

/* Its word differs from those of the windows before. */
static void open_window(identify_t *identify)
{
    const uint32_t number = identify->windows & 0x7FFU;

    identify->windows++;
    *identify_word(identify, PROBE_WINDOW) =
        (int32_t)((number << PROBE_WINDOW_BITS) | identify->aim.ticks);
    post(identify, IDENTIFY_WORDS - 1U);
}

static bool is_measured(const identify_t *identify)
{
    return is_taken(identify) &&
           probe_is_done(&identify->app->drive.probe, identify->in_force[IDENTIFY_WORDS - 1U]);
}

static bool has_arrived(const identify_t *identify)
{
    const drive_t *const drive = &identify->app->drive;
    const probe_t *const probe = &drive->probe;
    const bool turns = (probe->own_speed == probe->speed) && (probe->speed != 0);
    const bool rests =
        (probe->own_speed == 0) && (rotor_position_angle(&drive->vector.position) == probe->angle);

    return identify->aim.rushes || turns || rests;
}

/* ---- lines ---- */

static void add(text_t *text, int32_t value)
{
    text_add(text, " ");
    text_number(text, value, 0U);
}

static void add_dq(text_t *text, dq_t value)
{
    add(text, value.d);
    add(text, value.q);
}

static void say_scales(const identify_t *identify, text_t *text)
{
    const about_t *const about = identify->about;

    text_add(text, "identify 1");
    add(text, (int32_t)about->rotation.tick_ps);
    add(text, (int32_t)about->current_full_scale_ua);
    add(text, (int32_t)about->bus_full_scale_uv);
    add(text, (int32_t)about->rotation.pole_pairs);
    add(text, (int32_t)identify->app->drive.cfg->speed_shift);
    text_end_line(text);
}

static void say_record(const identify_t *identify, text_t *text)
{
    static const probe_word_t shown[] = {PROBE_CURRENT, PROBE_SPEED, PROBE_PULSE_D, PROBE_PULSE_Q,
                                         PROBE_PULSE_TICKS};
    const probe_sums_t *const sums = identify_sums(identify);

    text_add(text, "= ");
    text_add(text, identify->aim.kind);
    add(text, (int32_t)identify->rest.axis);
    for (uint32_t k = 0U; k < (uint32_t)(sizeof(shown) / sizeof(shown[0])); k++) {
        add(text, identify->aim.words[(uint32_t)shown[k] - (uint32_t)PROBE_CURRENT]);
    }
    add(text, (int32_t)identify->aim.ticks);
    add_dq(text, sums->voltage);
    add_dq(text, sums->current);
    add(text, sums->bus);
    add(text, sums->noise_a);
    add(text, sums->noise_b);
    add_dq(text, sums->change);
    add(text, sums->carried);
    add(text, sums->turn_q16);
    add(text, sums->across);
    add(text, sums->pull);
    text_end_line(text);
}

static void add_current(const identify_t *identify, text_t *text, int32_t current)
{
    const uint32_t base_ua = 2U * identify->about->current_full_scale_ua;

    text_number(text, units_thousandths(current, CURRENT_ONE, base_ua), 3U);
    text_add(text, " A");
}

/* Before each phase: what it will do, with which current and speed. */
static void say_phase(const identify_t *identify, text_t *text)
{
    const int32_t current = identify_continuous(identify);

    switch (identify->phase) {
    case IDENTIFY_PULSE:
        text_add(text, "pulses on each phase, the shaft rests, up to ");
        add_current(identify, text, current);
        break;
    case IDENTIFY_CATCH:
        text_add(text, "the shaft turns by up to one electrical turn, with ");
        add_current(identify, text, current);
        break;
    case IDENTIFY_STILL:
        text_add(text, "the shaft goes to three angles, up to ");
        add_current(identify, text, identify_largest_still(identify));
        break;
    case IDENTIFY_SPIN:
        text_add(text, "the shaft turns, up to ");
        text_number(text, units_rpm(&identify->about->rotation, identify_top_speed(identify)), 0U);
        text_add(text, " rpm, with ");
        add_current(identify, text, identify_spin_current(identify));
        break;
    case IDENTIFY_RAMP:
        text_add(text, "between half of that speed and the whole");
        break;
    case IDENTIFY_COAST:
        text_add(text, "no current, the shaft coasts");
        break;
    default: /* the end */
        text_add(text, (identify->why == NULL) ? "identify done" : "identify refused: ");
        text_add(text, (identify->why == NULL) ? "" : identify->why);
        break;
    }
    text_end_line(text);
}

/* ---- the run of an experiment ---- */

static bool plan_in_phase(identify_t *identify)
{
    bool aims = true; /* nothing more is to be planned */

    switch (identify->phase) {
    case IDENTIFY_PULSE:
        aims = identify_plan_pulse(identify);
        break;
    case IDENTIFY_CATCH:
        aims = identify_plan_catch(identify);
        break;
    case IDENTIFY_STILL:
        aims = identify_plan_still(identify);
        break;
    case IDENTIFY_SPIN:
        aims = identify_plan_spin(identify);
        break;
    case IDENTIFY_RAMP:
        aims = identify_plan_ramp(identify);
        break;
    case IDENTIFY_COAST:
        aims = identify_plan_coast(identify);
        break;
    default: /* it ends */
        break;
    }
    return aims;
}

static void plan(identify_t *identify)
{
    while (!plan_in_phase(identify)) {
        /* the next phase plans */
    }
    if (identify->aim.leads) {
        open_window(identify);
        wait_for(identify, IDENTIFY_LEADING);
    } else {
        wait_for(identify, IDENTIFY_ASKING);
    }
}

/* Largest mean change of a sensor from sample to sample that leaves a result, Q15 of I_b. */
static int32_t noise_most(const identify_t *identify)
{
    return identify_continuous(identify) / NOISE_SHARE;
}

/* Pulses and what turns change the current themselves. */
static bool is_noisy(const identify_t *identify)
{
    const probe_sums_t *const sums = identify_sums(identify);
    const int32_t noise = fx_max(sums->noise_a, sums->noise_b) / (int32_t)identify->aim.ticks;

    return (identify->phase == IDENTIFY_CATCH) && (noise > noise_most(identify));
}

static void end_experiment(identify_t *identify, text_t *text)
{
    say_record(identify, text);
    if (is_noisy(identify)) {
        identify_refuse(identify,
                        "the noise of the current sensors is too large for the continuous current");
    } else {
        plan(identify);
    }
}

static void go_on(identify_t *identify, text_t *text)
{
    switch (identify->wait) {
    case IDENTIFY_LEADING:
        if (passed(identify) >= identify->aim.settle) {
            wait_for(identify, IDENTIFY_ASKING);
        }
        break;
    case IDENTIFY_ASKING:
        if (is_taken(identify) && ask(identify)) {
            wait_for(identify, identify->aim.leads ? IDENTIFY_MEASURING : IDENTIFY_MOVING);
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
            wait_for(identify, IDENTIFY_MEASURING);
        }
        break;
    default: /* MEASURING */
        if (is_measured(identify)) {
            end_experiment(identify, text);
        }
        break;
    }
}

void identify_init(identify_t *identify, app_t *app, const about_t *about)
{
    *identify = (identify_t){.app = app, .about = about};
}

/* The words that probe_reset() leaves. */
static void begin(identify_t *identify)
{
    const uint32_t ticks = MS_PS / identify->about->rotation.tick_ps;
    const uint32_t pulse_ticks = (uint32_t)PROBE_PULSE_TICKS - (uint32_t)PROBE_CURRENT;
    const uint32_t emf = (uint32_t)PROBE_EMF - (uint32_t)PROBE_CURRENT;

    identify_init(identify, identify->app, identify->about);
    identify->ms_ticks = (ticks > 0U) ? ticks : 1U;
    identify->in_force[pulse_ticks] = 1;
    identify->in_force[emf] = 1;
    identify->aim.words[emf] = 1;
    identify_next_phase(identify, IDENTIFY_BEGINS);
}

const char *identify_start(identify_t *identify)
{
    const char *why = NULL;

    if (identify->app->drive.state != DRIVE_STATE_READY) {
        why = "the drive is not READY";
    } else if (identify_continuous(identify) < CURRENT_LEAST) {
        why =
            "the continuous current is below 1.2 % of the converter's range: nothing would be seen";
    } else {
        begin(identify);
    }
    return why;
}

bool identify_is_busy(const identify_t *identify)
{
    return identify->phase != IDENTIFY_IDLE;
}

void identify_stop(identify_t *identify)
{
    if (identify_is_busy(identify)) {
        commander_stop(identify->app);
        identify->phase = IDENTIFY_IDLE;
    }
}

/* The scales, then the first plan: its words are for a drive in PROBE. */
static void start_probing(identify_t *identify, text_t *text)
{
    say_scales(identify, text);
    identify_next_phase(identify, IDENTIFY_PULSE);
    plan(identify);
    post(identify, 0U);
}

/* A new phase is said before anything else. */
static void say_or_go_on(identify_t *identify, text_t *text)
{
    if (identify->said != identify->phase) {
        identify->said = identify->phase;
        say_phase(identify, text);
        if (identify->phase == IDENTIFY_ENDS) {
            identify_stop(identify);
        }
    } else {
        go_on(identify, text);
    }
}

void identify_step(identify_t *identify, text_t *text)
{
    const drive_state_t state = identify->app->drive.state;

    if (identify->phase == IDENTIFY_IDLE) {
        /* nothing is asked */
    } else if (identify->phase == IDENTIFY_BEGINS) {
        start_probing(identify, text);
    } else if (state == DRIVE_STATE_PROBE) {
        say_or_go_on(identify, text);
    } else if (state == DRIVE_STATE_FAULT) {
        identify_refuse(identify, "a fault has ended it");
        say_or_go_on(identify, text);
    } else {
        /* READY: the first word has not been taken yet */
    }
}
