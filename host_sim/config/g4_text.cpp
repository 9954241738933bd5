// SPDX-License-Identifier: MIT
#include "g4_text.h"

#include <fmt/format.h>

namespace nf
{

std::string g4_line(const std::string &name, const std::string &value, const std::string &meaning)
{
    return fmt::format("#define HAL_{} ({}) /* {} */\n", name, value, meaning);
}

std::string g4_unsigned(unsigned long value)
{
    return fmt::format("{}U", value);
}

std::string g4_hex(unsigned long value)
{
    return fmt::format("0x{:X}UL", value);
}

std::string g4_truth(bool value)
{
    return value ? "true" : "false";
}

std::string g4_rows(const std::string &name, const std::vector<std::string> &rows)
{
    std::string text = fmt::format("#define HAL_{}", name);
    for (const std::string &row : rows) {
        text += fmt::format(" \\\n    {{{}}},", row);
    }
    return text + "\n";
}

std::string g4_setting(const std::string &name, const std::string &mask, const std::string &value,
                       const char *group)
{
    return fmt::format("{0}, {1}, {2}, {3}, \"{0}\"", name, mask, value, group);
}

std::string g4_setting_of(const std::string &peripheral, const std::string &offset,
                          const std::string &value, const char *group)
{
    return fmt::format("{0} + {1}, ALL, {2}, {3}, \"{0}{4}\"", peripheral, offset, value, group,
                       offset.substr(offset.find('_')));
}

} // namespace nf
