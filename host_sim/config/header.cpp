// SPDX-License-Identifier: MIT
#include "header.h"

#include "describe.h"
#include "per_unit.h"

extern "C" {
#include "recorder.h"
}

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

// Text of the user inside a comment: plain ASCII that can neither end the comment nor open another.
std::string in_comment(std::string text)
{
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c < 0x20 || c > 0x7E || c == '\\'; }, '?');
    for (const char *mark : {"*/", "/*"}) {
        for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark)) {
            text.replace(at, 2, "* ");
        }
    }
    return text;
}

std::string provenance(const Config &config)
{
    const SourceFiles &files = config.sources;
    std::string text = fmt::format(" *     motor   {} ({})\n *     board   {} ({})\n"
                                   " *     tuning  {} ({})\n",
                                   in_comment(files.motor), in_comment(config.motor.name),
                                   in_comment(files.board), in_comment(config.board.name),
                                   in_comment(files.tuning), in_comment(config.tuning.name));
    for (const std::string &file : files.imperfections) {
        text += fmt::format(" *     with    {}\n", in_comment(file));
    }
    for (const std::string &override_text : files.overrides) {
        text += fmt::format(" *     set     {}\n", in_comment(override_text));
    }
    return text;
}

std::vector<std::string> split(const std::string &path)
{
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
        parts.push_back(path.substr(begin, dot - begin));
        begin = dot + 1;
    }
    parts.push_back(path.substr(begin));
    return parts;
}

std::string indent(std::size_t depth)
{
    return std::string(4 * (depth + 1), ' ');
}

// Designated initialisers: braces open and close where the path of a field changes.
std::string initialiser(const std::vector<ConfigRow> &rows)
{
    std::string text;
    std::vector<std::string> open;
    const auto close_to = [&](std::size_t depth) {
        while (open.size() > depth) {
            open.pop_back();
            text += indent(open.size()) + "},\n";
        }
    };
    for (const ConfigRow &row : rows) {
        std::vector<std::string> path = split(row.path);
        const std::string field = path.back();
        path.pop_back();
        const auto common =
            std::mismatch(open.begin(), open.end(), path.begin(), path.end()).first - open.begin();
        close_to(static_cast<std::size_t>(common));
        while (open.size() < path.size()) {
            text += fmt::format("{}.{} = {{\n", indent(open.size()), path[open.size()]);
            open.push_back(path[open.size()]);
        }
        text += fmt::format("{}.{} = {}{}, /* {} */\n", indent(open.size()), field, row.value,
                            row.is_unsigned ? "U" : "", row.meaning);
    }
    close_to(0);
    return text;
}

// A string literal of plain characters.
std::string quoted(const std::string &text)
{
    std::string safe = text;
    std::replace_if(
        safe.begin(), safe.end(),
        [](char c) { return c < 0x20 || c > 0x7E || c == '"' || c == '\\' || c == '?'; }, '_');
    return '"' + safe + '"';
}

// As the timer makes it, of a whole number of its counts.
double tick_ps(const BoardSettings &board)
{
    const double counts = std::round(board.timer_clock_hz / (2 * board.pwm_frequency_hz));
    return 2 * counts / board.timer_clock_hz * PS_PER_S;
}

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

// The initialisers of about_t.
std::string about(const Config &config)
{
    const BoardSettings &board = config.board;
    return fmt::format(
        "#define DRIVE_ABOUT \\\n"
        "    .name = {}, \\\n"
        "    .rotation = {{.pole_pairs = {}U, .tick_ps = {:.0f}U}}, \\\n"
        "    .speed_max_rpm = {:.0f}, \\\n"
        "    .current_zero_count = {:.0f}U, \\\n"
        "    .current_full_scale_ua = {:.0f}U, \\\n"
        "    .bus_full_scale_uv = {:.0f}U, \\\n"
        "    .temperature = {{.points = {}U, .at = {{{}}}}} /* counts and m°C, each */\n",
        quoted(
            fmt::format("neurofoc: {}, {}, {}", config.motor.name, board.name, config.tuning.name)),
        config.motor.pole_pairs, std::round(tick_ps(board)), std::floor(config.motor.max_speed_rpm),
        std::ldexp(0.5, board.adc_bits), std::round(board.current_full_scale_a / MICRO),
        std::round(board.bus_full_scale_v / MICRO), board.temperature_points_c.size(),
        temperature_points(board));
}

} // namespace

uint32_t recorder_segment_entries(const BoardSettings &board)
{
    return static_cast<uint32_t>(board.recorder_entries) / RECORDER_SEGMENTS;
}

std::string make_header(const Config &config)
{
    const std::vector<ConfigRow> rows = describe(config, build(config));
    return fmt::format(
        "/*\n"
        " * Configuration of the drive, made by nfconfig from\n"
        "{}"
        " * Change those and make it again. Behind each number is what it means.\n"
        " */\n"
        "#ifndef DRIVE_CONFIG_H\n"
        "#define DRIVE_CONFIG_H\n"
        "\n"
        "#include \"drive_cfg.h\"\n"
        "\n"
        "#define DRIVE_RECORDER_ENTRIES ({}U) /* of a segment: board.recorder_entries */\n"
        "\n"
        "/* For about.h. */\n"
        "{}"
        "\n"
        "static const drive_cfg_t DRIVE_CONFIG = {{\n"
        "{}"
        "}};\n"
        "\n"
        "#endif\n",
        provenance(config), recorder_segment_entries(config.board), about(config),
        initialiser(rows));
}

} // namespace nf
