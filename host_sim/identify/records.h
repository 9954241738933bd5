/* SPDX-License-Identifier: MIT */
// The lines that an identification sends (firmware/app/identify.h), read into SI units.
//
//   identify 1 TICK_PS CURRENT_FULL_SCALE_UA BUS_FULL_SCALE_UV POLE_PAIRS SPEED_SHIFT
//   = KIND axis current speed pulse_d pulse_q quarter ticks vd vq id iq bus noise_a noise_b change_d change_q carried turn
//     across pull
//
// All but KIND are whole numbers. A line that begins with neither "identify " nor "= " is other text of the console and is
// left out, so a log of a terminal can be read as it is.
#pragma once

#include <complex>
#include <string>
#include <vector>

namespace nf::identify
{

// What one of each quantity of the records is.
struct Scales {
    double period_s = 0;    // of a control tick, T
    double current_a = 0;   // I_b
    double voltage_v = 0;   // U_b
    double speed_rad_s = 0; // Ω_b, electrical
    int pole_pairs = 0;
};

// A window of the measurement. Vectors are d + j·q of the frame of the imposed current, and means over the window; what is
// a sum says so.
struct Window {
    unsigned line = 0; // of the text
    std::string kind;
    int axis = 0; // the frame stands along phase a, b or c: 0, 1, 2
    double command_a = 0;
    double command_rad_s = 0; // electrical
    double pulse_d_v = 0;
    double pulse_q_v = 0;
    int quarter = 1; // ticks of a quarter of the pulses
    int ticks = 1;
    std::complex<double> voltage_v; // demanded
    std::complex<double> current_a;
    double bus_v = 0;
    double noise_a = 0;    // of the sensors of a and b, |change from sample to sample|
    double change_d_a = 0; // sum, each with the sign of its pulse
    double change_q_a = 0;
    double speed_rad_s = 0; // electrical, of the frame
    double torque_nm = 0;   // of the EMF that the drive believed
    double duration_s = 0;
};

struct Records {
    Scales scales;
    std::vector<Window> windows; // in their order

    std::vector<Window> of(const std::string &kind) const;
};

// `name` stands for the text in messages: its file. Throws ConfigError, one line "NAME:LINE: …", for a line that is no such
// record, for a record without scales before it, for two first lines, and for a text without any record.
Records parse_records(const std::string &text, const std::string &name);

} // namespace nf::identify
