/* SPDX-License-Identifier: MIT */
// What data sheets print, and what a motor file holds: peak values of a phase in star connection.
#pragma once

#include <string>
#include <vector>

namespace nf
{

// value = factor · x^power / by^by_power
struct Conversion {
    const char *sheet; // what is printed, x
    const char *key;   // of [motor]
    double factor;
    int power;      // of x: 1 or −1
    const char *by; // symbol of the second quantity, "" without one
    int by_power;

    double value(double x, double second) const; // SI, as the key; `second` is that of `by`
    std::string formula() const;                 // "0.005513·x/P"
};
const std::vector<Conversion> &conversions();

// The conversion of that very `sheet`. Throws std::out_of_range where there is none.
const Conversion &conversion(const std::string &sheet);

} // namespace nf
