// SPDX-License-Identifier: MIT
// The files that come with the project, and the header made of them.
#include "config.h"
#include "describe.h"
#include "files.h"
#include "hal_header.h"
#include "header.h"
#include "schema.h"
#include "temperature_sensor.h"

extern "C" {
#include "about.h"
}

#include <algorithm>
#include <fmt/format.h>

extern "C" {
#include "config_check.h"
}

#include "testing.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

// generated.c, compiled from headers that nfconfig wrote
extern "C" const drive_cfg_t *generated_motor_a(void);
extern "C" const drive_cfg_t *generated_motor_b(void);
extern "C" const about_t *about_generated_motor_a(void);
extern "C" const about_t *about_generated_motor_b(void);

namespace
{

// Each motor for 24 to 48 V has its boards, and each one that weakens its field one that shorts it;
// the motors of both papers go with every laboratory inverter for 310 V.
bool go_together(const std::string &motor, const std::string &board)
{
    const std::multimap<std::string, std::string> own_boards = {
        {"odrive_d5065", "b_g431b_esc1"},
        {"odrive_d5065", "moteus_r4"},
        {"outrunner_24v", "b_g431b_esc1"},
        {"outrunner_24v", "moteus_r4"},
        {"outrunner_48v", "vesc_6"},
        {"outrunner_48v", "g474_in_line"},
        {"gbm2804h", "nucleo_ihm16m1"},
        {"teknic_m2310p", "frdm_mc_lvpmsm"},
        {"compressor", "compressor_310v"},
        {"motor_a_weakened", "bench_310v_short"},
        {"motor_b_weakened", "bench_310v_short"}};
    const auto [first, last] = own_boards.equal_range(motor);
    if (first != last) {
        return std::any_of(first, last, [&](const auto &own) { return own.second == board; });
    }
    return board == "bench_310v" || board == "bench_310v_short" || board == "g431_bench";
}

TEST(each_board_has_a_motor_that_goes_with_it)
{
    for (const std::string &board : nf::list_boards()) {
        const std::vector<std::string> motors = nf::list_motors();
        TEST_ASSERT_TRUE_MESSAGE(
            std::any_of(motors.begin(), motors.end(),
                        [&](const std::string &motor) { return go_together(motor, board); }),
            board.c_str());
    }
}

const std::vector<std::string> WEAKENED = {"compressor", "motor_a_weakened", "motor_b_weakened"};

// The voltage drive holds i_d at 0.
bool go_together(const std::string &motor, const std::string &board, const std::string &tuning)
{
    const bool weakens = std::find(WEAKENED.begin(), WEAKENED.end(), motor) != WEAKENED.end();
    return go_together(motor, board) && !(weakens && tuning == "voltage_phase");
}

bool is_accepted(const std::string &motor, const std::string &board,
                 const std::vector<std::string> &set, const char *tuning = "any")
{
    try {
        nf::build(nf::load_parts(motor, board, tuning, {}, set));
        return true;
    } catch (const nf::ConfigError &) {
        return false;
    }
}

// Its board is its own because it shorts the motor; the other one that does may suit it too.
TEST(a_motor_that_weakens_its_field_is_refused_where_a_fault_opens_the_gates_or_nothing_weakens)
{
    for (const std::string &motor : WEAKENED) {
        for (const std::string &board : nf::list_boards()) {
            if (go_together(motor, board)) {
                TEST_ASSERT_TRUE_MESSAGE(is_accepted(motor, board, {}), motor.c_str());
                TEST_ASSERT_FALSE_MESSAGE(is_accepted(motor, board, {"board.safe_state=open"}),
                                          motor.c_str());
                TEST_ASSERT_FALSE_MESSAGE(is_accepted(motor, board, {}, "voltage_phase"),
                                          motor.c_str());
            } else if (board != "bench_310v_short" && board != "compressor_310v") {
                TEST_ASSERT_FALSE_MESSAGE(is_accepted(motor, board, {}), motor.c_str());
            } else {
                // Its comparators and its scale decide.
            }
        }
    }
}

TEST(every_shipped_combination_fits_the_firmware)
{
    for (const std::string &motor : nf::list_motors()) {
        for (const std::string &board : nf::list_boards()) {
            for (const std::string &tuning : nf::list_tunings()) {
                if (!go_together(motor, board, tuning)) {
                    continue;
                }
                const drive_cfg_t cfg = nf::build(nf::load_parts(motor, board, tuning));
                TEST_ASSERT_NULL(config_check(&cfg));
            }
        }
    }
}

TEST(every_shipped_imperfection_fits_the_firmware)
{
    for (const std::string &name : nf::list_imperfections()) {
        const drive_cfg_t cfg =
            nf::build(nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {name}));
        TEST_ASSERT_NULL(config_check(&cfg));
    }
}

TEST(every_shipped_scenario_fits_the_firmware)
{
    for (const nf::ScenarioInfo &info : nf::list_scenarios()) {
        const nf::Config config = nf::load_scenario(info.id);
        const drive_cfg_t cfg = nf::build(config);
        TEST_ASSERT_NULL(config_check(&cfg));
        TEST_ASSERT_TRUE_MESSAGE(config.scenario.notes.empty(), info.id.c_str());
    }
}

TEST(the_set_all_is_the_sum_of_its_parts)
{
    const nf::PlantSettings plant =
        nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {"all"}).plant;
    TEST_ASSERT_EQUAL_DOUBLE(1.3, plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(0.95, plant.flux_scale);
    TEST_ASSERT_EQUAL_DOUBLE(0.8, plant.inductance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(2e-6, plant.dead_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(1.2, plant.device_drop_v);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, plant.adc_noise_lsb);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, plant.adc_offset_lsb[0]);
    TEST_ASSERT_EQUAL_DOUBLE(0.05, plant.coulomb_friction_nm);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, plant.bus_ripple_pct);
}

// But for the dead time and drop of the board, which the drive is told.
TEST(imperfections_of_the_plant_leave_the_firmware_alone)
{
    const drive_cfg_t plain = nf::build(nf::load_parts("motor_a", "bench_310v", "robust_motor_a"));
    const drive_cfg_t all =
        nf::build(nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {"all"},
                                 {"model.dead_time_s=0", "model.device_drop_v=0"}));
    const drive_cfg_t imp =
        nf::build(nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {"imp"}));
    TEST_ASSERT_EQUAL_MEMORY(&plain, &all, sizeof plain);
    TEST_ASSERT_NOT_EQUAL_INT(plain.observer.flux_q27, imp.observer.flux_q27);
}

// The number behind `name` in a hardware binding's header.
double defined(const std::string &header, const std::string &name)
{
    const std::size_t found = header.find(name + " (");
    TEST_ASSERT_TRUE(found != std::string::npos);
    return std::stod(header.substr(found + name.size() + 2));
}

double dead_time_of_the_timer(const nf::Config &config)
{
    return defined(nf::make_hal_header(config), "HAL_DEAD_TIME_TICKS") /
           config.board.timer_clock_hz;
}

// A slow PWM with a wide margin: the chip's limits come before those of the period.
const std::vector<std::string> SLOW = {"board.pwm_frequency_hz=6000", "board.duty_margin_pct=25",
                                       "motor.max_speed_rpm=1800", "board.bus_nominal_v=380"};

// "" or the refusal, after what hal/stm32g4/board.c asserts has held.
std::string refused_for_the_chip(std::vector<std::string> set)
{
    set.insert(set.begin(), SLOW.begin(), SLOW.end());
    try {
        const std::string header =
            nf::make_hal_header(nf::load_parts("motor_a", "g431_bench", "robust_motor_a", {}, set));
        TEST_ASSERT_EQUAL_DOUBLE(170e6, defined(header, "HAL_TIMER_CLOCK_HZ"));
        TEST_ASSERT_EQUAL_DOUBLE(12, defined(header, "HAL_ADC_BITS"));
        TEST_ASSERT_TRUE(defined(header, "HAL_DEAD_TIME_TICKS") <= 1008);
        TEST_ASSERT_TRUE(defined(header, "HAL_ADC_SAMPLING_NS") <= 1100);
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "";
}

TEST(a_header_that_is_made_is_one_that_the_chips_binding_compiles)
{
    TEST_ASSERT_EQUAL_STRING("", refused_for_the_chip({}).c_str());
    for (const nf::Field &field : nf::schema()) {
        nf::Config any;
        const nf::Target target = field.target(any);
        const std::string section = field.section;
        if ((section != "hal" && section != "board") ||
            (!std::holds_alternative<double *>(target) && !std::holds_alternative<int *>(target))) {
            continue;
        }
        for (const double end : {field.min, field.max}) {
            (void)refused_for_the_chip({fmt::format("{}={:.12g}", field.name(), end)});
        }
    }
}

TEST(what_the_chip_cannot_do_is_refused_where_it_is_written_and_its_ends_are_not)
{
    for (const char *fits : {"board.dead_time_s=5.929e-6", "hal.adc_sampling_ns=1100"}) {
        TEST_ASSERT_EQUAL_STRING("", refused_for_the_chip({fits}).c_str());
    }
    for (const char *misfit : {"board.dead_time_s=5.935e-06", "hal.adc_sampling_ns=1100.5",
                               "board.timer_clock_hz=160000000", "board.adc_bits=11"}) {
        const std::string key(misfit, std::strchr(misfit, '='));
        const std::string refusal = refused_for_the_chip({misfit});
        TEST_ASSERT_EQUAL_STRING(("--set: " + key + " = ").c_str(),
                                 refusal.substr(0, key.size() + 10).c_str());
        TEST_ASSERT_TRUE(refusal.find("this chip") != std::string::npos);
    }
}

// The timer rounds up to a tick of its clock, the drive to 2^-15 of the PWM period.
TEST(an_image_gives_back_the_dead_time_that_its_timer_makes)
{
    const std::map<std::string, std::string> images = {{"g431_bench", "motor_a"},
                                                       {"b_g431b_esc1", "outrunner_24v"}};
    for (const auto &[board, motor] : images) {
        const nf::Config config = nf::load_parts(motor, board, "robust_motor_a");
        const double period_s = 1 / config.board.pwm_frequency_hz;
        const double tolerance_s = 1 / config.board.timer_clock_hz + period_s / 32768 / 2;
        const double given_back_s = nf::build(config).modulator.dead_time_q15 * period_s / 32768;
        TEST_ASSERT_TRUE(given_back_s > tolerance_s);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance_s, dead_time_of_the_timer(config), given_back_s);
    }
}

// MB1419: from 3.3 V by an NTC of 10 kΩ at 25 °C, 3380 K, to the pin, and by 4.7 kΩ to ground.
double ntc_share(double celsius)
{
    const double ohm = 10e3 * std::exp(3380 * (1 / (celsius + 273.15) - 1 / 298.15));
    return 4.7e3 / (4.7e3 + ohm);
}

// What the line of the file makes of the sensor's own reading.
double temperature_by_file(const nf::BoardSettings &board, double celsius)
{
    const double count = std::ldexp(ntc_share(celsius), board.adc_bits);
    double low = board.temperature_points_c.front();
    double high = board.temperature_points_c.back();
    for (int k = 0; k < 50; k++) {
        const double middle = (low + high) / 2;
        (nf::temperature_count(board, middle) < count ? low : high) = middle;
    }
    return low;
}

TEST(the_temperature_of_the_board_as_sold_is_right_within_a_degree_from_0_to_100)
{
    for (const char *name : {"b_g431b_esc1", "g431_bench"}) {
        const nf::BoardSettings board =
            nf::load_parts(std::strcmp(name, "g431_bench") == 0 ? "motor_a" : "outrunner_24v", name,
                           "robust_motor_a")
                .board;
        for (int tenths = 0; tenths <= 1000; tenths++) {
            TEST_ASSERT_DOUBLE_WITHIN(1.0, tenths / 10.0,
                                      temperature_by_file(board, tenths / 10.0));
        }
    }
}

// A line of two points is the straight one that it was before there could be more.
TEST(a_line_of_two_points_is_straight)
{
    const nf::BoardSettings board = nf::load_parts("motor_a", "bench_310v", "robust_motor_a").board;
    for (int celsius = -50; celsius <= 150; celsius++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, (celsius + 50) / 200.0 * 4096,
                                  nf::temperature_count(board, celsius));
    }
}

// DS12589, operational amplifiers: 3 mV of offset, 2 % of gain; the bias is made by resistors of 1
// %.
TEST(an_offset_within_the_tolerances_of_each_board_of_the_chip_is_accepted)
{
    const char *const parts[][2] = {{"outrunner_24v", "b_g431b_esc1"}, {"motor_a", "g431_bench"}};
    for (const auto &part : parts) {
        const nf::Config config = nf::load_parts(part[0], part[1], "robust_motor_a");
        const nf::HalSettings &hal = config.hal;
        const double volts =
            3e-3 * hal.pga_gain + 0.02 * hal.amplifier_zero_v + 0.02 * hal.amplifier_zero_v;
        const double worst_a = volts / (hal.shunt_ohm * std::fabs(hal.amplifier_gain));
        TEST_ASSERT_TRUE(config.board.offset_max_a > worst_a);
    }
}

TEST(the_rows_cover_every_byte_of_the_configuration)
{
    const nf::Config config = nf::load_parts("motor_a", "bench_310v", "robust_motor_a");
    std::size_t bytes = 0;
    std::set<std::string> names;
    for (const nf::ConfigRow &row : nf::describe(config, nf::build(config))) {
        bytes += row.bytes;
        names.insert(row.path);
    }
    TEST_ASSERT_EQUAL_UINT(sizeof(drive_cfg_t), bytes);
    TEST_ASSERT_EQUAL_UINT(nf::describe(config, nf::build(config)).size(), names.size());
}

TEST(the_compiled_header_is_the_run_time_configuration_byte_for_byte)
{
    const drive_cfg_t a = nf::build(nf::load_parts("motor_a", "bench_310v", "published"));
    const drive_cfg_t b = nf::build(nf::load_parts("motor_b", "bench_310v", "robust_motor_a",
                                                   {"imp"}, {"motor.name=quote \" */ ?\?/ \\"}));
    TEST_ASSERT_EQUAL_MEMORY(&a, generated_motor_a(), sizeof a);
    TEST_ASSERT_EQUAL_MEMORY(&b, generated_motor_b(), sizeof b);
}

TEST(the_compiled_header_gives_the_numbers_their_units)
{
    const about_t &a = *about_generated_motor_a();
    TEST_ASSERT_EQUAL_STRING(
        "neurofoc: motor A (paper A, table 1), 310 V bench inverter, as published", a.name);
    TEST_ASSERT_NULL(a.build);
    TEST_ASSERT_EQUAL_UINT32(2, a.rotation.pole_pairs);
    TEST_ASSERT_EQUAL_UINT32(100000000, a.rotation.tick_ps);
    TEST_ASSERT_EQUAL_INT32(2000, a.speed_max_rpm);
    TEST_ASSERT_EQUAL_UINT32(1, a.is_example);
    TEST_ASSERT_EQUAL_UINT16(2048, a.current_zero_count);
    TEST_ASSERT_EQUAL_UINT32(20000000, a.current_full_scale_ua);
    TEST_ASSERT_EQUAL_UINT32(450000000, a.bus_full_scale_uv);
    TEST_ASSERT_EQUAL_INT32(-40, temperature_celsius(&a.temperature, 0));
    TEST_ASSERT_EQUAL_INT32(140, temperature_celsius(&a.temperature, 4095));
    TEST_ASSERT_EQUAL_STRING("neurofoc: quote _ */ __/ _, 310 V bench inverter, robust for motor A",
                             about_generated_motor_b()->name);
}

TEST(the_header_names_its_files_and_no_folder_of_this_machine)
{
    const std::string text = nf::make_header(nf::load_parts(
        "motor_a", "bench_310v", "robust_motor_a", {"imp"}, {"observer.kappa=0.01"}));
    for (const char *line :
         {" *     motor   motors/motor_a.toml (", " *     board   boards/bench_310v.toml (",
          " *     tuning  tunings/robust_motor_a.toml (", " *     with    imperfections/imp.toml\n",
          " *     set     observer.kappa=0.01\n"}) {
        TEST_ASSERT_NOT_NULL(std::strstr(text.c_str(), line));
    }
    TEST_ASSERT_NULL(std::strstr(text.c_str(), "host_sim"));
}

TEST(every_key_is_known_once_and_has_its_help)
{
    std::set<std::string> names;
    for (const nf::Field &field : nf::schema()) {
        TEST_ASSERT_TRUE(names.insert(field.name()).second);
        TEST_ASSERT_TRUE(field.min <= field.max);
        TEST_ASSERT_TRUE(std::strlen(field.help) > 0);
        TEST_ASSERT_FALSE(field.allowed().empty());
        TEST_ASSERT_FALSE(field.default_text().empty());
    }
}

// Paper A, table 1; paper B, section 4.
TEST(both_papers_motors_are_as_printed_and_run_from_310_v)
{
    const nf::Config a = nf::load_parts("motor_a", "bench_310v", "published");
    const nf::Config b = nf::load_parts("motor_b", "bench_310v", "published");
    TEST_ASSERT_EQUAL_INT(2, a.motor.pole_pairs);
    TEST_ASSERT_EQUAL_DOUBLE(2.125, a.motor.resistance_ohm);
    TEST_ASSERT_EQUAL_DOUBLE(0.0116, a.motor.inductance_d_h);
    TEST_ASSERT_EQUAL_DOUBLE(0.0116, a.motor.inductance_q_h);
    TEST_ASSERT_EQUAL_DOUBLE(0.387, a.motor.flux_linkage_wb);
    TEST_ASSERT_EQUAL_DOUBLE(7.8, a.motor.rated_torque_nm);
    TEST_ASSERT_EQUAL_DOUBLE(1800, a.motor.rated_speed_rpm);
    TEST_ASSERT_EQUAL_INT(2, b.motor.pole_pairs);
    TEST_ASSERT_EQUAL_DOUBLE(0.405, b.motor.resistance_ohm);
    TEST_ASSERT_EQUAL_DOUBLE(0.0135, b.motor.inductance_d_h);
    TEST_ASSERT_EQUAL_DOUBLE(0.0235, b.motor.inductance_q_h);
    TEST_ASSERT_EQUAL_DOUBLE(0.375, b.motor.flux_linkage_wb);
    TEST_ASSERT_EQUAL_DOUBLE(1200, b.motor.rated_speed_rpm);
    TEST_ASSERT_EQUAL_DOUBLE(310, a.board.bus_nominal_v);
}

// The keys of a motor's file whose lines are marked as assumptions.
std::set<std::string> assumed(const std::string &motor)
{
    std::ifstream file(nf::data_folder() / "motors" / (motor + ".toml"));
    std::set<std::string> keys;
    std::string line;
    while (std::getline(file, line)) {
        const std::size_t key_end = line.find(" = ");
        if (key_end != std::string::npos && line.find("# assumption") != std::string::npos) {
            keys.insert(line.substr(0, key_end));
        }
    }
    return keys;
}

TEST(what_a_paper_does_not_print_of_its_motor_is_marked_as_an_assumption)
{
    const std::set<std::string> not_in_a = {"max_speed_rpm", "max_current_a",
                                            "continuous_current_a", "inertia_kg_m2",
                                            "viscous_friction_nm_s"};
    const std::set<std::string> not_in_b = {"max_speed_rpm", "max_current_a", "inertia_kg_m2"};
    TEST_ASSERT_TRUE(assumed("motor_a") == not_in_a);
    TEST_ASSERT_TRUE(assumed("motor_b") == not_in_b);
}

} // namespace
