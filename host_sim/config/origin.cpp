// SPDX-License-Identifier: MIT
#include "origin.h"

#include <algorithm>

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
    std::string line = origin.text() + ": " + key;
    if (!value.empty()) {
        line += " = " + value;
    }
    line += (key.empty() ? "" : ": ") + problem;
    if (!allowed.empty()) {
        line += "; allowed: " + allowed;
    }
    const auto is_control = [](char c) {
        return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    };
    std::replace_if(line.begin(), line.end(), is_control, '?');
    throw ConfigError(line);
}

} // namespace nf
