// SPDX-License-Identifier: MIT
#include "header.h"

#include "about_text.h"
#include "describe.h"
#include "identity.h"

extern "C" {
#include "recorder.h"
}

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

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

// The initialisers of about_t.
std::string about(const Config &config)
{
    const config_identity_t identity = identity_of(config);
    return fmt::format("#define DRIVE_ABOUT \\\n"
                       "    .name = \"{}\", \\\n"
                       "    .identity = {{.schema = 0x{:08X}U, .board = 0x{:08X}U}}, \\\n"
                       "    .rotation = {{.pole_pairs = {}U, .tick_ps = {}U}}, \\\n"
                       "    .speed_max_rpm = {}, \\\n"
                       "    .is_example = {}U, \\\n"
                       "    .baud = {}U, \\\n"
                       "{}",
                       about_name(config), identity.schema, identity.board, config.motor.pole_pairs,
                       tick_ps(config.board), speed_max_rpm(config.motor),
                       config.sources.motor_is_example ? 1 : 0, config.board.baud,
                       about_board(config.board));
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
