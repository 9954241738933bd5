// SPDX-License-Identifier: MIT
#include "campaign.h"

#include <algorithm>

namespace nf::certify
{
namespace
{

constexpr const char *BASE = "any"; // the scenario that names what nobody chose

Series series_of(const std::string &tuning, const std::vector<std::string> &with,
                 std::vector<std::string> set)
{
    set.push_back("tuning=" + tuning);
    Series series;
    series.tuning = tuning;
    series.believed = load_scenario(BASE, with, set);
    try {
        (void)build(series.believed);
    } catch (const ConfigError &error) {
        series.refusal = error.what();
    }
    return series;
}

void run_one(Campaign &campaign, int run)
{
    const Point point = draw_point(campaign.box, campaign.seed, run);
    for (Series &series : campaign.series) {
        if (series.refusal.empty()) {
            series.trials.push_back(
                try_point(series.believed, campaign.box, point, noise_seed(campaign.seed, run)));
        }
    }
    campaign.points.push_back(point);
}

} // namespace

Campaign plan(const std::vector<std::string> &tunings, const std::vector<std::string> &with,
              const std::vector<std::string> &set)
{
    Campaign campaign;
    for (const std::string &tuning : tunings) {
        campaign.series.push_back(series_of(tuning, with, set));
    }
    const auto is_possible = [](const Series &series) { return series.refusal.empty(); };
    if (std::none_of(campaign.series.begin(), campaign.series.end(), is_possible)) {
        throw ConfigError(campaign.series.front().refusal);
    }
    campaign.box = box_of(campaign.series.front().believed);
    return campaign;
}

void run(Campaign &campaign, int runs, uint64_t seed, const Watcher &watcher)
{
    campaign.planned = runs;
    campaign.seed = seed;
    for (int run = 0; run < runs && !(watcher.stop && watcher.stop()); run++) {
        if (watcher.progress) {
            watcher.progress(static_cast<double>(run) / runs);
        }
        run_one(campaign, run);
    }
    if (watcher.progress) {
        watcher.progress(1);
    }
}

} // namespace nf::certify
