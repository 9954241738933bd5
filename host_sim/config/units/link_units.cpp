// SPDX-License-Identifier: MIT
#include "link_units.h"

#include <cmath>

namespace nf
{

link_cfg_t make_link(const TuningSettings &tuning, const Bases &b)
{
    link_cfg_t c{};
    // Rounded up: a time that is not 0 is not "never".
    c.timeout_ticks =
        static_cast<uint32_t>(std::ceil(tuning.command_timeout_s / b.control_period_s));
    return c;
}

} // namespace nf
