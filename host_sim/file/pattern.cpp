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

} // namespace nf
