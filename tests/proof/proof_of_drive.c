/* SPDX-License-Identifier: MIT */
/*
 * One step of the drive from any state within the ranges of state.def, with any valid configuration
 * and any frame, ends within them, and drive_init begins there: an induction over the ticks. Read
 * by Eva, see proof.py.
 */
#include "firmware.h"

#include "any_frame.h"

#include <__fc_builtin.h>

/*
 * The word from there is still within the configuration; that the byte is the first of one is not
 * needed.
 */
#define GUARD_AT_MAX (sizeof(drive_cfg_t) - sizeof(uint32_t) - 1U)

static drive_cfg_t cfg;
static drive_cfg_t before; /* of a change */
static drive_t drive;
static drive_in_t in;
static drive_out_t out;

/*@ requires lowest <= value <= highest;
    assigns \nothing; */
void within(int64_t value, int64_t lowest, int64_t highest);

/* Eva prints their arguments. */
/*@ assigns \nothing; */
void Frama_C_show_each_range(int64_t value);
/*@ assigns \nothing; */
void Frama_C_show_each_out(uint16_t phase_a, uint16_t phase_b, uint16_t phase_c, bool gate_enable);

/* Any words: what no list names is free. */
static void choose_words(uint32_t *words, uint32_t size)
{
    /*@ loop unroll 400; */
    for (uint32_t k = 0U; k < (size / sizeof(uint32_t)); k++) {
        words[k] = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    }
}

static void choose_configuration(void)
{
    choose_words((uint32_t *)&cfg, sizeof(cfg));
#define CFG(path, when, lo, hi, quantity, meaning) cfg.path = Frama_C_long_long_interval(lo, hi);
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) CFG(path, when, lo, hi, , )
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning)
#include "cfg.def"
#undef CFG
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
}

static void choose_startup(void)
{
#define CFG(path, when, lo, hi, quantity, meaning)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) \
    cfg.path = Frama_C_long_long_interval(lo, hi);
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    CFG_STARTUP(path, when, lo_startup, hi, , )
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning)
#include "cfg.def"
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
    if (cfg.startup.current_hold == 0) {
        cfg.startup.current_hold = 1;
    }
}

static void choose_voltage_drive(void)
{
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) \
    cfg.path = Frama_C_long_long_interval(lo, hi);
#include "cfg.def"
}

/*
 * Each of the states from number `first` to number `last`. A set of their codes: what lies between
 * them is no state.
 */
static drive_state_t any_state(uint32_t first, uint32_t last)
{
    return transitions_state(Frama_C_unsigned_int_interval(first, last));
}

static void choose_state(void)
{
    choose_words((uint32_t *)&drive, sizeof(drive));
    drive.cfg = &cfg;
#define FREE(path, quantity)
#define FIELD(path, lowest, highest, quantity) \
    drive.path = Frama_C_long_long_interval(lowest, highest);
#include "state.def"
#undef FIELD
    drive.rotor.position.turns_q32 = Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
    drive.vector.position.turns_q32 = Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
    drive.rotor.angle_sensor.position.turns_q32 = Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
    drive.motion.position_loop.profile_q32 = Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
    drive.motion.position_loop.zero_q32 = Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
    drive.state = any_state(0U, DRIVE_STATES - 1U);
    drive.state_guard.state = Frama_C_interval(DRIVE_STATE_INIT, DRIVE_STATE_FAULT);
    drive.guard.at = Frama_C_unsigned_int_interval(0U, GUARD_AT_MAX);
}

/* The state is one, code for code. */
static void check_code(void)
{
    /*@ split drive.state; */
    within(transitions_is_state(drive.state), 1, 1);
}

static void check_state(void)
{
#define FIELD(path, lowest, highest, quantity) \
    Frama_C_show_each_range(drive.path); \
    within(drive.path, lowest, highest);
#include "state.def"
    within(drive.cfg == &cfg, 1, 1);
    within(drive.guard.at, 0, GUARD_AT_MAX);
    check_code();
}

static void step(void)
{
    in = any_frame();
    drive_step(&drive, &in, &out);
    check_state();
    Frama_C_show_each_out(out.compare.phase[0], out.compare.phase[1], out.compare.phase[2],
                          out.gate_enable);
}

/*
 * Where a regulator alone makes the voltage: what is configured of the voltage drive is free, as it
 * is not read.
 */
static void choose_regulated(void)
{
    cfg.voltage_drive.enabled = 0U;
    choose_state();
    drive.voltage_drive.active = false;
}

static void check_regulated(void)
{
    within(drive.voltage_drive.active, 0, 0);
}

/*
 * Without a start-up its states are never entered, and what is configured of it is free, as it is
 * not read.
 */
static void step_without_startup(void)
{
    switch (Frama_C_interval(0, 2)) {
    case 1:
        drive.state = DRIVE_STATE_PROBE;
        break;
    case 2:
        drive.state = any_state(DRIVE_STATES - 2U, DRIVE_STATES - 1U); /* RUN, FAULT */
        break;
    default: /* INIT, OFFSET_CAL, READY */
        drive.state = any_state(0U, 2U);
        break;
    }
    step();
    if ((drive.state > DRIVE_STATE_READY) && (drive.state != DRIVE_STATE_PROBE)) {
        within(drive.state, DRIVE_STATE_RUN, DRIVE_STATE_FAULT);
    }
}

/*
 * Any configuration of the ranges, whatever parts are in use: where all of the inductions below
 * begin.
 */
void proof_init(void)
{
    choose_configuration();
    drive_init(&drive, &cfg);
    drive_warm(&drive, Frama_C_interval(0, DERATING_HEAT_MAX_Q24));
    check_state();
    check_regulated();
    within(drive.state, DRIVE_STATE_INIT, DRIVE_STATE_INIT);
    within(current_reference_torque_max(&cfg.current_reference, &cfg.current_loop,
                                        cfg.derating.current_max),
           0, CURRENT_REFERENCE_TORQUE_MAX); /* what a user may ask for */
}

/* With a sensor or with none. */
void proof_startup(void)
{
    choose_configuration();
    choose_startup();
    choose_voltage_drive();
    choose_state();
    step();
}

void proof_startup_regulated(void)
{
    choose_configuration();
    choose_startup();
    choose_regulated();
    step();
    check_regulated();
}

static void choose_plain(void)
{
    choose_configuration();
    cfg.startup.current_hold = 0;
    cfg.sampling.sensor_pole_pairs = 0U;
}

/* An observer beside a sensor has a start-up, see config_check.c, and so has an encoder. */
static void choose_sensed(void)
{
    choose_configuration();
    cfg.startup.current_hold = 0;
    cfg.observer.eta = 0;
    cfg.sensor.observer_above = 0;
    cfg.sensor.kind = (Frama_C_interval(0, 1) != 0)
                          ? SENSOR_KIND_ABSOLUTE
                          : Frama_C_unsigned_int_interval(0U, SENSOR_KIND_HALL);
}

/* First without a sensor, then with one or none. */
void proof_plain(void)
{
    choose_plain();
    choose_voltage_drive();
    choose_state();
    step_without_startup();
    choose_sensed();
    choose_voltage_drive();
    choose_state();
    step_without_startup();
}

void proof_plain_regulated(void)
{
    choose_plain();
    choose_regulated();
    step_without_startup();
    check_regulated();
    choose_sensed();
    choose_regulated();
    step_without_startup();
    check_regulated();
}

/*
 * From a code that is no state, with any configuration: between each state and the next one, and
 * beyond the last. One interval after the other, as none of the codes between two states is one of
 * them.
 */
void proof_no_state(void)
{
    choose_configuration();
    if (Frama_C_interval(0, 1) != 0) {
        choose_startup();
    } else {
        cfg.startup.current_hold = 0;
    }
    choose_voltage_drive();
    /*@ loop unroll 11; */
    for (uint32_t k = 0U; k < DRIVE_STATES; k++) {
        const uint32_t first = (uint32_t)transitions_state(k) + 1U;
        const uint32_t last =
            (k < (DRIVE_STATES - 1U)) ? ((uint32_t)transitions_state(k + 1U) - 1U) : UINT32_MAX;

        choose_state();
        drive.state = (drive_state_t)Frama_C_unsigned_int_interval(first, last);
        step();
        within(drive_is_driving(drive.state), 0, 0);
    }
}

/*
 * What a flipped bit leads to, from words that no tick makes; called by itself, as the tick that
 * finds it may be a later one.
 */
void proof_flipped(void)
{
    config_guard_t guard;
    fault_t fault;

    choose_configuration();
    choose_voltage_drive();
    choose_state();
    choose_words((uint32_t *)&drive.start.align, sizeof(drive.start.align));
    choose_words((uint32_t *)&drive.start.flying_start, sizeof(drive.start.flying_start));
    choose_words((uint32_t *)&drive.safe_state, sizeof(drive.safe_state));
    drive.motion.speed_loop.halvings = Frama_C_unsigned_int_interval(0U, UINT32_MAX);
    (void)holds_choices(&drive);
    choose_words((uint32_t *)&guard, sizeof(guard));
    (void)config_guard_step(&guard, &cfg, &fault);
    within(guard.at, 0, GUARD_AT_MAX);
    cfg.slow_ticks = Frama_C_unsigned_int_interval(0U, UINT8_MAX);
    within(slow_period(&cfg), SLOTS, UINT8_MAX);
    choose_configuration();
    drive_init(&drive, &cfg);
    check_state();
}

/*
 * From any state, with any two configurations: it ends within the ranges from which the steps go
 * on.
 */
static void change(void)
{
    drive.cfg = &before;
    drive_change(&drive, &cfg);
    check_state();
}

void proof_change(void)
{
    choose_configuration();
    before = cfg;
    choose_configuration();
    choose_state();
    change();
}

void proof_change_regulated(void)
{
    choose_configuration();
    before = cfg;
    choose_configuration();
    choose_regulated();
    change();
    check_regulated();
}
