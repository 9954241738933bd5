/* SPDX-License-Identifier: MIT */
// The records of the known motor as it turns: spin, ramps, coasting.
#pragma once

#include "known_motor.h"

#include "turn_fit.h"

namespace known
{

constexpr double TOP_EL = 600; // rad/s
constexpr double SPIN_A = 4;
constexpr double INERTIA = 2e-3;
constexpr double VISCOUS = 1e-3;
constexpr double COULOMB = 0.03;
constexpr double LAG_RAD = 0.3;
constexpr double TORQUE_FACTOR = 1.5 * POLE_PAIRS;

inline Inductances inductances()
{
    Inductances l;
    l.d_h = {D_H, 0, 0};
    l.q_h = {Q_H, 0, 0};
    return l;
}

inline double drag_nm(double speed_el)
{
    return VISCOUS * speed_el / POLE_PAIRS + COULOMB;
}

// A demand stays in space for a period, and is the mean of what turns meanwhile.
inline double held(double speed_el)
{
    const double x = speed_el * PERIOD_S / 2;
    return std::sin(x) / x;
}

struct Turning {
    double flux_wb = WB; // with current
    double coasting_wb = WB;
    double slow_wb = WB; // at a quarter and at half of the speed
    int coast_windows = 10;
    int coast_ticks = 400;
    double coast_nm = 0; // of a current that is left of coasting
};

inline Record turning(const std::string &kind, double speed_el, double current_a, double flux_wb)
{
    const std::complex<double> j(0, 1);
    const double lost = legs().lost_turning_v(current_a);
    Record r;
    r.kind = kind;
    r.ticks = 1000;
    r.current_a = current_a;
    r.speed_el_rad_s = speed_el;
    r.bus_v = BUS_V;
    r.i_a = current_a;
    const std::complex<double> v = OHM * current_a + lost + j * speed_el * Q_H * current_a +
                                   j * speed_el * flux_wb * std::polar(1.0, -LAG_RAD);
    r.voltage_v = v * held(speed_el);
    return r;
}

// With the sum of what turns it.
inline Record with_torque(Record r, double torque_nm)
{
    r.torque = torque_nm * r.ticks / TORQUE_FACTOR;
    return r;
}

inline Record spin(double speed_el, double current_a, double flux_wb)
{
    return with_torque(turning("spin", speed_el, current_a, flux_wb), drag_nm(speed_el));
}

inline Record ramp(double from_el, double to_el)
{
    Record r = turning("ramp", (from_el + to_el) / 2, SPIN_A, WB);
    r.ticks = 2000;
    const double slope = (to_el - from_el) / POLE_PAIRS / (r.ticks * PERIOD_S);
    return with_torque(r, drag_nm(r.speed_el_rad_s) + INERTIA * slope);
}

inline Record hold(double speed_el)
{
    return with_torque(turning("hold", speed_el, SPIN_A, WB), drag_nm(speed_el));
}

inline void add_coasting(Records &records, const Turning &t)
{
    double speed_el = TOP_EL;
    for (int k = 0; k < t.coast_windows; k++) {
        const double window_s = t.coast_ticks * PERIOD_S;
        const double fall = (drag_nm(speed_el) - t.coast_nm) / INERTIA * POLE_PAIRS * window_s;
        Record r;
        r.kind = "coast";
        r.ticks = t.coast_ticks;
        r.bus_v = BUS_V;
        r.speed_el_rad_s = speed_el - fall / 2;
        r.voltage_v =
            std::complex<double>(0, r.speed_el_rad_s * t.coasting_wb) * held(r.speed_el_rad_s);
        records.all.push_back(with_torque(r, t.coast_nm));
        speed_el -= fall;
    }
}

inline Records turning_records(const Turning &t = {})
{
    Records records = no_records();
    records.all.push_back(spin(TOP_EL / 4, SPIN_A, t.slow_wb));
    records.all.push_back(spin(TOP_EL / 2, SPIN_A, t.slow_wb));
    records.all.push_back(spin(TOP_EL, SPIN_A, t.flux_wb));
    records.all.push_back(spin(TOP_EL, SPIN_A / 2, t.flux_wb));
    for (int pair = 0; pair < 2; pair++) {
        records.all.push_back(ramp(TOP_EL, TOP_EL / 2));
        records.all.push_back(hold(TOP_EL / 2));
        records.all.push_back(ramp(TOP_EL / 2, TOP_EL));
        records.all.push_back(hold(TOP_EL));
    }
    for (Record &r : records.all) {
        if (r.kind == "hold") { // its flux is that of the spin, as is its speed
            const double torque = r.torque;
            r = turning("hold", r.speed_el_rad_s, SPIN_A,
                        r.speed_el_rad_s < TOP_EL ? t.slow_wb : t.flux_wb);
            r.torque = torque;
        }
    }
    add_coasting(records, t);
    return records;
}

} // namespace known
