// SPDX-License-Identifier: MIT
// Prints which share of the ticks of a running motor is shown, as the tables for docs/live.md: on
// slow lines with rings of several sizes, and on lines that spoil bytes. S2 with the imperfections
// `adc`, 10 kHz.
#include "follower.h"
#include "lossy_channel.h"
#include "simulated_board.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

constexpr double FOLLOWED_S = 10;
constexpr double PASS_S = 0.001;

class Count : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        longest_s = ticks == 0 ? 0 : std::max(longest_s, tick.time_s - last_s_);
        last_s_ = tick.time_s;
        ticks++;
    }
    uint64_t ticks = 0;
    double longest_s = 0; // without a tick

private:
    double last_s_ = 0;
};

// `spoilt`: share of the bytes, both ways; a third each is changed, dropped, doubled.
std::string share(int entries, int baud, double spoilt)
{
    const nf::Config config =
        nf::load_scenario("s2_robust", {"adc"},
                          {"scenario.duration_s=60", fmt::format("board.baud={}", baud),
                           fmt::format("board.recorder_entries={}", entries)});
    const nf::live::Loss loss = {spoilt / 3, spoilt / 3, spoilt / 3};
    nf::live::SimulatedBoard board(config);
    nf::live::BoardChannel clean(board);
    nf::live::LossyChannel line(clean, loss, loss, 1);
    Count shown;
    nf::live::FollowerOptions options;
    options.timing.answer_s = 0.02;
    options.timing.tries = 100;
    nf::live::Follower follower(line, shown, {}, options);
    follower.connect();
    const double from_s = line.now_s();
    while (line.now_s() < from_s + FOLLOWED_S) {
        follower.step(PASS_S);
    }
    const double all = FOLLOWED_S / board.run().sim().bases().control_period_s;
    const double percent = 100 * static_cast<double>(shown.ticks) / all;
    return follower.gaps().empty() && shown.ticks > 0
               ? "all"
               : fmt::format("{:.0f} %, {:.1f} s", percent, shown.longest_s);
}

void print_slow_lines()
{
    fmt::print("| ring, entries | 115200 baud | 150000 | 180000 | 200000 | 230400 |\n"
               "| --- | --- | --- | --- | --- | --- |\n");
    for (const int entries : {1168, 2048, 4096}) {
        fmt::print("| {} |", entries);
        for (const int rate : {115200, 150000, 180000, 200000, 230400}) {
            fmt::print(" {} |", share(entries, rate, 0));
        }
        fmt::print("\n");
    }
}

void print_bad_lines()
{
    fmt::print("| ring, entries | baud | 0.03 % | 0.1 % | 0.3 % | 1 % |\n"
               "| --- | --- | --- | --- | --- | --- |\n");
    for (const int entries : {1168, 4096}) {
        for (const int rate : {460800, 760000}) {
            fmt::print("| {} | {} |", entries, rate);
            for (const double spoilt : {0.0003, 0.001, 0.003, 0.01}) {
                fmt::print(" {} |", share(entries, rate, spoilt));
            }
            fmt::print("\n");
        }
    }
}

} // namespace

int main()
{
    try {
        print_slow_lines();
        fmt::print("\n");
        print_bad_lines();
        return 0;
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
}
