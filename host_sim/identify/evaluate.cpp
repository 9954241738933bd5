// SPDX-License-Identifier: MIT
#include "evaluate.h"

#include "flux_fit.h"
#include "inertia_fit.h"
#include "numbers.h"
#include "origin.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::identify
{
namespace
{

constexpr int ADC_BITS_ASSUMED = 12;
constexpr double MARGIN_ASSUMED = 0.05;
constexpr int ROUNDS = 2;                // of L, φ, J: the rotor that the pulses move has to be known
constexpr size_t COASTS_FOR_FRICTION = 5;

// All that is fitted.
struct Found {
    Legs legs;
    Inductances inductances;
    Flux flux;
    Estimate inertia;
    Friction friction;
    bool coasted = false;
};

Moved rotor_of(const Found &found, const Scales &scales)
{
    Moved rotor;
    rotor.flux_wb = found.flux.magnet_wb.value;
    rotor.acceleration =
        1.5 * scales.pole_pairs * scales.pole_pairs / std::max(found.inertia.value, 1e-12);
    return rotor;
}

Found find(const Records &records)
{
    Found found;
    found.legs = fit_legs(records);
    const std::vector<Burst> bursts = bursts_of(records, found.legs);
    found.inertia = fit_inertia(records);
    found.inductances = fit_inductances(bursts, found.legs, {});
    const double at_rest_h = found.inductances.q_h.value;
    for (int round = 0; round < ROUNDS; round++) {
        found.flux = fit_flux(records, found.legs, found.inductances);
        found.inductances =
            fit_inductances(bursts, found.legs, rotor_of(found, records.scales));
    }
    const double share = 2 * found.flux.magnet_wb.bar() / found.flux.magnet_wb.value +
                         found.inertia.bar() / found.inertia.value;
    found.inductances.q_h.bound += std::abs(found.inductances.q_h.value - at_rest_h) * share;
    const std::vector<Window> windows =
        followed(records, found.legs.model, found.flux.magnet_wb.value);
    found.coasted = windows.size() >= COASTS_FOR_FRICTION;
    found.friction = found.coasted
                         ? coasting_friction(windows, records.scales, found.inertia)
                         : holding_friction(records, found.legs);
    return found;
}

double three_digits(double number)
{
    const double unit = std::pow(10.0, std::floor(std::log10(number)) - 2);
    return std::floor(number / unit) * unit;
}

// Electrical speed at which the voltage of the continuous current is `most_v`: (ωφ + v_R)² + (ωL_q·I)² = most_v².
double highest_speed(const Found &found, double most_v)
{
    const double current_a = found.inductances.continuous_a;
    const double flux = found.flux.magnet_wb.value;
    const double across = found.inductances.q_h.value * current_a;
    const double lost_v = found.legs.resistance_ohm.value * current_a +
                          loss_turning(found.legs.model, current_a);
    const double square = flux * flux + across * across;
    const double half = flux * lost_v;
    const double root = half * half + square * (most_v * most_v - lost_v * lost_v);
    return root > 0 ? (std::sqrt(root) - half) / square : 0;
}

double rated_speed(const Found &found, const Records &records, const Known &known)
{
    const double share = known.board ? largest_ratio(*known.board)
                                     : (1 - MARGIN_ASSUMED) / std::sqrt(3.0);
    const double speed = highest_speed(found, share * found.legs.bus_v);
    const double rpm = speed * 60 / TWO_PI / records.scales.pole_pairs;
    const double most = known.plate.max_speed_rpm;
    return rpm > 0 && (rpm < most || most <= 0) ? three_digits(rpm) : most;
}

MotorSettings motor_of(const Found &found, const Records &records, const Known &known)
{
    MotorSettings motor = known.plate;
    motor.pole_pairs = records.scales.pole_pairs;
    motor.resistance_ohm = found.legs.resistance_ohm.value;
    motor.inductance_d_h = found.inductances.d_h.value;
    motor.inductance_q_h = found.inductances.q_h.value;
    motor.flux_linkage_wb = found.flux.magnet_wb.value;
    motor.inertia_kg_m2 = found.inertia.value;
    motor.viscous_friction_nm_s = std::max(0.0, found.friction.viscous_nm_s.value);
    const double current_a = motor.continuous_current_a > 0 ? motor.continuous_current_a
                                                            : found.inductances.continuous_a;
    motor.continuous_current_a = current_a;
    motor.rated_torque_nm = 1.5 * motor.pole_pairs * motor.flux_linkage_wb * current_a;
    motor.rated_speed_rpm = rated_speed(found, records, known);
    return motor;
}

// Bounds in % of R, L, φ, J by gains that nobody sees: volts over amperes, volts, volts times amperes.
void state_bars(MeasuredSettings &measured, const Found &found, const Known &known)
{
    const double volts = known.bus_gain_pct;
    const double both = volts + known.current_gain_pct;
    measured.resistance_std_pct = found.legs.resistance_ohm.std_pct();
    measured.resistance_bound_pct = found.legs.resistance_ohm.bound_pct() + both;
    measured.inductance_d_std_pct = found.inductances.d_h.std_pct();
    measured.inductance_d_bound_pct = found.inductances.d_h.bound_pct() + both;
    measured.inductance_q_std_pct = found.inductances.q_h.std_pct();
    measured.inductance_q_bound_pct = found.inductances.q_h.bound_pct() + both;
    measured.flux_linkage_std_pct = found.flux.magnet_wb.std_pct();
    measured.flux_linkage_bound_pct = found.flux.magnet_wb.bound_pct() + volts;
    measured.inertia_std_pct = found.inertia.std_pct();
    measured.inertia_bound_pct = found.inertia.bound_pct() + both;
    measured.viscous_friction_bar_nm_s = found.friction.viscous_nm_s.bar();
    measured.coulomb_friction_nm = std::max(0.0, found.friction.coulomb_nm.value);
    measured.coulomb_friction_bar_nm = found.friction.coulomb_nm.bar();
}

void state_legs(MeasuredSettings &measured, const Legs &legs, double period_s)
{
    const double per_volt = period_s / legs.bus_v;
    measured.dead_time_s = std::max(0.0, legs.loss_v.value * per_volt);
    measured.dead_time_bar_s = legs.loss_v.bar() * per_volt;
    measured.knee_a = legs.knee_a.value;
    measured.knee_bar_a = legs.knee_a.bar();
    measured.gain_mismatch_pct = 200 * legs.mismatch.value;
    measured.gain_mismatch_bar_pct = 200 * legs.mismatch.bar();
    measured.bus_v = legs.bus_v;
}

// The mean |difference| of two samples of a normal distribution is 2·σ/√π.
double noise_lsb(const Records &records, const Known &known)
{
    const std::vector<Window> windows = records.of("still");
    double mean_a = 0;
    for (const Window &window : windows) {
        mean_a += window.noise_a / static_cast<double>(windows.size());
    }
    const int bits = known.board && known.board->adc_bits > 0 ? known.board->adc_bits
                                                              : ADC_BITS_ASSUMED;
    return mean_a * std::sqrt(PI) / 2 * std::exp2(bits) / records.scales.current_a;
}

std::vector<std::string> remarks_of(const Found &found, const Known &known)
{
    std::vector<std::string> remarks;
    if (!known.board) {
        remarks.emplace_back("the board is not known: a converter of 12 bits is assumed for the "
                             "noise, and a duty margin of 5 % for the rated speed");
    }
    if (found.legs.heating != 0) {
        remarks.push_back(fmt::format("R drifted by {:.1f} % while it was measured: the winding "
                                      "warms up; R is its mean",
                                      100 * found.legs.heating));
    }
    const Flux &flux = found.flux;
    if (!flux.coasting_wb) {
        remarks.emplace_back("the rotor was lost as soon as it coasted: the flux linkage is from "
                             "windows with current alone");
    } else if (!agree(*flux.coasting_wb, flux.turning_wb)) {
        remarks.push_back(fmt::format(
            "the flux linkage with current, {:.4g} Wb, and of the rotor that coasts, {:.4g} Wb, "
            "differ by more than their error bars: the first one is taken",
            flux.turning_wb.value, flux.coasting_wb->value));
    }
    if (!found.coasted) {
        remarks.emplace_back("the rotor coasted too short for its friction: that is from the "
                             "torque that holds a speed, which is less exact");
    }
    return remarks;
}

} // namespace

Result evaluate(const Records &records, const Known &known, const std::string &name)
{
    Found found;
    try {
        found = find(records);
    } catch (const std::runtime_error &error) {
        fail({name, 0, Author::user}, "records", "", error.what(), "");
    }
    Result result;
    result.motor = motor_of(found, records, known);
    state_bars(result.measured, found, known);
    state_legs(result.measured, found.legs, records.scales.period_s);
    result.measured.temperature_c = known.temperature_c;
    result.measured.current_a = found.inductances.continuous_a;
    result.measured.speed_rpm =
        found.flux.highest_rad_s * 60 / TWO_PI / records.scales.pole_pairs;
    result.measured.current_noise_lsb = noise_lsb(records, known);
    result.remarks = remarks_of(found, known);
    return result;
}

} // namespace nf::identify
