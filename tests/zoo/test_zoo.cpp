// SPDX-License-Identifier: MIT
// The zoo: how a motor is named, that it is the same everywhere, and that each is a motor somebody
// could have.
#include "block.h"
#include "config.h"
#include "draw.h"
#include "machine.h"
#include "zoo.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;
namespace zoo = nf::zoo;

constexpr int MOTORS = 300; // 50 of each class
constexpr double RAD_S_PER_RPM = 3.14159265358979323846 / 30;
// Files have six digits.
constexpr double ROUNDING = 2e-5;
const std::set<std::string> CLASSES = {"gimbal", "outrunner",  "hub",
                                       "servo",  "compressor", "industrial"};

void expect_within(double low, double high, double value, const std::string &what)
{
    const bool is_within = value >= low * (1 - ROUNDING) && value <= high * (1 + ROUNDING);
    TEST_ASSERT_TRUE_MESSAGE(is_within,
                             fmt::format("{}: {} not in {}…{}", what, value, low, high).c_str());
}

nf::Config load(const std::string &name)
{
    return nf::load_scenario(name);
}

// What a text is refused with; "" where it is accepted.
std::string refusal(const std::function<void()> &load)
{
    try {
        load();
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

zoo::Reference parsed(const std::string &name)
{
    const std::optional<zoo::Reference> found = zoo::parse(name);
    TEST_ASSERT_TRUE_MESSAGE(found.has_value(), name.c_str());
    return *found;
}

// ---- names ----------------------------------------------------------------------------------

TEST(a_name_is_a_number_with_class_and_seed_where_they_are_not_the_usual)
{
    const std::map<std::string, std::string> full = {
        {"zoo:0", "zoo:gimbal:0@1"},
        {"zoo:17", "zoo:industrial:17@1"},
        {"zoo:servo:17", "zoo:servo:17@1"},
        {"zoo:18@4294967295", "zoo:gimbal:18@4294967295"},
        {"zoo:hub:0@0:user", "zoo:hub:0@0:user"},
        {"zoo:1:user", "zoo:outrunner:1@1:user"},
    };
    for (const auto &[written, name] : full) {
        TEST_ASSERT_EQUAL_STRING(name.c_str(), parsed(written).name().c_str());
        TEST_ASSERT_EQUAL_STRING(name.c_str(), parsed(name).name().c_str());
    }
}

TEST(what_is_no_name_is_refused_with_what_is_one)
{
    for (const char *wrong :
         {"zoo:", "zoo:x", "zoo:-1", "zoo:1.5", "zoo:4294967296", "zoo:17@", "zoo:17@x",
          "zoo:bird:1", "zoo:servo:", "zoo:servo:1:2", "zoo:1:users", "zoo::1", "zoo:1@2@3"}) {
        const std::string said = refusal([&] { load(wrong); });
        TEST_ASSERT_EQUAL_STRING(
            fmt::format("command line: scenario = \"{}\": is not in the zoo; allowed: {}", wrong,
                        zoo::allowed())
                .c_str(),
            said.c_str());
    }
    TEST_ASSERT_NOT_EQUAL_size_t(std::string::npos, zoo::allowed().find("compressor, industrial"));
}

// A motor is one, exact or not; and there are no tunings.
TEST(only_a_scenario_is_of_a_user_and_nothing_is_a_tuning)
{
    const auto parts = [](const char *motor, const char *tuning) {
        return refusal([&] { nf::load_parts(motor, "zoo:1", tuning); });
    };
    TEST_ASSERT_EQUAL_STRING("", parts("zoo:1", "robust_motor_a").c_str());
    TEST_ASSERT_EQUAL_INT(0, parts("zoo:1:user", "robust_motor_a")
                                 .rfind("command line: motor = \"zoo:1:user\": is not", 0));
    TEST_ASSERT_EQUAL_STRING(
        "command line: tuning = \"zoo:1\": is not in the zoo; allowed: any, published, "
        "robust_motor_a, voltage_phase or a path ending in .toml",
        parts("zoo:1", "zoo:1").c_str());
}

TEST(a_refusal_names_the_line_of_the_drawn_file)
{
    const std::string said =
        refusal([] { nf::load_scenario("zoo:17", {}, {"board.overcurrent_a=0.1"}); });
    TEST_ASSERT_EQUAL_STRING(
        "zoo:industrial:17@1/motor.toml:13: motor.max_current_a = 24.7801: is "
        "too large; allowed: at most 0.1 A, which is board.overcurrent_a (--set)",
        said.c_str());
}

// ---- draws ----------------------------------------------------------------------------------

// Once and for all: results are compared over the years, and on other machines.
TEST(a_motor_is_the_same_everywhere)
{
    const nf::MotorSettings motor = load("zoo:servo:17@3").motor;
    TEST_ASSERT_EQUAL_STRING("servo, 144 W, 160 V", motor.name.c_str());
    TEST_ASSERT_EQUAL_STRING(
        "8 4.29097 4.11998e-05",
        fmt::format("{} {} {}", motor.pole_pairs, motor.resistance_ohm, motor.inertia_kg_m2)
            .c_str());
}

TEST(number_class_and_seed_each_make_another_motor)
{
    std::set<double> inertias;
    for (const char *name : {"zoo:servo:17", "zoo:servo:18", "zoo:hub:17", "zoo:servo:17@2"}) {
        inertias.insert(load(name).motor.inertia_kg_m2);
    }
    TEST_ASSERT_EQUAL_size_t(4, inertias.size());
}

TEST(a_number_that_is_drawn_does_not_depend_on_the_others)
{
    const zoo::Draw first("key");
    const zoo::Draw second("key");
    const double a = first.uniform("a", {0, 1});
    second.uniform("b", {0, 1});
    TEST_ASSERT_EQUAL_DOUBLE(a, second.uniform("a", {0, 1}));
    TEST_ASSERT_TRUE(std::abs(a - first.uniform("b", {0, 1})) > 0);
    TEST_ASSERT_TRUE(std::abs(a - zoo::Draw("kez").uniform("a", {0, 1})) > 0);
}

// Means of many draws, each within five standard deviations of the mean.
TEST(draws_fill_their_ranges_evenly)
{
    constexpr int many = 4000;
    const double sure = 5 / std::sqrt(static_cast<double>(many));
    double uniform = 0;
    int below_middle = 0;
    std::map<int, int> whole;
    for (int k = 0; k < many; k++) {
        const zoo::Draw draw(std::to_string(k));
        const double u = draw.uniform("u", {-2, 6});
        TEST_ASSERT_TRUE(u >= -2 && u < 6);
        uniform += u / many;
        below_middle += draw.log_uniform("l", {0.25, 4}) < 1 ? 1 : 0;
        whole[draw.whole("w", 3, 6)]++;
        TEST_ASSERT_LESS_THAN_size_t(5, draw.below("b", 5));
    }
    TEST_ASSERT_DOUBLE_WITHIN(sure * 8 / std::sqrt(12.0), 2, uniform);
    TEST_ASSERT_DOUBLE_WITHIN(sure * 0.5, 0.5, static_cast<double>(below_middle) / many);
    TEST_ASSERT_EQUAL_size_t(4, whole.size());
    TEST_ASSERT_EQUAL_INT(3, whole.begin()->first);
    for (const auto &[value, count] : whole) {
        TEST_ASSERT_DOUBLE_WITHIN(sure * std::sqrt(3.0 / 16), 0.25,
                                  static_cast<double>(count) / many);
    }
}

// ---- motors ---------------------------------------------------------------------------------

const std::map<std::string, std::vector<double>> POWER_AND_BUS = {
    {"gimbal", {5, 50, 12, 24}},           {"outrunner", {50, 2000, 12, 48}},
    {"hub", {150, 800, 24, 60}},           {"servo", {50, 2000, 48, 310}},
    {"compressor", {100, 3000, 310, 310}}, {"industrial", {1000, 15000, 310, 560}},
};

void expect_a_motor(const std::string &name, const nf::Config &config)
{
    const nf::MotorSettings &m = config.motor;
    const nf::BoardSettings &b = config.board;
    const std::string kind = parsed(name).kind;
    const std::vector<double> &range = POWER_AND_BUS.at(kind);
    const double rated = m.rated_speed_rpm * RAD_S_PER_RPM;
    const double power = m.rated_torque_nm * rated;
    const double omega = rated * m.pole_pairs;
    const double emf = omega * m.flux_linkage_wb;
    const double current = m.rated_torque_nm / (1.5 * m.pole_pairs * m.flux_linkage_wb);
    const double inductance = (m.inductance_d_h + m.inductance_q_h) / 2;
    expect_within(range[0], range[1], power, name + " power");
    expect_within(range[2], range[3], b.bus_nominal_v, name + " bus");
    expect_within(0.5, 0.8, emf * std::sqrt(3.0) / b.bus_nominal_v, name + " EMF");
    // A resistance of 1 mΩ, 1 µH and 1e-7 kg·m² are the least there is.
    const double loss = m.resistance_ohm * current / emf;
    expect_within(0.02,
                  kind == "gimbal"           ? 1
                  : m.resistance_ohm > 0.001 ? 0.15
                                             : 1,
                  loss, name + " copper loss");
    expect_within(0.03, m.inductance_d_h > 1e-6 ? 0.6 : 3, omega * inductance * current / emf,
                  name + " reactance");
    expect_within(1, 2.2, m.inductance_q_h / m.inductance_d_h, name + " saliency");
    expect_within(0.005, m.inertia_kg_m2 > 1e-7 ? 1 : 3,
                  m.inertia_kg_m2 * rated / m.rated_torque_nm, name + " acceleration");
    expect_within(1.3, 3, m.max_current_a / current, name + " largest current");
    expect_within(1.05, 1.3, m.max_speed_rpm / m.rated_speed_rpm, name + " highest speed");
    // The scenario's load at rated speed, with φ and the bus a tenth worse each.
    const double loaded =
        std::hypot(emf + m.resistance_ohm * current / 2, omega * m.inductance_q_h * current / 2);
    const double circle = (1 - b.duty_margin_pct / 100) * b.bus_nominal_v / std::sqrt(3.0);
    expect_within(0, 1 / 1.1 / 1.05, loaded / circle, name + " voltage");
}

void expect_a_board(const std::string &name, const nf::Config &config)
{
    const nf::MotorSettings &m = config.motor;
    const nf::BoardSettings &b = config.board;
    const double period = 1 / b.pwm_frequency_hz;
    expect_within(8000, 40000, b.pwm_frequency_hz, name + " PWM");
    expect_within(0, 0.35, m.max_speed_rpm * RAD_S_PER_RPM * m.pole_pairs * period, name + " turn");
    expect_within(1.3, 3, b.current_full_scale_a / m.max_current_a, name + " converter");
    expect_within(0, std::min(3e-6, 0.03 * period), b.dead_time_s, name + " dead time");
    expect_within(1.15, 3, b.overcurrent_a / m.max_current_a, name + " over-current");
    expect_within(1, 10, b.trip_a / b.overcurrent_a, name + " trip");
}

TEST(each_is_a_motor_and_a_board_of_its_class_that_the_firmware_takes)
{
    std::set<std::string> seen;
    for (int k = 0; k < MOTORS; k++) {
        const std::string name = fmt::format("zoo:{}", k);
        const nf::Config config = load(name);
        expect_a_motor(name, config);
        expect_a_board(name, config);
        TEST_ASSERT_EQUAL_STRING("", refusal([&] { nf::build(config); }).c_str());
        seen.insert(parsed(name).kind);
    }
    TEST_ASSERT_TRUE(seen == CLASSES);
}

// What is sent to a board, and what its image is made of, is what the simulator runs.
TEST(a_block_of_motor_and_board_has_the_configuration_of_the_simulated_drive)
{
    const unsigned motors = testing_runs(60, 600);
    for (unsigned k = 0; k < motors; k++) {
        const std::string name = fmt::format("zoo:{}", k);
        const config_block_t block = nf::make_block(nf::load_parts(name, name, nf::DEFAULT_TUNING));
        const drive_cfg_t simulated = nf::build(load(name + ":user"));
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&simulated, &block.cfg, sizeof simulated, name.c_str());
    }
}

void expect_errors(const std::string &name, const nf::Config &exact, const nf::Config &user)
{
    const nf::PlantSettings &p = user.plant;
    expect_within(0.7, 1.5, p.resistance_scale, name + " R");
    expect_within(0.8, 1.25, p.inductance_scale, name + " L");
    expect_within(0.9, 1.1, p.flux_scale, name + " flux");
    expect_within(0.5, 3, p.inertia_scale, name + " J");
    expect_within(0.8, 1.2, p.saliency_scale, name + " saliency");
    expect_within(0.7, 1.3, p.dead_time_s / exact.board.dead_time_s, name + " dead time");
    expect_within(0, 0.05, p.coulomb_friction_nm / exact.motor.rated_torque_nm, name + " Coulomb");
    expect_within(0, 3, p.cogging_pct, name + " cogging");
    expect_within(0, 2, std::abs(p.emf_5th_pct), name + " 5th");
    expect_within(0, 1, std::abs(p.emf_7th_pct), name + " 7th");
    expect_within(0.5, 1.5, p.adc_noise_lsb, name + " noise");
    expect_within(2, 2, std::abs(p.adc_gain_error_pct[0] - p.adc_gain_error_pct[1]),
                  name + " gain");
    expect_within(5, 5, p.bus_ripple_pct, name + " ripple");
    TEST_ASSERT_TRUE(p.commutation_knee_a > 0);
    TEST_ASSERT_EQUAL_DOUBLE(exact.board.dead_time_s, user.model.dead_time_s);
    expect_within(0, 0.5, user.scenario.load.front().value / exact.motor.rated_torque_nm,
                  name + " load");
}

// The file is the same, what is real is not.
TEST(a_users_motor_differs_from_its_file)
{
    for (int k = 0; k < MOTORS; k++) {
        const std::string name = fmt::format("zoo:{}", k);
        const nf::Config exact = load(name);
        const nf::Config user = load(name + ":user");
        expect_errors(name, exact, user);
        TEST_ASSERT_EQUAL_DOUBLE(exact.motor.resistance_ohm, user.motor.resistance_ohm);
        TEST_ASSERT_EQUAL_DOUBLE(1, exact.plant.resistance_scale);
        TEST_ASSERT_EQUAL_DOUBLE(exact.board.dead_time_s, exact.plant.dead_time_s);
        TEST_ASSERT_EQUAL_DOUBLE(exact.scenario.duration_s, user.scenario.duration_s);
    }
}

TEST(the_saliency_of_the_real_motor_is_the_files_times_its_error)
{
    const nf::Config user = load("zoo:4:user");
    const plant_cfg_t plant = nf::make_plant_cfg(user, nf::build(user));
    const double file = user.motor.inductance_q_h / user.motor.inductance_d_h;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, file * user.plant.saliency_scale,
                              plant.motor.inductance_q_h / plant.motor.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, user.plant.inductance_scale,
                              plant.motor.inductance_d_h / user.motor.inductance_d_h);
}

// ---- where they go --------------------------------------------------------------------------

TEST(a_motor_brings_its_board_along_unless_another_is_chosen)
{
    const auto board = [](const std::vector<std::string> &set) {
        return nf::load_scenario("any", {}, set).board.name;
    };
    const std::string own = load("zoo:4").board.name;
    TEST_ASSERT_EQUAL_STRING(own.c_str(), board({"motor=zoo:4"}).c_str());
    const std::string bench = nf::load_scenario("any").board.name;
    TEST_ASSERT_EQUAL_STRING(bench.c_str(), board({"motor=zoo:4", "board=bench_310v"}).c_str());
    TEST_ASSERT_EQUAL_STRING(bench.c_str(), board({"board=bench_310v", "motor=zoo:4"}).c_str());
    TEST_ASSERT_EQUAL_STRING(bench.c_str(), board({"motor=motor_b"}).c_str());
}

TEST(its_errors_are_a_set_of_imperfections_for_any_scenario)
{
    const nf::Config any = nf::load_scenario("any", {"zoo:17"}, {"motor=zoo:17"});
    const nf::Config user = load("zoo:17:user");
    TEST_ASSERT_EQUAL_DOUBLE(user.plant.flux_scale, any.plant.flux_scale);
    TEST_ASSERT_EQUAL_STRING("zoo:industrial:17@1", any.sources.imperfections.front().c_str());
    TEST_ASSERT_EQUAL_STRING("zoo:industrial:17@1", any.sources.motor.c_str());
    TEST_ASSERT_EQUAL_STRING("zoo:industrial:17@1:user", user.scenario.id.c_str());
}

// As nfconfig writes them.
TEST(the_files_make_the_same_run)
{
    std::string folder = (fs::temp_directory_path() / "zooXXXXXX").string();
    TEST_ASSERT_NOT_NULL(mkdtemp(folder.data()));
    for (const zoo::File &file : zoo::files(parsed("zoo:17"))) {
        std::ofstream(fs::path(folder) / file.name) << file.text;
    }
    for (const auto &[file, name] :
         {std::pair("exact.toml", "zoo:17"), {"user.toml", "zoo:17:user"}}) {
        const nf::Config written = load(folder + "/" + file);
        const nf::Config drawn = load(name);
        const drive_cfg_t a = nf::build(written);
        const drive_cfg_t b = nf::build(drawn);
        TEST_ASSERT_EQUAL_UINT32(a.crc, b.crc);
        TEST_ASSERT_EQUAL_DOUBLE(drawn.plant.flux_scale, written.plant.flux_scale);
        TEST_ASSERT_EQUAL_size_t(drawn.scenario.load.size(), written.scenario.load.size());
    }
    fs::remove_all(folder);
}

} // namespace
