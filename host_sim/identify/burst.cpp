// SPDX-License-Identifier: MIT
#include "burst.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nf::identify
{
namespace
{

constexpr int QUARTERS = 4;
constexpr int PARTS_LEAST = 2;  // of a tick
constexpr int PARTS_MOST = 100;
constexpr double PART_OF_DECAY = 0.2; // of the fastest time constant, a step
constexpr int SEARCH_STEPS = 40;
constexpr double SEARCHED = 1e-6;

struct State {
    std::complex<double> current_a;
    double speed_rad_s = 0;
};

struct Slope {
    std::complex<double> current;
    double speed;
};

double sign_of(const Burst &burst, int tick)
{
    const int quarter = tick / burst.quarter % QUARTERS;
    return quarter == 1 || quarter == 2 ? -1 : 1;
}

Slope slope(const State &at, std::complex<double> voltage_v, const LegModel &legs,
            const Moved &motor)
{
    const std::complex<double> i = at.current_a;
    const std::complex<double> left =
        voltage_v - legs.resistance_ohm * i - loss_at_rest(legs, i);
    const double emf_v = at.speed_rad_s * (motor.flux_wb + motor.inductance_d_h * i.real());
    const double torque_flux =
        motor.flux_wb + (motor.inductance_d_h - motor.inductance_q_h) * i.real();
    return {{left.real() / motor.inductance_d_h, (left.imag() - emf_v) / motor.inductance_q_h},
            motor.acceleration * torque_flux * i.imag()};
}

State moved(const State &from, const Slope &by, double time_s)
{
    return {from.current_a + by.current * time_s, from.speed_rad_s + by.speed * time_s};
}

// By the midpoint rule.
State next(const State &from, std::complex<double> voltage_v, double time_s,
           const LegModel &legs, const Moved &motor)
{
    const State middle = moved(from, slope(from, voltage_v, legs, motor), time_s / 2);
    return moved(from, slope(middle, voltage_v, legs, motor), time_s);
}

// So many steps in a tick that the decay through R and the knee is followed.
int parts_of(const Burst &burst, const LegModel &legs, const Moved &motor)
{
    const double least_h = std::min(motor.inductance_d_h, motor.inductance_q_h);
    const double rate = (legs.resistance_ohm + legs.loss_v / legs.knee_a) / least_h;
    const double parts = std::ceil(burst.period_s * rate / PART_OF_DECAY);
    return static_cast<int>(std::clamp<double>(parts, PARTS_LEAST, PARTS_MOST));
}

} // namespace

double Burst::peak_a() const
{
    return change_a / ticks * quarter;
}

std::vector<Burst> bursts_of(const Records &records, const Legs &legs)
{
    std::vector<Burst> bursts;
    for (const Window &window : records.of("burst")) {
        Burst burst;
        burst.along = window.pulse_d_v > 0;
        burst.axis = window.axis;
        burst.held_a = window.command_a / gain_along(legs, window.axis);
        burst.mean_a = window.current_a.real() / gain_along(legs, window.axis);
        burst.pulse_v = burst.along ? window.pulse_d_v : window.pulse_q_v;
        burst.quarter = window.quarter;
        burst.ticks = window.ticks;
        burst.change_a = burst.along ? window.change_d_a / gain_along(legs, window.axis)
                                     : window.change_q_a / gain_across(legs, window.axis);
        burst.period_s = records.scales.period_s;
        burst.bus_v = window.bus_v;
        bursts.push_back(burst);
    }
    return bursts;
}

double answer(const Burst &burst, const LegModel &legs, const Moved &motor)
{
    const std::complex<double> held_v =
        legs.resistance_ohm * burst.held_a + loss_at_rest(legs, burst.held_a);
    const int parts = parts_of(burst, legs, motor);
    State state{burst.held_a};
    double change_a = 0;
    for (int tick = 0; tick < burst.ticks; tick++) {
        const double pulse_v = sign_of(burst, tick) * burst.pulse_v;
        const std::complex<double> voltage_v =
            held_v + std::complex<double>(burst.along ? pulse_v : 0, burst.along ? 0 : pulse_v);
        const State before = state;
        for (int part = 0; part < parts; part++) {
            state = next(state, voltage_v, burst.period_s / parts, legs, motor);
        }
        const std::complex<double> by = state.current_a - before.current_a;
        change_a += sign_of(burst, tick) * (burst.along ? by.real() : by.imag());
    }
    return change_a;
}

double inductance_of(const Burst &burst, const LegModel &legs, const Moved &motor)
{
    Moved tried = motor;
    double &inductance_h = burst.along ? tried.inductance_d_h : tried.inductance_q_h;
    for (int step = 0; step < SEARCH_STEPS; step++) {
        // The answer goes with 1/L, or less.
        const double ratio = answer(burst, legs, tried) / burst.change_a;
        if (!(ratio > 0) || !std::isfinite(ratio)) {
            break;
        }
        inductance_h *= ratio;
        if (std::abs(ratio - 1) < SEARCHED) {
            return inductance_h;
        }
    }
    throw std::runtime_error("the pulses of a burst move no current that an inductance explains");
}

} // namespace nf::identify
