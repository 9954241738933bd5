// SPDX-License-Identifier: MIT
// A run of the simulator whose power stage obeys a control image in an emulator:
//
//     bil_plant SCENARIO IMPERFECTIONS [SET...]
//
// IMPERFECTIONS is a set as of `motorsim run --with`, SET an override as of `motorsim run --set`.
// Each tick writes to stdout what the image's converters measure and what its user has asked for,
// and reads from stdin what the image's timer does with it (scenario.py, little-endian both). The
// host's drive sees the same and must have demanded the same. The table of results goes to stderr.
// Exit status: 0 all limits hold, 1 one does not or the image and the host differ, 2 bad input.
#include "report.h"
#include "scenario.h"

#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

constexpr int LIMITS_HOLD = 0;
constexpr int FAILED = 1;
constexpr int BAD_INPUT = 2;

struct Asked {
    std::uint16_t adc_ia;
    std::uint16_t adc_ib;
    std::uint16_t adc_bus;
    std::uint16_t adc_temperature;
    std::int32_t run;
    std::int32_t speed_rpm;
};
static_assert(sizeof(Asked) == 16, "no padding");

struct Done {
    std::uint16_t compare[PLANT_LEGS];
    std::uint16_t gates;
};
static_assert(sizeof(Done) == 8, "no padding");

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

class Image
{
public:
    drive_out_t step(const nf::Tick &tick)
    {
        const drive_in_t &in = tick.sim->in();
        const drive_out_t &host = tick.sim->out();
        put({in.adc_ia, in.adc_ib, in.adc_bus, in.adc_temperature,
             in.command.request == DRIVE_REQUEST_RUN ? 1 : 0,
             static_cast<std::int32_t>(tick.command)});
        const Done done = get();
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

private:
    int64_t tick_ = 0;
};

int run(const std::vector<std::string> &arguments)
{
    const nf::Config config = nf::load_scenario(arguments.at(0), {arguments.at(1)},
                                                {arguments.begin() + 2, arguments.end()});
    if (config.scenario.mode != nf::DriveMode::speed) {
        throw std::runtime_error("the image's console commands speeds only");
    }
    Image image;
    nf::RunOptions options;
    options.power_stage = [&image](const nf::Tick &tick) { return image.step(tick); };
    const nf::RunResult result = nf::run_scenario(config, options);
    fmt::print(stderr, "{}", nf::table_text(config, result));
    return nf::violations(config, result).empty() ? LIMITS_HOLD : FAILED;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 3) {
        std::fputs("usage: bil_plant SCENARIO IMPERFECTIONS [SET...]\n", stderr);
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
