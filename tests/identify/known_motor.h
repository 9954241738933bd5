/* SPDX-License-Identifier: MIT */
// A motor that is known, and the records that the drive would send of it.
#pragma once

#include "inductance_fit.h"
#include "pulse_model.h"

#include <cmath>
#include <complex>
#include <string>
#include <vector>

namespace known
{

using namespace nf::identify;

constexpr double PERIOD_S = 1e-4;
constexpr double BUS_V = 300;
constexpr double OHM = 2;
constexpr double LOSS_V = 3;
constexpr double KNEE_A = 0.2;
constexpr double LARGEST_A = 10;
constexpr double CONTINUOUS_A = 5;
constexpr double D_H = 0.008;
constexpr double Q_H = 0.008;
constexpr double WB = 0.2;
constexpr int POLE_PAIRS = 3;

inline Legs legs()
{
    Legs legs;
    legs.resistance_ohm = {OHM, 0, 0};
    legs.loss_v = {LOSS_V, 0, 0};
    legs.knee_a = {KNEE_A, 0, 0};
    legs.bus_v = BUS_V;
    legs.period_s = PERIOD_S;
    legs.largest_a = LARGEST_A;
    return legs;
}

inline Records no_records()
{
    Records records;
    records.scales = {PERIOD_S, 40, 600, 4000, POLE_PAIRS};
    return records;
}

// Of the sensors of phases a and b and of their sum.
inline double gain(int axis, double mismatch)
{
    const double gains[] = {1 + mismatch / 2, 1 - mismatch / 2, 1};
    return gains[axis];
}

struct Rest {
    double warming = 0; // share by which R rises until the end of the levels
    double mismatch = 0;
    std::size_t levels = 14; // of an axis, at most
    double (*noise_v)() = [] { return 0.0; };
};

// The levels of identify_rest.c on the three axes. R rises with the sum of i².
inline void add_levels(Records &records, const Rest &rest)
{
    const double shares[] = {255, 205, 164, 131, 105, 84, 67, 54, 43, 34, 27, 54, 105, 205};
    double whole = 0;
    for (std::size_t k = 0; k < rest.levels; k++) {
        whole += 3 * shares[k] * shares[k];
    }
    double until = 0;
    for (int axis = 0; axis < 3; axis++) {
        for (std::size_t k = 0; k < rest.levels; k++) {
            const double i_a = LARGEST_A * shares[k] / 256;
            const double heat = (until + shares[k] * shares[k] / 2) / whole;
            Record r;
            r.kind = "still";
            r.axis = axis;
            r.ticks = 500;
            r.bus_v = BUS_V;
            r.i_a = i_a * gain(axis, rest.mismatch);
            r.voltage_v = OHM * (1 + rest.warming * heat) * i_a +
                          legs().lost_v(std::complex<double>(i_a)).real() + rest.noise_v();
            records.all.push_back(r);
            until += shares[k] * shares[k];
        }
    }
}

} // namespace known
