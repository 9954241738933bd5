// SPDX-License-Identifier: MIT
#include "setting_error.h"

#include <fmt/format.h>

namespace nf
{

SettingError::SettingError(const char *key_, double value_, SettingLimit limit_,
                           const char *reason_)
    : std::runtime_error(fmt::format("{} = {:g}: {}", key_, value_, reason_)), key(key_),
      value(value_), limit(limit_), reason(reason_)
{
}

} // namespace nf
