/* SPDX-License-Identifier: MIT */
// Factors between the units of files and reports and those of SI.
#pragma once

namespace nf
{

constexpr double PI = 3.14159265358979323846;
constexpr double TWO_PI = 2 * PI;
constexpr double RAD_S_PER_RPM = PI / 30;
constexpr double RAD_PER_DEG = PI / 180;
constexpr double PER_CENT = 0.01;   // a share from per cent
constexpr double IN_PER_CENT = 100; // per cent from a share

} // namespace nf
