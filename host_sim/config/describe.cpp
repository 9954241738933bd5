// SPDX-License-Identifier: MIT
#include "describe.h"

#include "acts.h"
#include "bars.h"
#include "cfg_rows.h"
#include "per_unit.h"

#include <map>
#include <utility>

#include <fmt/format.h>

namespace nf
{
namespace
{

// How far a row's value may be wrong, where the motor file says so.
std::string bar_text(const Config &config, const std::string &path)
{
    static const std::map<std::string, std::pair<const char *, double MotorSettings::*>> values = {
        {"current_loop.resistance_q13", {"motor.resistance_ohm", &MotorSettings::resistance_ohm}},
        {"current_loop.reactance_d_q13", {"motor.inductance_d_h", &MotorSettings::inductance_d_h}},
        {"current_loop.reactance_q_q13", {"motor.inductance_q_h", &MotorSettings::inductance_q_h}},
        {"current_loop.emf_q13", {"motor.flux_linkage_wb", &MotorSettings::flux_linkage_wb}},
    };
    const auto value = values.find(path);
    double bar = 0;
    double of = 0;
    if (value != values.end()) {
        bar = bar_of(config.motor, config.measured, value->second.first);
        of = config.motor.*value->second.second;
    } else if (path == "modulator.dead_time_q15" && has_no_model_dead_time(config)) {
        bar = bar_of(config.motor, config.measured, "measured.dead_time_s");
        of = config.measured.dead_time_s;
    }
    return bar > 0 && of > 0 ? fmt::format(", measured ± {} %", two_digits(100 * bar / of)) : "";
}

// What the files say that the number was made of.
std::map<std::string, std::string> sources(const Config &config)
{
    const TuningSettings tuning =
        settled_tuning(config.motor, config.board, config.tuning, config.model);
    return {
        {"observer.eta", fmt::format("κ = {:g}", tuning.observer_kappa)},
        {"observer.kappa_p", fmt::format("κ_p = {:g}", tuning.observer_kappa_p)},
        {"speed_loop.pi.kp", fmt::format("bandwidth {:.5g} Hz", tuning.speed_bandwidth_hz)},
        {"position_loop.softness_q15", fmt::format("{:.5g} s", tuning.position_softness_s)},
        {"position_loop.gain", fmt::format("bandwidth {:.5g} Hz", tuning.position_bandwidth_hz)},
        {"torque_filter.smooth_rate_q15", fmt::format("{:.5g} Hz", tuning.torque_filter_hz)},
        {"torque_filter.notch_share_q15",
         fmt::format("{:.5g} Hz, {:g} % wide", tuning.notch_hz, tuning.notch_width_pct)},
        {"modulator.timer_counts",
         fmt::format("{:g} Hz from {:g} Hz", config.board.pwm_frequency_hz,
                     config.board.timer_clock_hz)},
    };
}

} // namespace

std::vector<ConfigRow> describe(const Config &config, const drive_cfg_t &built)
{
    const Bases bases = make_bases(config.motor, config.board);
    const std::map<std::string, std::string> made_of = sources(config);
    std::vector<ConfigRow> rows;
    for (const CfgRow &row : cfg_rows()) {
        std::string meaning = fmt::format(fmt::runtime(row.meaning), value_text(row, bases, built));
        if (const auto from = made_of.find(row.path); from != made_of.end()) {
            meaning += ", " + from->second;
        }
        meaning += bar_text(config, row.path);
        rows.push_back({row.path, raw_value(row, built), row.is_unsigned, sizeof(std::int32_t),
                        row.in_run, meaning});
    }
    return rows;
}

} // namespace nf
