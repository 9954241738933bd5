/* SPDX-License-Identifier: MIT */
// The axes of the three legs in the frame of one phase, and what of a leg's voltage the winding
// gets.
#pragma once

#include <complex>
#include <cstddef>

namespace nf::identify
{

constexpr std::size_t LEGS = 3;
// Of a leg's voltage: the star point takes the third.
constexpr double TWO_THIRDS = 2.0 / 3;
constexpr double HALF_SQRT3 = 0.86602540378443864676;
// Of the phase in whose frame the vectors are, and of the next ones.
constexpr std::complex<double> LEG_AXIS[LEGS] = {{1, 0}, {-0.5, HALF_SQRT3}, {-0.5, -HALF_SQRT3}};

// What a vector has on the axis of a leg: its current, or its voltage without the zero sequence.
inline double on_leg(std::complex<double> vector, std::size_t leg)
{
    return (vector * std::conj(LEG_AXIS[leg])).real();
}

} // namespace nf::identify
