// SPDX-License-Identifier: MIT
// A board out of the box and a motor of which only the name plate is known: all that a person does
// with them, line by line.
#include "bars.h"
#include "board_commands.h"
#include "demands.h"
#include "flash_file.h"
#include "own_path.h"
#include "plate.h"
#include "simulated_board.h"

extern "C" {
#include "testing.h"
}

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace
{

using nf::live::BoardChannel;
using nf::live::BoardCommands;
using nf::live::FileChoice;
using nf::live::Follower;
using nf::live::FollowerOptions;
using nf::live::SimulatedBoard;

constexpr double PASS_S = 0.001;
constexpr double CONNECTED_S = 1; // the follower is in step
constexpr FollowerOptions QUICK = {{0.02, 100, 0.006}, 10, 0.2, 1};

// The image has the example of the board; the motor at it is another one.
const std::vector<std::string> OTHER_MOTOR = {
    "plant.resistance_scale=1.6", "plant.inductance_scale=1.5", "plant.flux_scale=0.7",
    "plant.inertia_scale=2", "plant.coulomb_friction_nm=0.003"};

nf::Config out_of_the_box(const std::vector<std::string> &plant = OTHER_MOTOR)
{
    std::vector<std::string> set = {"motor=outrunner_24v", "board=b_g431b_esc1", "scenario.load=[]",
                                    "scenario.duration_s=200"};
    set.insert(set.end(), plant.begin(), plant.end());
    return nf::load_scenario("any", {}, set);
}

// Connected from power-up on, and asked for nothing: the script that the simulated board begins
// with is stopped.
class Session : public nf::TickSink
{
public:
    explicit Session(const nf::Config &config, const hal_host_flash_t *flash = nullptr,
                     const FileChoice &files = {})
        : config_(config), board_(config_, flash), line_(board_),
          follower_(line_, *this,
                    {[this](const std::string &text) { said_.push_back(text); },
                     [this](const std::string &text) { commands_.take_text(text); }},
                    QUICK),
          commands_(follower_, files,
                    {[this](const std::string &text) { said_.push_back(text); },
                     [this](double seconds) { pass(seconds); },
                     [](const nf::RecordedRun &) { return true; }})
    {
        follower_.connect();
        does("stop");
        pass(CONNECTED_S);
    }

    std::string does(const std::string &text)
    {
        const nf::debug::Answer answer = commands_.execute(text);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::done, answer.outcome,
                                  (text + ": " + answer.text).c_str());
        return answer.text;
    }

    std::string refuses(const std::string &text)
    {
        const nf::debug::Answer answer = commands_.execute(text);
        TEST_ASSERT_EQUAL_MESSAGE(nf::debug::Outcome::refused, answer.outcome,
                                  (text + ": " + answer.text).c_str());
        return answer.text;
    }

    nf::debug::Answer begins(const std::string &plate)
    {
        return commands_.begin_identification(plate);
    }

    bool has_ended() const
    {
        return commands_.identification_has_ended();
    }

    std::vector<std::string> phases() const
    {
        return commands_.identification()->measurement().phases();
    }

    // Nothing was found.
    std::string why()
    {
        try {
            (void)commands_.take_identification();
        } catch (const nf::ConfigError &error) {
            return error.what();
        }
        return "";
    }

    std::string said() const
    {
        return fmt::format("{}", fmt::join(said_, "\n"));
    }

    config_block_t in_force()
    {
        return follower_.block_in_force();
    }

    // Read while nobody writes to it.
    const hal_host_flash_t &flash()
    {
        return board_.flash();
    }

private:
    void add(const nf::Tick & /*shown*/) override
    {
    }

    void pass(double seconds)
    {
        const double until_s = line_.now_s() + seconds;
        while (line_.now_s() < until_s) {
            follower_.step(PASS_S);
        }
    }

    const nf::Config config_;
    SimulatedBoard board_;
    BoardChannel line_;
    std::vector<std::string> said_;
    Follower follower_;
    BoardCommands commands_;
};

// A folder of a test, gone behind it.
struct Folder {
    Folder() : path(own_path("nf_first_hour"))
    {
        std::filesystem::remove_all(path);
        std::filesystem::create_directory(path);
    }
    ~Folder()
    {
        std::filesystem::remove_all(path);
    }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    std::string file(const char *name) const
    {
        return (std::filesystem::path(path) / name).string();
    }

    const std::filesystem::path path;
};

void write_plate(const std::string &path, const char *max_current_a = "30")
{
    std::ofstream(path)
        << "[motor]\nname = \"out of the drawer\"\npole_pairs = 7\nmax_speed_rpm = 5000\n"
        << "continuous_current_a = 15\nmax_current_a = " << max_current_a << '\n';
}

void expect_measured(const nf::Config &found, const char *key, double value, double truth)
{
    const double bar = nf::bar_of(found.motor, found.measured, key);
    TEST_ASSERT_TRUE_MESSAGE(bar > 0, key);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(bar, truth, value, key);
}

TEST(from_a_name_plate_to_a_stored_configuration_and_a_second_board_all_is_done_at_the_line)
{
    const Folder folder;
    const std::string plate = folder.file("plate.toml");
    const std::string measured = folder.file("measured.toml");
    const std::string block = folder.file("mine.nfb");
    write_plate(plate);
    const nf::Config box = out_of_the_box();
    auto first = std::make_unique<Session>(box);

    TEST_ASSERT_TRUE(first->refuses("identify").find("example motor") != std::string::npos);
    first->does(fmt::format("identify {} {}", plate, measured));
    TEST_ASSERT_TRUE_MESSAGE(first->said().find("the shaft turns") != std::string::npos,
                             first->said().c_str());
    TEST_ASSERT_TRUE_MESSAGE(first->said().find("= pulse") == std::string::npos,
                             "the numbers are for the program");
    const nf::Config found = nf::load_motor(measured);
    const nf::MotorSettings &motor = found.motor;
    TEST_ASSERT_EQUAL_STRING("out of the drawer", motor.name.c_str());
    expect_measured(found, "motor.resistance_ohm", motor.resistance_ohm,
                    box.motor.resistance_ohm * 1.6);
    expect_measured(found, "motor.inductance_d_h", motor.inductance_d_h,
                    box.motor.inductance_d_h * 1.5);
    expect_measured(found, "motor.flux_linkage_wb", motor.flux_linkage_wb,
                    box.motor.flux_linkage_wb * 0.7);
    expect_measured(found, "motor.inertia_kg_m2", motor.inertia_kg_m2, box.motor.inertia_kg_m2 * 2);

    first->does("adopt " + measured);
    first->does("store");
    const config_block_t stored = first->in_force();
    const auto again =
        std::make_unique<Session>(box, &first->flash(), FileChoice{measured, "", "", {}});
    first.reset();
    const config_block_t kept = again->in_force();
    TEST_ASSERT_EQUAL_MEMORY(&stored, &kept, sizeof stored);

    TEST_ASSERT_TRUE(again->does("get speed_loop").find("speed_loop.") != std::string::npos);
    again->does("unlock");
    again->does("set motor.max_speed_rpm=4000 tuning.command_timeout_s=2 observer.kappa=0.02");
    again->does("dump " + block);
    Session other(box);
    other.does("load " + block); // of another motor
    const config_block_t loaded = other.in_force();
    const config_block_t dumped = again->in_force();
    TEST_ASSERT_EQUAL_MEMORY(&dumped, &loaded, sizeof dumped);
}

TEST(a_measurement_that_does_not_begin_leaves_no_file_and_says_why)
{
    const Folder folder;
    const std::string plate = folder.file("plate.toml");
    const std::string measured = folder.file("measured.toml");
    write_plate(plate);
    Session session(out_of_the_box());
    const uint32_t before = session.in_force().cfg.crc;
    session.does("run");
    session.does("speed 1000");
    TEST_ASSERT_EQUAL_STRING(
        "identify: the motor is asked to run; `stop` first",
        session.refuses(fmt::format("identify {} {}", plate, measured)).c_str());
    TEST_ASSERT_FALSE(std::filesystem::exists(measured));
    TEST_ASSERT_EQUAL_UINT32(before, session.in_force().cfg.crc);
    session.does("stop");
}

TEST(while_the_drive_measures_a_motor_nothing_changes_what_it_measures_with_and_a_stop_ends_it)
{
    const Folder folder;
    const std::string plate = folder.file("plate.toml");
    write_plate(plate);
    Session session(out_of_the_box());
    TEST_ASSERT_EQUAL(nf::debug::Outcome::done, session.begins(plate).outcome);
    TEST_ASSERT_EQUAL_STRING("the motor is being measured; stop ends that",
                             session.refuses("set observer.kappa=0.02").c_str());
    session.refuses("run");
    session.does("get observer");
    session.does("status");
    session.does("wait 1");
    TEST_ASSERT_FALSE(session.has_ended());
    const std::vector<std::string> phases = session.phases();
    TEST_ASSERT_EQUAL_UINT(0, phases.at(0).find("pulses on each phase"));
    TEST_ASSERT_EQUAL_UINT(0, phases.at(1).find("the shaft turns by up to"));
    session.does("stop");
    session.does("wait 0.1");
    TEST_ASSERT_TRUE(session.has_ended());
    TEST_ASSERT_EQUAL_STRING("identify: a stop has ended it", session.why().c_str());
    session.does("defaults");
}

TEST(what_a_motor_will_see_is_said_before_and_is_no_more_than_the_name_plate_allows)
{
    const Folder folder;
    const std::string plate = folder.file("plate.toml");
    write_plate(plate);
    const nf::Config known = nf::known_from_plate(nf::load_plate(plate, "b_g431b_esc1"));
    const nf::identify::Demands demands = nf::identify::demands_of(known);
    constexpr double steps_a = 0.01; // of Q15, of this board's full scale
    TEST_ASSERT_DOUBLE_WITHIN(steps_a, 15, demands.current_a);
    TEST_ASSERT_DOUBLE_WITHIN(steps_a, 27, demands.largest_current_a); // 9/10 of the largest
    TEST_ASSERT_DOUBLE_WITHIN(1, 5000 / 2. * 4 / 3, demands.speed_rpm);
}

TEST(what_is_stored_is_there_after_another_start_from_the_file_of_the_flash)
{
    const Folder folder;
    const std::string path = folder.file("board.flash");
    const auto session = std::make_unique<Session>(out_of_the_box());
    session->does("set observer.kappa=0.02");
    session->does("store");
    {
        nf::OutputFile file(path);
        nf::live::write_flash(file, session->flash());
    }
    const hal_host_flash_t kept = nf::live::read_flash(path, 1);
    const auto again = std::make_unique<Session>(out_of_the_box(), &kept);
    TEST_ASSERT_EQUAL_UINT32(session->in_force().cfg.crc, again->in_force().cfg.crc);
    std::ofstream(path) << "no flash";
    try {
        (void)nf::live::read_flash(path, 1);
        TEST_FAIL_MESSAGE("it is no flash");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_UINT(0, std::string(error.what()).find(path + ": has 8 bytes"));
    }
}

TEST(a_wrong_name_plate_is_refused_by_file_and_key_and_an_existing_file_is_kept)
{
    const Folder folder;
    const std::string plate = folder.file("plate.toml");
    const std::string measured = folder.file("measured.toml");
    Session session(out_of_the_box());
    const uint32_t before = session.in_force().cfg.crc;
    write_plate(plate, "3000000");
    const std::string why = session.refuses(fmt::format("identify {} {}", plate, measured));
    TEST_ASSERT_TRUE_MESSAGE(why.find("motor.max_current_a") != std::string::npos, why.c_str());
    TEST_ASSERT_FALSE(std::filesystem::exists(measured));
    write_plate(plate);
    std::ofstream(measured) << "mine";
    TEST_ASSERT_EQUAL_UINT(
        0, session.refuses(fmt::format("identify {} {}", plate, measured)).find(measured));
    TEST_ASSERT_TRUE(session.refuses("identify a b c").find("\"c\"") != std::string::npos);
    TEST_ASSERT_EQUAL_UINT32(before, session.in_force().cfg.crc);
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
