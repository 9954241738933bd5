// SPDX-License-Identifier: MIT
#include "pulse_model.h"

#include "leg_axes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nf::identify
{
namespace
{

using Vector = std::complex<double>;

struct Edge {
    double at; // share of the period
    std::size_t leg;
    bool rises;
};

// The six edges of a period in which this voltage is demanded, symmetric to its middle.
std::array<Edge, 2 * LEGS> edges_of(Vector voltage, double bus_v)
{
    double leg_v[LEGS];
    for (std::size_t leg = 0; leg < LEGS; leg++) {
        leg_v[leg] = on_leg(voltage, leg);
    }
    const auto [low, high] = std::minmax_element(leg_v, leg_v + LEGS);
    const double middle = (*low + *high) / 2;
    std::array<Edge, 2 * LEGS> edges{};
    for (std::size_t leg = 0; leg < LEGS; leg++) {
        const double duty = std::clamp(0.5 + (leg_v[leg] - middle) / bus_v, 0.0, 1.0);
        edges[leg] = {(1 - duty) / 2, leg, true};
        edges[leg + LEGS] = {(1 + duty) / 2, leg, false};
    }
    std::sort(edges.begin(), edges.end(), [](const Edge &a, const Edge &b) { return a.at < b.at; });
    return edges;
}

class Winding
{
public:
    Winding(const Legs &legs, double inductance_h, Vector current)
        : legs_(legs), inductance_h_(inductance_h), current_(current)
    {
    }

    Vector current() const
    {
        return current_;
    }

    // The current control holds the current in the axis without pulses.
    void hold(Vector current, Vector pulses)
    {
        const double along = (current_ * std::conj(pulses)).real();
        const Vector rest = current - (current * std::conj(pulses)).real() * pulses;
        current_ = rest + along * pulses;
    }

    // Half of what a leg loses in a period it loses at each of its edges, against the current that it then has.
    void run_period(Vector voltage)
    {
        Vector potential = 0;
        double now = 0;
        for (const Edge &edge : edges_of(voltage, legs_.bus_v)) {
            run(potential, (edge.at - now) * legs_.period_s);
            now = edge.at;
            const double lost_v = legs_.lost_v(on_leg(current_, edge.leg));
            current_ -=
                TWO_THIRDS * LEG_AXIS[edge.leg] * lost_v / 2.0 * legs_.period_s / inductance_h_;
            potential += (edge.rises ? 1 : -1) * TWO_THIRDS * legs_.bus_v * LEG_AXIS[edge.leg];
        }
        run(potential, (1 - now) * legs_.period_s);
    }

private:
    void run(Vector potential, double duration_s)
    {
        const Vector end = potential / legs_.resistance_ohm.value;
        const double left = std::exp(-legs_.resistance_ohm.value * duration_s / inductance_h_);
        current_ = end + (current_ - end) * left;
    }

    const Legs &legs_;
    double inductance_h_;
    Vector current_;
};

// The pulse's sign in a tick: +, −, −, + for a quarter each.
double sign_of_pulse(int tick, int quarter_ticks)
{
    const int part = (tick / quarter_ticks) % 4;
    return part == 1 || part == 2 ? -1 : 1;
}

} // namespace

double modelled_change(const Record &burst, const Legs &legs, double inductance_h)
{
    const Vector direction = burst.across ? Vector(0, 1) : Vector(1, 0);
    const Vector bias = burst.across ? burst.i_a.real() : burst.current_a;
    const Vector held = legs.resistance_ohm.value * bias + legs.lost_v(bias);
    Winding winding(legs, inductance_h, bias);
    double sum = 0;
    for (int tick = 0; tick < static_cast<int>(burst.ticks); tick++) {
        const double sign = sign_of_pulse(tick, burst.quarter_ticks);
        const Vector before = winding.current();
        winding.run_period(held + sign * burst.pulse_v * direction);
        winding.hold(bias, direction);
        sum += sign * ((winding.current() - before) * std::conj(direction)).real();
    }
    return sum;
}

} // namespace nf::identify
