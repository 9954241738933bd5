// SPDX-License-Identifier: MIT
#include "errors.h"

namespace nf::zoo
{
namespace
{

// What a leg's output holds: wires and motor cable, and the devices for each ampere that they are
// made for.
struct Leg {
    Range cable_f;
    Range device_f_per_a;
};
constexpr Leg LOW_VOLTAGE_LEG = {{20e-12, 100e-12}, {20e-12, 100e-12}};
constexpr Leg MAINS_LEG = {{100e-12, 1e-9}, {10e-12, 30e-12}};

// The current that charges that capacitance just within the dead time.
double draw_knee(const Draw &draw, const Board &board, double max_current_a, double dead_time_s)
{
    const Leg &leg = board.bus_nominal_v <= LOW_VOLTAGE ? LOW_VOLTAGE_LEG : MAINS_LEG;
    const double capacitance_f =
        draw.log_uniform("cable", leg.cable_f) +
        max_current_a * draw.log_uniform("output capacitance", leg.device_f_per_a);
    return capacitance_f * board.bus_nominal_v / dead_time_s;
}

} // namespace

Errors draw_errors(const Draw &draw, const Specimen &specimen)
{
    Errors errors;
    errors.resistance_scale = draw.uniform("R error", {0.7, 1.5});
    errors.inductance_scale = draw.log_uniform("L error", {0.8, 1.25});
    errors.flux_scale = draw.uniform("flux error", {0.9, 1.1});
    errors.inertia_scale = draw.log_uniform("J error", {0.5, 3});
    errors.saliency_scale = draw.uniform("saliency error", {0.8, 1.2});
    errors.dead_time_scale = draw.uniform("dead time error", {0.7, 1.3});
    errors.commutation_knee_a = draw_knee(draw, specimen.board, specimen.motor.max_current_a,
                                          specimen.board.dead_time_s * errors.dead_time_scale);
    errors.coulomb_share = draw.uniform("Coulomb friction", {0, 0.05});
    errors.cogging_pct = draw.uniform("cogging", {0, 3});
    // The least common multiple of slots and poles is 6 or 12 times the pole pairs of most
    // windings.
    errors.cogging_order =
        (draw.below("cogging order", 2) == 0 ? 6 : 12) * specimen.motor.pole_pairs;
    errors.emf_5th_pct = draw.uniform("5th harmonic", {-2, 2});
    errors.emf_7th_pct = draw.uniform("7th harmonic", {-1, 1});
    errors.adc_noise_lsb = draw.uniform("noise", {0.5, 1.5});
    errors.adc_offset_lsb[0] = draw.uniform("offset a", {-5, 5});
    errors.adc_offset_lsb[1] = draw.uniform("offset b", {-5, 5});
    const double mismatch_pct = draw.below("gain mismatch", 2) == 0 ? 2 : -2;
    errors.adc_gain_error_pct[0] = mismatch_pct / 2;
    errors.adc_gain_error_pct[1] = -mismatch_pct / 2;
    errors.adc_third_gain_error_pct = draw.uniform("third gain", {-2, 2});
    errors.bus_ripple_pct = 5;
    errors.bus_ripple_hz = draw.below("mains", 2) == 0 ? 100 : 300; // one phase or three
    errors.load_share = draw.uniform("load", {0, 0.5});
    return errors;
}

} // namespace nf::zoo
