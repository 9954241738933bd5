// SPDX-License-Identifier: MIT
#include "about_text.h"

#include "temperature_sensor.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double PS_PER_S = 1e12;
constexpr double MILLI = 1e-3;
constexpr double MICRO = 1e-6;

std::string temperature_points(const BoardSettings &board)
{
    std::string points;
    int k = 0;
    for (const double celsius : board.temperature_points_c) {
        points += fmt::format("{}[{}] = {{{:.0f}, {:.0f}}}", k == 0 ? "" : ", ", k,
                              temperature_count(board, celsius), celsius / MILLI);
        k++;
    }
    return points;
}

} // namespace

std::string about_name(const Config &config)
{
    std::string safe = fmt::format("neurofoc: {}, {}, {}", config.motor.name, config.board.name,
                                   config.tuning.name);
    std::replace_if(
        safe.begin(), safe.end(),
        [](char c) { return c < 0x20 || c > 0x7E || c == '"' || c == '\\' || c == '?'; }, '_');
    return safe;
}

std::uint32_t tick_ps(const BoardSettings &board)
{
    const double counts = std::round(board.timer_clock_hz / (2 * board.pwm_frequency_hz));
    return static_cast<std::uint32_t>(std::round(2 * counts / board.timer_clock_hz * PS_PER_S));
}

std::int32_t speed_max_rpm(const MotorSettings &motor)
{
    return static_cast<std::int32_t>(std::floor(motor.max_speed_rpm));
}

std::string about_board(const BoardSettings &board)
{
    return fmt::format(
        "    .current_zero_count = {:.0f}U, \\\n"
        "    .current_full_scale_ua = {:.0f}U, \\\n"
        "    .bus_full_scale_uv = {:.0f}U, \\\n"
        "    .temperature = {{.points = {}U, .at = {{{}}}}} /* counts and m°C, each */\n",
        std::ldexp(0.5, board.adc_bits), std::round(board.current_full_scale_a / MICRO),
        std::round(board.bus_full_scale_v / MICRO), board.temperature_points_c.size(),
        temperature_points(board));
}

} // namespace nf
