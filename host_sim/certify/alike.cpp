// SPDX-License-Identifier: MIT
#include "alike.h"

#include "dimensionless.h"
#include "scenario.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace nf::certify
{
namespace
{

constexpr double NO_DIFFICULTY = 1e-4; // a number below is no difficulty, whatever it is

using Logs = std::vector<double>;

struct Kin {
    std::string name; // of the exact motor
    Logs logs;
};

Logs logs_of(const Config &config)
{
    Logs logs;
    for (const Dimensionless &number : dimensionless(config)) {
        logs.push_back(std::log(std::max(number.value, NO_DIFFICULTY)));
    }
    return logs;
}

std::vector<Kin> draw_kin(int drawn)
{
    std::vector<Kin> kin;
    for (int number = 0; number < drawn; number++) {
        const std::string name = fmt::format("zoo:{}", number);
        kin.push_back({name, logs_of(load_scenario(name))});
    }
    return kin;
}

double deviation(const std::vector<Kin> &kin, std::size_t number)
{
    double sum = 0;
    double squares = 0;
    for (const Kin &each : kin) {
        sum += each.logs[number];
        squares += each.logs[number] * each.logs[number];
    }
    const auto count = static_cast<double>(kin.size());
    return std::sqrt(std::max(squares / count - sum * sum / (count * count), 0.0));
}

double distance(const Logs &one, const Logs &other, const Logs &deviations)
{
    double squares = 0;
    for (std::size_t number = 0; number < one.size(); number++) {
        if (deviations[number] > 0) {
            squares += std::pow((one[number] - other[number]) / deviations[number], 2);
        }
    }
    return squares;
}

} // namespace

std::vector<std::string> most_alike(const std::string &motor, const std::string &board, int drawn,
                                    int count)
{
    const Logs own = logs_of(load_parts(motor, board, DEFAULT_TUNING));
    std::vector<Kin> kin = draw_kin(drawn);
    Logs deviations;
    for (std::size_t number = 0; number < own.size(); number++) {
        deviations.push_back(deviation(kin, number));
    }
    std::sort(kin.begin(), kin.end(), [&](const Kin &a, const Kin &b) {
        return distance(own, a.logs, deviations) < distance(own, b.logs, deviations);
    });
    std::vector<std::string> scenarios;
    for (std::size_t k = 0; k < kin.size() && k < static_cast<std::size_t>(count); k++) {
        scenarios.push_back(kin[k].name + ":user");
    }
    return scenarios;
}

int count_held(const std::vector<std::string> &scenarios, const std::string &tuning)
{
    const auto holds = [&](const std::string &scenario) {
        try {
            const Config config = load_scenario(scenario, {}, {"tuning=" + tuning});
            const RunResult result = run_scenario(config);
            return result.faults.empty() && result.metrics.locked;
        } catch (const ConfigError &) {
            return false;
        }
    };
    return static_cast<int>(std::count_if(scenarios.begin(), scenarios.end(), holds));
}

} // namespace nf::certify
