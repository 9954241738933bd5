// SPDX-License-Identifier: MIT
// From the motor file to the gains: what a tuning leaves open is filled in by the motor,
// docs/configuration.md.
#include "folder.h"
#include "motor_model.h"
#include "startup_units.h"

#include "numbers.h"
#include "rules.h"

#include "testing.h"

#include <algorithm>

using test::Folder;

namespace
{

// The step of an integer field: a number rounded to it is off by half of one.
constexpr double ROUNDING = 0.5;
// Settings go through one or two products of doubles.
constexpr double RELATIVE = 1e-12;

// [speed_loop] and [position_loop] of the valid tuning, all left to the motor.
const std::vector<std::string> OPEN = {
    "speed_loop.bandwidth_hz=0",    "speed_loop.ramp_rpm_s=0",
    "position_loop.bandwidth_hz=0", "position_loop.speed_rpm=0",
    "position_loop.softness_s=0",   "position_loop.acceleration_rad_s2=0",
};
const std::vector<std::string> START_UP = {"startup.current_pct=100",
                                           "startup.handover_speed_pct=10"};

std::vector<std::string> also(std::vector<std::string> a, const std::vector<std::string> &b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

nf::TuningSettings filled(const std::vector<std::string> &set)
{
    const nf::Config config = nf::load_scenario("s", {}, set);
    return nf::by_rules(config.tuning, config.motor, config.board, config.model);
}

drive_cfg_t built(const std::vector<std::string> &set, const std::vector<std::string> &with = {})
{
    return nf::build(nf::load_scenario("s", with, set));
}

void expect_ratio(double expected, double a, double b)
{
    TEST_ASSERT_DOUBLE_WITHIN(RELATIVE * expected, expected, a / b);
}

// T_max/J: a motor of twice the inertia gets half the bandwidth, ramp and profile, with the same
// shape.
TEST(what_is_left_open_follows_the_torque_over_the_inertia)
{
    const Folder folder;
    const nf::TuningSettings light = filled(OPEN);
    const nf::TuningSettings heavy = filled(also(OPEN, {"motor.inertia_kg_m2=0.006"}));
    expect_ratio(2, light.speed_bandwidth_hz, heavy.speed_bandwidth_hz);
    expect_ratio(2, light.speed_ramp_rpm_s, heavy.speed_ramp_rpm_s);
    expect_ratio(2, light.position_bandwidth_hz, heavy.position_bandwidth_hz);
    expect_ratio(2, light.position_acceleration_rad_s2, heavy.position_acceleration_rad_s2);
    expect_ratio(2, heavy.position_softness_s, light.position_softness_s);
    expect_ratio(1, light.position_speed_rpm, heavy.position_speed_rpm);
}

TEST(ramp_and_profile_leave_torque_to_the_load)
{
    const Folder folder;
    const nf::TuningSettings t = filled(OPEN);
    const double torque = 1.5 * 2 * 0.387 * 10; // N·m, of the largest current
    const double ramp_rad_s2 = nf::rad_s_from_rpm(t.speed_ramp_rpm_s);
    TEST_ASSERT_TRUE(0.003 * ramp_rad_s2 < torque / 2);
    TEST_ASSERT_TRUE(0.003 * t.position_acceleration_rad_s2 < torque / 2);
    TEST_ASSERT_TRUE(t.position_bandwidth_hz < t.speed_bandwidth_hz);
    TEST_ASSERT_TRUE(t.position_speed_rpm < 1800);
}

TEST(what_the_tuning_says_is_not_changed)
{
    const Folder folder;
    const nf::TuningSettings t = filled({});
    TEST_ASSERT_EQUAL_DOUBLE(20, t.speed_bandwidth_hz);
    TEST_ASSERT_EQUAL_DOUBLE(10000, t.speed_ramp_rpm_s);
    TEST_ASSERT_EQUAL_DOUBLE(5, t.position_bandwidth_hz);
    TEST_ASSERT_EQUAL_DOUBLE(900, t.position_speed_rpm);
    TEST_ASSERT_EQUAL_DOUBLE(800, t.position_acceleration_rad_s2);
    TEST_ASSERT_EQUAL_DOUBLE(0.01, t.position_softness_s);
    const nf::TuningSettings one = filled(also(OPEN, {"speed_loop.bandwidth_hz=7"}));
    TEST_ASSERT_EQUAL_DOUBLE(7, one.speed_bandwidth_hz);
    TEST_ASSERT_TRUE(one.speed_ramp_rpm_s > 0);
}

// 7.8 N·m at 1.5·2·0.387 N·m/A.
TEST(the_continuous_current_is_that_of_rated_torque_unless_written)
{
    nf::MotorSettings motor;
    motor.pole_pairs = 2;
    motor.flux_linkage_wb = 0.387;
    motor.rated_torque_nm = 7.8;
    motor.max_current_a = 10;
    TEST_ASSERT_DOUBLE_WITHIN(RELATIVE, 7.8 / (3 * 0.387), nf::continuous_current(motor));
    motor.continuous_current_a = 4;
    TEST_ASSERT_EQUAL_DOUBLE(4, nf::continuous_current(motor));
    motor.continuous_current_a = 12;
    TEST_ASSERT_EQUAL_DOUBLE(10, nf::continuous_current(motor));
}

TEST(without_a_start_up_current_there_is_no_start_up)
{
    const Folder folder;
    const startup_cfg_t c = built({}).startup;
    TEST_ASSERT_EQUAL_INT32(0, c.current_hold);
    TEST_ASSERT_EQUAL_INT32(0, c.handover_speed);
}

// I_b = 40 A; 50 % of 4 A, and a tenth of 1800 rpm.
TEST(start_up_current_and_hand_over_are_shares_of_the_motor)
{
    const Folder folder;
    const std::vector<std::string> set = {"startup.current_pct=50", "motor.continuous_current_a=4",
                                          "startup.handover_speed_pct=10"};
    const nf::Config config = nf::load_scenario("s", {}, set);
    const startup_cfg_t c = nf::build(config).startup;
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 2.0 / 40 * 32768, c.current_hold);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 10.0 / 40 * 32768, c.current_move);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, bases.step_from_rpm(180), c.handover_speed);
    TEST_ASSERT_TRUE(0 < c.track_speed && c.track_speed < c.hold_speed);
    TEST_ASSERT_TRUE(c.hold_speed < c.handover_speed);
    TEST_ASSERT_TRUE(c.residual_max < c.residual_lost);
    TEST_ASSERT_TRUE(0 < c.ramp && c.ramp < nf::build(config).speed_loop.ramp);
    TEST_ASSERT_EQUAL_INT32(c.current_hold, c.align.current_high);
    TEST_ASSERT_TRUE(0 < c.align.current_low && c.align.current_low < c.align.current_high);
}

// Whatever the motor, the alignment is as long in swings of the rotor: ω_n falls with the root of
// the inertia.
TEST(the_alignment_takes_as_many_swings_of_the_rotor_for_every_inertia)
{
    const Folder folder;
    const align_cfg_t light = built(START_UP).startup.align;
    const align_cfg_t heavy = built(also(START_UP, {"motor.inertia_kg_m2=0.012"})).startup.align;
    // Both counts of ticks are rounded up.
    TEST_ASSERT_INT_WITHIN(2, 2 * light.pull_ticks, heavy.pull_ticks);
    TEST_ASSERT_INT_WITHIN(2, 2 * light.sweep_ticks, heavy.sweep_ticks);
    TEST_ASSERT_INT_WITHIN(2, 2 * light.settle_ticks, heavy.settle_ticks);
    // The sweep is half a turn: 2^31, and each tick's step is rounded.
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING * light.sweep_ticks, 2147483648.0,
                              static_cast<double>(light.sweep_speed) * light.sweep_ticks);
}

TEST(the_scenario_begins_after_the_start_up)
{
    const Folder folder;
    const nf::Config plain = nf::load_scenario("s");
    const nf::Config started = nf::load_scenario("s", {}, START_UP);
    const double start_s = nf::startup_time(started.motor, started.board, started.tuning);
    TEST_ASSERT_TRUE(start_s > 0);
    TEST_ASSERT_EQUAL_DOUBLE(0, nf::startup_time(plain.motor, plain.board, plain.tuning));
    TEST_ASSERT_EQUAL_DOUBLE(plain.scenario.prelude_s + start_s, started.scenario.prelude_s);
}

const std::vector<std::string> BOARD_1_US = {"board.dead_time_s=1e-6", "board.device_drop_v=0.9"};

// 1 µs of 100 µs; 0.9 V of 450 V.
TEST(the_plant_and_the_belief_have_the_dead_time_of_the_board)
{
    const Folder folder;
    const nf::Config config = nf::load_scenario("s", {}, BOARD_1_US);
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, config.plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.9, config.plant.device_drop_v);
    const modulator_cfg_t told = nf::build(config).modulator;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.01 * 32768, told.dead_time_q15);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.002 * 32768, told.drop_q15);
}

TEST(a_plant_with_another_dead_time_is_believed)
{
    const Folder folder;
    const nf::Config config =
        nf::load_scenario("s", {}, also(BOARD_1_US, {"plant.dead_time_s=2e-6"}));
    TEST_ASSERT_EQUAL_DOUBLE(2e-6, config.plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(2e-6, config.model.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.9, config.model.device_drop_v);
}

TEST(a_plant_may_be_better_than_its_board)
{
    const Folder folder;
    const nf::Config config = nf::load_scenario("s", {}, also(BOARD_1_US, {"plant.dead_time_s=0"}));
    TEST_ASSERT_EQUAL_DOUBLE(0, config.plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0, config.model.dead_time_s);
}

TEST(a_belief_of_its_own_leaves_plant_and_board_alone)
{
    const Folder folder;
    const nf::Config config = nf::load_scenario("s", {}, also(BOARD_1_US, {"model.dead_time_s=0"}));
    TEST_ASSERT_EQUAL_DOUBLE(0, config.model.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, config.plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, config.board.dead_time_s);
}

TEST(a_belief_of_minus_one_is_what_the_plant_has)
{
    const Folder folder;
    const std::vector<std::string> plant = {"plant.dead_time_s=1e-6", "plant.device_drop_v=0.9"};
    const modulator_cfg_t as_plant = built(plant).modulator;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.01 * 32768, as_plant.dead_time_q15);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.002 * 32768, as_plant.drop_q15);
    const modulator_cfg_t told =
        built(also(plant, {"model.dead_time_s=2e-6", "model.device_drop_v=0"})).modulator;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.02 * 32768, told.dead_time_q15);
    TEST_ASSERT_EQUAL_INT32(0, told.drop_q15);
    TEST_ASSERT_EQUAL_INT32(0, built({}).modulator.dead_time_q15);
}

// 14 % of 4 A of I_b = 40 A.
TEST(the_least_current_is_there_only_where_dead_time_or_drop_is_compensated)
{
    const Folder folder;
    const std::vector<std::string> floor = {"current_loop.floor_pct=14",
                                            "motor.continuous_current_a=4"};
    for (const auto &mode : {START_UP, {}, std::vector<std::string>{"drive.angle_source=sensor"}}) {
        const std::vector<std::string> set = also(floor, mode);
        TEST_ASSERT_EQUAL_INT32(0, built(set).current_reference.floor);
        const current_reference_cfg_t reference =
            built(also(set, {"plant.dead_time_s=1e-6"})).current_reference;
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.14 * 4 / 40 * 32768, reference.floor);
        TEST_ASSERT_TRUE(reference.slope > 0);
    }
}

TEST(the_model_may_be_corrected_as_far_as_the_tuning_says)
{
    const Folder folder;
    const model_cfg_t off = built({}).model;
    TEST_ASSERT_EQUAL_INT32(0, off.resistance_limit_q14 | off.inductance_limit_q14 |
                                   off.saliency_limit_q14 | off.flux_limit_q14);
    const model_cfg_t c = built({"adaptation.resistance_pct=60", "adaptation.inductance_pct=40",
                                 "adaptation.saliency_pct=70", "adaptation.flux_pct=25"})
                              .model;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.60 * 16384, c.resistance_limit_q14);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.40 * 16384, c.inductance_limit_q14);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.70 * 16384, c.saliency_limit_q14);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.25 * 16384, c.flux_limit_q14);
}

int bits_lost(uint32_t before, uint32_t after)
{
    return static_cast<int>(before) - static_cast<int>(after);
}

// The weights keep room for the largest correction: none of them may end at 15 bits.
TEST(the_weights_have_room_for_the_largest_correction)
{
    const Folder folder;
    const nn_observer_cfg_t c =
        built({"adaptation.resistance_pct=60", "adaptation.inductance_pct=40",
               "adaptation.flux_pct=25", "observer.kappa_p=0.1"})
            .observer;
    const int32_t largest_weight = std::max(c.decay, c.volt_gain);
    TEST_ASSERT_TRUE(largest_weight * (1.6 / 0.6) <= 32767);
    TEST_ASSERT_TRUE(c.eta * 1.4 * 1.4 <= 32767);
    TEST_ASSERT_TRUE(c.kappa_p * 1.4 * 1.4 <= 32767);
    TEST_ASSERT_TRUE(c.flux_q27 * (1.25 / 0.6) <= 134217727);
}

TEST(the_gains_of_the_current_loop_have_room_for_it_too)
{
    const Folder folder;
    const current_loop_cfg_t plain = built({}).current_loop;
    const current_loop_cfg_t c =
        built({"adaptation.inductance_pct=40", "adaptation.saliency_pct=100"}).current_loop;
    for (const auto &[kept, own] : {std::pair{plain.pi_d, c.pi_d}, std::pair{plain.pi_q, c.pi_q}}) {
        TEST_ASSERT_TRUE(own.kp * 1.4 * 2 <= 32767);
        TEST_ASSERT_TRUE(own.ki * 1.4 * 2 <= 32767);
        TEST_ASSERT_DOUBLE_WITHIN(
            ROUNDING, std::ldexp(kept.kp, -bits_lost(kept.kp_shift, own.kp_shift)), own.kp);
        TEST_ASSERT_DOUBLE_WITHIN(
            ROUNDING, std::ldexp(kept.ki, -bits_lost(kept.ki_shift, own.ki_shift)), own.ki);
    }
}

TEST(rho_is_the_tunings_limit_and_off_by_default)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_INT32(0, built({}).observer.rho_max_q13);
    TEST_ASSERT_EQUAL_INT32(2 * 8192, built({"observer.rho_max=2"}).observer.rho_max_q13);
}

// 1.5·2·0.387 N·m/A·5 A; |6.72 A·2.125 Ω + 377·0.387, 377·0.0116·6.72| at 1800 rpm;
// 3·(2·π·2·2000/60/10000)² = 0.005264.
TEST(a_rating_that_is_not_reached_is_noted_with_its_line)
{
    const Folder folder;
    TEST_ASSERT_TRUE(nf::load_scenario("s").scenario.notes.empty());
    const struct {
        const char *set;
        const char *note;
    } cases[] = {
        {"motor.max_current_a=5", "motors/m.toml:8: motor.rated_torque_nm = 7.8: "
                                  "motor.max_current_a = 5 makes at most 5.805 N·m"},
        {"board.bus_nominal_v=280", "motors/m.toml:9: motor.rated_speed_rpm = 1800: with rated "
                                    "torque it takes 162.8 V of phase voltage; board.bus_nominal_v "
                                    "= 280 and board.duty_margin_pct = 5 leave 153.6 V"},
        {"observer.kappa=0.005",
         "--set: observer.kappa = 0.005: without observer.kappa_p the estimate is little damped at "
         "motor.max_speed_rpm = 2000 and board.pwm_frequency_hz = 10000; at least 0.005264 is "
         "asked for"},
        {"observer.kappa=0.0026",
         "--set: observer.kappa = 0.0026: without observer.kappa_p the estimate is not stable at "
         "motor.max_speed_rpm = 2000 and board.pwm_frequency_hz = 10000; at least 0.005264 is "
         "asked for"},
        {"speed_loop.notch_hz=55",
         "tunings/t.toml:5: speed_loop.bandwidth_hz = 20: speed_loop.notch_hz = 55 and "
         "speed_loop.torque_filter_hz = 0 leave 27° of phase margin; up to 18.6 Hz it is 30° and "
         "more"},
        {"speed_loop.notch_hz=40",
         "tunings/t.toml:5: speed_loop.bandwidth_hz = 20: speed_loop.notch_hz = 40 and "
         "speed_loop.torque_filter_hz = 0 leave no phase margin; up to 14.48 Hz it is 30° and "
         "more"},
    };
    for (const auto &[set, note] : cases) {
        const nf::Config config = nf::load_scenario("s", {}, {set});
        TEST_ASSERT_EQUAL_size_t(1, config.scenario.notes.size());
        TEST_ASSERT_EQUAL_STRING(note, config.scenario.notes[0].c_str());
    }
    folder.edit("tunings/t.toml", "kappa = 0.03", "kappa = 0.001");
    for (const char *fine : {"observer.kappa_p=0.1", "drive.angle_source=sensor"}) {
        TEST_ASSERT_TRUE(nf::load_scenario("s", {}, {fine}).scenario.notes.empty());
    }
    folder.edit("tunings/t.toml", "bandwidth_hz = 20", "bandwidth_hz = 0");
    TEST_ASSERT_TRUE(nf::load_scenario("s", {}, {"speed_loop.notch_hz=40"}).scenario.notes.empty());
}

// L_q − L_d = 28.4 mH: at 6.3 A 3·(0.387 + 0.0284·2.2)·5.9 = 7.98 N·m, and without its reluctance
// 7.31 of 7.8 N·m.
TEST(reluctance_counts_for_a_rating_where_the_drive_uses_it)
{
    const Folder folder;
    const std::vector<std::string> set = {"motor.inductance_q_h=0.04", "motor.max_current_a=6.3",
                                          "motor.rated_speed_rpm=1500"};
    for (const std::string &note : nf::load_scenario("s", {}, set).scenario.notes) {
        TEST_FAIL_MESSAGE(note.c_str());
    }
    // without, and with L_q < L_d, of which the drive makes no use
    for (const char *unused : {"current_loop.most_torque=0", "motor.inductance_d_h=0.07"}) {
        const std::vector<std::string> notes =
            nf::load_scenario("s", {}, also(set, {unused})).scenario.notes;
        TEST_ASSERT_TRUE_MESSAGE(std::any_of(notes.begin(), notes.end(),
                                             [](const std::string &note) {
                                                 return note.find("7.314 N·m") != std::string::npos;
                                             }),
                                 unused);
    }
}

// 10 kHz; a charge is not shorter than asked for.
TEST(charge_of_the_bootstrap_supplies_is_the_boards_and_needs_a_start_up)
{
    const Folder folder;
    const struct {
        const char *seconds;
        uint32_t ticks;
    } lengths[] = {{"0", 0}, {"1e-5", 1}, {"0.01", 100}, {"0.01002", 101}, {"0.1", 1000}};
    for (const auto &[seconds, ticks] : lengths) {
        const std::string set = std::string("board.bootstrap_charge_s=") + seconds;
        const nf::Config config = nf::load_scenario("s", {}, {set, "startup.current_pct=50"});
        TEST_ASSERT_EQUAL_UINT32(ticks, nf::build(config).startup.flying_start.charge_ticks);
        TEST_ASSERT_TRUE(config.scenario.notes.empty());
    }
    for (const char *without : {"startup.current_pct=0", "drive.angle_source=sensor"}) {
        const nf::Config config =
            nf::load_scenario("s", {}, {"board.bootstrap_charge_s=0.01", without});
        TEST_ASSERT_EQUAL_size_t(1, config.scenario.notes.size());
        TEST_ASSERT_EQUAL_STRING(
            "--set: board.bootstrap_charge_s = 0.01: acts only with "
            "drive.angle_source other than \"sensor\" and startup.current_pct above 0",
            config.scenario.notes[0].c_str());
    }
}

TEST(a_word_that_does_not_act_is_repeated_as_it_was_written)
{
    const Folder folder;
    const nf::Config config = nf::load_scenario("s", {}, {"input.button=enable"});
    TEST_ASSERT_EQUAL_size_t(1, config.scenario.notes.size());
    TEST_ASSERT_EQUAL_STRING(
        "--set: input.button = \"enable\": acts only with input.kind other than \"none\"",
        config.scenario.notes[0].c_str());
}

} // namespace
