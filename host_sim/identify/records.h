/* SPDX-License-Identifier: MIT */
// The records of an identification, as firmware/app/identify.h sends them, in SI units.
#pragma once

#include <complex>
#include <string>
#include <vector>

namespace nf::identify
{

// The first line: what the integers of the others are.
struct Scales {
    double period_s = 0;
    double current_a = 0;      // I_b
    double voltage_v = 0;      // U_b
    double speed_el_rad_s = 0; // Ω_b
    int pole_pairs = 0;
};

// One window. Vectors are in the frame of the imposed current: real along it, imaginary across. Means over the window,
// except where another is said.
struct Record {
    std::string kind;      // pulse, catch, still, burst, spin, ramp, hold, coast
    int axis = 0;          // of phase a, b, c: 0, 1, 2
    double current_a = 0;  // asked for
    double pulse_v = 0;    // of the pulses along or across the current, 0: none
    bool across = false;   // they are across
    int quarter_ticks = 0; // of them
    double ticks = 0;
    std::complex<double> voltage_v;
    std::complex<double> i_a; // measured
    double bus_v = 0;
    double noise_a[2] = {0,
                         0}; // mean |change| of the sensors of phases a and b from sample to sample
    std::complex<double>
        change_a; // sum of the current's changes by the pulses, each with the sign of its pulse
    double speed_el_rad_s = 0; // of the vector
    double torque =
        0; // sum of power of the EMF over speed, U_b·I_b/Ω_b, two thirds of P·torque in them; V·A·s a tick
};

struct Records {
    Scales scales;
    std::vector<Record> all; // in their order
    double duration_s = 0;   // of all windows

    std::vector<Record> of(const std::string &kind) const;
};

// Reads the lines that a console has sent; of several identifications the last one counts, and what is no record is
// skipped. Throws ConfigError with one line that names `name`, the line, what was found and what is expected: for records of
// another version, a record before the scales, a number too many or too few, no number or one that the firmware cannot
// send, an unknown kind; with the drive's own words where it has refused; and for no record at all.
Records read_records(const std::vector<std::string> &lines, const std::string &name);

} // namespace nf::identify
