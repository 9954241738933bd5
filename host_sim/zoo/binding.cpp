// SPDX-License-Identifier: MIT
#include "binding.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nf::zoo
{
namespace
{

constexpr double REFERENCE_V = 3.3;
constexpr double SWING_V = REFERENCE_V / 2; // of the converter, either way
constexpr Range SHUNT_V = {0.03, 0.2};      // at full scale
constexpr double SAMPLING_MIN_S = 50e-9;
// Of the comparators: hysteresis and offset within the first, the data sheet's offset by the
// second.
constexpr double RISE_MIN_V = 0.025;
constexpr double OFFSET_V = 0.003;
constexpr double OFFSET_RESERVE = 1.1;
constexpr double FALLING = 0.3;      // of the boards
constexpr double FALLING_MAX = 0.95; // of the swing: there is room below the middle

// The comparators look at the pin before the programmable amplifier: the larger its gain, the less
// they see.
std::vector<int> possible_gains(const Specimen &specimen)
{
    const double volts_per_a = SWING_V / specimen.board.current_full_scale_a;
    const double trip_a = specimen.board.trip_a;
    std::vector<int> gains;
    for (const int gain : {2, 4, 8, 16, 32, 64}) {
        const double early_a = OFFSET_V * OFFSET_RESERVE * gain / volts_per_a;
        const bool is_above = trip_a >= specimen.motor.max_current_a + early_a;
        if (is_above && trip_a * volts_per_a / gain >= RISE_MIN_V) {
            gains.push_back(gain);
        }
    }
    return gains;
}

} // namespace

Binding draw_binding(const Draw &draw, const Specimen &specimen)
{
    const Board &board = specimen.board;
    const std::vector<int> gains = possible_gains(specimen);
    const double shunt_v = draw.log_uniform("shunt", SHUNT_V);
    const double trip_share = board.trip_a / board.current_full_scale_a;
    Binding binding;
    binding.sampling_s = draw.uniform("sampling", {SAMPLING_MIN_S, board.settling_s});
    binding.falls = trip_share < FALLING_MAX && draw.uniform("comparators", {0, 1}) < FALLING;
    binding.shunt_ohm = shunt_v / board.current_full_scale_a;
    binding.amplifier_gain = SWING_V / shunt_v * (draw.below("sign", 2) == 0 ? 1 : -1);
    binding.amplifier_zero_v = SWING_V;
    binding.pga_gain = gains[draw.below("programmable gain", gains.size())];
    binding.adc_reference_v = REFERENCE_V;
    binding.bus_divider = REFERENCE_V / board.bus_full_scale_v;
    return binding;
}

} // namespace nf::zoo
