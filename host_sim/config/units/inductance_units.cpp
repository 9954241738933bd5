// SPDX-License-Identifier: MIT
#include "inductance_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Between them voltages for L_d and L_q: at most this share of the bus, so that the duty has room.
constexpr double STEP_SHARE = 0.3;
constexpr double STEP_TICKS_MIN = 2; // a filter before the converter takes less of it than of one
constexpr double STEP_TICKS_MAX = 16;
constexpr double PULSE_QUARTERS = 4;

// How long a voltage acts that changes a flux linkage by so much.
uint32_t step_ticks(double flux, const BoardSettings &board, const Bases &b)
{
    const double needed = flux / (STEP_SHARE * board.bus_nominal_v) / b.control_period_s;
    return static_cast<uint32_t>(std::clamp(std::ceil(needed), STEP_TICKS_MIN, STEP_TICKS_MAX));
}

// The step along the current lowers it by fall_a; what R·i takes from it is added.
void set_voltage_step(inductance_cfg_t &c, double fall_a, const BoardSettings &board,
                      const Model &m, const Bases &b)
{
    const double flux = m.inductance_d * fall_a;
    c.step_ticks = step_ticks(flux, board, b);
    const double time_s = c.step_ticks * b.control_period_s;
    const double drop = m.resistance * time_s / (2 * m.inductance_d);
    const double voltage = std::min(STEP_SHARE * board.bus_nominal_v, flux / time_s * (1 + drop));
    keep(c.step_voltage, voltage / b.voltage_v * Q15, 1, MANTISSA_MAX);
    keep(c.step_response, voltage * time_s / m.inductance_d / b.current_a * Q15, 1, Q14);
}

void set_voltage_pulse(inductance_cfg_t &c, double swing_a, const BoardSettings &board,
                       const Model &m, const Bases &b)
{
    const double flux = m.inductance_q * swing_a;
    c.pulse_ticks = step_ticks(flux, board, b);
    const double time_s = c.pulse_ticks * b.control_period_s;
    const double voltage = std::min(STEP_SHARE * board.bus_nominal_v, flux / time_s);
    const double response_a = PULSE_QUARTERS * voltage * time_s / m.inductance_d;
    keep(c.pulse_voltage, voltage / b.voltage_v * Q15, 1, MANTISSA_MAX);
    keep(c.pulse_response, response_a / b.current_a * Q15, 1, 2 * Q15 - 1);
}

} // namespace

inductance_cfg_t make_inductance(double fall_a, double swing_a, const BoardSettings &board,
                                 const Model &m, const Bases &b)
{
    inductance_cfg_t c{};
    set_voltage_step(c, fall_a, board, m, b);
    set_voltage_pulse(c, swing_a, board, m, b);
    return c;
}

double inductance_time_s(const Bases &b)
{
    return (1 + PULSE_QUARTERS) * STEP_TICKS_MAX * b.control_period_s;
}

} // namespace nf
