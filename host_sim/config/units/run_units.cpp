// SPDX-License-Identifier: MIT
#include "run_units.h"

#include "numbers.h"

#include <cmath>

namespace nf
{

run_cfg_t make_run(const TuningSettings &tuning)
{
    run_cfg_t c{};
    c.acceleration_q14 = static_cast<int32_t>(std::lround(tuning.observer_acceleration * Q14));
    return c;
}

} // namespace nf
