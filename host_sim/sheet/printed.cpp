// SPDX-License-Identifier: MIT
#include "printed.h"

#include "readable.h"
#include "spelling.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::sheet
{
namespace
{

// A number at the beginning of a text, and what comes after it.
struct Split {
    double number = 0;
    std::string rest;
    bool is_number = false;
};

Split split(const std::string &spelt)
{
    const std::size_t sign = !spelt.empty() && spelt[0] == '+' ? 1 : 0;
    const char *const end = spelt.data() + spelt.size();
    Split found;
    const auto [after, error] = std::from_chars(spelt.data() + sign, end, found.number);
    found.is_number = error == std::errc() && std::isfinite(found.number);
    found.rest = std::string(after, end);
    return found;
}

struct UnitFound {
    const Unit *unit = nullptr;
    std::size_t end = 0;
};

// The longest: "oz.in.s2" and not "oz.in", with the rest as words.
UnitFound find_unit(const Quantity &quantity, const std::string &text)
{
    UnitFound longest;
    for (const Unit &unit : quantity.units) {
        std::istringstream spellings(fmt::format("{}|{}", unit.symbol, unit.also));
        for (std::string symbol; std::getline(spellings, symbol, '|');) {
            const std::size_t end = symbol.empty() ? 0 : end_of_unit(symbol, text, 0);
            if (end != std::string::npos && end > longest.end) {
                longest = {&unit, end};
            }
        }
    }
    return longest;
}

std::string first_word(const std::string &rest)
{
    const std::string text = tidied(rest);
    return text.substr(0, text.find(' '));
}

// Nothing stands after the number, and nothing has to.
bool is_bare(const Quantity &quantity, const Split &found)
{
    const bool is_zero = quantity.needs == Needs::nothing && std::abs(found.number) <= 0;
    return tidied(found.rest).empty() && (quantity.is_bare_allowed || is_zero);
}

Split number_of(const std::string &option, const Quantity &quantity, const std::string &typed)
{
    const Split found = split(one_spelling(typed));
    if (!found.is_number) {
        refuse(option, typed,
               fmt::format("does not begin with a number; {} is written as number and unit: {}",
                           quantity.noun, unit_names(quantity)));
    }
    const bool is_comma = found.rest.size() > 1 && found.rest[0] == ',' &&
                          std::isdigit(static_cast<unsigned char>(found.rest[1])) != 0;
    if (is_comma) {
        refuse(option, typed,
               "has a comma in the number: write 0.5 with a point, and 1000 without");
    }
    return found;
}

UnitFound unit_of(const std::string &option, const Quantity &quantity, const std::string &typed,
                  const Split &found)
{
    const UnitFound unit = find_unit(quantity, found.rest);
    if (unit.unit != nullptr || is_bare(quantity, found)) {
        return unit.unit != nullptr ? unit : UnitFound{&quantity.units.front(), 0};
    }
    const std::string word = first_word(found.rest);
    refuse(
        option, typed,
        fmt::format("{} {}; allowed: {}",
                    word.empty() ? "has no unit" : fmt::format("\"{}\" is no unit", readable(word)),
                    word.empty() ? fmt::format("for {}", quantity.noun)
                                 : fmt::format("of {}", quantity.noun),
                    unit_names(quantity)));
}

} // namespace

double Printed::si() const
{
    return number * unit.si;
}

std::string Printed::as_typed(const std::string &other_number) const
{
    const std::string said = words(convention);
    return fmt::format("{}{}{}{}{}", other_number, *unit.symbol == '\0' ? "" : " ", unit.symbol,
                       said.empty() ? "" : " ", said);
}

Printed read_printed(const std::string &option, const Quantity &quantity, const std::string &typed)
{
    const Split found = number_of(option, quantity, typed);
    const UnitFound unit = unit_of(option, quantity, typed, found);
    const std::vector<std::string> said = words_of(found.rest.substr(unit.end));
    Printed printed = {tidied(typed), found.number, *unit.unit, {}};
    if (said.empty() && quantity.may_leave_unsaid) {
        return printed;
    }
    std::string problem;
    const std::optional<Convention> convention = convention_of(quantity.needs, said, problem);
    if (!convention) {
        refuse(option, typed, problem);
    }
    printed.convention = *convention;
    return printed;
}

bool has_unit_of(const Quantity &quantity, const std::string &typed)
{
    const Split found = split(one_spelling(typed));
    return found.is_number && find_unit(quantity, found.rest).unit != nullptr;
}

bool needs_no_unit(const Quantity &quantity, const std::string &typed)
{
    const Split found = split(one_spelling(typed));
    return found.is_number && is_bare(quantity, found);
}

std::string unit_names(const Quantity &quantity)
{
    std::vector<std::string> names;
    names.reserve(quantity.units.size());
    for (const Unit &unit : quantity.units) {
        names.emplace_back(unit.symbol);
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace nf::sheet
