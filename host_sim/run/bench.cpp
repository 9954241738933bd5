// SPDX-License-Identifier: MIT
#include "bench.h"

#include "machine.h"
#include "profile.h"
#include "scenario.h"

#include <algorithm>
#include <chrono>
#include <vector>

namespace nf
{
namespace
{

struct Frame {
    drive_in_t in;
    drive_out_t out;
    double load_nm;
};

class Recorder : public TickSink
{
public:
    void add(const Tick &tick) override
    {
        frames.push_back({tick.sim->in(), tick.sim->out(), tick.load_nm});
    }
    std::vector<Frame> frames;
};

// What a replay computes, so that none of it can be left out.
volatile uint64_t checksum = 0;

void replay_plant(const Config &config, const drive_cfg_t &drive_cfg,
                  const std::vector<Frame> &frames)
{
    const plant_cfg_t cfg = make_plant_cfg(config, drive_cfg);
    plant_t plant{};
    const char *bad = nullptr;
    (void)plant_init(&plant, &cfg, &bad);
    for (const Frame &frame : frames) {
        plant_adc_t adc{};
        plant_sample(&plant, &adc);
        checksum = checksum + adc.ia;
        plant_set_load_torque(&plant, frame.load_nm);
        const uint16_t *const phase = frame.out.compare.phase;
        const uint32_t compare[PLANT_LEGS] = {phase[0], phase[1], phase[2]};
        plant_write_compare(&plant, compare);
        plant_set_gates(&plant, frame.out.gate_enable);
        plant_step(&plant);
    }
}

void replay_drive(const drive_cfg_t &cfg, const std::vector<Frame> &frames)
{
    drive_t drive{};
    (void)drive_init(&drive, &cfg);
    for (const Frame &frame : frames) {
        drive_out_t out{};
        drive_step(&drive, &frame.in, &out);
        checksum = checksum + out.compare.phase[0];
    }
}

template <typename Work> double seconds(Work work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <typename Work> std::vector<double> timed(int runs, Work work)
{
    std::vector<double> times;
    times.reserve(static_cast<std::size_t>(runs));
    work();
    for (int k = 0; k < runs; k++) {
        times.push_back(seconds(work));
    }
    std::sort(times.begin(), times.end());
    return times;
}

} // namespace

BenchResult bench(const Config &config, int runs)
{
    Recorder recorder;
    RunOptions options;
    options.sink = &recorder;
    const RunResult result = run_scenario(config, options);
    const drive_cfg_t cfg = build(config);
    const auto whole = timed(
        runs, [&] { checksum = checksum + static_cast<uint64_t>(run_scenario(config).ticks); });
    const auto plant = timed(runs, [&] { replay_plant(config, cfg, recorder.frames); });
    const auto drive = timed(runs, [&] { replay_drive(cfg, recorder.frames); });
    const double ns_per_tick = 1e9 / static_cast<double>(result.ticks);
    BenchResult b;
    b.scenario = config.scenario.id;
    b.runs = runs;
    b.ticks = result.ticks;
    b.simulated_s =
        static_cast<double>(result.ticks) * make_bases(config.motor, config.board).control_period_s;
    const double median = whole[whole.size() / 2];
    b.best_ns = whole.front() * ns_per_tick;
    b.median_ns = median * ns_per_tick;
    b.plant_ns = plant.front() * ns_per_tick;
    b.drive_ns = drive.front() * ns_per_tick;
    b.real_time_best = b.simulated_s / whole.front();
    b.real_time_median = b.simulated_s / median;
    return b;
}

} // namespace nf
