// SPDX-License-Identifier: MIT
#include "origin.h"

#include "readable.h"

#include <fmt/format.h>

namespace nf
{

std::string Origin::text() const
{
    return line == 0 ? file : fmt::format("{}:{}", file, line);
}

void fail(const Origin &origin, const std::string &key, const std::string &value,
          const std::string &problem, const std::string &allowed)
{
    const Origin shown = {readable(origin.file, READABLE_PATH), origin.line};
    std::string line = shown.text() + ": " + key;
    if (!value.empty()) {
        line += " = " + value;
    }
    line += (key.empty() ? "" : ": ") + problem;
    if (!allowed.empty()) {
        line += "; allowed: " + allowed;
    }
    throw ConfigError(readable(line, READABLE_LINE));
}

} // namespace nf
