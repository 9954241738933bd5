// SPDX-License-Identifier: MIT
#include "virtual_resistance_units.h"

#include "numbers.h"

namespace nf
{

virtual_resistance_cfg_t make_virtual_resistance(const TuningSettings &tuning, const Bases &b)
{
    virtual_resistance_cfg_t c{};
    store(c.resistance_q15, tuning.virtual_resistance_ohm * b.current_a / b.voltage_v * Q15, 0, Q14,
          {"voltage_loop.virtual_resistance_ohm", tuning.virtual_resistance_ohm},
          "a quarter of board.bus_full_scale_v over board.current_full_scale_a");
    store(c.mean_rate_q15, b.control_period_s / tuning.virtual_mean_s * Q15, 1, Q14,
          {"voltage_loop.virtual_mean_s", tuning.virtual_mean_s, -1},
          "2 to 32768 periods of the PWM");
    return c;
}

} // namespace nf
