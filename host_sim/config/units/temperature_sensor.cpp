// SPDX-License-Identifier: MIT
#include "temperature_sensor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nf
{

double temperature_count(const BoardSettings &board, double temperature_c)
{
    const std::vector<double> &points = board.temperature_points_c;
    const std::vector<double> &pct = board.temperature_points_pct;
    const auto above = std::upper_bound(points.begin() + 1, points.end() - 1, temperature_c);
    const auto k = static_cast<std::size_t>(above - points.begin());
    const double share = (temperature_c - points[k - 1]) / (points[k] - points[k - 1]);
    return std::ldexp((pct[k - 1] + share * (pct[k] - pct[k - 1])) / 100, board.adc_bits);
}

double temperature_at(const BoardSettings &board, double count)
{
    const std::vector<double> &pct = board.temperature_points_pct;
    const double wanted = 100 * std::ldexp(count, -board.adc_bits);
    const bool rises = pct.back() > pct.front();
    std::size_t k = 1;
    while (k + 1 < pct.size() && (rises ? pct[k] < wanted : pct[k] > wanted)) {
        k++;
    }
    const std::vector<double> &points = board.temperature_points_c;
    const double share = (wanted - pct[k - 1]) / (pct[k] - pct[k - 1]);
    return points[k - 1] + share * (points[k] - points[k - 1]);
}

} // namespace nf
