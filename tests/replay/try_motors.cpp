// SPDX-License-Identifier: MIT
// Tries configurations as a user would, many in one process: for each FOLDER of the command line it reads scenario.toml, makes
// the headers as FOLDER/drive_config.h and FOLDER/hal_config.h, runs and records some ticks, and replays the recording. Prints a line of
// JSON a folder: {"refused": LINE}, or what the run and the replay came to.
#include "hal_header.h"
#include "header.h"
#include "reader.h"
#include "replay.h"
#include "scripted_run.h"
#include "writer.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

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

nlohmann::json tried(const std::filesystem::path &folder)
{
    const nf::Config config = nf::load_scenario((folder / "scenario.toml").string());
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

nlohmann::json outcome(const std::filesystem::path &folder)
{
    try {
        return tried(folder);
    } catch (const std::exception &error) {
        return {{"refused", error.what()}};
    }
}

} // namespace

int main(int argc, char **argv)
{
    try {
        for (int k = 1; k < argc; k++) {
            fmt::print("{}\n", outcome(argv[k]).dump());
        }
    } catch (const std::exception &error) {
        std::fputs(error.what(), stderr);
        return 1;
    }
    return 0;
}
