// SPDX-License-Identifier: MIT
#include "reference.h"

#include "specimen.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include <fmt/format.h>

namespace nf::zoo
{
namespace
{

const std::string PREFIX = "zoo:";
const std::string USER = ":user";

bool is_class(const std::string &name)
{
    return std::any_of(classes().begin(), classes().end(),
                       [&](const Class &kind) { return kind.name == name; });
}

// The whole of a text as a number.
std::optional<uint32_t> whole_number(const std::string &text)
{
    uint32_t number = 0;
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    const bool is_whole = error == std::errc() && stop == end;
    return is_whole ? std::optional<uint32_t>(number) : std::nullopt;
}

// Takes the text from the last `mark` on off its end; empty where there is none.
std::optional<std::string> cut_behind(std::string &text, char mark)
{
    const std::size_t at = text.rfind(mark);
    if (at == std::string::npos) {
        return std::nullopt;
    }
    std::string behind = text.substr(at + 1);
    text.resize(at);
    return behind;
}

} // namespace

std::string Reference::key() const
{
    return fmt::format("{}{}:{}@{}", PREFIX, kind, number, seed);
}

std::string Reference::name() const
{
    return key() + (user ? USER : "");
}

bool is_reference(const std::string &text)
{
    return text.rfind(PREFIX, 0) == 0;
}

// zoo:[CLASS:]NUMBER[@SEED][:user]
std::optional<Reference> parse(const std::string &text)
{
    if (!is_reference(text)) {
        return std::nullopt;
    }
    Reference found;
    std::string rest = text.substr(PREFIX.size());
    if (rest.size() >= USER.size() &&
        rest.compare(rest.size() - USER.size(), USER.size(), USER) == 0) {
        found.user = true;
        rest.resize(rest.size() - USER.size());
    }
    const std::optional<std::string> seed = cut_behind(rest, '@');
    const std::size_t colon = rest.rfind(':');
    const bool has_class = colon != std::string::npos;
    const std::optional<uint32_t> number = whole_number(has_class ? rest.substr(colon + 1) : rest);
    const std::optional<uint32_t> wanted = seed ? whole_number(*seed) : found.seed;
    if (!number || !wanted) {
        return std::nullopt;
    }
    found.number = *number;
    found.seed = *wanted;
    found.kind =
        has_class ? rest.substr(0, colon) : classes()[found.number % classes().size()].name;
    return is_class(found.kind) ? std::optional<Reference>(found) : std::nullopt;
}

std::string allowed()
{
    std::string names;
    for (const Class &kind : classes()) {
        names += (names.empty() ? "" : ", ") + std::string(kind.name);
    }
    return fmt::format("zoo:NUMBER, zoo:CLASS:NUMBER, either with @SEED; CLASS one of {}; a "
                       "scenario also with :user",
                       names);
}

} // namespace nf::zoo
