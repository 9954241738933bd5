// SPDX-License-Identifier: MIT
// Tries motors of the zoo as a user would, many in one process: try_motors FOLDER FIRST COUNT SEED.
// For each number from FIRST on it writes the files of the motor and the headers made of them,
// drive_config.h and hal_config.h, into a folder of its own in FOLDER, runs and records some ticks,
// and replays the recording. Prints a line of JSON a motor: {"refused": LINE}, or what the run and
// the replay came to.
#include "hal_header.h"
#include "header.h"
#include "reader.h"
#include "replay.h"
#include "scripted_run.h"
#include "writer.h"
#include "zoo.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace
{

constexpr int TICKS = 6000; // the calibration, and the beginning of a start

void write(const std::filesystem::path &path, const std::string &text)
{
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) {
        throw std::runtime_error(path.string() + ": cannot be written");
    }
}

// A fault ends it: the recorder keeps the first one.
std::string recorded(const nf::Config &config, nf::ScriptedRun &run)
{
    nf::replay::Writer writer(config);
    for (int k = 0; k < TICKS && run.sim().drive().state != DRIVE_STATE_FAULT; k++) {
        writer.add(run.control());
        run.advance();
    }
    return writer.text();
}

// Most users have the default tuning, a rotor that stands, or turns already.
std::vector<std::string> overrides(unsigned number, const nf::Config &config)
{
    const char *const tunings[] = {"robust_motor_a", "robust_motor_a", "robust_motor_a",
                                   "voltage_phase"};
    constexpr double speeds[] = {0, 0.5, 0, -0.8};
    return {
        fmt::format("tuning={}", tunings[number % std::size(tunings)]),
        fmt::format("scenario.initial_speed_rpm={}",
                    speeds[number / 4 % std::size(speeds)] * config.motor.rated_speed_rpm),
        "scenario.request=[]",
        fmt::format("scenario.command=[{{time_s = 0, speed_rpm = {}}}]",
                    config.motor.rated_speed_rpm / 2),
        "scenario.load=[]",
    };
}

nlohmann::json tried(const std::filesystem::path &folder, unsigned number)
{
    const std::string scenario = (folder / "exact.toml").string();
    const nf::Config config =
        nf::load_scenario(scenario, {}, overrides(number, nf::load_scenario(scenario)));
    write(folder / "drive_config.h", nf::make_header(config));
    write(folder / "hal_config.h", nf::make_hal_header(config));
    nf::ScriptedRun run(config);
    const nf::replay::Recording recording = nf::replay::read(recorded(config, run));
    const nf::replay::Result result = nf::replay::replay(recording);
    const nf::Bases &bases = recording.run.image.bases;
    return {
        {"frames", recording.run.frames.size()},
        {"state", recording.header.fault_id == FAULT_NONE ? "no fault" : "fault"},
        {"recorded_hash", recording.header.end_hash},
        {"replayed_hash", result.end_hash},
        {"departs", result.difference.has_value()},
        {"rpm_of_a_step", run.sim().bases().rpm_from_step(1)},
        {"replayed_rpm_of_a_step", bases.rpm_from_step(1)},
        {"current_a", run.sim().bases().current_a},
        {"replayed_current_a", bases.current_a},
        {"voltage_v", run.sim().bases().voltage_v},
        {"replayed_voltage_v", bases.voltage_v},
    };
}

nlohmann::json outcome(const std::filesystem::path &folder, unsigned number)
{
    try {
        return tried(folder, number);
    } catch (const std::exception &error) {
        return {{"refused", error.what()}};
    }
}

void try_one(const std::filesystem::path &folder, unsigned number, const std::string &seed)
{
    const std::optional<nf::zoo::Reference> motor =
        nf::zoo::parse(fmt::format("zoo:{}@{}", number, seed));
    if (!motor) {
        throw std::runtime_error(nf::zoo::allowed());
    }
    const std::filesystem::path own = folder / std::to_string(number);
    std::filesystem::create_directory(own);
    for (const nf::zoo::File &file : nf::zoo::files(*motor)) {
        write(own / file.name, file.text);
    }
    fmt::print("{}\n", outcome(own, number).dump());
}

} // namespace

int main(int argc, char **argv)
{
    try {
        if (argc != 5) {
            throw std::runtime_error("try_motors FOLDER FIRST COUNT SEED");
        }
        const unsigned long first = std::stoul(argv[2]);
        for (unsigned long k = 0; k < std::stoul(argv[3]); k++) {
            try_one(argv[1], static_cast<unsigned>(first + k), argv[4]);
        }
    } catch (const std::exception &error) {
        std::fputs(error.what(), stderr);
        return 1;
    }
    return 0;
}
