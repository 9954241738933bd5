// SPDX-License-Identifier: MIT
#include "trial.h"

#include "draw.h"
#include "machine.h"
#include "scenario.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>

#include <fmt/format.h>

namespace nf::certify
{
namespace
{

constexpr double REACHED = 0.95; // of a speed

zoo::Draw draw_of(uint64_t seed, int run)
{
    return zoo::Draw(fmt::format("certify:{}@{}", run, seed));
}

// The plant follows no knee that is too small; such a leg is as good as an ideal one, and the least
// knee is the nearest.
void keep_knee(Config &real, const drive_cfg_t &drive)
{
    constexpr double reserve = 1.05;
    const double knee_a = real.plant.commutation_knee_a;
    real.plant.commutation_knee_a = 0;
    const plant_cfg_t ideal = make_plant_cfg(real, drive);
    const bool has_loss = real.plant.dead_time_s > 0 || real.plant.device_drop_v > 0;
    if (knee_a > 0 && has_loss) {
        real.plant.commutation_knee_a = std::max(knee_a, reserve * plant_least_knee(&ideal));
    }
}

Config machine_at(const Config &believed, const std::vector<Axis> &box, const Point &point,
                  unsigned noise)
{
    Config real = believed;
    real.scenario = timetable(believed, most_inertia(box));
    real.scenario.seed = noise;
    for (std::size_t k = 0; k < box.size(); k++) {
        box[k].set(real, point[k]);
    }
    keep_knee(real, build(believed));
    return real;
}

Verdict verdict_of(const RunResult &result, const Margins &margins)
{
    if (!result.faults.empty()) {
        return Verdict::stopped;
    }
    if (!result.metrics.locked) {
        return Verdict::lost;
    }
    return margins.reached < REACHED ? Verdict::slow : Verdict::held;
}

} // namespace

const char *verdict_text(Verdict verdict)
{
    switch (verdict) {
    case Verdict::held:
        return "held";
    case Verdict::slow:
        return "slow";
    case Verdict::stopped:
        return "stopped";
    case Verdict::lost:
        break;
    }
    return "lost";
}

double Trial::worst() const
{
    return is_locked(verdict) ? std::max(margins.worst(), 0.0) : 0;
}

Point draw_point(const std::vector<Axis> &box, uint64_t seed, int run)
{
    const zoo::Draw draw = draw_of(seed, run);
    Point point;
    point.reserve(box.size());
    for (const Axis &axis : box) {
        point.push_back(draw.uniform(axis.key.c_str(), {axis.low, axis.high}));
    }
    return point;
}

unsigned noise_seed(uint64_t seed, int run)
{
    return static_cast<unsigned>(draw_of(seed, run).below("noise seed", 1U << 31U));
}

Trial try_point(const Config &believed, const std::vector<Axis> &box, const Point &point,
                unsigned noise)
{
    const Config real = machine_at(believed, box, point, noise);
    MarginWatch watch(believed, real.scenario);
    RunOptions options;
    options.sink = &watch;
    const RunResult result = run_scenario(real, believed, options);
    Trial trial;
    trial.margins = watch.margins();
    trial.verdict = verdict_of(result, trial.margins);
    trial.fault = result.faults.empty() ? "" : fault_text(result.faults.front().id)->name;
    trial.swings = result.metrics.limit_cycle;
    return trial;
}

} // namespace nf::certify
