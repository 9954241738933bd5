// SPDX-License-Identifier: MIT
#include "modulator_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The bus reciprocal covers this share of the under-voltage limit.
constexpr double BUS_FLOOR = 0.8;

// Current from which on a leg's sign is certain: so many counts of the converter.
constexpr double EDGE_LSB = 8;
constexpr double EDGE_KNEES = 3.5; // fits the loss of a leg that commutates softly: modulator.h

// What a leg holds where the board file does not say: half a metre of wire and the devices' own for
// each ampere, or at mains voltage a motor cable and IGBTs. Real ones are within a factor of three,
// and half to twice of it is near enough.
struct LegCapacitance {
    double cable_f;
    double device_f_per_a;
};
constexpr double MAINS_V = 100;
constexpr LegCapacitance LOW_VOLTAGE_LEG = {45e-12, 45e-12};
constexpr LegCapacitance MAINS_LEG = {320e-12, 17e-12};

void set_dead_time(modulator_cfg_t &c, const BoardSettings &board, const TuningSettings &tuning,
                   const ModelScales &model, const Model &m, const Bases &b)
{
    const double ripple =
        board.bus_nominal_v * b.control_period_s / (6 * (m.inductance_d + m.inductance_q));
    store(c.dead_time_q15, model.dead_time_s / b.control_period_s * Q15, 0, Q13,
          {"model.dead_time_s", model.dead_time_s}, "a quarter of the PWM period");
    c.dead_time_band_q15 =
        static_cast<int32_t>(std::lround(c.dead_time_q15 * tuning.adapt_dead_time_pct / 100));
    store(c.drop_q15, model.device_drop_v / b.voltage_v * Q15, 0, Q15 / 16,
          {"model.device_drop_v", model.device_drop_v}, "a sixteenth of board.bus_full_scale_v");
    c.ripple_q15 = static_cast<int32_t>(std::lround(std::min(ripple / b.current_a * Q15, Q14)));
    const double edge_a = std::max(EDGE_LSB * b.current_a / std::ldexp(1.0, board.adc_bits),
                                   EDGE_KNEES * commutation_knee_a(board, model));
    c.edge_slope = static_cast<int32_t>(std::max(1L, std::lround(b.current_a / edge_a)));
}

} // namespace

modulator_cfg_t make_modulator(const BoardSettings &board, const TuningSettings &tuning,
                               const ModelScales &model, const Model &m, const Bases &b)
{
    modulator_cfg_t c{};
    store(c.timer_counts, board.timer_clock_hz / (2 * board.pwm_frequency_hz), 1, MANTISSA_MAX,
          {"board.timer_clock_hz", board.timer_clock_hz},
          "65534 periods of the clock in one of the PWM");
    c.ratio_max_q15 = static_cast<int32_t>(std::lround(largest_ratio(board) * Q15 - 0.5));
    require(b.voltage_v / (board.bus_min_v * BUS_FLOOR), 0, Q15 / Q12,
            {"board.bus_min_v", board.bus_min_v, -1},
            "the modulator divides by no less than 0.8 of it, an eighth of board.bus_full_scale_v");
    set_dead_time(c, board, tuning, model, m, b);
    return c;
}

double largest_ratio(const BoardSettings &board)
{
    return (1 - board.duty_margin_pct / 100) / std::sqrt(3.0);
}

double leg_loss_v(const BoardSettings &board, double dead_time_s, double device_drop_v)
{
    return 4.0 / 3 * (board.bus_nominal_v * dead_time_s * board.pwm_frequency_hz + device_drop_v);
}

double commutation_knee_a(const BoardSettings &board, const ModelScales &model)
{
    const LegCapacitance &typical = board.bus_nominal_v < MAINS_V ? LOW_VOLTAGE_LEG : MAINS_LEG;
    const double capacitance_f =
        model.output_capacitance_f >= 0
            ? model.output_capacitance_f
            : typical.cable_f + typical.device_f_per_a * board.overcurrent_a;
    return model.dead_time_s > 0 ? capacitance_f * board.bus_nominal_v / model.dead_time_s : 0;
}

} // namespace nf
