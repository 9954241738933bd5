// SPDX-License-Identifier: MIT
#include "worst_map.h"

#include <algorithm>
#include <cmath>

namespace nf::certify
{
namespace
{

constexpr double RUNS_A_CELL = 4; // on average
constexpr std::size_t SIDE_MIN = 3;
constexpr std::size_t SIDE_MAX = 8;

std::size_t side_of(std::size_t runs)
{
    const double side = std::sqrt(static_cast<double>(runs) / RUNS_A_CELL);
    return std::clamp(static_cast<std::size_t>(side), SIDE_MIN, SIDE_MAX);
}

std::size_t place_of(double x, const Axis &axis, std::size_t side)
{
    const double share = (x - axis.low) / (axis.high - axis.low);
    return std::min(static_cast<std::size_t>(share * static_cast<double>(side)), side - 1);
}

} // namespace

WorstMap map_of(const Campaign &campaign, const Judgement &judgement)
{
    const std::vector<Influence> &influences = judgement.summaries[judgement.best].influences;
    const std::vector<Trial> &trials = campaign.series[judgement.best].trials;
    WorstMap map{influences[0].axis, influences[1].axis, side_of(trials.size()), {}};
    map.cells.resize(map.side * map.side);
    for (std::size_t run = 0; run < trials.size(); run++) {
        const Point &point = campaign.points[run];
        const std::size_t column = place_of(point[map.across], campaign.box[map.across], map.side);
        const std::size_t row = place_of(point[map.up], campaign.box[map.up], map.side);
        Cell &cell = map.cells[row * map.side + column];
        cell.runs++;
        cell.failed += is_locked(trials[run].verdict) ? 0 : 1;
        cell.worst = std::min(cell.worst, trials[run].worst());
    }
    return map;
}

} // namespace nf::certify
