// SPDX-License-Identifier: MIT
// What an identification found: written with the digits that its bars allow, read back, and
// believed by the drive alone.
#include "folder.h"

#include "bars.h"
#include "describe.h"
#include "measured_file.h"
#include "schema.h"

#include <fmt/format.h>

#include "testing.h"

#include <cmath>

using test::Folder;

namespace
{

nf::MotorSettings motor()
{
    nf::MotorSettings m;
    m.name = "a \"quoted\" \\ name, Ω";
    m.pole_pairs = 7;
    m.resistance_ohm = 0.0391234;
    m.inductance_d_h = 1.5712e-5;
    m.inductance_q_h = 1.6123e-5;
    m.flux_linkage_wb = 0.0029173;
    m.rated_torque_nm = 0.61263;
    m.rated_speed_rpm = 5000;
    m.max_speed_rpm = 5400.25;
    m.max_current_a = 30;
    m.continuous_current_a = 20;
    m.inertia_kg_m2 = 0.000203;
    m.viscous_friction_nm_s = 2.1e-5;
    return m;
}

nf::MeasuredSettings measured()
{
    nf::MeasuredSettings e;
    e.resistance_std_pct = 0.3;
    e.resistance_bound_pct = 0.4;
    e.inductance_d_std_pct = 1.06;
    e.inductance_q_bound_pct = 12.4;
    e.flux_linkage_std_pct = 0.5;
    e.inertia_std_pct = 3;
    e.viscous_friction_bar_nm_s = 3e-5;
    e.coulomb_friction_nm = 0.01234;
    e.coulomb_friction_bar_nm = 0.0011;
    e.dead_time_s = 7.134e-7;
    e.dead_time_bar_s = 2.5e-8;
    e.knee_a = 0.4567;
    e.knee_bar_a = 0.061;
    e.temperature_c = 31.25;
    e.bus_v = 24.0312;
    e.current_a = 20;
    e.speed_rpm = 4321;
    e.current_noise_lsb = 1.23456;
    e.gain_mismatch_pct = -0.3456;
    e.gain_mismatch_bar_pct = 0.12;
    return e;
}

const char *const WRITTEN = "# Identified.\n"
                            "#\n"
                            "# A line?\n"
                            "\n"
                            "[motor]\n"
                            "name = \"a \\\"quoted\\\" \\\\ name, Ω\"\n"
                            "pole_pairs = 7\n"
                            "resistance_ohm = 0.03912 # ± 0.00028 Ω\n"
                            "inductance_d_h = 1.571e-05 # ± 3.3e-07 H\n"
                            "inductance_q_h = 1.61e-05 # ± 2.0e-06 H\n"
                            "flux_linkage_wb = 0.002917 # ± 2.9e-05 Wb\n"
                            "rated_torque_nm = 0.6126 # ± 0.0061 N·m\n"
                            "rated_speed_rpm = 5000\n"
                            "max_speed_rpm = 5400.25\n"
                            "max_current_a = 30\n"
                            "continuous_current_a = 20\n"
                            "inertia_kg_m2 = 0.000203 # ± 1.2e-05 kg·m²\n"
                            "viscous_friction_nm_s = 2.1e-05 # ± 3.0e-05 N·m·s\n"
                            "\n"
                            "[measured]\n"
                            "resistance_std_pct = 0.30\n"
                            "resistance_bound_pct = 0.40\n"
                            "inductance_d_std_pct = 1.1\n"
                            "inductance_q_bound_pct = 12\n"
                            "flux_linkage_std_pct = 0.50\n"
                            "inertia_std_pct = 3.0\n"
                            "viscous_friction_bar_nm_s = 3.0e-05\n"
                            "coulomb_friction_nm = 0.0123 # ± 0.0011 N·m\n"
                            "coulomb_friction_bar_nm = 0.0011\n"
                            "dead_time_s = 7.13e-07 # ± 2.5e-08 s\n"
                            "dead_time_bar_s = 2.5e-08\n"
                            "knee_a = 0.457 # ± 0.061 A\n"
                            "knee_bar_a = 0.061\n"
                            "temperature_c = 31.25\n"
                            "bus_v = 24.03\n"
                            "current_a = 20\n"
                            "speed_rpm = 4321\n"
                            "current_noise_lsb = 1.235\n"
                            "gain_mismatch_pct = -0.35 # ± 0.12 %\n"
                            "gain_mismatch_bar_pct = 0.12\n";

TEST(a_file_has_the_digits_that_its_bars_allow)
{
    TEST_ASSERT_EQUAL_STRING(
        WRITTEN, nf::measured_motor_file(motor(), measured(), "Identified.\n\nA line\t").c_str());
}

TEST(a_value_is_rounded_at_the_second_digit_of_its_bar)
{
    TEST_ASSERT_EQUAL_STRING("2.125", nf::within_bar(2.1253, 0.031).c_str());
    TEST_ASSERT_EQUAL_STRING("2.100", nf::within_bar(2.1, 0.031).c_str());
    TEST_ASSERT_EQUAL_STRING("-2.125", nf::within_bar(-2.1253, 0.031).c_str());
    TEST_ASSERT_EQUAL_STRING("12350", nf::within_bar(12345.6, 123).c_str());
    TEST_ASSERT_EQUAL_STRING("1.571e-05", nf::within_bar(1.5712e-5, 1.7e-7).c_str());
    TEST_ASSERT_EQUAL_STRING("2.13", nf::within_bar(2.1253, 0.0996).c_str()); // a bar of 0.10
    TEST_ASSERT_EQUAL_STRING("0.001", nf::within_bar(0.0014, 0.12).c_str());  // one digit is left
    TEST_ASSERT_EQUAL_STRING("0.1234567890123", nf::within_bar(0.1234567890123, 0).c_str());
    TEST_ASSERT_EQUAL_STRING("0", nf::within_bar(0, 0.1).c_str());
    TEST_ASSERT_EQUAL_STRING("0.10", nf::two_digits(0.0996).c_str());
    TEST_ASSERT_EQUAL_STRING("12", nf::two_digits(12.4).c_str());
    TEST_ASSERT_EQUAL_STRING("1.5e-06", nf::two_digits(1.49e-6).c_str());
}

nf::Config read_back(const Folder &folder, const std::string &text)
{
    folder.write("motors/written.toml", text);
    return nf::load_motor("written");
}

// Half of the last digit: 1/20 of a bar of two digits that begins with 1, and as much of the bar
// itself.
constexpr double LOST_OF_BAR = 0.05;

void expect_the_same(nf::Config &expected, nf::Config &found, const nf::Field &field)
{
    const nf::Target target = field.target(expected);
    const nf::Target other = field.target(found);
    if (const auto *real = std::get_if<double *>(&target)) {
        const double bar = nf::bar_of(expected.motor, expected.measured, field.name());
        const double lost = bar > 0 ? LOST_OF_BAR * bar
                                    : (std::string(field.section) == "measured" ? LOST_OF_BAR : 0) *
                                          std::abs(**real);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(lost, **real, *std::get<double *>(other),
                                          field.name().c_str());
    } else if (const auto *whole = std::get_if<int *>(&target)) {
        TEST_ASSERT_EQUAL_INT(**whole, *std::get<int *>(other));
    } else {
        TEST_ASSERT_EQUAL_STRING(field.value_text(expected).c_str(),
                                 field.value_text(found).c_str());
    }
}

TEST(what_is_written_is_read_back)
{
    const Folder folder;
    nf::Config expected;
    expected.motor = motor();
    expected.motor.sensor.kind = nf::SensorKind::hall;
    expected.motor.sensor.reversed = true;
    expected.motor.sensor.hall_patterns = {4, 6, 2, 3, 1, 5};
    expected.motor.sensor.hall_edges_deg = {1.5, 60.25, 120, 180, 240, 300};
    expected.measured = measured();
    nf::Config found =
        read_back(folder, nf::measured_motor_file(expected.motor, expected.measured, "head"));
    for (const nf::Field &field : nf::schema()) {
        if (nf::may_hold(nf::FileKind::motor, field.section)) {
            expect_the_same(expected, found, field);
        }
    }
}

TEST(without_findings_there_is_no_table_of_them)
{
    const std::string text = nf::measured_motor_file(motor(), {}, "");
    TEST_ASSERT_EQUAL_size_t(0, text.find("[motor]\n"));
    TEST_ASSERT_EQUAL_size_t(std::string::npos, text.find("[measured]"));
    TEST_ASSERT_NOT_EQUAL_size_t(std::string::npos, text.find("resistance_ohm = 0.0391234\n"));
}

TEST(a_value_that_no_loader_takes_is_not_written)
{
    nf::MotorSettings m = motor();
    m.resistance_ohm = 0.0004;
    try {
        nf::measured_motor_file(m, measured(), "");
        TEST_FAIL_MESSAGE("accepted");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING("identified motor: motor.resistance_ohm = 0.0004: is too small; "
                                 "allowed: 0.001 to 50 Ω",
                                 error.what());
    }
}

const char *const FOUND = "[measured]\ndead_time_s = 1e-6\nknee_a = 0.5\nbus_v = 300\n";

// Q15 of a period of 0.1 ms.
TEST(the_drive_believes_the_measured_dead_time_and_the_plant_does_not)
{
    const Folder folder;
    folder.edit("motors/m.toml", "", FOUND);
    const std::vector<std::string> board = {"board.dead_time_s=2e-6"};
    const nf::Config config = nf::load_scenario("s", {}, board);
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, config.model.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(2e-6, config.plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0, config.plant.commutation_knee_a);
    TEST_ASSERT_EQUAL_INT(std::lround(1e-6 / 1e-4 * 32768),
                          nf::build(config).modulator.dead_time_q15);
    const nf::Config written =
        nf::load_scenario("s", {}, {"board.dead_time_s=2e-6", "model.dead_time_s=3e-6"});
    TEST_ASSERT_EQUAL_DOUBLE(3e-6, written.model.dead_time_s);
    const nf::Config as_if_none = nf::load_scenario("s", {}, {board[0], "measured.dead_time_s=-1"});
    TEST_ASSERT_EQUAL_DOUBLE(2e-6, as_if_none.model.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(nf::AS_BOARD, as_if_none.model.output_capacitance_f);
}

// A measured dead time is all that the legs lose; the drop compensated beside it would be so twice.
TEST(the_drive_believes_no_drop_beside_a_measured_dead_time)
{
    const Folder folder;
    folder.edit("motors/m.toml", "", FOUND);
    const std::string drop = "board.device_drop_v=1.2";
    const nf::Config config = nf::load_scenario("s", {}, {drop});
    TEST_ASSERT_EQUAL_DOUBLE(1.2, config.plant.device_drop_v);
    TEST_ASSERT_EQUAL_DOUBLE(0, config.model.device_drop_v);
    TEST_ASSERT_EQUAL_INT(0, nf::build(config).modulator.drop_q15);
    const nf::Config own_drop = nf::load_scenario("s", {}, {drop, "model.device_drop_v=0.7"});
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, own_drop.model.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.7, own_drop.model.device_drop_v);
    for (const char *const without : {"model.dead_time_s=3e-6", "measured.dead_time_s=-1"}) {
        const nf::Config plain = nf::load_scenario("s", {}, {drop, without});
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(1.2, plain.model.device_drop_v, without);
    }
}

// The knee is 0.5 A at 300 V, and so 0.5·310/300 A at the board's 310 V.
TEST(the_drive_believes_the_measured_knee)
{
    const Folder folder;
    folder.edit("motors/m.toml", "", FOUND);
    const nf::Config config = nf::load_scenario("s");
    TEST_ASSERT_DOUBLE_WITHIN(1e-21, 0.5 * 1e-6 / 300, config.model.output_capacitance_f);
    const double edge_a = 3.5 * 0.5 * 310 / 300;
    TEST_ASSERT_EQUAL_INT(std::lround(40 / edge_a), nf::build(config).modulator.edge_slope);
    const nf::Config nominal = nf::load_scenario("s", {}, {"measured.bus_v=0"});
    TEST_ASSERT_DOUBLE_WITHIN(1e-21, 0.5 * 1e-6 / 310, nominal.model.output_capacitance_f);
    const nf::Config written = nf::load_scenario("s", {}, {"model.output_capacitance_f=1e-9"});
    TEST_ASSERT_EQUAL_DOUBLE(1e-9, written.model.output_capacitance_f);
}

TEST(a_measured_dead_time_that_does_not_fit_is_named_where_it_stands)
{
    const Folder folder;
    folder.edit("motors/m.toml", "", "[measured]\ndead_time_s = 9e-6\n");
    folder.edit("boards/b.toml", "pwm_frequency_hz = 10000", "pwm_frequency_hz = 40000");
    TEST_ASSERT_EQUAL_STRING(
        "motors/m.toml:15: measured.dead_time_s = 9e-06: does not fit the firmware; allowed: at "
        "most 6.25e-06 s: a quarter of the PWM period",
        test::refusal().c_str());
}

TEST(wrong_findings_are_refused_as_all_other_keys)
{
    const Folder folder;
    folder.edit("motors/m.toml", "", "[measured]\nresistance_std_pct = -1\n");
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:15: measured.resistance_std_pct = -1: is too small; "
                             "allowed: 0 to 1000 %",
                             test::refusal().c_str());
    folder.edit("motors/m.toml", "", "[measured]\nresistance_std = 1\n");
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:15: measured.resistance_std = 1: unknown key, did you "
                             "mean measured.resistance_std_pct?",
                             test::refusal().c_str());
}

std::string meaning(const nf::Config &config, const std::string &path)
{
    for (const nf::ConfigRow &row : nf::describe(config, nf::build(config))) {
        if (row.path == path) {
            return row.meaning;
        }
    }
    return "";
}

TEST(the_firmwares_numbers_are_shown_with_their_bars)
{
    const Folder folder;
    folder.edit("motors/m.toml", "",
                "[measured]\nresistance_std_pct = 0.3\nresistance_bound_pct = 0.4\n"
                "dead_time_s = 1e-6\ndead_time_bar_s = 5e-8\n");
    const nf::Config config = nf::load_scenario("s");
    TEST_ASSERT_EQUAL_STRING("R = 2.1245 Ohm, measured ± 0.72 %",
                             meaning(config, "current_loop.resistance_q13").c_str());
    TEST_ASSERT_EQUAL_STRING("φ = 0.38703 Wb", meaning(config, "current_loop.emf_q13").c_str());
    const std::string dead_time = meaning(config, "modulator.dead_time_q15");
    TEST_ASSERT_NOT_EQUAL_size_t(std::string::npos, dead_time.find(", measured ± 5.0 %"));
    const nf::Config written = nf::load_scenario("s", {}, {"model.dead_time_s=2e-6"});
    TEST_ASSERT_EQUAL_size_t(std::string::npos,
                             meaning(written, "modulator.dead_time_q15").find("measured"));
}

} // namespace
