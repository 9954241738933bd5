// SPDX-License-Identifier: MIT
#include "spelling.h"

#include "pattern.h"
#include "readable.h"

#include <cctype>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

using Replacement = std::pair<const char *, const char *>;

// Byte for byte: regular expressions of the library know no characters beyond ASCII.
constexpr Replacement SIGNS[] = {
    {"·", "."}, {"⋅", "."},   {"•", "."},   {"×", "."},        {"*", "."},      {"²", "2"},
    {"³", "3"}, {"⁻¹", "-1"}, {"Ω", "ohm"}, {"\u2126", "ohm"}, {"µ", "u"},      {"\u03BC", "u"},
    {"^", ""},  {"–", "-"},   {"‑", "-"},   {"−", "-"},        {"\u00A0", " "}, {"\u202F", " "},
};

// The library's expressions recurse with each character.
constexpr std::size_t LONGEST = 200;

bool is_letter(char c)
{
    return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

char lower(char c)
{
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool is_in_word(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           (static_cast<unsigned char>(c) & 0x80U) != 0;
}

void replace_all(std::string &text, const std::string &from, const std::string &to)
{
    for (std::size_t at = text.find(from); at != std::string::npos;
         at = text.find(from, at + to.size())) {
        text.replace(at, from.size(), to);
    }
}

constexpr Replacement PATTERNS[] = {
    {R"(\b(1|r|rev|u)/min\b)", "rpm"},
    {R"(\bmin ?-1)", "rpm"},
    {R"(/ ?\(? ?1000 ?rpm(?: ?\))?)", "/krpm"},
    {R"(\b6[ -]?step\b)", "six step"},
    {R"(\(rad/s\))", "rad/s"},
    // a mark that the unit goes on after
    {R"(([VA])[ _]?\(?(rms|pk|peak|eff|dc)\)?(/[^ ]+))", "$1$3 $2"},
    {R"(([VA])_?\(?(rms|pk|peak|eff|dc)\b\)?)", "$1 $2"},
};

std::size_t skip_blanks(const std::string &text, std::size_t at)
{
    while (at < text.size() && text[at] == ' ') {
        at++;
    }
    return at;
}

// After a '.' of a symbol.
std::size_t end_of_dot(const std::string &text, std::size_t at)
{
    at = skip_blanks(text, at);
    if (at < text.size() && (text[at] == '.' || text[at] == '-')) {
        at++;
    }
    return skip_blanks(text, at);
}

// After a '/' of a symbol.
std::size_t end_of_stroke(const std::string &text, std::size_t at)
{
    at = skip_blanks(text, at);
    for (const char *per : {"/", "per "}) {
        const std::string stroke = per;
        if (text.compare(at, stroke.size(), stroke) == 0) {
            return skip_blanks(text, at + stroke.size());
        }
    }
    return std::string::npos;
}

std::size_t end_of_sign(char sign, bool exactly, const std::string &text, std::size_t at)
{
    if (sign == '.') {
        return end_of_dot(text, at);
    }
    if (sign == '/') {
        return end_of_stroke(text, at);
    }
    const bool same =
        at < text.size() && (exactly ? text[at] == sign : lower(text[at]) == lower(sign));
    return same ? at + 1 : std::string::npos;
}

} // namespace

void refuse(const std::string &option, const std::string &typed, const std::string &problem)
{
    throw std::runtime_error(
        fmt::format("{} \"{}\": {}", option, readable(tidied(typed)), problem));
}

std::string tidied(const std::string &text)
{
    std::string tidy;
    for (const char c : text) {
        const bool blank = c == ' ' || c == '\t';
        if (!blank) {
            tidy += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
        } else if (!tidy.empty() && tidy.back() != ' ') {
            tidy += ' ';
        }
    }
    while (!tidy.empty() && tidy.back() == ' ') {
        tidy.pop_back();
    }
    return tidy;
}

std::string one_spelling(const std::string &text)
{
    std::string spelt = text;
    for (const auto &[from, to] : SIGNS) {
        replace_all(spelt, from, to);
    }
    spelt = tidied(spelt);
    if (spelt.size() > LONGEST) {
        refuse("value", spelt.substr(0, LONGEST / 8) + "…",
               fmt::format("is longer than {} characters", LONGEST));
    }
    for (const auto &[expression, instead] : PATTERNS) {
        spelt = replace_matches(spelt, expression, instead);
    }
    return spelt;
}

std::size_t end_of_unit(const std::string &symbol, const std::string &text, std::size_t from)
{
    std::size_t at = skip_blanks(text, from);
    for (std::size_t k = 0; k < symbol.size(); k++) {
        const bool is_prefix =
            k == 0 && symbol[0] == 'm' && symbol.size() > 1 && is_letter(symbol[1]);
        at = end_of_sign(symbol[k], is_prefix, text, at);
        if (at == std::string::npos) {
            return at;
        }
    }
    const bool ends =
        at >= text.size() || std::string(" ,;()@").find(text[at]) != std::string::npos;
    return ends ? at : std::string::npos;
}

std::vector<std::string> words_of(const std::string &text)
{
    std::vector<std::string> words;
    bool within = false;
    for (const char c : text) {
        if (!is_in_word(c)) {
            within = false;
            continue;
        }
        if (!within) {
            words.emplace_back();
        }
        words.back() += lower(c);
        within = true;
    }
    return words;
}

} // namespace nf::sheet
