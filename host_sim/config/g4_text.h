/* SPDX-License-Identifier: MIT */
// Lines of hal_config.h.
#pragma once

#include <string>
#include <vector>

namespace nf
{

// `#define HAL_NAME (value)` with its meaning.
std::string g4_line(const std::string &name, const std::string &value, const std::string &meaning);

// `#define HAL_NAME` with rows of a table of the binding, each a line.
std::string g4_rows(const std::string &name, const std::vector<std::string> &rows);

// A row of settings.c.
std::string g4_setting(const std::string &name, const std::string &mask, const std::string &value,
                       const char *group);

// A row whose bits all count. The register is given by its peripheral and its offset: TIM2 and
// "TIM_CR1" for a row "TIM2_CR1".
std::string g4_setting_of(const std::string &peripheral, const std::string &offset,
                          const std::string &value, const char *group);

// Values as C has them.
std::string g4_unsigned(unsigned long value);
std::string g4_hex(unsigned long value);
std::string g4_truth(bool value);

} // namespace nf
