// SPDX-License-Identifier: MIT
#include "statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>

namespace nf::certify
{
namespace
{

double mean_of(const std::vector<double> &values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double squares_about(const std::vector<double> &values, double centre)
{
    return std::accumulate(values.begin(), values.end(), 0.0, [&](double sum, double value) {
        return sum + (value - centre) * (value - centre);
    });
}

} // namespace

double least_share(int good, int count)
{
    constexpr double z = 1.6449; // 95 % of a normal distribution lie below
    if (count == 0) {
        return 0;
    }
    const double share = static_cast<double>(good) / count;
    const double spread =
        z * std::sqrt(share * (1 - share) / count + z * z / (4.0 * count * count));
    return std::max(0.0, (share + z * z / (2 * count) - spread) / (1 + z * z / count));
}

double quantile(std::vector<double> values, double share)
{
    if (values.empty()) {
        return 0;
    }
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

int quarter_of(double x, double low, double high)
{
    return std::clamp(static_cast<int>(4 * (x - low) / (high - low)), 0, 3);
}

double explained_share(const std::vector<int> &groups, const std::vector<double> &values)
{
    std::map<int, std::vector<double>> members;
    for (std::size_t k = 0; k < values.size(); k++) {
        members[groups[k]].push_back(values[k]);
    }
    const auto between = static_cast<double>(members.size()) - 1;
    const double within = static_cast<double>(values.size() - members.size());
    if (between < 1 || within < 1) {
        return 0;
    }
    double unexplained = 0;
    for (const auto &[group, those] : members) {
        unexplained += squares_about(those, mean_of(those));
    }
    const double all = squares_about(values, mean_of(values));
    const double by_chance = between * unexplained / within;
    return all > 0 ? std::max(0.0, (all - unexplained - by_chance) / all) : 0;
}

} // namespace nf::certify
