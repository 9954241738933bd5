/* SPDX-License-Identifier: MIT */
#include "input.h"

#include "commander.h"
#include "throttle.h"

#include <stddef.h>

#define PULSES_MAX (64U) /* pulses of one pass; the rest waits for the next one */
#define Q15_ONE (32768)  /* also from Q30 to Q15 */

/* The button counts as pressed until it has been seen released. */
static void begin_input(input_t *input, uint32_t kind, uint32_t tick)
{
    *input = (input_t){.tick = tick,
                       .rest = tick,
                       .kind = (uint8_t)kind,
                       .voltage = {.tick = tick},
                       .button = {.raw = true, .pressed = true, .since = tick},
                       .guard = {.source = SOURCE_INPUT}};
    input_signal_init(&input->signal, tick);
}

void input_init(input_t *input)
{
    begin_input(input, (uint32_t)INPUT_KIND_NONE, 0U);
}

/* ---- readings ---- */

/* Stop and commands of DShot are the reading of an input at rest. */
static void take_frame(input_t *input, const input_cfg_t *cfg, uint32_t tick)
{
    const uint32_t value = input->dshot.frame.value;
    const uint32_t reading = (value < DSHOT_FIRST_THROTTLE) ? fx_unsigned(cfg->middle)
                                                            : ((value - DSHOT_FIRST_THROTTLE) + 1U);

    input_signal_good(&input->signal, reading, tick);
}

static void take_pulse(input_t *input, const input_cfg_t *cfg, const hal_pulse_t *pulse,
                       uint32_t tick)
{
    if (cfg->kind == (uint32_t)INPUT_KIND_RC_PULSE) {
        rc_pulse_take(&input->rc, pulse, cfg, &input->signal, tick);
    } else if (dshot_take(&input->dshot, pulse, &input->signal)) {
        take_frame(input, cfg, tick);
    } else {
        /* the frame goes on, or it was bad */
    }
}

/* The time is read first: a pulse that had ended before it does not wait any more. */
static void take_pulses(input_t *input, const input_cfg_t *cfg, hal_t *hal, uint32_t tick)
{
    const uint32_t time = hal_pulse_now(hal);
    hal_pulse_t pulse = {.start = 0U};
    bool more = true;

    for (uint32_t k = 0U; (k < PULSES_MAX) && more; k++) {
        more = hal_pulse(hal, &pulse);
        if (more) {
            take_pulse(input, cfg, &pulse, tick);
        }
    }
    if (!more && (cfg->kind == (uint32_t)INPUT_KIND_DSHOT) &&
        dshot_step(&input->dshot, time, &input->signal)) {
        take_frame(input, cfg, tick);
    }
}

static void take_reading(input_t *input, const drive_cfg_t *cfg, hal_t *hal, uint32_t tick)
{
    const input_cfg_t *const set = &cfg->input;

    if (set->kind == (uint32_t)INPUT_KIND_VOLTAGE) {
        const hal_inputs_t inputs = hal_inputs(hal);

        voltage_input_take(&input->voltage, &inputs, cfg->sampling.bus_shift, set, &input->signal,
                           tick);
    } else {
        take_pulses(input, set, hal, tick);
    }
    input_signal_step(&input->signal, tick, set->timeout_ticks);
}

/* ---- arming ---- */

static bool signal_is_lost(const input_t *input)
{
    return input->signal.lost != (uint8_t)INPUT_LOST_NOT;
}

static void disarm(input_t *input, uint32_t tick)
{
    source_guard_leave(&input->guard);
    input->state = (uint8_t)INPUT_WAITS;
    input->rest = tick;
    input->is_on = false;
}

/* Whether anything is asked of the drive, whoever has asked. */
static bool is_commanded(const app_t *app)
{
    return command_mailbox_take(&app->mailbox).request != 0U;
}

/*
 * A button that is held does not count when it is stuck. An enable may be held once it was pressed
 * after what has disarmed the input.
 */
static bool rests(input_t *input, const app_t *app, const input_cfg_t *cfg)
{
    const bool set_point = cfg->button == (uint32_t)INPUT_BUTTON_START_STOP;
    const bool held = input->button.pressed && !input->is_on;
    const bool noisy = input_signal_was_noisy(&input->signal);

    return !noisy && !signal_is_lost(input) && !held && (set_point || (input->share == 0)) &&
           !is_commanded(app);
}

/* ---- the button ---- */

/*
 * A stop of the button, whoever runs the motor. A measurement that waits for the winding to cool
 * asks nothing of the drive yet; it ends too, as it would turn the motor later. Returns whether
 * there was something to stop.
 */
static bool stop_by_button(input_t *input, app_t *app, identify_t *identify, uint32_t tick)
{
    const bool stops = is_commanded(app) || identify_is_busy(identify);

    if (stops) {
        identify_stop(identify);
        commander_stop(app, SOURCE_INPUT);
        disarm(input, tick);
    }
    return stops;
}

/* A press that has not started a run yet is taken back by the next one. */
static void press_button(input_t *input, app_t *app, identify_t *identify, const input_cfg_t *cfg,
                         uint32_t tick)
{
    const bool toggles = cfg->button == (uint32_t)INPUT_BUTTON_START_STOP;

    if (app->drive.state == DRIVE_STATE_FAULT) {
        (void)commander_clear(app, SOURCE_INPUT);
    } else if (!toggles || !stop_by_button(input, app, identify, tick)) {
        input->is_on = !toggles || ((input->state == (uint8_t)INPUT_ARMED) && !input->is_on);
    } else {
        /* it was a stop */
    }
}

/* The button of an enable opens the gates, whoever runs the motor. */
static void release_button(input_t *input, app_t *app, identify_t *identify, const input_cfg_t *cfg,
                           uint32_t tick)
{
    if (cfg->button == (uint32_t)INPUT_BUTTON_ENABLE) {
        (void)stop_by_button(input, app, identify, tick);
        input->is_on = false;
    }
}

static void step_button(input_t *input, const live_config_t *live, identify_t *identify,
                        const input_cfg_t *cfg, uint32_t tick)
{
    const bool raw = (cfg->button != (uint32_t)INPUT_BUTTON_NONE) && hal_inputs(live->hal).button;
    const bool was_pressed = input->button.pressed;
    const bool becomes_pressed =
        button_step(&input->button, raw, tick, units_ticks(&live->about.rotation, BUTTON_US));

    if (becomes_pressed) {
        press_button(input, live->app, identify, cfg, tick);
    } else if (was_pressed && !input->button.pressed) {
        release_button(input, live->app, identify, cfg, tick);
    } else {
        /* the button stays as it is */
    }
}

/* ---- command ---- */

/* Puts the demand in force as the target of the run, or of the next one. */
static void post_demand(const input_t *input, const live_config_t *live, const input_cfg_t *cfg)
{
    const int64_t demand_q15 = input->demand_q30 / Q15_ONE;
    app_t *const app = live->app;

    if (cfg->commands == (uint32_t)INPUT_COMMANDS_TORQUE) {
        const int32_t most = commander_torque_max(app);

        (void)commander_set_torque(app, SOURCE_INPUT, (int32_t)((demand_q15 * most) / Q15_ONE));
    } else {
        const step_t most = units_step(&live->about.rotation, live->about.speed_max_rpm);

        (void)commander_set_speed(app, SOURCE_INPUT, (int32_t)((demand_q15 * most) / Q15_ONE));
    }
}

/*
 * The demand begins at 0. It is in force before the run: an older target must not begin to decide.
 */
static void input_start_run(input_t *input, const live_config_t *live, const input_cfg_t *cfg)
{
    input->demand_q30 = 0;
    post_demand(input, live, cfg);
    if (commander_run(live->app, SOURCE_INPUT) == NULL) {
        source_guard_commanded(&input->guard);
        input->state = (uint8_t)INPUT_RUNS;
    }
}

/* The target follows the throttle; at rest the run ends once the motor is slow. */
static void follow(input_t *input, const live_config_t *live, const input_cfg_t *cfg, uint32_t tick)
{
    const int32_t wanted_q15 = throttle_curve(cfg, input->share);

    input->demand_q30 = throttle_slope(cfg, input->demand_q30, wanted_q15, tick - input->tick);
    post_demand(input, live, cfg);
    if ((input->share == 0) && (input->demand_q30 == 0) && source_guard_is_slow(live->app)) {
        const bool holds = input->is_on && (cfg->button == (uint32_t)INPUT_BUTTON_ENABLE);

        commander_stop(live->app, SOURCE_INPUT);
        disarm(input, tick);
        input->is_on = holds;
    }
}

static void wait_for_rest(input_t *input, const app_t *app, const input_cfg_t *cfg, uint32_t tick)
{
    if (!rests(input, app, cfg)) {
        input->rest = tick;
    } else if ((tick - input->rest) >= cfg->arm_ticks) {
        input->state = (uint8_t)INPUT_ARMED;
        input->rested = input->signal.count;
    } else {
        /* not long enough */
    }
}

/* A single reading starts nothing, and a run that cannot begin now must not begin later. */
static void wait_for_demand(input_t *input, const live_config_t *live, const input_cfg_t *cfg,
                            uint32_t tick)
{
    const bool may_run = (cfg->button == (uint32_t)INPUT_BUTTON_NONE) || input->is_on;
    const bool waits = !may_run && (cfg->button == (uint32_t)INPUT_BUTTON_START_STOP);
    const bool ready = (live->app->drive.state == DRIVE_STATE_READY) && !is_commanded(live->app);
    const bool can_begin = may_run && ready;
    const uint32_t moved = ((uint32_t)input->signal.count - input->rested) & UINT8_MAX;
    const bool asks = (input->share != 0) && !waits && (moved >= INPUT_SIGNAL_GOOD);
    const bool noisy = input_signal_was_noisy(&input->signal);

    if (noisy || signal_is_lost(input) || (asks && !can_begin)) {
        disarm(input, tick);
    } else if ((input->share == 0) || waits) {
        input->rested = input->signal.count;
    } else if (asks) {
        input_start_run(input, live, cfg);
    } else {
        /* not often enough */
    }
}

/* Returns the reason in the pass in which the drive begins to stop, else NULL. */
static const char *command(input_t *input, const live_config_t *live, identify_t *identify,
                           uint32_t tick)
{
    const input_cfg_t *const cfg = &live->in_force->cfg.input;
    const char *lost = NULL;

    if (commander_source(live->app) != SOURCE_INPUT) {
        disarm(input, tick);
    } else if (input->state == (uint8_t)INPUT_ENDS) {
        (void)source_guard_step(&input->guard, live->app, identify, tick, 0U);
    } else if (signal_is_lost(input)) {
        lost = input_signal_text(input->signal.lost);
        (void)source_guard_lose(&input->guard, live->app, identify, lost);
        input->state = (uint8_t)INPUT_ENDS;
        input->is_on = false;
    } else {
        follow(input, live, cfg, tick);
    }
    return lost;
}

/* Returns as input_step(). */
static const char *decide(input_t *input, const live_config_t *live, identify_t *identify,
                          uint32_t tick)
{
    const input_cfg_t *const cfg = &live->in_force->cfg.input;
    app_t *const app = live->app;
    const char *lost = NULL;

    if ((input->upsets != app->upsets) || identify_is_busy(identify)) {
        if (commander_source(app) == SOURCE_INPUT) {
            commander_stop(app, SOURCE_INPUT); /* nobody would follow this run */
        }
        disarm(input, tick);
    }
    input->share =
        signal_is_lost(input) ? 0 : throttle_share(cfg, input_signal_value(&input->signal));
    step_button(input, live, identify, cfg, tick);
    if (input->state == (uint8_t)INPUT_WAITS) {
        wait_for_rest(input, app, cfg, tick);
    } else if (input->state == (uint8_t)INPUT_ARMED) {
        wait_for_demand(input, live, cfg, tick);
    } else {
        lost = command(input, live, identify, tick);
    }
    input->upsets = app->upsets; /* what the input has done itself it has done above */
    return lost;
}

const char *input_step(input_t *input, const live_config_t *live, identify_t *identify,
                       uint32_t tick)
{
    const drive_cfg_t *const cfg = &live->in_force->cfg;
    const char *lost = NULL;

    if ((uint32_t)input->kind != cfg->input.kind) {
        begin_input(input, cfg->input.kind, tick);
    }
    if ((cfg->input.kind != (uint32_t)INPUT_KIND_NONE) && (tick != input->tick) &&
        (live->app->drive.cfg != NULL)) {
        take_reading(input, cfg, live->hal, tick);
        lost = decide(input, live, identify, tick);
        input->tick = tick;
    }
    return lost;
}

const char *input_text(const input_t *input)
{
    static const char *const states[] = {"has to be seen at rest", "armed", "runs the motor",
                                         "stops the motor"};
    const char *text = NULL;

    if (input->kind == (uint8_t)INPUT_KIND_NONE) {
        /* there is no input */
    } else if (signal_is_lost(input)) {
        text = input_signal_text(input->signal.lost);
    } else {
        text = states[input->state];
    }
    return text;
}
