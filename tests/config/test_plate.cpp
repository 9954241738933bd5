// SPDX-License-Identifier: MIT
// A name plate: where it is accepted, what is said elsewhere, and the typical values that the rest
// of it has.
#include "folder.h"

#include "plate.h"
#include "schema.h"
#include "zoo.h"

#include <fmt/format.h>

#include "testing.h"

#include <cmath>

using test::Folder;

namespace
{

const std::string PLATE = "[motor]\n"
                          "name = \"plate\"\n"
                          "pole_pairs = 2\n"
                          "max_speed_rpm = 2000\n"
                          "max_current_a = 10\n"
                          "continuous_current_a = 8\n";

const std::string UNKNOWN =
    "motor.resistance_ohm, motor.inductance_d_h, motor.inductance_q_h, motor.flux_linkage_wb, "
    "motor.rated_torque_nm, motor.rated_speed_rpm, motor.inertia_kg_m2";

void write_plate(const Folder &folder, const std::string &more = "")
{
    folder.write("motors/m.toml", PLATE + more);
    folder.write("tunings/any.toml", test::VALID.at("tunings/t.toml"));
}

template <typename Load> std::string refusal_of(const Load &load)
{
    try {
        load();
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "accepted";
}

std::string plate_refusal(const std::vector<std::string> &set = {})
{
    return refusal_of([&] { nf::load_plate("m", "b", {}, set); });
}

TEST(every_other_loader_says_that_it_is_a_name_plate)
{
    const Folder folder;
    write_plate(folder);
    const std::string line = "motors/m.toml:1: " + UNKNOWN +
                             ", motor.viscous_friction_nm_s: are missing: this is a name plate";
    TEST_ASSERT_EQUAL(0, test::refusal().find(line));
    TEST_ASSERT_EQUAL(0, refusal_of([] { nf::load_parts("m", "b", "t"); }).find(line));
    TEST_ASSERT_EQUAL(0, refusal_of([] { nf::load_motor("m"); }).find(line));
}

TEST(a_friction_in_a_name_plate_makes_no_difference)
{
    const Folder folder;
    write_plate(folder, "viscous_friction_nm_s = 0.5\n");
    const std::string line = "motors/m.toml:1: " + UNKNOWN + ": are missing: this is a name plate";
    TEST_ASSERT_EQUAL(0, test::refusal().find(line));
    TEST_ASSERT_EQUAL_DOUBLE(0, nf::load_plate("m", "b").motor.viscous_friction_nm_s);
}

TEST(what_is_neither_complete_nor_a_name_plate_is_refused_everywhere)
{
    const Folder folder;
    write_plate(folder, "resistance_ohm = 2\n");
    const std::string line =
        "motors/m.toml:1: motor.inductance_d_h (5e-07 to 1 H), motor.inductance_q_h (5e-07 to 1 "
        "H), motor.flux_linkage_wb (1e-05 to 10 Wb), motor.rated_torque_nm (1e-05 to 10000 N·m), "
        "motor.rated_speed_rpm (1 to 200000 rpm), motor.inertia_kg_m2 (1e-07 to 100 kg·m²), "
        "motor.viscous_friction_nm_s (0 to 100 N·m·s): are missing";
    TEST_ASSERT_EQUAL_STRING(line.c_str(), test::refusal().c_str());
    TEST_ASSERT_EQUAL_STRING(line.c_str(), plate_refusal().c_str());
}

TEST(a_name_plate_says_all_that_it_is_asked_for)
{
    const Folder folder;
    write_plate(folder);
    TEST_ASSERT_EQUAL_STRING("accepted", plate_refusal().c_str());
    TEST_ASSERT_EQUAL_STRING(
        "--set: motor.continuous_current_a = 0: is the current of rated torque, and a name plate "
        "does not say that torque; allowed: above 0, to 1000 A",
        plate_refusal({"motor.continuous_current_a=0"}).c_str());
    TEST_ASSERT_EQUAL_STRING("--set: motor.max_current_a = 19: is too large; allowed: at most 18 "
                             "A, which is board.overcurrent_a (boards/b.toml:11)",
                             plate_refusal({"motor.max_current_a=19"}).c_str());
    folder.write("motors/m.toml", PLATE.substr(0, PLATE.find("continuous_current_a")));
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:1: motor.continuous_current_a: is missing, and a name "
                             "plate needs it; allowed: 0 to 1000 A",
                             plate_refusal().c_str());
    folder.write("motors/m.toml", PLATE.substr(0, PLATE.find("max_current_a")));
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:1: motor.max_current_a (0.01 to 1000 A), "
                             "motor.continuous_current_a (0 to 1000 A): are missing, and a name "
                             "plate needs them",
                             plate_refusal().c_str());
}

void expect_the_plate(const nf::MotorSettings &motor, double continuous_current_a)
{
    TEST_ASSERT_TRUE(nf::is_plate(motor));
    TEST_ASSERT_EQUAL_INT(2, motor.pole_pairs);
    TEST_ASSERT_EQUAL_DOUBLE(2000, motor.max_speed_rpm);
    TEST_ASSERT_EQUAL_DOUBLE(10, motor.max_current_a);
    TEST_ASSERT_EQUAL_DOUBLE(continuous_current_a, motor.continuous_current_a);
}

TEST(a_name_plate_is_read_with_its_board)
{
    const Folder folder;
    write_plate(folder);
    const nf::Config config = nf::load_plate("m", "b", {"warm"}, {"board.dead_time_s=1e-6"});
    expect_the_plate(config.motor, 8);
    TEST_ASSERT_EQUAL_STRING("plate", config.motor.name.c_str());
    TEST_ASSERT_EQUAL_DOUBLE(310, config.board.bus_nominal_v);
    TEST_ASSERT_EQUAL_DOUBLE(1.1, config.plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(1e-6, config.model.dead_time_s);
    TEST_ASSERT_EQUAL_STRING("motors/m.toml", config.sources.motor.c_str());
}

// 7.8 N·m are 7.8/(1.5·2·0.387) A.
TEST(of_a_complete_motor_file_the_name_plate_is_taken)
{
    const Folder folder;
    write_plate(folder);
    folder.edit("motors/m.toml", "", "[measured]\ndead_time_s = 2e-6\nflux_linkage_std_pct = 1\n");
    const nf::Config config = nf::load_plate("m", "b");
    expect_the_plate(config.motor, 7.8 / (1.5 * 2 * 0.387));
    TEST_ASSERT_FALSE(nf::is_plate(nf::load_motor("m").motor));
    TEST_ASSERT_EQUAL_DOUBLE(nf::NOT_MEASURED, config.measured.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0, config.measured.flux_linkage_std_pct);
    TEST_ASSERT_EQUAL_DOUBLE(0, config.model.dead_time_s);
    TEST_ASSERT_EQUAL_size_t(0, config.origins.count("motor.resistance_ohm"));
    TEST_ASSERT_EQUAL_size_t(0, config.origins.count("measured.dead_time_s"));
}

constexpr double ROUNDED = 1e-12; // relative

void expect_near(double expected, double value)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED * std::abs(expected), expected, value);
}

// 310 V, 2000 rpm, 2 pole pairs, 8 A: by hand.
TEST(typical_values_have_the_ratios_of_the_zoo)
{
    const Folder folder;
    write_plate(folder);
    const nf::Config config = nf::load_plate("m", "b");
    const nf::MotorSettings motor = nf::typical(config.motor, config.board);
    const double speed_mech = 2000 * 3.14159265358979323846 / 30;
    const double emf_v = 0.6 * 310 / std::sqrt(3.0);
    const double share = 0.15 * std::pow(1.5 * emf_v * 8 / 100, -0.35);
    expect_near(emf_v / (2 * speed_mech), motor.flux_linkage_wb);
    expect_near(share * emf_v / 8, motor.resistance_ohm);
    expect_near(0.13 * emf_v / (2 * speed_mech * 8), motor.inductance_d_h);
    expect_near(motor.inductance_d_h, motor.inductance_q_h);
    expect_near(1.5 * emf_v * 8 / speed_mech, motor.rated_torque_nm);
    expect_near(2000, motor.rated_speed_rpm);
    expect_near(0.1 * motor.rated_torque_nm / speed_mech, motor.inertia_kg_m2);
    expect_near(0.02 * motor.rated_torque_nm / speed_mech, motor.viscous_friction_nm_s);
}

void expect_within_ranges(const nf::Config &config)
{
    nf::Config copy = config;
    for (const std::string &key : nf::unknown_of_plate()) {
        const nf::Field &field = *nf::find_field(key);
        const double value = *std::get<double *>(field.target(copy));
        TEST_ASSERT_TRUE_MESSAGE(value >= field.min && value <= field.max, key.c_str());
    }
}

constexpr int MOTORS = 600; // a hundred of each class

// And the drive starts from them: the firmware's numbers hold them, with the rules of any motor.
TEST(typical_values_fit_the_boards_of_all_classes_of_the_zoo)
{
    for (int k = 0; k < MOTORS; k++) {
        const std::string name = fmt::format("zoo:{}", k);
        const nf::Config config = nf::with_typical(nf::load_plate(name, name));
        expect_within_ranges(config);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("accepted", refusal_of([&] { nf::build(config); }).c_str(),
                                         name.c_str());
    }
}

TEST(typical_values_stay_within_the_ranges_at_the_ends_of_the_plates)
{
    nf::Config config;
    for (const double rpm : {1.0, 200000.0}) {
        for (const double current_a : {0.01, 1000.0}) {
            for (const double bus_v : {5.0, 1000.0}) {
                for (const int pole_pairs : {1, 50}) {
                    config.motor.max_speed_rpm = rpm;
                    config.motor.max_current_a = current_a;
                    config.motor.continuous_current_a = current_a;
                    config.motor.pole_pairs = pole_pairs;
                    config.board.bus_nominal_v = bus_v;
                    config.motor = nf::typical(config.motor, config.board);
                    expect_within_ranges(config);
                }
            }
        }
    }
}

// A speed loop of 1 kHz is too fast for a slow period of 1 ms.
TEST(a_refusal_says_which_values_nobody_wrote)
{
    const Folder folder;
    write_plate(folder);
    const nf::Config config =
        nf::with_typical(nf::load_plate("m", "b", {}, {"speed_loop.bandwidth_hz=1000"}));
    const std::string line = refusal_of([&] { nf::build(config); });
    TEST_ASSERT_NOT_EQUAL_size_t(std::string::npos, line.find("speed_loop.bandwidth_hz"));
    TEST_ASSERT_EQUAL_STRING("motors/m.toml (typical value)",
                             config.origins.at("motor.inertia_kg_m2").text().c_str());
}

} // namespace
