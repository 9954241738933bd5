// SPDX-License-Identifier: MIT
// Any text as a configuration file: it is refused with one line, or the drive and the simulation
// run with it.
//
// The first byte chooses what the rest is: a motor, board, tuning, scenario or imperfection file,
// or overrides, one a line; and what stands beside it.
#include "bytes.h"
#include "config.h"
#include "describe.h"
#include "drive_holds.h"
#include "fuzzed.h"
#include "hal_header.h"
#include "header.h"
#include "sim.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace
{

constexpr int TICKS = 50; // with a configuration that was accepted
constexpr std::size_t OVERRIDES_MAX = 8;

// A file that is there as long as the program runs.
class File
{
public:
    File()
        : folder_(std::filesystem::temp_directory_path() /
                  ("fuzz_config." + std::to_string(getpid())))
    {
        std::filesystem::create_directories(folder_);
    }
    File(const File &) = delete;
    File &operator=(const File &) = delete;
    ~File()
    {
        std::error_code error;
        std::filesystem::remove_all(folder_, error);
    }

    std::string with(const std::string &text) const
    {
        const std::filesystem::path path = folder_ / "input.toml";
        std::ofstream(path, std::ios::binary) << text;
        return path.string();
    }

private:
    std::filesystem::path folder_;
};

struct Parts {
    const char *motor;
    const char *board;
    const char *tuning;
};

constexpr Parts PARTS[] = {
    {"motor_a", "bench_310v", "robust_motor_a"},
    {"motor_b", "bench_310v", "voltage_phase"},
    {"outrunner_24v", "b_g431b_esc1", "robust_motor_a"},
    {"motor_a", "g431_bench", "published"},
};

std::vector<std::string> lines_of(const std::string &text)
{
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; lines.size() < OVERRIDES_MAX && std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

nf::Config load(unsigned choice, const std::string &text)
{
    static const File file;
    const Parts &parts = PARTS[(choice / 6) % std::size(PARTS)];
    switch (choice % 6) {
    case 0:
        return nf::load_parts(file.with(text), parts.board, parts.tuning);
    case 1:
        return nf::load_parts(parts.motor, file.with(text), parts.tuning);
    case 2:
        return nf::load_parts(parts.motor, parts.board, file.with(text));
    case 3:
        return nf::load_scenario(file.with(text));
    case 4:
        return nf::load_scenario("s2_robust", {file.with(text)});
    default:
        return nf::load_parts(parts.motor, parts.board, parts.tuning, {}, lines_of(text));
    }
}

void one_line(const nf::ConfigError &error)
{
    const std::string line = error.what();
    HOLDS(!line.empty(), "a refusal says why");
    for (const char c : line) {
        HOLDS(static_cast<unsigned char>(c) >= ' ' && c != '\x7F', line.c_str());
    }
}

void run(const nf::Config &config)
{
    nf::Simulation sim(config);
    sim.request(DRIVE_REQUEST_RUN);
    sim.command_speed_rpm(config.motor.rated_speed_rpm);
    for (int k = 0; k < TICKS; k++) {
        const drive_state_t before = sim.drive().state;
        sim.control();
        fuzz::tick_holds(before, sim.drive(), sim.in(), sim.out());
        sim.advance();
    }
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz::Bytes bytes(data, size);
    const unsigned choice = bytes.byte();
    try {
        const nf::Config config = load(choice, bytes.rest());
        const drive_cfg_t cfg = nf::build(config);
        fuzz::configuration_holds(cfg);
        (void)nf::make_header(config);
        run(config);
        (void)nf::make_hal_header(config);
    } catch (const nf::ConfigError &error) {
        one_line(error);
    }
    return 0;
}
