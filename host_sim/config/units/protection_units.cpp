// SPDX-License-Identifier: MIT
#include "protection_units.h"

#include "derating_units.h"
#include "numbers.h"
#include "safe_state_units.h"

namespace nf
{

protection_cfg_t make_protection(const BoardSettings &board, const Bases &b)
{
    const char *const reason = "what the firmware can measure";
    protection_cfg_t c{};
    const double rail = Q14 - 1 - std::ldexp(1.0, 15 - board.adc_bits);
    store(c.current_max, board.overcurrent_a / b.current_a * Q15, 1, rail,
          {"board.overcurrent_a", board.overcurrent_a}, reason);
    if (board.trip_a > 0) {
        require(board.trip_a, board.overcurrent_a, HUGE_VAL, {"board.trip_a", board.trip_a},
                "board.overcurrent_a: the comparators must not trip before the drive's own limit");
    }
    require({"board.bus_max_v", board.bus_max_v}, board.bus_nominal_v + braking_room_v(b), HUGE_VAL,
            "board.bus_nominal_v, and room to derate braking before it");
    store(c.bus_max, acting_bus_limit(board) / b.voltage_v * Q15, 1, MANTISSA_MAX - 1,
          {"board.bus_max_v", board.bus_max_v}, reason);
    store(c.bus_min, board.bus_min_v / b.voltage_v * Q15, 0, MANTISSA_MAX - 1,
          {"board.bus_min_v", board.bus_min_v}, reason);
    store(c.offset_max, board.offset_max_a / b.current_a * Q15, 0, MANTISSA_MAX,
          {"board.offset_max_a", board.offset_max_a}, reason);
    require(c.offset_max, 0, rail - c.current_max, {"board.offset_max_a", board.offset_max_a},
            "a sample at the end of the converter has to exceed board.overcurrent_a whatever the "
            "offset");
    return c;
}

} // namespace nf
