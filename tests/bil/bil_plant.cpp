// SPDX-License-Identifier: MIT
// A run of the simulator whose power stage obeys a control image in an emulator:
//
//     bil_plant SCENARIO IMPERFECTIONS [--json FILE] [SET...]
//
// IMPERFECTIONS is a set as of `motorsim run --with`, SET an override as of `motorsim run --set`.
// Each tick writes to stdout what the image's converters measure and what its user has asked for,
// and reads from stdin what the image's timer does with it (scenario.py, little-endian both). The
// host's drive sees the same and must have demanded the same. Where the image's background commands
// by itself, it says what, and the host's drive is commanded the same. The table of results goes to
// stderr, and as of `motorsim run --json` to FILE.
// Exit status: 0 all limits hold, 1 one does not or the image and the host differ, 2 bad input.
#include "report.h"
#include "scenario.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

constexpr double Q16 = 65536;
constexpr int LIMITS_HOLD = 0;
constexpr int FAILED = 1;
constexpr int BAD_INPUT = 2;

struct Asked {
    std::uint16_t adc_ia;
    std::uint16_t adc_ib;
    std::uint16_t adc_bus;
    std::uint16_t adc_temperature;
    std::uint16_t shaft; // reading of the shaft's sensor, hal_shaft()
    std::uint16_t index;
    std::uint16_t indexed;
    std::uint16_t age_q8;
    std::uint16_t frame; // of an absolute encoder, at this instant
    std::uint16_t unused;
    std::int32_t run;
    std::int32_t speed_rpm;
    std::int32_t target; // the script's, as drive_command_t has it
    std::int32_t mode;
};
static_assert(sizeof(Asked) == 36, "no padding");

struct Done {
    std::uint16_t compare[PLANT_LEGS];
    std::uint16_t gates;
    std::int32_t target; // with `commands`: of the next tick
    std::uint8_t mode;
    std::uint8_t request;
    std::uint16_t commands; // the image's background, in place of the script
};
static_assert(sizeof(Done) == 16, "no padding");

struct Different : std::runtime_error {
    using std::runtime_error::runtime_error;
};

void put(const Asked &asked)
{
    if (std::fwrite(&asked, sizeof asked, 1, stdout) != 1 || std::fflush(stdout) != 0) {
        throw std::runtime_error("nobody listens");
    }
}

Done get()
{
    Done done{};
    if (std::fread(&done, sizeof done, 1, stdin) != 1) {
        throw std::runtime_error("nobody answers");
    }
    return done;
}

std::string text(const std::uint16_t *compare, bool gates)
{
    return fmt::format("compare {} {} {}, gates {}", compare[0], compare[1], compare[2],
                       gates ? "on" : "open");
}

std::int32_t target_of(const nf::Tick &tick)
{
    const nf::Bases &bases = tick.sim->bases();
    const double target = tick.mode == nf::DriveMode::position
                              ? bases.turns_from_mech_rad(tick.command) * Q16
                              : bases.step_from_rpm(tick.command);
    return static_cast<std::int32_t>(std::lround(target));
}

std::optional<drive_command_t> command_of(const Done &done)
{
    if (done.commands == 0) {
        return {};
    }
    return drive_command_t{done.target, done.mode, done.request};
}

class Image
{
public:
    drive_out_t step(const nf::Tick &tick)
    {
        const drive_in_t &in = tick.sim->in();
        const drive_out_t &host = tick.sim->out();
        const hal_shaft_t &shaft = tick.sim->hal().seen_shaft;
        put({in.adc_ia, in.adc_ib, in.adc_bus, in.adc_temperature, shaft.reading, shaft.index,
             static_cast<std::uint16_t>(shaft.indexed), shaft.age_q8, tick.sim->plant().shaft.frame,
             0, tick.request == DRIVE_REQUEST_RUN ? 1 : 0, static_cast<std::int32_t>(tick.command),
             target_of(tick),
             tick.mode == nf::DriveMode::position ? DRIVE_MODE_POSITION : DRIVE_MODE_SPEED});
        const Done done = get();
        commanded_ = command_of(done);
        if (!commanded_ && tick.mode != nf::DriveMode::speed) {
            throw std::runtime_error("the image's console commands speeds only");
        }
        drive_out_t out{};
        std::memcpy(out.compare.phase, done.compare, sizeof done.compare);
        out.gate_enable = done.gates != 0;
        if (std::memcmp(done.compare, host.compare.phase, sizeof done.compare) != 0 ||
            out.gate_enable != host.gate_enable) {
            throw Different(fmt::format("tick {}: image: {}; host: {}", tick_,
                                        text(done.compare, out.gate_enable),
                                        text(host.compare.phase, host.gate_enable)));
        }
        tick_++;
        return out;
    }

    const std::optional<drive_command_t> &commanded() const
    {
        return commanded_;
    }

private:
    int64_t tick_ = 0;
    std::optional<drive_command_t> commanded_;
};

// The file of --json, which is taken out; "": none.
std::string take_json(std::vector<std::string> &arguments)
{
    std::string file;
    if (arguments.size() > 3 && arguments.at(2) == "--json") {
        file = arguments.at(3);
        arguments.erase(arguments.begin() + 2, arguments.begin() + 4);
    }
    return file;
}

int run(std::vector<std::string> arguments)
{
    const std::string json = take_json(arguments);
    const nf::Config config = nf::load_scenario(arguments.at(0), {arguments.at(1)},
                                                {arguments.begin() + 2, arguments.end()});
    Image image;
    nf::RunOptions options;
    options.power_stage = [&image](const nf::Tick &tick) { return image.step(tick); };
    options.commander = [&image] { return image.commanded(); };
    const nf::RunResult result = nf::run_scenario(config, options);
    fmt::print(stderr, "{}", nf::table_text(config, result));
    if (!json.empty()) {
        std::ofstream(json) << nf::json_text(config, result);
    }
    return nf::violations(config, result).empty() ? LIMITS_HOLD : FAILED;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 3) {
        std::fputs("usage: bil_plant SCENARIO IMPERFECTIONS [--json FILE] [SET...]\n", stderr);
        return BAD_INPUT;
    }
    try {
        return run({argv + 1, argv + argc});
    } catch (const Different &difference) {
        fmt::print(stderr, "bil_plant: {}\n", difference.what());
        return FAILED;
    } catch (const std::exception &error) {
        fmt::print(stderr, "bil_plant: {}\n", error.what());
        return BAD_INPUT;
    }
}
