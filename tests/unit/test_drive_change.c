/* SPDX-License-Identifier: MIT */
/*
 * Another configuration while the drive runs: what it keeps, what it computes anew, and when it
 * begins anew.
 */
#include "any_state.h"
#include "config_change.h"
#include "config_check.h"
#include "drive_words.h"
#include "driven_motor.h"
#include "motor.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define FAST_RPM (600.0)
#define LOAD_NM (4.0)
#define PATIENCE_TICKS (40000U) /* 4 s: more than any state lasts here */
#define SETTLED_TICKS (20000U)
#define GUARD_TICKS (2U * CONFIG_GUARD_STEPS * 40U) /* one word in each fourth slow period */
#define STATES (20000)

typedef struct {
    const char *path;
    size_t offset;
    int32_t lo;
    int32_t hi;
} row_t;

#define RUN(path, lo, hi) {#path, offsetof(drive_cfg_t, path), lo, hi},
#define REST(path, lo, hi)
#define CFG(path, when, lo, hi, quantity, meaning) when(path, lo, hi)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) when(path, lo, hi)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) when(path, lo_startup, hi)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) when(path, lo, hi)
static const row_t RUN_ROWS[] = {
#include "cfg.def"
};

static drive_cfg_t other;
static seeded_t seed;

static void begin(void)
{
    power_on();
    other = cfg;
}

void setUp(void)
{
    seed = (seeded_t){0xC4A6EU};
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    begin();
}

/* To the tick that enters `state`. */
static void go_to(drive_state_t state)
{
    in.command.request = (state == DRIVE_STATE_PROBE) ? DRIVE_REQUEST_PROBE : DRIVE_REQUEST_RUN;
    in.command.target = (state <= DRIVE_STATE_HOLD) ? 0 : (int32_t)lround(FAST_RPM * STEPS_PER_RPM);
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.state != state); k++) {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(state, drive.state);
}

static void run_loaded(void)
{
    go_to(DRIVE_STATE_RUN);
    ticks(SETTLED_TICKS);
    load_nm = LOAD_NM;
    ticks(SETTLED_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
}

static void change(void)
{
    other.crc = config_guard_crc(&other);
    TEST_ASSERT_NULL(config_check(&other));
    drive_change(&drive, &other);
}

static int32_t scaled(int32_t value, double factor)
{
    return (int32_t)lround((double)value * factor);
}

/* ---- what it does not touch ---- */

TEST(test_the_same_configuration_changes_nothing_but_its_place)
{
    static const drive_state_t states[] = {
        DRIVE_STATE_READY,   DRIVE_STATE_PROBE,    DRIVE_STATE_FLYING_START, DRIVE_STATE_ALIGN,
        DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN};

    for (size_t i = 0U; i < COUNT(states); i++) {
        drive_t before;

        setUp();
        go_to(states[i]);
        before = drive;
        change();
        TEST_ASSERT_EQUAL_PTR(&other, drive.cfg);
        before.cfg = drive.cfg;
        TEST_ASSERT_EQUAL_MEMORY(&before, &drive, sizeof drive);
    }
}

/*
 * What a recording says of a change is its CRC: whoever follows the drive by its inputs sees none
 * here.
 */
TEST(test_the_same_configuration_leaves_the_hash_of_the_state)
{
    const drive_t before = drive;

    change();
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&before), drive_words_hash(&drive));
}

TEST(test_the_guard_accepts_the_new_configuration_wherever_it_was)
{
    ticks(GUARD_TICKS / 3U);
    TEST_ASSERT_TRUE(drive.guard.at > 0U);
    other.speed_loop.ramp++;
    change();
    ticks(GUARD_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    other.speed_loop.ramp++; /* and still finds a word that is not what its checksum says */
    ticks(GUARD_TICKS);
    TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, drive.fault.id);
}

/* ---- what it computes anew ---- */

TEST(test_limits_are_in_force_at_once)
{
    other.protection.bus_max = 20000;
    other.protection.bus_min = 1000;
    change();
    TEST_ASSERT_EQUAL_INT32(20000, drive.limits.bus_max);
    TEST_ASSERT_EQUAL_INT32(0, drive.limits.bus_min); /* not while the gates are open */
    tick();
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, drive.fault.id); /* 310 V are 22573 */
    setUp();
    go_to(DRIVE_STATE_RUN);
    other.protection.current_max = 9000;
    other.protection.bus_min = 1000;
    change();
    TEST_ASSERT_EQUAL_INT32(9000, drive.limits.current_max);
    TEST_ASSERT_EQUAL_INT32(1000, drive.limits.bus_min);
}

static const model_measured_t MEASURED = {
    .resistance_q13 = 2200, .inductance_q14 = 18000, .saliency_q13 = 9500};

static void measure_model(void)
{
    motor_set(&drive.motor, &cfg, &MEASURED);
    drive.motor.model.flux_q30 = 0x3C000000; /* 15/16, within the limits of ±1/4 */
}

static void scale_motor(double factor)
{
    current_loop_cfg_t *const loops[] = {&other.current_loop, &other.hold_loop};

    for (size_t i = 0U; i < COUNT(loops); i++) {
        loops[i]->resistance_q13 = scaled(loops[i]->resistance_q13, factor);
        loops[i]->reactance_d_q13 = scaled(loops[i]->reactance_d_q13, factor);
        loops[i]->reactance_q_q13 = scaled(loops[i]->reactance_q_q13, factor);
        loops[i]->emf_q13 = scaled(loops[i]->emf_q13, factor);
    }
    other.observer.decay = scaled(other.observer.decay, factor);
    other.observer.flux_q27 = scaled(other.observer.flux_q27, factor);
}

/* A ratio is rounded down after it was rounded to Q14: two LSB of the number. */
static void assert_times(int32_t expected, double ratio, int32_t value)
{
    TEST_ASSERT_INT32_WITHIN(2, (int32_t)lround((double)expected * ratio), value);
}

TEST(test_what_was_measured_stays_as_a_ratio_to_the_new_values)
{
    model_t before;

    measure_model();
    before = drive.motor.model;
    scale_motor(1.05);
    change();
    TEST_ASSERT_EQUAL_INT32(before.resistance_q14, drive.motor.model.resistance_q14);
    TEST_ASSERT_EQUAL_INT32(before.inductance_q14, drive.motor.model.inductance_q14);
    TEST_ASSERT_EQUAL_INT32(before.inductance_inverse_q14,
                            drive.motor.model.inductance_inverse_q14);
    TEST_ASSERT_EQUAL_INT32(before.saliency_q14, drive.motor.model.saliency_q14);
    TEST_ASSERT_EQUAL_INT32(before.flux_q30, drive.motor.model.flux_q30);
    assert_times(other.current_loop.resistance_q13, before.resistance_q14 / 16384.0,
                 drive.motor.model.run_loop.resistance_q13);
    assert_times(other.current_loop.reactance_d_q13, before.inductance_q14 / 16384.0,
                 drive.motor.model.run_loop.reactance_d_q13);
    assert_times(other.current_loop.emf_q13, 15.0 / 16.0, drive.motor.model.hold_loop.emf_q13);
    assert_times(other.current_loop.pi_d.kp, before.inductance_q14 / 16384.0,
                 drive.motor.model.run_loop.pi_d.kp);
}

/* Each part that keeps something of the configuration, or in its scale, is told. */
TEST(test_every_part_takes_the_change_over)
{
    static const struct {
        const char *name;
        size_t offset;
    } kept[] = {
        {"model", offsetof(drive_t, motor.model.run_loop.pi_d.kp)},
        {"modulator", offsetof(drive_t, modulator.dead_time_q15)},
        {"heat", offsetof(drive_t, derating.heat_q24)},
        {"inertia", offsetof(drive_t, motion.speed_loop.inertia_q17)},
    };
    drive_t before;

    drive.derating.heat_q24 = 8000000;
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    drive.motion.speed_loop.inertia_q17 = 500000;
    before = drive;
    other.current_loop.pi_d.kp /= 2;
    other.modulator.dead_time_q15++;
    other.derating.heat_gain /= 2;
    other.speed_loop.inertia_most_q13 = 8192;
    change();
    for (size_t i = 0U; i < COUNT(kept); i++) {
        TEST_ASSERT_TRUE_MESSAGE(memcmp((char *)&before + kept[i].offset,
                                        (char *)&drive + kept[i].offset, sizeof(int32_t)) != 0,
                                 kept[i].name);
    }
}

/* ---- a measurement that is under way ---- */

/*
 * Whatever has changed: with other pulses its sums would be of both, and what was pulsed to one
 * side would not be pulsed back.
 */
TEST(test_an_alignment_measures_again)
{
    go_to(DRIVE_STATE_ALIGN);
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.start.align.phase != ALIGN_INDUCTANCE);
         k++) {
        tick();
    }
    ticks(5U);
    other.startup.ramp++;
    change();
    TEST_ASSERT_EQUAL_INT(ALIGN_PULL, drive.start.align.phase);
    TEST_ASSERT_EQUAL_INT32(0, drive.start.align.high.current);
    TEST_ASSERT_EQUAL_INT32(drive.control.current_ref.d, drive.start.align.current_ref);
    go_to(DRIVE_STATE_HOLD);
    TEST_ASSERT_INT32_WITHIN(164, 16384,
                             drive.motor.model.inductance_q14); /* within 1 %, as without */
}

TEST(test_a_rotor_that_is_pulled_is_pulled_on)
{
    align_t before;

    go_to(DRIVE_STATE_ALIGN);
    ticks(20U);
    before = drive.start.align;
    other.startup.ramp++;
    change();
    TEST_ASSERT_EQUAL_MEMORY(&before, &drive.start.align, sizeof before);
}

TEST(test_a_flying_start_looks_again)
{
    go_to(DRIVE_STATE_FLYING_START);
    for (uint32_t k = 0U;
         (k < PATIENCE_TICKS) && (drive.start.flying_start.phase != FLYING_START_SECOND_PULSE);
         k++) {
        tick();
    }
    other.startup.ramp++;
    change();
    TEST_ASSERT_EQUAL_INT(FLYING_START_PRELOAD, drive.start.flying_start.phase);
    TEST_ASSERT_FALSE(drive.start.flying_start.gates);
    go_to(DRIVE_STATE_RUN);
}

/* ---- nothing jumps ---- */

/* Voltage and current of the next tick, with the configuration of before and with the new one. */
typedef struct {
    dq_t voltage;
    dq_t current; /* of the network */
} next_t;

static next_t next_tick_of(drive_t copy)
{
    drive_out_t ignored = out;

    example_motor_measure(&motor, &in);
    drive_step(&copy, &in, &ignored);
    return (next_t){copy.control.voltage, copy.rotor.observer.current};
}

/*
 * A motor that is 10 % another one. Without the integrals the voltage would jump by a tenth of R·i
 * + ω·φ, 4 V or 300 LSB. What is left are six products that are rounded down.
 */
#define JUMP_MAX (6)
/*
 * The network's current changes by what its weights do in one tick: a tenth of ω·φ·T/L, 0.042 A or
 * 34 LSB at 600 rpm, a tenth of R·i·T/L, 5 LSB, and the roundings of its states.
 */
#define NETWORK_MAX (42)

static void assert_near(int32_t limit, dq_t expected, dq_t value)
{
    TEST_ASSERT_INT32_WITHIN(limit, expected.d, value.d);
    TEST_ASSERT_INT32_WITHIN(limit, expected.q, value.q);
}

static void assert_no_jump(double factor)
{
    next_t before;
    next_t after;

    run_loaded();
    before = next_tick_of(drive);
    scale_motor(factor);
    change();
    after = next_tick_of(drive);
    assert_near(JUMP_MAX, before.voltage, after.voltage);
    assert_near(NETWORK_MAX, before.current, after.current);
}

TEST(test_with_other_values_of_the_motor_voltage_and_network_do_not_jump)
{
    assert_no_jump(1.1);
    setUp();
    assert_no_jump(0.9);
}

TEST(test_with_another_saliency_the_network_does_not_jump)
{
    dq_t before;

    run_loaded();
    before = next_tick_of(drive).current;
    other.observer.saliency_q13 = scaled(8192, 1.05);
    other.observer.iq_gain_q14 = scaled(16384, 1.0 / 1.05);
    change();
    assert_near(NETWORK_MAX, before, next_tick_of(drive).current);
}

TEST(test_an_imposed_current_does_not_jump)
{
    dq_t before;

    go_to(DRIVE_STATE_IF_RAMP);
    ticks(100U);
    before = next_tick_of(drive).voltage;
    scale_motor(1.1);
    change();
    assert_near(JUMP_MAX, before, next_tick_of(drive).voltage);
}

/*
 * A filter that comes into force holds the torque current of now, not that of the beginning of RUN.
 */
TEST(test_a_torque_filter_begins_with_the_present_torque)
{
    int32_t torque;

    run_loaded();
    torque = drive.control.current_ref.q;
    TEST_ASSERT_TRUE(abs(drive.motion.torque_filter.origin - torque) > 1000);
    other.torque_filter.smooth_rate_q15 = 3000;
    change();
    TEST_ASSERT_EQUAL_INT32(torque, drive.motion.torque_filter.origin);
    TEST_ASSERT_EQUAL_INT32(torque * 2048, drive.motion.torque_filter.smooth_q26);
    drive.motion.torque_filter.smooth_q26 = 1; /* a filter that stays goes on */
    cfg = other;
    cfg.speed_loop.ramp++;
    cfg.crc = config_guard_crc(&cfg);
    drive_change(&drive, &cfg);
    TEST_ASSERT_EQUAL_INT32(1, drive.motion.torque_filter.smooth_q26);
}

/* Nothing limits the current there, so it begins again by itself when all is calm. */
TEST(test_a_voltage_drive_goes_back_to_current_control)
{
    dq_t voltage;

    cfg = example_drive_cfg();
    cfg.voltage_drive = example_voltage_drive_cfg();
    cfg.current_reference.floor = 0;
    begin();
    go_to(DRIVE_STATE_RUN);
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && !drive.voltage_drive.active; k++) {
        tick();
    }
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    ticks(100U);
    voltage = drive.control.voltage;
    other.voltage_drive.pi.kp = scaled(other.voltage_drive.pi.kp, 1.1);
    change();
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    tick();
    /* the proportional part: 1/8 A off its mean, 100 LSB, times ω_c·L of 3.2 U_b/I_b */
    assert_near(400, voltage, drive.control.voltage);
    ticks(SETTLED_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
}

/* ---- settings for which it begins anew ---- */

TEST(test_a_setting_of_rest_makes_a_drive_at_rest_calibrate_again)
{
    const uint32_t tick_before = drive.tick;
    const uint32_t left = drive.slow_count;

    drive.derating.heat_q24 = 1234567;
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    drive.motor.identified = true;
    state_guard_keep_measured(&drive.state_guard, &drive);
    other.sampling.offset_log2 = 4U;
    TEST_ASSERT_NOT_NULL(config_change_refused(&cfg, &other));
    change();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_INIT, drive.state);
    TEST_ASSERT_EQUAL_UINT32(tick_before, drive.tick);
    TEST_ASSERT_EQUAL_UINT32(left, drive.slow_count);
    TEST_ASSERT_EQUAL_INT32(1234567, drive.derating.heat_q24);
    TEST_ASSERT_FALSE(drive.motor.identified);
    ticks(17U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
}

TEST(test_a_shorter_slow_period_is_not_exceeded)
{
    cfg.slow_ticks = 100U;
    begin();
    drive.slow_count = 100U;
    other.slow_ticks = 6U;
    change();
    TEST_ASSERT_EQUAL_UINT32(6U, drive.slow_count);
}

TEST(test_in_run_it_opens_the_gates)
{
    go_to(DRIVE_STATE_RUN);
    ticks(100U);
    other.speed_shift++;
    change();
    tick();
    TEST_ASSERT_FALSE(out.gate_enable);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
}

/* A fast rotor is shorted instead; the drive begins anew when it is slow. */
TEST(test_in_run_it_shorts_a_motor_that_is_too_fast_for_open_gates)
{
    cfg.safe_state = example_safe_state_cfg(1, 32767, 50U);
    begin();
    go_to(DRIVE_STATE_RUN);
    ticks(100U);
    other.speed_shift++;
    change();
    for (uint32_t k = 0U; k < 50U; k++) {
        tick();
        TEST_ASSERT_TRUE(out.gate_enable);
        TEST_ASSERT_EQUAL_UINT16(0U, out.compare.phase[0]);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_INIT, drive.state);
    }
    ticks(2U);
    TEST_ASSERT_FALSE(out.gate_enable);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
}

TEST(test_a_latched_fault_stays)
{
    in.flags = DRIVE_FLAG_BREAK;
    tick();
    in.flags = 0U;
    other.speed_shift++;
    change();
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_BREAK, drive.fault.id);
    in.command.request = DRIVE_REQUEST_CLEAR;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
}

/* ---- any state, any configuration ---- */

/*
 * Half of the rows that may change, anywhere in their ranges, as far as the rules between two
 * settings allow it.
 */
static void choose_change(void)
{
    other = cfg;
    for (size_t i = 0; i < COUNT(RUN_ROWS); i++) {
        const int32_t value = (int32_t)any_within(&seed, RUN_ROWS[i].lo, RUN_ROWS[i].hi);
        int32_t before;

        if (seeded_in(&seed, 0, 1) == 0) {
            memcpy(&before, (char *)&other + RUN_ROWS[i].offset, sizeof before);
            memcpy((char *)&other + RUN_ROWS[i].offset, &value, sizeof value);
            if ((config_check(&other) != NULL) || (config_change_refused(&cfg, &other) != NULL)) {
                memcpy((char *)&other + RUN_ROWS[i].offset, &before, sizeof before);
            }
        }
    }
    other.crc = config_guard_crc(&other);
}

/*
 * The low bytes come first. Narrow words have a sign unless their range is above that of int32_t or
 * is a byte.
 */
static int64_t word_of(const state_word_t *word)
{
    int64_t value = 0;

    memcpy(&value, (char *)&drive + word->offset, word->size);
    if ((word->size == sizeof(int32_t)) && (word->hi <= INT32_MAX)) {
        value = (int32_t)(uint32_t)value;
    }
    return value;
}

static void assert_within_its_ranges(void)
{
    for (size_t i = 0; i < STATE_WORDS_COUNT; i++) {
        const int64_t value = word_of(&STATE_WORDS[i]);

        TEST_ASSERT_TRUE_MESSAGE((value >= STATE_WORDS[i].lo) && (value <= STATE_WORDS[i].hi),
                                 STATE_WORDS[i].name);
    }
}

TEST(test_from_any_state_any_change_ends_within_the_ranges_of_the_state)
{
    cfg.voltage_drive = example_voltage_drive_cfg();
    for (int32_t k = 0; k < STATES; k++) {
        drive_state_t before;

        drive = any_state(&seed, &cfg);
        choose_change();
        before = drive.state;
        drive_change(&drive, &other);
        assert_within_its_ranges();
        TEST_ASSERT_EQUAL_INT(before, drive.state);
        TEST_ASSERT_EQUAL_PTR(&other, drive.cfg);
        in.adc_ia = (uint16_t)seeded_in(&seed, 0, 4095);
        drive_step(&drive, &in, &out);
        assert_within_its_ranges();
    }
}
