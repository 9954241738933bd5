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

// A Hall signal over a window.
struct HallLevels {
    std::complex<double> middle; // mean of e^jθ where it is high, and of 0 where it is low
    double high = 0;             // share of the ticks
};

// One window. Vectors are in the frame of the imposed current: real along it, imaginary across.
// Means over the window, except where another is said.
struct Record {
    std::string kind;      // pulse, catch, still, burst, spin, ramp, hold, coast, hall
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
    // Of a record of hall: the survey of the signals over as many ticks.
    double start_turns = 0; // angle of the vector at its start
    double turns_el = 0;    // that the vector turns, with a sign
    HallLevels halls[3];
    double torque = 0; // sum of power of the EMF over speed, U_b·I_b/Ω_b, two thirds of P·torque in
                       // them; V·A·s a tick
};

struct Records {
    Scales scales;
    std::vector<Record> all; // in their order
    double duration_s = 0;   // of all windows
    std::string remark;      // what a person should know of the log, in one line; may be empty

    std::vector<Record> of(const std::string &kind) const;
};

// Reads the lines of a console's log (log_file.h); of several identifications the last one counts.
// What a logger puts in front of a line is skipped, and so is what is no record, and a line that
// the log has twice. Throws ConfigError with one line that names `name`, the line, what was found
// and what is expected: for a checksum that does not come out, as where a digit was changed or a
// record is missing; for records that end early; for records of another version, a record before
// the scales, a number too many or too few, no number or one that the firmware cannot send, an
// unknown kind; with the drive's own words where it has refused; and for no record at all. Records
// of version 1, which had no checksums, are read with a remark.
Records read_records(const std::vector<std::string> &lines, const std::string &name);

// Of a log file. Throws ConfigError, or InputError where it cannot be read.
Records read_records_file(const std::string &path);

} // namespace nf::identify
