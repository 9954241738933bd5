// SPDX-License-Identifier: MIT
#include "pattern.h"

#include <regex>

namespace nf
{
namespace
{

std::regex compiled(const char *expression)
{
    return std::regex(expression, std::regex::ECMAScript | std::regex::icase);
}

} // namespace

std::string replace_matches(const std::string &text, const char *expression, const char *instead)
{
    return std::regex_replace(text, compiled(expression), instead);
}

std::vector<std::string> split_at_matches(const std::string &text, const char *expression)
{
    const std::regex between = compiled(expression);
    const std::sregex_token_iterator first(text.begin(), text.end(), between, -1);
    return {first, {}};
}

} // namespace nf
