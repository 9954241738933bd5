// SPDX-License-Identifier: MIT
// Which layer wins, where values come from, and what a scenario file says.
#include "folder.h"

#include "testing.h"

using test::Folder;

namespace
{

nf::Config load(const std::vector<std::string> &with = {}, const std::vector<std::string> &set = {})
{
    return nf::load_scenario("s", with, set);
}

TEST(a_later_layer_wins_and_leaves_the_other_keys_alone)
{
    const Folder folder;
    folder.write("imperfections/cold.toml", "plant.resistance_scale = 0.9\n");
    TEST_ASSERT_EQUAL_DOUBLE(1.0, load().plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(1.1, load({"warm"}).plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(0.9, load({"warm", "cold"}).plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(1.1, load({"cold", "warm"}).plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(0.99, load({"warm", "cold"}).plant.flux_scale);
}

TEST(a_set_overrides_what_it_includes)
{
    const Folder folder;
    const nf::Config config = load({"hot"});
    TEST_ASSERT_EQUAL_DOUBLE(1.3, config.plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(0.99, config.plant.flux_scale);
}

TEST(a_scenario_overrides_the_tuning_and_a_set_overrides_the_scenario)
{
    const Folder folder;
    folder.edit("scenarios/s.toml", "[accept.ideal]",
                "[observer]\nkappa = 0.01\n[plant]\nresistance_scale = 2\n[accept.ideal]");
    TEST_ASSERT_EQUAL_DOUBLE(0.01, load().tuning.observer_kappa);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, load().plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(1.1, load({"warm"}).plant.resistance_scale);
}

TEST(an_override_wins_over_every_file_and_the_last_one_wins)
{
    const Folder folder;
    const nf::Config config = load(
        {"hot"}, {"plant.resistance_scale=1.5", "motor.resistance_ohm=2.5",
                  "plant.adc_offset_lsb=[3, -4]", "scenario.seed=7", "scenario.title=two words",
                  "plant.resistance_scale=1.6", "board.name=\"quoted\""});
    TEST_ASSERT_EQUAL_DOUBLE(1.6, config.plant.resistance_scale);
    TEST_ASSERT_EQUAL_DOUBLE(2.5, config.motor.resistance_ohm);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, config.plant.adc_offset_lsb[0]);
    TEST_ASSERT_EQUAL_DOUBLE(-4.0, config.plant.adc_offset_lsb[1]);
    TEST_ASSERT_EQUAL_UINT(7, config.scenario.seed);
    TEST_ASSERT_EQUAL_STRING("two words", config.scenario.title.c_str());
    TEST_ASSERT_EQUAL_STRING("quoted", config.board.name.c_str());
}

TEST(an_override_supplies_what_a_file_lacks)
{
    const Folder folder;
    folder.edit("motors/m.toml", "resistance_ohm = 2.125\n", "");
    TEST_ASSERT_EQUAL_DOUBLE(2.5, load({}, {"motor.resistance_ohm=2.5"}).motor.resistance_ohm);
}

TEST(an_override_of_the_motor_takes_another_file)
{
    const Folder folder;
    folder.write("elsewhere/n.toml", test::VALID.at("motors/m.toml"));
    TEST_ASSERT_EQUAL_STRING("elsewhere/n.toml",
                             load({}, {"motor=elsewhere/n.toml"}).sources.motor.c_str());
    TEST_ASSERT_EQUAL_STRING("motors/m.toml", load().sources.motor.c_str());
}

TEST(a_wrong_value_is_refused_even_if_it_is_overridden)
{
    const Folder folder;
    folder.edit("motors/m.toml", "2.125", "-1");
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:4: motor.resistance_ohm = -1: is too small; allowed: "
                             "0.001 to 50 Ω",
                             test::refusal({}, {"motor.resistance_ohm=2"}).c_str());
}

TEST(every_value_remembers_its_origin)
{
    const Folder folder;
    const nf::Config config = load({"hot"}, {"observer.kappa=0.02"});
    const auto origin = [&](const char *key) { return config.origins.at(key).text(); };
    TEST_ASSERT_EQUAL_STRING("motors/m.toml:4", origin("motor.resistance_ohm").c_str());
    TEST_ASSERT_EQUAL_STRING("imperfections/hot.toml:3", origin("plant.resistance_scale").c_str());
    TEST_ASSERT_EQUAL_STRING("imperfections/warm.toml:3", origin("plant.flux_scale").c_str());
    TEST_ASSERT_EQUAL_STRING("tunings/t.toml:2", origin("observer.kappa_p").c_str());
    TEST_ASSERT_EQUAL_STRING("--set", origin("observer.kappa").c_str());
    TEST_ASSERT_EQUAL_UINT(0, config.origins.count("plant.dead_time_s"));
}

TEST(a_scenario_has_its_command_load_and_limits)
{
    const Folder folder;
    folder.edit("scenarios/s.toml", "[accept.ideal]",
                "[[scenario.load]]\ntime_s = 0.5\ntorque_nm = 3\n"
                "[[scenario.load]]\ntime_s = 0.8\ntorque_nm = 0\n[accept.ideal]");
    const nf::ScenarioSettings s = load().scenario;
    TEST_ASSERT_EQUAL_STRING("s", s.id.c_str());
    TEST_ASSERT_TRUE(s.mode == nf::DriveMode::speed);
    TEST_ASSERT_EQUAL_UINT(2, s.command.size());
    TEST_ASSERT_EQUAL_DOUBLE(0.2, s.command[1].time_s);
    TEST_ASSERT_EQUAL_DOUBLE(1000.0, s.command[1].value);
    TEST_ASSERT_EQUAL_UINT(2, s.load.size());
    TEST_ASSERT_EQUAL_DOUBLE(3.0, s.load[0].value);
    TEST_ASSERT_EQUAL_size_t(1, s.limits("ideal")->flags.count("locked"));
    TEST_ASSERT_EQUAL_DOUBLE(5.0, s.limits("ideal")->upper.at("speed_error_max_rpm"));
    TEST_ASSERT_EQUAL_DOUBLE(50.0, s.limits("hot")->upper.at("speed_error_max_rpm"));
    TEST_ASSERT_EQUAL_size_t(0, s.limits("hot")->flags.count("locked"));
}

TEST(a_position_scenario_commands_positions)
{
    const Folder folder;
    folder.edit("scenarios/s.toml",
                "\"speed\"\nduration_s = 1\ncommand = [{time_s = -0.1, "
                "speed_rpm = 0}, {time_s = 0.2, speed_rpm = 1000}]",
                "\"position\"\nduration_s = 1\ncommand = [{time_s = 0.3, position_rad = 9.42}]");
    TEST_ASSERT_TRUE(load().scenario.mode == nf::DriveMode::position);
    TEST_ASSERT_EQUAL_DOUBLE(9.42, load().scenario.command[0].value);
}

// Rated are 1800 rpm and 7.8 N·m.
TEST(shares_of_rated_speed_and_torque_are_those_of_the_motor_in_force)
{
    const Folder folder;
    const std::vector<std::string> shares = {
        "scenario.command=[{time_s = 0, speed_pct = -50}, {time_s = 0.5, speed_rpm = 100}]",
        "scenario.load=[{time_s = 0, torque_pct = 150}, {time_s = 0.5, torque_nm = 3}]"};
    const nf::ScenarioSettings own = load({}, shares).scenario;
    TEST_ASSERT_EQUAL_DOUBLE(-900.0, own.command[0].value);
    TEST_ASSERT_EQUAL_DOUBLE(100.0, own.command[1].value);
    TEST_ASSERT_EQUAL_DOUBLE(11.7, own.load[0].value);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, own.load[1].value);
    const nf::ScenarioSettings other =
        load({}, {shares[0], shares[1], "motor.rated_speed_rpm=1000", "motor.rated_torque_nm=2"})
            .scenario;
    TEST_ASSERT_EQUAL_DOUBLE(-500.0, other.command[0].value);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, other.load[0].value);
}

std::string notes_with(const std::vector<std::string> &set)
{
    std::string all;
    for (const std::string &note : load({}, set).scenario.notes) {
        all += note + '\n';
    }
    return all;
}

TEST(a_command_beyond_the_motors_speed_is_noted)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING("", notes_with({"motor.max_speed_rpm=1000"}).c_str());
    TEST_ASSERT_EQUAL_STRING(
        "scenarios/s.toml:8: scenario.command.speed_rpm = 1000: the drive turns no faster than "
        "motor.max_speed_rpm = 999 rpm (--set)\n",
        notes_with({"motor.max_speed_rpm=999"}).c_str());
    TEST_ASSERT_EQUAL_STRING(
        "--set: scenario.command.speed_pct = -120: the drive turns no faster than "
        "motor.max_speed_rpm = 2000 rpm (motors/m.toml:10), 111.1 % of motor.rated_speed_rpm\n",
        notes_with({"scenario.command=[{time_s = 0, speed_pct = -120}]"}).c_str());
    folder.edit("scenarios/s.toml",
                "\"speed\"\nduration_s = 1\ncommand = [{time_s = -0.1, "
                "speed_rpm = 0}, {time_s = 0.2, speed_rpm = 1000}]",
                "\"position\"\nduration_s = 1\ncommand = [{time_s = 0.3, position_rad = 3000}]");
    TEST_ASSERT_EQUAL_STRING("", notes_with({}).c_str());
}

// The last tick that acts is one PWM period of 0.1 ms before the end.
TEST(a_step_that_comes_too_late_is_noted)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_STRING(
        "--set: scenario.load.time_s = 1: never acts, the run ends before: scenario.duration_s = 1 "
        "s (scenarios/s.toml:7)\n",
        notes_with(
            {"scenario.load=[{time_s = 0.9999, torque_nm = 1}, {time_s = 1, torque_nm = 2}]"})
            .c_str());
    TEST_ASSERT_EQUAL_STRING(
        "scenarios/s.toml:8: scenario.command.time_s = 0.2: never acts, the run ends before: "
        "scenario.duration_s = 0.1 s (--set)\n",
        notes_with({"scenario.duration_s=0.1"}).c_str());
}

const char *const DERIVED = "base = \"s\"\n"
                            "tuning = \"t\"\n"
                            "[scenario]\n"
                            "title = \"derived\"\n"
                            "command = [{time_s = 0, speed_rpm = 500}]\n"
                            "[accept.ideal]\n"
                            "speed_error_max_rpm = 7\n";

TEST(a_scenario_overrides_its_base_key_by_key)
{
    const Folder folder;
    folder.write("scenarios/d.toml", DERIVED);
    const nf::ScenarioSettings s = nf::load_scenario("d").scenario;
    TEST_ASSERT_EQUAL_STRING("d", s.id.c_str());
    TEST_ASSERT_EQUAL_STRING("derived", s.title.c_str());
    TEST_ASSERT_EQUAL_DOUBLE(1.0, s.duration_s);
    TEST_ASSERT_EQUAL_UINT(1, s.command.size());
    TEST_ASSERT_EQUAL_DOUBLE(7.0, s.limits("ideal")->upper.at("speed_error_max_rpm"));
    TEST_ASSERT_EQUAL_size_t(1, s.limits("ideal")->flags.count("locked"));
    TEST_ASSERT_EQUAL_DOUBLE(50.0, s.limits("hot")->upper.at("speed_error_max_rpm"));
    TEST_ASSERT_EQUAL_STRING("derived", nf::list_scenarios()[0].title.c_str());
}

TEST(a_scenario_can_do_without_the_limits_of_its_base)
{
    const Folder folder;
    folder.write("scenarios/d.toml",
                 std::string(DERIVED).replace(std::string(DERIVED).find("title"), 0,
                                              "inherit_limits = false\n"));
    const nf::ScenarioSettings s = nf::load_scenario("d").scenario;
    TEST_ASSERT_EQUAL_DOUBLE(7.0, s.limits("ideal")->upper.at("speed_error_max_rpm"));
    TEST_ASSERT_EQUAL_size_t(0, s.limits("ideal")->flags.count("locked"));
    TEST_ASSERT_NULL(s.limits("hot"));
    const nf::ScenarioSettings none =
        nf::load_scenario("s", {}, {"scenario.inherit_limits=false"}).scenario;
    TEST_ASSERT_NULL(none.limits("ideal"));
    const nf::ScenarioSettings all =
        nf::load_scenario("s", {}, {"scenario.inherit_limits=true"}).scenario;
    TEST_ASSERT_EQUAL_size_t(1, all.limits("ideal")->flags.count("locked"));
}

// 2^8 samples, the tick before them, and the slow period in which the command is taken, at 10 kHz.
TEST(without_a_prelude_the_drive_calibrates_before_t_0)
{
    const Folder folder;
    TEST_ASSERT_EQUAL_DOUBLE(0.0267, load().scenario.prelude_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.0139, load({}, {"board.offset_samples_log2=7"}).scenario.prelude_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.5, load({}, {"scenario.prelude_s=0.5"}).scenario.prelude_s);
}

TEST(a_selection_has_one_name_in_any_order)
{
    TEST_ASSERT_EQUAL_STRING("ideal", nf::selection_name({}).c_str());
    TEST_ASSERT_EQUAL_STRING("ideal", nf::selection_name({"ideal"}).c_str());
    TEST_ASSERT_EQUAL_STRING("adc", nf::selection_name({"adc", "ideal", "adc"}).c_str());
    TEST_ASSERT_EQUAL_STRING("adc+hot", nf::selection_name({"hot", "adc"}).c_str());
    TEST_ASSERT_EQUAL_STRING("adc", nf::selection_name({"some/where/adc.toml"}).c_str());
}

TEST(a_path_is_relative_to_the_file_that_names_it)
{
    const Folder folder;
    folder.write("elsewhere/scenario.toml",
                 "motor = \"./n.toml\"\nboard = \"b\"\ntuning = \"t\"\n[scenario]\ntitle = \"x\"\n"
                 "mode = \"speed\"\nduration_s = 1\n");
    folder.write("elsewhere/n.toml", test::VALID.at("motors/m.toml"));
    const nf::Config config = nf::load_scenario("elsewhere/scenario.toml");
    TEST_ASSERT_EQUAL_STRING("elsewhere/n.toml:4",
                             config.origins.at("motor.resistance_ohm").text().c_str());
    TEST_ASSERT_EQUAL_STRING("scenario", config.scenario.id.c_str());
}

TEST(the_files_of_the_data_folder_are_listed_by_name)
{
    const Folder folder;
    folder.write("scenarios/a.toml", test::VALID.at("scenarios/s.toml"));
    folder.write("imperfections/notes.txt", "");
    const std::vector<nf::ScenarioInfo> scenarios = nf::list_scenarios();
    TEST_ASSERT_EQUAL_UINT(2, scenarios.size());
    TEST_ASSERT_EQUAL_STRING("a", scenarios[0].id.c_str());
    TEST_ASSERT_EQUAL_STRING("a step", scenarios[1].title.c_str());
    TEST_ASSERT_TRUE(nf::list_imperfections() == (std::vector<std::string>{"hot", "warm"}));
    TEST_ASSERT_TRUE(nf::list_motors() == std::vector<std::string>{"m"});
}

} // namespace
