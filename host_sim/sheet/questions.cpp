// SPDX-License-Identifier: MIT
#include "questions.h"

#include "spelling.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::sheet
{
namespace
{

using Alternatives = std::vector<std::string>;

// "winding resistance, as 0.608 ohm phase to phase: "
std::string question(const Alternatives &options)
{
    std::string text;
    for (const std::string &name : options) {
        const SheetOption &option = sheet_option(name);
        text +=
            fmt::format("{}{}, as {}", text.empty() ? "" : "\n  or ", option.help, option.example);
    }
    return text + ": ";
}

// The numbers of poles and of pole pairs look alike, and the inductance of both axes that of one:
// the first is asked for.
Alternatives asked(const Alternatives &group)
{
    const auto has = [&](const char *name) {
        return std::count(group.begin(), group.end(), name) != 0;
    };
    return has("--poles") || has("--inductance") ? Alternatives{group.front()} : group;
}

bool fits(const std::string &name, const std::string &answer)
{
    const std::vector<Quantity> &quantities = sheet_option(name).quantities;
    const bool is_bare = quantities.size() == 1 && needs_no_unit(quantities.front(), answer);
    return is_bare || std::any_of(quantities.begin(), quantities.end(),
                                  [&](const Quantity &one) { return has_unit_of(one, answer); });
}

std::string all_units(const Alternatives &options)
{
    std::vector<std::string> names;
    for (const std::string &name : options) {
        names.push_back(unit_names(sheet_option(name).quantities.front()));
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

// Throws what is wrong with the answer.
void answer(Sheet &sheet, const Alternatives &options, const std::string &typed)
{
    if (options.size() == 1) {
        sheet.give(options.front(), typed);
        return;
    }
    const auto found = std::find_if(options.begin(), options.end(),
                                    [&](const std::string &name) { return fits(name, typed); });
    if (found == options.end()) {
        refuse("answer", typed, fmt::format("has no unit of it; allowed: {}", all_units(options)));
    }
    sheet.give(*found, typed);
}

} // namespace

void ask(Sheet &sheet, const Dialogue &dialogue)
{
    for (auto open = sheet.missing(); !open.empty(); open = sheet.missing()) {
        const Alternatives options = asked(open.front());
        dialogue.say(question(options));
        const std::optional<std::string> typed = dialogue.line();
        if (!typed) {
            dialogue.say("\n");
            return;
        }
        try {
            answer(sheet, options, *typed);
        } catch (const std::exception &error) {
            dialogue.say(fmt::format("{}\n", error.what()));
        }
    }
}

std::string missing_text(const Sheet &sheet)
{
    std::vector<std::string> lines;
    for (const Alternatives &group : sheet.missing()) {
        std::vector<std::string> options;
        for (const std::string &name : group) {
            options.push_back(fmt::format("{} \"{}\"", name, sheet_option(name).example));
        }
        lines.push_back(fmt::format("{}", fmt::join(options, " or ")));
    }
    // Without an inductance of either axis the one of both is named once.
    lines.erase(std::unique(lines.begin(), lines.end(),
                            [](const std::string &a, const std::string &b) {
                                return a.rfind("--inductance ", 0) == 0 &&
                                       b.rfind("--inductance ", 0) == 0;
                            }),
                lines.end());
    return fmt::format("missing, each with an example: {}", fmt::join(lines, ", "));
}

} // namespace nf::sheet
