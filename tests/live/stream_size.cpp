// SPDX-License-Identifier: MIT
// Prints how many bytes a tick of the stream takes, as a table for docs/live.md: S1 to S5, with the
// imperfections `adc` and `all`, from the board's line, with all that is around the entries.
#include "follower.h"
#include "line_rate.h"
#include "simulated_board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

#include <fmt/format.h>

namespace
{

constexpr double WINDOW_S = 0.1;
constexpr double BEGIN_S = 0.5;
constexpr double PASS_S = 0.001;

struct Size {
    double mean; // bytes a tick
    double largest;
};

class Nobody : public nf::TickSink
{
public:
    void add(const nf::Tick & /*tick*/) override
    {
    }
};

// A run to the end of its script. The line is never full.
Size measure(const std::string &scenario, const std::string &with)
{
    const nf::Config config =
        nf::load_scenario(scenario, {with}, {"board.baud=760000", "board.recorder_entries=4096"});
    nf::live::SimulatedBoard board(config);
    nf::live::BoardChannel line(board);
    Nobody nobody;
    nf::live::Follower follower(line, nobody, {}, {});
    follower.connect();
    // The first state is asked for once, and is no part of the stream.
    for (const double until_s = line.now_s() + BEGIN_S; line.now_s() < until_s;) {
        follower.step(PASS_S);
    }
    const double begun_s = line.now_s();
    const uint64_t begun = follower.bytes_in();
    const double tick_s = board.run().sim().bases().control_period_s;
    double largest = 0;
    while (line.now_s() < board.script_s()) {
        const double from_s = line.now_s();
        const uint64_t from = follower.bytes_in();
        while (line.now_s() < from_s + WINDOW_S) {
            follower.step(PASS_S);
        }
        largest = std::max(largest, static_cast<double>(follower.bytes_in() - from) /
                                        ((line.now_s() - from_s) / tick_s));
    }
    const double ticks = (line.now_s() - begun_s) / tick_s;
    return {static_cast<double>(follower.bytes_in() - begun) / ticks, largest};
}

double baud(double bytes, double ticks_per_s)
{
    return std::ceil(bytes * ticks_per_s * nf::live::BITS_OF_A_BYTE /
                     nf::live::SHARE_OF_THE_STREAM);
}

} // namespace

int main()
{
    try {
        bool fits = true;
        fmt::print("| scenario | with | mean | largest in 0.1 s | baud at 10 kHz | at 20 kHz |\n"
                   "| --- | --- | --- | --- | --- | --- |\n");
        for (const char *scenario : {"s1", "s2", "s3", "s4", "s5"}) {
            for (const char *with : {"adc", "all"}) {
                const Size size = measure(scenario, with);
                fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.0f} | {:.0f} |\n", scenario, with,
                           size.mean, size.largest, baud(size.largest, 10e3),
                           baud(size.largest, 20e3));
                fits = fits && size.largest <= nf::live::BYTES_OF_A_TICK;
            }
        }
        // What `motorsim live` asks of a line is enough for each of them.
        return fits ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "stream_size: %s\n", error.what());
        return 2;
    }
}
