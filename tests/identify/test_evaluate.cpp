// SPDX-License-Identifier: MIT
// What is said of a known motor: the values, the remarks, the table and the JSON.
#include "bars.h"
#include "evaluate.h"
#include "findings.h"
#include "plate.h"
#include "turning_motor.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "testing.h"

namespace
{

using namespace known;

constexpr double FITTED = 2e-3; // of each fit, test_legs_fit.cpp and its neighbours
constexpr double NOISE_CHANGE_A = 0.02;

// The board and the name plate of the records.
nf::Config plate()
{
    nf::Config config = nf::known_from_plate(nf::load_scenario("s1"));
    config.board.pwm_frequency_hz = 1 / PERIOD_S;
    config.board.current_full_scale_a = 20;
    config.board.bus_full_scale_v = 600;
    config.board.bus_nominal_v = BUS_V;
    config.motor.pole_pairs = POLE_PAIRS;
    config.motor.continuous_current_a = CONTINUOUS_A;
    config.motor.max_current_a = LARGEST_A;
    config.motor.max_speed_rpm = 2500;
    return config;
}

// mismatch: of the sensors, along and across the axes of a and b.
void add_bursts(Records &records, double mismatch)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int k = 0; k < 8; k++) {
            Record r;
            r.kind = "burst";
            r.axis = axis;
            r.across = k >= 4;
            r.current_a = r.across ? 0.6 : 1.0 + k;
            r.i_a = r.current_a;
            r.pulse_v = r.across ? 80 + 10 * k : 60;
            r.quarter_ticks = 3;
            r.ticks = 120;
            r.bus_v = BUS_V;
            const double seen = gain(axis, r.across ? -mismatch : mismatch);
            const double change_a = modelled_change(r, legs(), D_H) * seen;
            r.change_a =
                r.across ? std::complex<double>(0, change_a) : std::complex<double>(change_a, 0);
            records.all.push_back(r);
        }
    }
}

Records all_records(const Turning &t = {}, double mismatch = 0)
{
    Records records = no_records();
    Rest rest;
    rest.mismatch = mismatch;
    add_levels(records, rest);
    for (Record &level : records.all) {
        level.noise_a[0] = NOISE_CHANGE_A;
        level.noise_a[1] = NOISE_CHANGE_A;
    }
    add_bursts(records, mismatch);
    const Records turning = turning_records(t);
    records.all.insert(records.all.end(), turning.all.begin(), turning.all.end());
    records.scales.current_a = 40;
    records.scales.voltage_v = 600;
    return records;
}

Result result_of(const Turning &t = {})
{
    return evaluate(all_records(t), plate(), 25);
}

// Whether a remark is exactly this, or begins with it.
void expect_remark(const char *begin, const Result &result)
{
    const bool said =
        std::any_of(result.remarks.begin(), result.remarks.end(),
                    [&](const std::string &remark) { return remark.rfind(begin, 0) == 0; });
    TEST_ASSERT_TRUE_MESSAGE(said, result.remarks.empty() ? "nothing is said"
                                                          : result.remarks.front().c_str());
}

TEST(test_a_known_motor_is_found_without_a_remark)
{
    const Result found = result_of();
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * OHM, OHM, found.motor.resistance_ohm);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * D_H, D_H, found.motor.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * WB, WB, found.motor.flux_linkage_wb);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * INERTIA, INERTIA, found.motor.inertia_kg_m2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * KNEE_A, KNEE_A, found.measured.knee_a);
    TEST_ASSERT_EQUAL_size_t_MESSAGE(0, found.remarks.size(),
                                     found.remarks.empty() ? "" : found.remarks.front().c_str());
}

// The change from sample to sample is 2/√π of the deviation; 40 A are 2^adc_bits counts.
TEST(test_the_noise_is_in_counts)
{
    const nf::Config config = plate();
    const double count_a = 40 / std::exp2(config.board.adc_bits);
    const Result found = result_of();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, NOISE_CHANGE_A * 0.886227 / count_a,
                              found.measured.current_noise_lsb);
    TEST_ASSERT_TRUE(found.noise_bar_lsb > 0);
}

// A converter that rounds adds 1/√12 of a count, which noise of more than a count smooths away.
TEST(test_the_rounding_of_a_converter_is_in_the_bar_of_a_small_noise_only)
{
    const double count_a = 40 / std::exp2(plate().board.adc_bits);
    const auto bar_at = [&](double noise_lsb) {
        Records records = all_records();
        for (Record &r : records.all) {
            r.noise_a[0] = noise_lsb * count_a / 0.886227;
            r.noise_a[1] = r.noise_a[0];
        }
        return evaluate(records, plate(), 25).noise_bar_lsb;
    };
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.05 + 0.288675, bar_at(0));
    // exp(−2·π²/16) = 0.291213
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.05 + 0.0075 + 0.291213 * 0.288675, bar_at(0.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.05 + 0.06, bar_at(2));
}

TEST(test_a_disagreement_of_the_two_ways_to_the_flux_is_said)
{
    Turning t;
    t.coasting_wb = 1.05 * WB;
    expect_remark("φ is 0.2 Wb with current and 0.21 Wb without: the two ways disagree by",
                  result_of(t));
    t.coasting_wb = 1.5 * WB;
    const Result found = result_of(t);
    expect_remark("φ is 0.2 Wb with current and 0.3 Wb without: the two ways disagree by 50.0 %, "
                  "the flux linkage comes from the spin only",
                  found);
}

// Two sensors of 1 % each may differ by 2 %.
TEST(test_gains_that_differ_by_more_than_usual_are_said)
{
    const Result usual = evaluate(all_records({}, 0.02), plate(), 25);
    TEST_ASSERT_EQUAL_size_t_MESSAGE(0, usual.remarks.size(),
                                     usual.remarks.empty() ? "" : usual.remarks.front().c_str());
    for (const double mismatch : {0.05, -0.05}) {
        const Result found = evaluate(all_records({}, mismatch), plate(), 25);
        const double ratio = (1 + mismatch / 2) / (1 - mismatch / 2);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 100 * (ratio - 1), found.measured.gain_mismatch_pct);
        expect_remark(
            fmt::format("the current sensors' gains differ: a over b is {:.3f}", ratio).c_str(),
            found);
    }
}

TEST(test_a_rotor_that_stops_too_fast_is_said)
{
    Turning t;
    t.coast_windows = 2;
    expect_remark("the rotor stops too fast without current: the flux linkage comes from the spin "
                  "only",
                  result_of(t));
}

TEST(test_a_flux_that_changes_with_the_speed_is_said)
{
    Turning t;
    t.slow_wb = 1.2 * WB;
    expect_remark(
        "φ falls with the speed, 0.24 Wb at 477 rpm and 0.2 Wb at 1910 rpm: R or what the "
        "legs lose differs from that at rest",
        result_of(t));
    t.slow_wb = 0.8 * WB;
    expect_remark("φ rises with the speed, 0.16 Wb at 477 rpm", result_of(t));
}

TEST(test_a_highest_speed_beyond_the_bus_is_lowered)
{
    nf::Config config = plate();
    config.motor.max_speed_rpm = 9000;
    const Result found = evaluate(all_records(), config, 25);
    // the bus less the margin, over the largest φ that the bar leaves possible
    const nf::identify::Value &wb = found.flux.wb;
    const double bar_wb = nf::error_bar(wb.std, wb.bound);
    const double left_v = (1 - config.board.duty_margin_pct / 100) * BUS_V / std::sqrt(3.0);
    const double most_rpm = left_v / (wb.value + bar_wb) / POLE_PAIRS * 30 / 3.14159265358979323846;
    TEST_ASSERT_TRUE(bar_wb > 1e-3 * WB);
    TEST_ASSERT_EQUAL_DOUBLE(std::floor(most_rpm), found.motor.max_speed_rpm);
    expect_remark(
        fmt::format("max_speed_rpm is lowered from 9000 to {:.0f}", std::floor(most_rpm)).c_str(),
        found);
    TEST_ASSERT_NOT_EQUAL_size_t(
        std::string::npos,
        found.remarks.front().find(": above it the EMF exceeds the bus voltage"));
}

// More L across. An imposed current has i·cos of the load angle along the magnet, where the
// saliency takes from the flux.
Records salient_records(double q_h)
{
    const std::complex<double> j(0, 1);
    Records records = all_records();
    for (Record &r : records.all) {
        const double w = r.speed_el_rad_s;
        if (r.kind == "burst" && r.across) {
            r.change_a = std::complex<double>(0, modelled_change(r, legs(), q_h));
        } else if (w != 0 && r.i_a != std::complex<double>(0)) {
            const double less_wb = (q_h - D_H) * r.i_a.real() * std::cos(LAG_RAD);
            r.voltage_v +=
                j * w * held(w) * ((q_h - Q_H) * r.i_a - less_wb * std::polar(1.0, -LAG_RAD));
        }
    }
    return records;
}

// 0.9 of the voltage circle less R·i are 138.1 V of 0.95·300 V/√3 with 2 Ω at 5 A. They bear φ and
// L_q·i across it, 0.2 Wb and 16 mH · 5 A: 641.1 rad/s, 2040.8 rpm of three pole pairs, of which
// three digits stay.
TEST(test_the_rated_speed_leaves_room_for_the_voltage_of_l_q)
{
    constexpr double SALIENT_H = 0.016;
    const Result found = evaluate(salient_records(SALIENT_H), plate(), 25);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * SALIENT_H, SALIENT_H, found.motor.inductance_q_h);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * D_H, D_H, found.motor.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(FITTED * WB, WB, found.motor.flux_linkage_wb);
    TEST_ASSERT_EQUAL_DOUBLE(2040, found.motor.rated_speed_rpm);
}

TEST(test_records_of_another_board_are_refused)
{
    nf::Config config = plate();
    config.board.bus_full_scale_v = 500;
    try {
        evaluate(all_records(), config, 25);
        TEST_FAIL_MESSAGE("records of another board have been taken");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING("the records are of another board or motor: the bus's full scale, "
                                 "V, is 500 in the files and 600 in the records",
                                 error.what());
    }
}

TEST(test_the_table_and_the_json_have_a_row_each)
{
    const Result found = result_of();
    const std::string table = table_text(found, std::nullopt);
    const auto json = nlohmann::json::parse(json_text(found, std::nullopt, 15));
    for (const char *const title :
         {"R  ", "knee of a leg", "gain a/b - 1", "noise", "L_d at 2 A", "L_q at 5 A"}) {
        TEST_ASSERT_NOT_EQUAL_size_t_MESSAGE(std::string::npos, table.find(title), title);
    }
    for (const char *const key :
         {"resistance_ohm", "knee_a", "gain_mismatch_pct", "current_noise_lsb", "lost_time_s"}) {
        TEST_ASSERT_TRUE_MESSAGE(json.at(key).at("bar").get<double>() > 0, key);
        TEST_ASSERT_FALSE_MESSAGE(json.at(key).contains("truth"), key);
    }
    TEST_ASSERT_EQUAL_size_t(4, json.at("inductance_d_over_current").size());
    TEST_ASSERT_EQUAL_size_t(3, json.at("inductance_q_over_current").size());
    TEST_ASSERT_EQUAL_size_t(3, json.at("flux_over_speed").size());
}

} // namespace
