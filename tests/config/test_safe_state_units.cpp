// SPDX-License-Identifier: MIT
// Up to which speed open gates are safe, what the short circuit takes, and the line for each
// highest speed at which nothing is safe.
#include "folder.h"

#include "numbers.h"
#include "safe_state_units.h"

#include "testing.h"

#include <cmath>

using test::Folder;
using test::refusal;

namespace
{

using Words = std::vector<std::string>;

constexpr double RELATIVE = 1e-12; // a few products of doubles
constexpr double ROUNDING = 0.5;   // of an integer field
constexpr double ROOT_3 = 1.7320508075688772;

// The motor m: P 2, R 2.125 ohm, L 11.6 mH, 0.387 Wb, 2000 rpm, 10 A. The board b: 200, 310, 400 V,
// 18 A.
nf::Config loaded(const Words &set)
{
    return nf::load_scenario("s", {}, set);
}

double safe_speed(const Words &set)
{
    const nf::Config config = loaded(set);
    return nf::safe_open_speed(config.motor, config.board);
}

void expect(double by_hand, double found)
{
    TEST_ASSERT_DOUBLE_WITHIN(RELATIVE * std::abs(by_hand), by_hand, found);
}

void expect_line(const Words &set, const char *line)
{
    TEST_ASSERT_EQUAL_STRING(line, refusal({}, set).c_str());
}

TEST(without_a_capacitance_the_emf_stays_below_the_highest_bus)
{
    const Folder folder;
    expect(400 / (ROOT_3 * 0.387), safe_speed({}));
}

// 1.5·11.6 mH·(18 A)²/1 mF = 5637.6 V²: from 200 V it is 300 V less 5637.6/400, from 310 V 355 V
// less 5637.6/180.
TEST(a_capacitor_is_charged_from_the_lowest_bus_by_emf_and_windings)
{
    const Folder folder;
    expect((300 - 14.094) / (ROOT_3 * 0.387), safe_speed({"board.bus_capacitance_f=1e-3"}));
    // 28188 V²: 300 V less 70.47, 355 less 156.6
    expect((355 - 156.6) / (ROOT_3 * 0.387), safe_speed({"board.bus_capacitance_f=2e-4"}));
}

// The saliency adds up to half of |L_q − L_d|·I to the flux: 0.387 Wb and 5 mH·10 A/2. The larger L
// has the energy.
TEST(a_salient_motor_gives_the_bus_more_whichever_axis_has_more_inductance)
{
    const Folder folder;
    const double square = 1.5 * 0.0166 * 324 / 1e-3;
    for (const char *larger : {"motor.inductance_q_h=0.0166", "motor.inductance_d_h=0.0166"}) {
        expect((300 - square / 400) / (ROOT_3 * (0.387 + 0.025)),
               safe_speed({"board.bus_capacitance_f=1e-3", larger}));
    }
}

TEST(open_gates_are_the_default_and_short_no_motor)
{
    const Folder folder;
    const safe_state_cfg_t c = nf::build(loaded({})).safe_state;
    TEST_ASSERT_EQUAL_INT32(0, c.open_speed);
}

const Words SHORT = {"board.safe_state=short", "board.bus_capacitance_f=1e-3"};

Words also(Words a, const Words &b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// A short circuit in time leaves the 400 V less what 18 A charge in two control periods, 3.6 V.
// From 200 V that leaves 298.2 V less 5637.6/392.8: 423.5 rad/s, 0.04235 rad a tick. 18.9 ticks are
// 0.8 rad, 296.8 two turns. The short circuit takes 423.5·0.387/√(2.125² + 4.912²) = 30.6 A, of
// which the sensors see 20 A; over 19 ticks it changes by 2·20·sin 0.4023.
TEST(the_numbers_of_the_firmware)
{
    const Folder folder;
    const safe_state_cfg_t c = nf::build(loaded(SHORT)).safe_state;
    const double limit = 400 - 3.6;
    const double turn =
        ((limit + 200) / 2 - 5637.6 / (2 * (limit - 200))) / (ROOT_3 * 0.387) * 1e-4;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, turn / nf::TWO_PI * 4294967296.0, c.open_speed);
    TEST_ASSERT_EQUAL_UINT32(19, c.span_ticks);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.75 * 40 * std::sin(9.5 * turn) / 40 * 32768,
                              c.change_min);
    TEST_ASSERT_EQUAL_UINT32(297, c.settle_ticks);
}

double acting_limit(const Words &set)
{
    const nf::Config config = loaded(set);
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    const double limit = nf::acting_bus_limit(config.board);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, limit / bases.voltage_v * 32768,
                              nf::build(config).protection.bus_max);
    return limit;
}

// Two control periods of 80 A charge 1 mF by 16 V, of 18 A by 3.6 V. Open gates ask for nothing of
// it.
TEST(a_motor_is_shorted_two_periods_of_charge_below_the_highest_bus)
{
    const Folder folder;
    expect(400 - 16, acting_limit(also(SHORT, {"board.trip_a=80"})));
    expect(400 - 3.6, acting_limit(SHORT));
    expect(400, acting_limit({"board.trip_a=80"}));
}

// Of the way from nominal to the fault's limit, 384 V: derating of the braking begins at half of
// it, and has ended at 3/4 of the rest.
TEST(braking_is_derated_before_the_motor_is_shorted)
{
    const Folder folder;
    const nf::Config config = loaded(also(SHORT, {"board.trip_a=80"}));
    const double step = nf::make_bases(config.motor, config.board).voltage_v / 32768;
    const derating_cfg_t c = nf::build(config).derating;
    TEST_ASSERT_EQUAL_INT32(32767, derating_share(&c.bus_high, static_cast<int32_t>(346 / step)));
    TEST_ASSERT_TRUE(derating_share(&c.bus_high, static_cast<int32_t>(362 / step)) < 32768 / 2);
    TEST_ASSERT_EQUAL_INT32(0, derating_share(&c.bus_high, static_cast<int32_t>(376 / step)));
}

TEST(the_short_circuit_current_by_hand)
{
    const Folder folder;
    nf::Config config = loaded({});
    // At R/L: φ/(√2·L).
    expect(0.387 / 0.0116 / std::sqrt(2.0),
           nf::short_circuit_current(config.motor, 2.125 / 0.0116));
    // Without R it is φ/L_d at any speed, and the peak adds the flux of 10 A, hypot(0.387, 0.116),
    // over L.
    config.motor.resistance_ohm = 0;
    expect(0.387 / 0.0116, nf::short_circuit_current(config.motor, 100));
    const double voltage = 400 * 0.95 / ROOT_3 / nf::safe_open_speed(config.motor, config.board);
    TEST_ASSERT_TRUE(voltage < std::hypot(0.387, 0.116)); // no more turns at that speed
    expect((0.387 + voltage) / 0.0116, nf::short_circuit_peak(config.motor, config.board, 100));
}

// The flux of 10 A stays for half a turn, less what R takes of it over the larger L: it drives most
// current through the smaller one.
TEST(the_peak_of_a_short_circuit_is_that_of_the_axis_with_less_inductance)
{
    const Folder folder;
    constexpr double SPEED = 500;
    const double flux = std::hypot(0.387, 0.0066 * 10); // the voltage lets more turn
    const double x_d = SPEED * 0.0116;
    const double x_q = SPEED * 0.0066;
    const double lasting = SPEED * 0.387 * std::hypot(2.125, x_q) / (2.125 * 2.125 + x_d * x_q);
    const double left = std::exp(-nf::PI * 2.125 / x_d);
    const nf::Config config = loaded({"motor.inductance_q_h=0.0066"});
    expect(lasting + flux / 0.0066 * left,
           nf::short_circuit_peak(config.motor, config.board, SPEED));
}

const Words FAST = {"board.bus_capacitance_f=1e-3"};

TEST(a_highest_speed_beyond_open_gates_is_refused)
{
    const Folder folder;
    expect_line(
        FAST,
        "motors/m.toml:10: motor.max_speed_rpm = 2000: does not fit the firmware; allowed: at most 1770 rpm: above it, at the limit of the over-speed fault, the EMF charges the bus beyond board.bus_max_v once the gates open; "
        "board.safe_state = \"short\" shorts the motor instead");
    TEST_ASSERT_EQUAL_STRING("accepted",
                             refusal({}, also(FAST, {"motor.max_speed_rpm=1770"})).c_str());
}

TEST(a_capacitor_too_small_for_the_windings_is_refused)
{
    const Folder folder;
    expect_line(
        {"board.bus_capacitance_f=8e-5"},
        "--set: board.bus_capacitance_f = 8e-05: does not fit the firmware; allowed: at least 8.823e-05 F: below it the energy "
        "of the motor's windings at board.overcurrent_a alone charges the bus beyond board.bus_max_v");
}

TEST(a_short_circuit_that_trips_the_comparators_is_refused)
{
    const Folder folder;
    expect_line(
        also(FAST, {"board.safe_state=short", "board.trip_a=30"}),
        "motors/m.toml:10: motor.max_speed_rpm = 2000: does not fit the firmware; allowed: at most 1749 rpm: above it a stop or a fault shorts the motor, and the peak of that current makes the comparators open the "
        "gates: board.trip_a is too low for this motor");
    TEST_ASSERT_EQUAL_STRING(
        "accepted", refusal({}, also(FAST, {"board.safe_state=short", "board.trip_a=90"})).c_str());
}

TEST(a_short_circuit_that_demagnetises_is_refused)
{
    const Folder folder;
    expect_line(
        also(FAST, {"board.safe_state=short", "motor.demagnetising_current_a=40"}),
        "motors/m.toml:10: motor.max_speed_rpm = 2000: does not fit the firmware; allowed: at most 1758 rpm: above it a stop or a fault shorts the motor, and the peak of that current is beyond "
        "motor.demagnetising_current_a");
    TEST_ASSERT_EQUAL_STRING(
        "accepted",
        refusal({}, also(FAST, {"board.safe_state=short", "motor.demagnetising_current_a=90"}))
            .c_str());
}

// 200 A would charge less from 310 V beyond 355 V in two periods.
TEST(a_capacitor_too_small_to_be_caught_in_time_is_refused)
{
    const Folder folder;
    const std::string rest =
        ": does not fit the firmware; allowed: at least 0.0008889 F: with board.safe_state = \"short\": in two control periods the largest current may charge it by half "
        "of the way from board.bus_nominal_v to board.bus_max_v";
    expect_line({"board.safe_state=short", "board.trip_a=200", "board.bus_capacitance_f=0.00088"},
                ("--set: board.bus_capacitance_f = 0.00088" + rest).c_str());
    expect_line({"board.safe_state=short", "board.trip_a=200", "board.bus_capacitance_f=0"},
                ("--set: board.bus_capacitance_f = 0" + rest).c_str());
}

TEST(the_capacitor_has_to_be_written)
{
    const Folder folder;
    expect_line(
        {"board.safe_state=short"},
        "--set: board.safe_state = \"short\": board.bus_capacitance_f is not written; allowed: \"open\", or \"short\" with it");
}

// It is never shorted by a stop or a fault.
TEST(a_motor_that_stays_below_that_speed_is_not_asked_for_its_short_circuit)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING(
        "accepted",
        refusal({}, also(SHORT, {"board.trip_a=30", "motor.max_speed_rpm=1700"})).c_str());
}

} // namespace
