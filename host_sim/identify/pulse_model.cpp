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
    Winding(const Legs &legs, double inductance_h, double lag_s, Vector current)
        : legs_(legs), inductance_h_(inductance_h), lag_s_(lag_s), current_(current), seen_(current)
    {
    }

    // As the sensors show it.
    Vector seen() const
    {
        return seen_;
    }

    // The current control holds the current in the axis without pulses.
    void hold(Vector current, Vector pulses)
    {
        const double along = (current_ * std::conj(pulses)).real();
        const Vector rest = current - (current * std::conj(pulses)).real() * pulses;
        const Vector held = rest + along * pulses;
        seen_ += held - current_;
        current_ = held;
    }

    // From now on a rotor that turns takes this voltage.
    void turn(Vector emf)
    {
        emf_ = emf;
    }

    // Half of what a leg loses in a period it loses at each of its edges, against the current that
    // it then has.
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
        const Vector end = (potential - emf_) / legs_.resistance_ohm.value;
        const double left = std::exp(-legs_.resistance_ohm.value * duration_s / inductance_h_);
        const Vector from = current_;
        current_ = end + (current_ - end) * left;
        follow(from, duration_s);
    }

    // The low pass of the sensors while the current runs straight, which it nearly does between two
    // edges.
    void follow(Vector from, double duration_s)
    {
        const double way = lag_s_ > 0 ? duration_s / lag_s_ : 0;
        if (lag_s_ <= 0) {
            seen_ = current_;
        } else if (way > 0) {
            const double kept = std::exp(-way);
            const double rise = 1 + std::expm1(-way) / way;
            seen_ = kept * seen_ + (1 - kept) * from + rise * (current_ - from);
        }
    }

    const Legs &legs_;
    double inductance_h_;
    double lag_s_;
    Vector current_;
    Vector seen_;
    Vector emf_ = 0;
};

// The pulse's sign in a tick: +, −, −, + for a quarter each.
double sign_of_pulse(int tick, int quarter_ticks)
{
    const int part = (tick / quarter_ticks) % 4;
    return part == 1 || part == 2 ? -1 : 1;
}

// By how much a current in this direction seems larger than it is at the sample, with the voltage
// that holds it there.
Vector seen_more(const Record &r, const Legs &legs, double inductance_h, double lag_s,
                 Vector direction)
{
    constexpr double settled = 6; // time constants
    const int periods = static_cast<int>(std::ceil(settled * lag_s / legs.period_s));
    const Vector current = r.i_a * direction;
    const Vector voltage = r.voltage_v * direction;
    const Vector needed = legs.resistance_ohm.value * current + legs.lost_v(current);
    Winding winding(legs, inductance_h, lag_s, current);
    winding.turn(voltage - needed);
    for (int k = 0; k < periods; k++) {
        winding.run_period(voltage);
        winding.hold(current, 0);
    }
    return (winding.seen() - current) / direction;
}

// The mean over the directions that a vector passes when it turns: the legs have the same edges in
// each sixth.
Vector mean_seen_more(const Record &r, const Legs &legs, double inductance_h, double lag_s)
{
    constexpr int directions = 12;
    constexpr double sixth = 1.04719755119659774615;
    if (r.speed_el_rad_s == 0) {
        return seen_more(r, legs, inductance_h, lag_s, 1);
    }
    Vector sum = 0;
    for (int k = 0; k < directions; k++) {
        const Vector direction = std::polar(1.0, (k + 0.5) / directions * sixth);
        sum += seen_more(r, legs, inductance_h, lag_s, direction);
    }
    return sum / static_cast<double>(directions);
}

} // namespace

double modelled_change(const Record &burst, const Legs &legs, double inductance_h,
                       double sensor_lag_s)
{
    const Vector direction = burst.across ? Vector(0, 1) : Vector(1, 0);
    const Vector bias = burst.across ? burst.i_a.real() : burst.current_a;
    const Vector held = legs.resistance_ohm.value * bias + legs.lost_v(bias);
    Winding winding(legs, inductance_h, sensor_lag_s, bias);
    double sum = 0;
    for (int tick = 0; tick < static_cast<int>(burst.ticks); tick++) {
        const double sign = sign_of_pulse(tick, burst.quarter_ticks);
        const Vector before = winding.seen();
        winding.run_period(held + sign * burst.pulse_v * direction);
        winding.hold(bias, direction);
        sum += sign * ((winding.seen() - before) * std::conj(direction)).real();
    }
    return sum;
}

Records without_lag(const Records &records, const Legs &legs, double inductance_h,
                    double sensor_lag_s)
{
    Records undone = records;
    for (Record &r : undone.all) {
        const Vector later(1, r.speed_el_rad_s * sensor_lag_s);
        const Legs there = legs.at_bus(r.bus_v);
        r.i_a = later * (r.i_a - mean_seen_more(r, there, inductance_h, sensor_lag_s));
    }
    return undone;
}

} // namespace nf::identify
