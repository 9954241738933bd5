// SPDX-License-Identifier: MIT
// Each kind of wrong input gets one line that names file, line, key, value and what is allowed.
#include "folder.h"

#include "testing.h"

#include <fmt/format.h>

using test::Folder;
using test::refusal;

namespace
{

// A line that is wrong. The message begins with the name of the file that it is in.
struct Case {
    const char *old; // empty: the text is appended
    const char *text;
    const char *message;
};

void expect_all(std::initializer_list<Case> cases)
{
    for (const auto &[old, text, message] : cases) {
        const std::string file = message;
        const Folder folder;
        folder.edit(file.substr(0, file.find(':')), old, text);
        TEST_ASSERT_EQUAL_STRING(message, refusal({"hot"}).c_str());
    }
}

// A wrong value in place of a valid one, and the message between "KEY = " and "; allowed: ".
struct Value {
    const char *text;
    const char *said;
};

void expect_values(const std::string &key, const std::string &valid, const std::string &allowed,
                   std::initializer_list<Value> cases)
{
    for (const auto &[text, said] : cases) {
        const Folder folder;
        folder.edit(key.substr(0, key.find(':')), valid, text);
        const std::string message = key + " = " + said + "; allowed: " + allowed;
        TEST_ASSERT_EQUAL_STRING(message.c_str(), refusal({"hot"}).c_str());
    }
}

// What is added to [scenario], from line 9 on, and the message after the file's name.
struct Added {
    const char *text;
    const char *message;
};

void expect_added(std::initializer_list<Added> cases)
{
    for (const auto &[text, message] : cases) {
        const Folder folder;
        folder.edit("scenarios/s.toml", "[accept.ideal]", std::string(text) + "\n[accept.ideal]");
        TEST_ASSERT_EQUAL_STRING((std::string("scenarios/s.toml:") + message).c_str(),
                                 refusal({"hot"}).c_str());
    }
}

// An override KEY=VALUE and the message after "--set: KEY = VALUE: ".
struct Override {
    const char *set;
    const char *said;

    std::string message() const
    {
        const std::string text = set;
        const std::size_t equals = text.find('=');
        return "--set: " + text.substr(0, equals) + " = " + text.substr(equals + 1) + ": " + said;
    }
};

void expect_overrides(std::initializer_list<Override> cases)
{
    const Folder folder;
    for (const Override &wrong : cases) {
        TEST_ASSERT_EQUAL_STRING(wrong.message().c_str(), refusal({}, {wrong.set}).c_str());
    }
}

// For an override whose message shows something else than KEY = VALUE: what follows "--set: ".
void expect_override(const char *set, const std::string &message)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING(("--set: " + message).c_str(), refusal({}, {set}).c_str());
}

void expect_begin(const std::string &expected, const std::string &message)
{
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), message.substr(0, expected.size()).c_str());
}

void expect_accepted(const std::vector<std::string> &set)
{
    TEST_ASSERT_EQUAL_STRING("accepted", refusal({}, set).c_str());
}

TEST(the_valid_files_are_accepted)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING("accepted", refusal().c_str());
    TEST_ASSERT_EQUAL_STRING("accepted", refusal({"hot"}).c_str());
}

TEST(an_unknown_key_is_named_with_the_nearest_known_one)
{
    expect_all({
        {"resistance_ohm", "resistence_ohm",
         "motors/m.toml:4: motor.resistence_ohm = 2.125: unknown key, did you mean "
         "motor.resistance_ohm?"},
        {"inertia_kg_m2", "inertia",
         "motors/m.toml:12: motor.inertia = 0.003: unknown key, did you mean motor.inertia_kg_m2?"},
        {"damping = 1", "damping = 1\nkappa = 0.1",
         "tunings/t.toml:7: speed_loop.kappa = 0.1: unknown key, did you mean observer.kappa?"},
        {"", "xyz = 1\n",
         "tunings/t.toml:15: position_loop.xyz = 1: unknown key; allowed: "
         "position_loop.bandwidth_hz, position_loop.speed_rpm, position_loop.acceleration_rad_s2, "
         "position_loop.softness_s"},
        {"[motor]", "xyz = 1\n[motor]",
         "motors/m.toml:1: xyz = 1: unknown key; allowed: motor, sensor, measured"},
    });
}

TEST(an_unknown_table_is_named_with_those_of_the_file)
{
    expect_all({
        {"[motor]", "[moter]",
         "motors/m.toml:1: [moter]: no table of motor files, did you mean [motor]?; allowed: "
         "[motor], [sensor], [measured]"},
        {"[plant]", "[motor]",
         "imperfections/warm.toml:1: [motor]: no table of imperfection files; allowed: "
         "[board], [model], [plant]"},
    });
}

TEST(a_missing_setting_is_named_with_its_table)
{
    expect_all({
        {"resistance_ohm = 2.125\n", "",
         "motors/m.toml:1: motor.resistance_ohm: is missing; allowed: 0.001 to 50 Ω"},
        {"damping = 1\n", "",
         "tunings/t.toml:4: speed_loop.damping: is missing; allowed: 0.1 to 10"},
        {"rated_torque_nm = 7.8\nrated_speed_rpm = 1800\n", "",
         "motors/m.toml:1: motor.rated_torque_nm (1e-05 to 10000 N·m), motor.rated_speed_rpm (1 to "
         "200000 rpm): are missing"},
        {"mode = \"speed\"\n", "",
         "scenarios/s.toml:4: scenario.mode: is missing; allowed: \"speed\", \"position\" or "
         "\"torque\""},
        {"tuning = \"t\"\n", "",
         "scenarios/s.toml:1: tuning: is missing; allowed: t or a path ending in .toml"},
    });
}

TEST(a_wrong_type_is_named)
{
    expect_values("motors/m.toml:4: motor.resistance_ohm", "2.125", "0.001 to 50 Ω",
                  {
                      {"\"2.125\"", "\"2.125\": is a string"},
                      {"true", "true: is a boolean"},
                      {"1979-05-27", "a date or time: is a date or time"},
                      {"[2.125]", "[2.125]: is a list"},
                  });
    expect_all({
        {"", "adc_offset_lsb = [1, 2, 3]\n",
         "imperfections/warm.toml:4: plant.adc_offset_lsb = [1, 2, 3]: has 3 items; allowed: "
         "[a, b], each -10000 to 10000 LSB"},
        {"motor = \"m\"", "motor = 5",
         "scenarios/s.toml:1: motor = 5: is a whole number; allowed: a string, the name or path of "
         "a file"},
        {"[\"warm\"]", "[1]",
         "imperfections/hot.toml:1: include = [1]: is no list of strings; allowed: names or paths "
         "of imperfection sets"},
    });
}

TEST(a_value_out_of_range_is_named_with_the_range_and_unit)
{
    expect_values("motors/m.toml:4: motor.resistance_ohm", "2.125", "0.001 to 50 Ω",
                  {{"-1", "-1: is too small"}});
    expect_values("boards/b.toml:5: board.adc_bits", "12", "a whole number, 8 to 15 bit",
                  {{"24", "24: is too large"}});
    expect_values("motors/m.toml:3: motor.pole_pairs", "2\n", "a whole number, 1 to 50",
                  {{"9223372036854775807\n", "9223372036854775807: is too large"}});
    expect_values("motors/m.toml:2: motor.name", "\"m\"", "a string of 1 to 80 characters",
                  {
                      {"5", "5: is a whole number"},
                      {"\"\"", "\"\": has 0 characters"},
                      {"\"a\\nb\"", "\"a\\nb\": has a control character"},
                  });
}

TEST(numbers_that_are_none_are_named)
{
    expect_values("motors/m.toml:4: motor.resistance_ohm", "2.125", "0.001 to 50 Ω",
                  {
                      {"nan", "nan: is not a finite number"},
                      {"+inf", "inf: is not a finite number"},
                      {"+2_1.5e400 # too large", "inf: is not a finite number"},
                      // Its place is counted in characters, not in bytes.
                      {"[\"µ\", 1e999]", "[\"µ\", inf]: is a list"},
                  });
    expect_values("scenarios/s.toml:8: scenario.command.speed_rpm", "1000", "-200000 to 200000 rpm",
                  {
                      {"-1e999", "-inf: is not a finite number"},
                      {"nan", "nan: is not a finite number"},
                  });
    expect_values("scenarios/s.toml:13: accept.any.speed_error_max_rpm", "50", "0 to 1000000",
                  {{"-inf", "-inf: is not a finite number"}});
}

TEST(settings_that_contradict_each_other_name_both)
{
    expect_all({
        {"max_current_a = 10", "max_current_a = 19",
         "motors/m.toml:11: motor.max_current_a = 19: is too large; allowed: at most 18 A, which "
         "is board.overcurrent_a (boards/b.toml:11)"},
        {"", "temperature_max_c = 150\n",
         "boards/b.toml:15: board.temperature_max_c = 150: is beyond what the sensor sees; "
         "allowed: between -50 and 150, the ends of board.temperature_points_c"},
        {"", "temperature_points_c = [0, 80]\n",
         "boards/b.toml:2: board.temperature_max_c = 100: is beyond what the sensor sees; allowed: "
         "between 0 and 80, the ends of board.temperature_points_c"},
        {"", "temperature_points_c = [80, 80]\n",
         "boards/b.toml:15: board.temperature_points_c = [80, 80]: does not rise; allowed: each "
         "above the one before"},
        {"", "temperature_points_c = [0, 80, 120]\n",
         "boards/b.toml:2: board.temperature_points_pct = [0, 100]: has not as many points as the "
         "temperatures; allowed: 3, one for each of board.temperature_points_c"},
        {"", "temperature_points_c = [0, 80, 120]\ntemperature_points_pct = [0, 50, 40]\n",
         "boards/b.toml:16: board.temperature_points_pct = [0, 50, 40]: turns around; allowed: "
         "each above the one before, or each below"},
        {"duration_s = 1", "duration_s = 1\nevaluate_from_s = 2",
         "scenarios/s.toml:8: scenario.evaluate_from_s = 2: is too large; allowed: at most 1 s, "
         "which is scenario.duration_s (scenarios/s.toml:7)"},
        {"duration_s = 1", "duration_s = 1\nprelude_s = 0.02",
         "scenarios/s.toml:8: scenario.prelude_s = 0.02: ends before the drive has calibrated its "
         "sensors; allowed: 0, which is as long as that takes, or at least 0.0267 s"},
    });
}

// Each with its own limit, in the unit of the key; at the limit nothing is wrong with that key.
TEST(what_the_firmware_cannot_hold_is_named_with_its_limit)
{
    const struct {
        const char *key;
        const char *value;
        const char *limit;
        const char *number; // of the limit
    } misfits[] = {
        {"board.timer_clock_hz", "1000000000", "at most 655300000 Hz", "655300000"},
        {"board.bus_min_v", "40", "at least 70.32 V", "70.32"},
        {"board.overcurrent_a", "20", "at most 19.98 A", "19.98"},
        {"current_loop.bandwidth_hz", "10000", "at most 4433 Hz", "4433"},
        {"speed_loop.bandwidth_hz", "1000", "at most 56.52 Hz", "56.52"},
        {"speed_loop.notch_hz", "700", "at most 500 Hz", "500"},
        {"speed_loop.notch_hz", "3.9", "at least 3.907 Hz", "3.907"},
        {"speed_loop.torque_filter_hz", "501", "at most 500 Hz", "500"},
        {"speed_loop.torque_filter_hz", "1", "at least 3.907 Hz", "3.907"},
        {"position_loop.speed_rpm", "0.1", "at least 14.2 rpm", "14.2"},
        {"position_loop.softness_s", "1", "at most 0.04908 s", "0.04908"},
        {"position_loop.acceleration_rad_s2", "10000000", "at most 3926000 rad/s²", "3926000"},
        {"motor.inductance_d_h", "1", "at most 0.02319 H", "0.02319"},
        {"board.temperature_warn_c", "100", "at most 99.9 °C", "99.9"},
    };
    const Folder folder;
    for (const auto &[key, value, limit, number] : misfits) {
        const std::string name = key;
        const std::string place = "--set: " + name + " = ";
        const std::string reason = ": does not fit the firmware; ";
        expect_begin(place + value + reason + "allowed: " + limit + ": ",
                     refusal({}, {name + "=" + value}));
        TEST_ASSERT_NOT_EQUAL_INT(
            0, refusal({}, {name + "=" + number}).rfind(place + number + reason, 0));
    }
}

// A motor whose φ/L_d of 0.35 A is small against the current range: 32767 steps of 2^-4 a radian
// are κ_p·(2/π)·I_b·I_x/(φ/L_d)²·2^(4 − 12); with I_b = I_x = 40 A, φ/L_d = 0.35 A that is κ_p =
// 0.2462.
TEST(a_gain_beyond_the_observer_is_named_with_what_it_can_be)
{
    const Folder folder;
    folder.edit("motors/m.toml", "flux_linkage_wb = 0.387", "flux_linkage_wb = 0.00406");
    folder.edit("tunings/t.toml", "kappa_p = 0", "kappa_p = 0.4");
    expect_begin(
        "motors/m.toml:7: motor.flux_linkage_wb = 0.00406: observer.kappa_p = 0.4 "
        "(tunings/t.toml:2) does not fit the firmware with it; allowed: write "
        "observer.kappa_p in a scenario or tuning of your own or with --set, at most 0.2462: ",
        refusal({}, {"observer.kappa=0.01", "motor.rated_torque_nm=0.05"}));
}

// A file outside the data folder is the user's; what serves every drive is not blamed for it.
TEST(a_motor_of_ones_own_is_blamed_before_a_shipped_tuning_or_board)
{
    const struct {
        const char *old;
        const char *text;
        const char *message; // its beginning, after the file's name
    } cases[] = {
        {"2000", "880",
         ":10: motor.max_speed_rpm = 880: is too small; allowed: at least 900 rpm, which is "
         "position_loop.speed_rpm (tunings/t.toml:12); or write position_loop.speed_rpm in a "
         "scenario or tuning of your own or with --set, at most 880 rpm, or 0, which leaves it to "
         "the motor"},
        {"0.003", "0.3",
         ":12: motor.inertia_kg_m2 = 0.3: speed_loop.bandwidth_hz = 20 (tunings/t.toml:5) does not "
         "fit the firmware with it; allowed: write speed_loop.bandwidth_hz in a scenario or tuning "
         "of your own or with --set, at most 5.652 Hz, or 0, which leaves it to the motor: more is "
         "beyond the firmware's gains"},
        {"inductance_d_h = 0.0116\ninductance_q_h = 0.0116\nflux_linkage_wb = 0.387",
         "inductance_d_h = 2e-5\ninductance_q_h = 2e-5\nflux_linkage_wb = 0.008",
         ":5: motor.inductance_d_h = 2e-05: board.pwm_frequency_hz = 10000 (boards/b.toml:3) does "
         "not fit the firmware"},
    };
    for (const auto &[old, text, message] : cases) {
        const Folder folder;
        folder.edit("motors/m.toml", old, text);
        const std::string path = folder.path().string() + "_own.toml";
        std::filesystem::rename("motors/m.toml", path);
        const std::string refused = refusal({}, {"motor=" + path});
        std::filesystem::remove(path);
        expect_begin(path + message, refused);
    }
}

// The other way round: a board of one's own for a shipped motor.
TEST(a_board_of_ones_own_is_blamed_before_a_shipped_motor)
{
    expect_override(
        "board.overcurrent_a=5",
        "board.overcurrent_a = 5: is too small; allowed: at least 10 A, which is "
        "motor.max_current_a (motors/m.toml:11); or write motor.max_current_a in a file "
        "of your own or with --set, at most 5 A");
    const Folder folder;
    const char *const low = "board.bus_nominal_v=201";
    const char *const blamed = "--set: board.bus_nominal_v = 201: motor.max_speed_rpm = 2000 "
                               "(motors/m.toml:10) does not fit the firmware with it; allowed";
    expect_begin(blamed, refusal({}, {low}));
    // Both are the user's, and move the limit alike where nothing weakens the flux.
    expect_begin(blamed,
                 refusal({}, {low, "motor.flux_linkage_wb=0.387", "current_loop.weakening_pct=0"}));
}

// A servo of 100 W on a board for ±15 A, with the gains of the robust tuning.
TEST(a_motor_of_little_flux_takes_the_usual_gains)
{
    const Folder folder;
    expect_accepted({"motor.pole_pairs=4", "motor.resistance_ohm=1", "motor.inductance_d_h=1e-3",
                     "motor.inductance_q_h=1e-3", "motor.flux_linkage_wb=0.01",
                     "motor.inertia_kg_m2=1e-5", "motor.max_current_a=8",
                     "board.pwm_frequency_hz=20000", "board.current_full_scale_a=15",
                     "board.overcurrent_a=13", "observer.kappa=0.01", "observer.kappa_p=0.1"});
}

// 0.7 rad in 100 µs are 7000 rad/s, 33423 rpm with two pole pairs; the EMF of 0.02 Wb fits the bus
// there.
TEST(a_speed_with_too_large_a_turn_in_a_period_is_named_with_what_is_allowed)
{
    const std::vector<std::string> fast = {
        "motor.resistance_ohm=0.133", "motor.inductance_d_h=0.000725",
        "motor.inductance_q_h=0.000725", "motor.flux_linkage_wb=0.02",
        "motor.inertia_kg_m2=1.2e-5"};
    const Folder folder;
    folder.edit("motors/m.toml", "max_speed_rpm = 2000", "max_speed_rpm = 40000");
    expect_begin("motors/m.toml:10: motor.max_speed_rpm = 40000: does not fit the firmware; "
                 "allowed: at most 33420 rpm: above it",
                 refusal({}, fast));
    folder.edit("motors/m.toml", "max_speed_rpm = 2000", "max_speed_rpm = 33420");
    expect_accepted(fast);
}

// Start-up, adaptation and what the tuning leaves to the motor, key by key.
TEST(the_optional_settings_are_refused_outside_their_ranges)
{
    expect_overrides({
        {"motor.continuous_current_a=-1", "is too small; allowed: 0 to 1000 A"},
        {"observer.feedback=0.31", "is too large; allowed: -1 to 0.3"},
        {"observer.rho_max=4", "is too large; allowed: -1 to 3.9"},
        {"startup.current_pct=201", "is too large; allowed: 0 to 200 %"},
        {"startup.handover_speed_pct=0", "is too small; allowed: 1 to 50 %"},
        {"adaptation.resistance_pct=91", "is too large; allowed: 0 to 90 %"},
        {"adaptation.inductance_pct=51", "is too large; allowed: 0 to 50 %"},
        {"adaptation.saliency_pct=101", "is too large; allowed: 0 to 100 %"},
        {"adaptation.flux_pct=-1", "is too small; allowed: 0 to 50 %"},
        {"current_loop.floor_pct=51", "is too large; allowed: -1 to 50 %"},
        {"current_loop.most_torque=0.7",
         "is a number with a fraction; allowed: a whole number, 0 to 1"},
        {"current_loop.most_torque=2", "is too large; allowed: a whole number, 0 to 1"},
        {"startup.align_current_pct=301", "is too large; allowed: 0 to 300 %"},
        {"model.dead_time_s=2e-05", "is too large; allowed: -1 to 1e-05 s"},
        {"model.device_drop_v=-2", "is too small; allowed: -1 to 10 V"},
        {"speed_loop.ramp_rpm_s=-1", "is too small; allowed: 0 to 10000000 rpm/s"},
    });
}

// A quarter of 33.3 µs, whoever's dead time it is.
TEST(a_dead_time_that_does_not_fit_is_named_where_it_is_written)
{
    const Folder folder;
    for (const char *const set :
         {"board.dead_time_s=9e-06", "plant.dead_time_s=9e-06", "model.dead_time_s=9e-06"}) {
        const Override wrong = {set, "does not fit the firmware; allowed: at most 8.333e-06 s: a "
                                     "quarter of the PWM period"};
        TEST_ASSERT_EQUAL_STRING(wrong.message().c_str(),
                                 refusal({}, {"board.pwm_frequency_hz=30000", set}).c_str());
    }
}

// What is said of 5000 rpm, and that the speed which is allowed is.
void expect_speed(std::vector<std::string> set, const std::string &allowed, const char *reason)
{
    const Folder folder;
    const std::string said =
        "does not fit the firmware; allowed: at most " + allowed + " rpm: above it" + reason;
    const Override beyond = {"motor.max_speed_rpm=5000", said.c_str()};
    set.emplace_back(beyond.set);
    TEST_ASSERT_EQUAL_STRING(beyond.message().c_str(), refusal({}, set).c_str());
    set.back() = "motor.max_speed_rpm=" + allowed;
    expect_accepted(set);
}

// Of 0.95·310 V/√3 = 170.03 V the current control keeps 3/256: 168.04 V at 2·0.387 Wb are 217.1
// rad/s. With i_d = −2.5 A, 25 % of 10 A, 11.6 mH leave 0.358 Wb: 234.7 rad/s.
TEST(a_speed_whose_emf_exceeds_the_bus_is_named_with_what_is_allowed)
{
    expect_speed({"current_loop.weakening_pct=0"}, "2073",
                 " the motor's EMF exceeds what board.bus_nominal_v and board.duty_margin_pct "
                 "leave, and current_loop.weakening_pct = 0 or drive.method = \"voltage_phase\" "
                 "does not weaken the field");
    expect_speed({"current_loop.weakening_pct=25"}, "2241",
                 " the motor's EMF exceeds what board.bus_nominal_v and board.duty_margin_pct "
                 "leave, even with the field weakened by current_loop.weakening_pct of "
                 "motor.max_current_a");
    // L_q has no part in what a current along the field leaves of it
    expect_speed({"current_loop.weakening_pct=25", "motor.inductance_q_h=0.0232"}, "2241",
                 " the motor's EMF exceeds what board.bus_nominal_v and board.duty_margin_pct "
                 "leave, even with the field weakened by current_loop.weakening_pct of "
                 "motor.max_current_a");
}

// With 95 % of 10 A the voltage would bear 2899 rpm. Without a capacitor 400 V/√3 at 1.15·2·0.387
// Wb: 259.5 rad/s.
TEST(a_speed_whose_emf_overcharges_the_bus_with_open_gates_is_named_with_what_is_allowed)
{
    expect_speed({}, "2477",
                 ", at the limit of the over-speed fault, the EMF charges the bus beyond "
                 "board.bus_max_v once the gates open; board.safe_state = \"short\" shorts the "
                 "motor instead");
}

// K_i follows as 8 times K_p, as far as the firmware's numbers hold: not its writer's matter.
TEST(a_voltage_gain_is_not_refused_for_the_integral_that_follows)
{
    const Folder folder;
    const std::vector<std::string> set = {"drive.method=voltage_phase",
                                          "voltage_loop.kp_v_s_per_rad=1000"};
    const drive_cfg_t cfg = nf::build(nf::load_scenario("s", {}, set));
    TEST_ASSERT_EQUAL_INT32(32767, cfg.voltage_drive.pi.ki);
}

// Softness and bandwidth of the position loop follow from the motor and from what is written of the
// others.
TEST(no_rule_breaks_what_another_key_allows)
{
    const Folder folder;
    for (const char *set : {"speed_loop.bandwidth_hz=1", "speed_loop.bandwidth_hz=0.001",
                            "position_loop.acceleration_rad_s2=100000", "motor.inertia_kg_m2=1e-7",
                            "motor.inertia_kg_m2=100", "speed_loop.slow_ticks=100"}) {
        expect_accepted({"position_loop.bandwidth_hz=0", "position_loop.softness_s=0",
                         "speed_loop.inertia_feed_forward=0", "speed_loop.ramp_rpm_s=0",
                         "speed_loop.bandwidth_hz=0", set});
    }
}

// -1 leaves these to their rules, 0 means something of its own.
TEST(what_is_neither_a_value_nor_left_to_a_rule_is_refused)
{
    const Folder folder;
    for (const std::string key :
         {"observer.kappa_p", "observer.rho_max", "observer.feedback", "current_loop.floor_pct"}) {
        expect_accepted({key + "=-1"});
        expect_begin("--set: " + key + " = -0.5: does not fit the firmware; allowed: at least 0",
                     refusal({}, {key + "=-0.5"}));
    }
}

TEST(a_limit_of_what_goes_back_is_none_or_a_current)
{
    const Folder folder;
    expect_accepted({"board.bus_regeneration_max_a=-1"});
    expect_begin("--set: board.bus_regeneration_max_a = -0.5: ",
                 refusal({}, {"board.bus_regeneration_max_a=-0.5"}));
}

TEST(points_of_numbers_are_no_dots_of_keys)
{
    const Folder folder;
    std::string list;
    for (int k = 0; k < 100; k++) {
        list += fmt::format("{{time_s=0.{:03},torque_nm=0.1}},", k);
    }
    expect_accepted({"scenario.load=[" + list + "]"});
    std::string deep = "1";
    for (int k = 0; k < 100; k++) {
        deep += ".1";
    }
    expect_begin("--set: scenario.load = \"[{1.1.1",
                 refusal({}, {"scenario.load=[{" + deep + "=1}]"}));
}

const std::string DOTS(65, '.');

TEST(text_that_is_not_toml_is_named_with_its_line)
{
    expect_all({
        {"= 2.125", "2.125",
         "motors/m.toml:4: TOML syntax: Error while parsing key-value pair: expected '=', saw '2'"},
        {"", "resistance_ohm = 3\n",
         "motors/m.toml:14: TOML syntax: Error while parsing key-value pair: cannot redefine "
         "existing floating-point 'resistance_ohm'"},
        {"[motor]", "[.]",
         "motors/m.toml:1: TOML syntax: Error while parsing key: expected bare key starting "
         "character or string delimiter, saw '.'"},
        {"", DOTS.c_str(), "motors/m.toml:14: TOML syntax: more than 64 dots in a line"},
    });
    // Behind a number quotes begin no string.
    for (const char *const text : {"2.125 µ", "2.125\"µ\"", "-[{a.'µ'"}) {
        expect_all({{"2.125", text,
                     "motors/m.toml:4: TOML syntax: a character outside ASCII that is in no string "
                     "or comment"}});
    }
}

// As a shell's redirection or an editor writes it. The mark may be missing.
TEST(text_in_two_bytes_a_character_is_named_as_that)
{
    using namespace std::string_literals;
    for (const std::string &begin : {"\xFF\xFE[\0"s, "\xFE\xFF\0["s, "[\0"s, "\0["s}) {
        const Folder folder;
        folder.edit("motors/m.toml", "[", begin);
        expect_begin("motors/m.toml:1: is UTF-16 text; allowed: UTF-8", refusal({}, {}));
    }
}

TEST(text_of_any_language_is_allowed_in_strings_and_comments)
{
    for (const char *text : {"\"µ \\\" é\" # ± '", "'µ \" é'", "\"µ\"", "\"\"\"µ\"é\"\"\"\""}) {
        const Folder folder;
        folder.edit("motors/m.toml", " = \"m\"", std::string("=") + text);
        expect_accepted({});
    }
    const Folder folder;
    folder.edit("motors/m.toml", "[motor]", "\xEF\xBB\xBF[motor]");
    expect_accepted({});
}

TEST(a_file_that_does_not_exist_is_named_with_those_that_do)
{
    expect_all({
        {"motor = \"m\"", "motor = \"mm\"",
         "scenarios/s.toml:1: motor = \"mm\": not found, did you mean m?; allowed: m or a path "
         "ending in .toml"},
        {"motor = \"m\"", "motor = \"../m.toml\"",
         "scenarios/s.toml:1: motor = \"../m.toml\": not found; allowed: m or a path ending in "
         ".toml"},
        {"\"warm\"", "\"cold\"",
         "imperfections/hot.toml:1: include = \"cold\": not found; allowed: hot, warm or a path "
         "ending in .toml"},
        {"\"warm\"", "\"hot\"",
         "imperfections/hot.toml:1: include = \"hot\": includes itself; allowed: at most 8 levels"},
    });
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING("--with: imperfection = \"warn\": not found, did you mean warm?; "
                             "allowed: hot, warm or a path ending in .toml",
                             refusal({"warn"}).c_str());
}

TEST(a_folder_without_files_leaves_the_path)
{
    const Folder folder;
    std::filesystem::remove_all("motors");
    std::filesystem::create_directory("motors");
    TEST_ASSERT_EQUAL_STRING("scenarios/s.toml:1: motor = \"m\": not found; allowed: a path ending "
                             "in .toml",
                             refusal().c_str());
}

TEST(a_file_that_cannot_be_read_is_named)
{
    const Folder folder;
    std::filesystem::create_directory("folder.toml");
    TEST_ASSERT_EQUAL_STRING("folder.toml: cannot be read; allowed: a regular file",
                             refusal({"folder.toml"}).c_str());
    folder.write("large.toml", std::string((1U << 20U) + 1U, '#'));
    TEST_ASSERT_EQUAL_STRING("large.toml: is too large; allowed: at most 1048576 bytes",
                             refusal({"large.toml"}).c_str());
}

TEST(command_and_load_are_checked_entry_by_entry)
{
    expect_all({
        {"speed_rpm = 1000", "position_rad = 1",
         "scenarios/s.toml:8: scenario.command.position_rad = 1: unknown key; allowed: time_s, "
         "speed_rpm, speed_pct"},
        {", speed_rpm = 1000", "",
         "scenarios/s.toml:8: scenario.command.speed_rpm: is missing; allowed: -200000 to 200000 "
         "rpm, or speed_pct"},
        {"time_s = 0.2", "time_s = -0.1",
         "scenarios/s.toml:8: scenario.command.time_s = -0.1: does not rise; allowed: more than "
         "-0.1 s"},
    });
    expect_added({
        {"[[scenario.load]]\ntime_s = 0\ntorque_nm = 1e9",
         "11: scenario.load.torque_nm = 1000000000: is too large; allowed: -10000 to 10000 N·m"},
        {"load = 3", "9: scenario.load = 3: is a whole number; allowed: tables [[scenario.load]]"},
    });
}

TEST(faults_are_checked_word_by_word)
{
    const struct {
        const char *entry;
        const char *message; // after the list's name
    } cases[] = {
        {"3", " = 3: is a whole number; allowed: tables [[scenario.fault]]"},
        {"{what = 'adc_a_high'}", ".time_s: is missing; allowed: -3600 to 3600 s"},
        {"{time_s = 1, what = 'adc_a_hihg'}",
         ".what = \"adc_a_hihg\": unknown fault, did you mean adc_a_high?"},
        {"{time_s = 1, what = 5}",
         ".what = 5: is a whole number; allowed: adc_a_stuck, adc_a_high, "},
        {"{time_s = 1}", ".what: is missing; allowed: adc_a_stuck, adc_a_high, "},
        {"{time_s = 1, what = 'adc_a_high', value = 3}", ".value = 3: adc_a_high takes no value"},
        {"{time_s = 1, what = 'bus_voltage'}", ".value: is missing; allowed: 0.001 to 2000 V"},
        {"{time_s = 1, what = 'temperature', value = 999}",
         ".value = 999: is too large; allowed: -250 to 250 °C"},
        {"{time_s = 1, what = 'temperature', value = 'hot'}",
         ".value = \"hot\": is a string; allowed: -250 to 250 °C"},
        {"{time_s = 1, what = 'config_corrupt', value = 1.5}",
         ".value = 1.5: is a number with a fraction; allowed: a whole number, 0 to "},
        {"{time_s = 1, what = 'config_corrupt', value = 100000}", ".value = 100000: is too large"},
        {"{time_s = 1, what = 'late_isr', until_s = 1}",
         ".until_s = 1: is too small; allowed: more than 1 s, which is scenario.fault.time_s"},
        {"{time_s = 1, what = 'rotor_jump', value = 90, until_s = 2}",
         ".until_s = 2: rotor_jump does not last"},
        {"{time_s = 1, what = 'late_isr', how = 2}",
         ".how = 2: unknown key; allowed: time_s, what, value, until_s"},
    };
    const Folder folder;
    for (const auto &[entry, message] : cases) {
        expect_begin(std::string("--set: scenario.fault") + message,
                     refusal({}, {std::string("scenario.fault=[") + entry + "]"}));
    }
}

TEST(requests_are_checked_word_by_word)
{
    expect_added({
        {"[[scenario.request]]\ntime_s = 0",
         "9: scenario.request: asks for nothing; allowed: run = true or false, clear = true"},
        {"[[scenario.request]]\ntime_s = 0\nrun = 1",
         "11: scenario.request.run = 1: is a whole number; allowed: true or false"},
        {"[[scenario.request]]\ntime_s = 0\nclear = false",
         "11: scenario.request.clear = false: asks for nothing; allowed: true"},
        {"[[scenario.request]]\ntime_s = 1\nrun = true\n"
         "[[scenario.request]]\ntime_s = 1\nrun = false",
         "12: scenario.request.time_s = 1: does not rise; allowed: more than 1 s"},
    });
}

// The base's, the file's own or an override's: what is asked for has to happen.
TEST(a_fault_or_request_after_the_end_is_refused)
{
    expect_added({
        {"[[scenario.fault]]\ntime_s = 1.5\nwhat = \"adc_a_high\"",
         "10: scenario.fault.time_s = 1.5: is not before the end of the run; allowed: less than "
         "scenario.duration_s = 1 s (scenarios/s.toml:7)"},
        {"[[scenario.request]]\ntime_s = 1\nrun = false",
         "10: scenario.request.time_s = 1: is not before the end of the run; allowed: less than "
         "scenario.duration_s = 1 s (scenarios/s.toml:7)"},
    });
    const char *const fault = "scenario.fault=[{time_s = 0.9999, what = 'late_isr'}]";
    const Folder folder;
    expect_accepted({fault});
    expect_accepted({fault, "scenario.duration_s=2"});
    TEST_ASSERT_EQUAL_STRING(
        "--set: scenario.fault.time_s = 0.9999: is not before the end of the run; allowed: less "
        "than scenario.duration_s = 0.5 s (--set)",
        refusal({}, {fault, "scenario.duration_s=0.5"}).c_str());
    // Parts alone have no end; a refusal would end the test.
    (void)nf::load_parts("m", "b", "t", {}, {fault});
}

TEST(an_entry_holds_one_value_in_si_or_percent)
{
    expect_override("scenario.command=[{time_s = 0, speed_pct = 5, speed_rpm = 3}]",
                    "scenario.command.speed_pct = 5: stands beside speed_rpm; allowed: one "
                    "of both");
    expect_override("scenario.command=[{time_s = 0, speed_pct = 201}]",
                    "scenario.command.speed_pct = 201: is too large; allowed: -200 to 200 %");
    expect_override("scenario.load=[{time_s = 0, torque_pct = \"half\"}]",
                    "scenario.load.torque_pct = \"half\": is a string; allowed: -300 to 300 %");
    expect_override("scenario.inherit_limits=0",
                    "scenario.inherit_limits = 0: is a whole number; allowed: true or false");
}

TEST(lists_can_be_overridden)
{
    const Folder folder;
    const nf::Config config =
        nf::load_scenario("s", {},
                          {"scenario.fault=[{time_s = 0.5, what = 'late_isr', until_s = 0.6}]",
                           "scenario.request=[{time_s = 0.1, clear = true}]", "scenario.command=[]",
                           "scenario.load=[{time_s = 0.25, torque_nm = 2}]"});
    TEST_ASSERT_EQUAL_size_t(1, config.scenario.faults.size());
    TEST_ASSERT_TRUE(config.scenario.faults[0].kind == nf::FaultKind::late_isr);
    TEST_ASSERT_EQUAL_DOUBLE(0.6, config.scenario.faults[0].until_s.value());
    TEST_ASSERT_TRUE(config.scenario.requests.at(0).clear);
    TEST_ASSERT_FALSE(config.scenario.requests.at(0).run.has_value());
    TEST_ASSERT_TRUE(config.scenario.command.empty());
    TEST_ASSERT_EQUAL_DOUBLE(2, config.scenario.load.at(0).value);
}

TEST(accepted_limits_name_known_metrics_and_sets)
{
    expect_all({
        {"speed_error_max_rpm = 50", "speed_eror_max_rpm = 50",
         "scenarios/s.toml:13: accept.any.speed_eror_max_rpm = 50: unknown metric, did you mean "
         "speed_error_max_rpm?"},
        {"locked = true", "locked = false",
         "scenarios/s.toml:11: accept.ideal.locked = false: is no limit; allowed: true"},
        {"locked = true", "limit_cycle = true",
         "scenarios/s.toml:11: accept.ideal.limit_cycle = true: is no limit; allowed: false"},
        {"[accept.any]", "[accept.warn]",
         "scenarios/s.toml:12: [accept.warn]: no such imperfection set, did you mean warm?; "
         "allowed: any, ideal, hot, warm; several joined with '+'"},
        {"[accept.any]", "[accept.\"warm+hot\"]",
         "scenarios/s.toml:12: [accept.warm+hot]: is not how this selection is written; allowed: "
         "[accept.\"hot+warm\"]"},
    });
}

TEST(a_base_is_checked_like_the_scenario_itself)
{
    expect_all({
        {"motor = \"m\"", "base = \"ss\"",
         "scenarios/s.toml:1: base = \"ss\": not found, did you mean s?; allowed: s or a path "
         "ending in .toml"},
        {"motor = \"m\"", "base = \"s\"",
         "scenarios/s.toml:1: base = \"s\": is based on itself; allowed: at most 8 levels"},
    });
    const Folder folder;
    folder.write("scenarios/d.toml", test::VALID.at("scenarios/s.toml"));
    folder.write("scenarios/s.toml", "base = \"d\"\n[scenario]\nload = 3\n");
    TEST_ASSERT_EQUAL_STRING("scenarios/s.toml:3: scenario.load = 3: is a whole number; allowed: "
                             "tables [[scenario.load]]",
                             refusal().c_str());
}

TEST(overrides_are_refused_like_lines_of_files)
{
    expect_overrides({
        {"motor.resistance_ohm=nan", "is not a finite number; allowed: 0.001 to 50 Ω"},
        {"observer.kapa=1", "unknown key, did you mean observer.kappa?"},
        {"scenario.faults=[]", "unknown key, did you mean scenario.fault?"},
    });
    expect_override("motor.resistance_ohm=1e400",
                    "motor.resistance_ohm = inf: is not a finite number; allowed: 0.001 to 50 Ω");
    expect_override("motor.resistance_ohm",
                    "\"motor.resistance_ohm\": is no override; allowed: section.key=value");
    expect_override("motor.resistance_ohm=",
                    "motor.resistance_ohm: has no value; allowed: KEY=VALUE");
    expect_override("motor=n", "motor = \"n\": not found, did you mean m?; allowed: m or a "
                               "path ending in .toml");
    expect_override("motor.resistance_ohm=1\n[board]",
                    "motor.resistance_ohm = \"1\\n[board]\": is a string; allowed: 0.001 to 50 Ω");
}

// As a person writes numbers: a point without a digit on one side, and a whole number with a point.
TEST(numbers_of_an_override_may_have_a_point_without_a_digit)
{
    const auto loaded = [](const std::string &set) { return nf::load_scenario("s1", {}, {set}); };
    TEST_ASSERT_EQUAL_DOUBLE(0.045, loaded("observer.kappa=.045").tuning.observer_kappa);
    TEST_ASSERT_EQUAL_DOUBLE(1, loaded("scenario.evaluate_from_s=1.").scenario.evaluate_from_s);
    TEST_ASSERT_EQUAL_DOUBLE(-0.5,
                             loaded("scenario.initial_speed_rpm=-.5").scenario.initial_speed_rpm);
    TEST_ASSERT_EQUAL_INT(7, loaded("motor.pole_pairs=7.0").motor.pole_pairs);
    TEST_ASSERT_EQUAL_INT(7, loaded("motor.pole_pairs=7.").motor.pole_pairs);
    TEST_ASSERT_EQUAL_UINT32(20, loaded("scenario.seed=2e1").scenario.seed);
    const auto load = loaded("scenario.load=[{time_s=.5, torque_nm=1.}]").scenario.load;
    TEST_ASSERT_EQUAL_DOUBLE(0.5, load.front().time_s);
    TEST_ASSERT_EQUAL_DOUBLE(1, load.front().value);
    expect_overrides({
        {"motor.pole_pairs=7.5", "is a number with a fraction; allowed: a whole number, 1 to 50"},
    });
    expect_override("observer.kappa=.", "observer.kappa = \".\": is a string; allowed: 0 to 0.5");
    expect_override("observer.kappa=1.2.3",
                    "observer.kappa = \"1.2.3\": is a string; allowed: 0 to 0.5");
}

// The commands of a base are of its mode.
TEST(another_mode_than_that_of_the_bases_commands_is_named_where_it_stands)
{
    const Folder folder;
    const std::string said = "scenario.mode = \"torque\": the commands are of the mode \"speed\" "
                             "(scenarios/s.toml:8); allowed: that mode, or a list scenario.command "
                             "of its own";
    TEST_ASSERT_EQUAL_STRING(("--set: " + said).c_str(),
                             refusal({}, {"scenario.mode=torque"}).c_str());
    expect_accepted({"scenario.mode=torque", "scenario.command=[{time_s=.1, torque_nm=.5}]"});
    expect_accepted({"scenario.mode=speed"});
}

} // namespace
