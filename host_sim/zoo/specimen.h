/* SPDX-License-Identifier: MIT */
// A motor and a board that goes with it, made of the ratios that a designer of motors works with.
//
// A class gives power, speed, pole pairs and bus voltage. From them follow, by drawn shares: the
// flux linkage by the EMF's share of the voltage, R by the copper loss, L by the reactance, J by
// the time to accelerate with rated torque. The board has a converter somewhat larger than the
// largest current, and a dead time by its voltage.
#pragma once

#include "draw.h"

#include <string>
#include <vector>

namespace nf::zoo
{

constexpr double RAD_S_PER_RPM = 3.14159265358979323846 / 30;

// A bus up to here is that of a battery or a small supply.
constexpr double LOW_VOLTAGE = 72;

struct Class {
    const char *name;
    std::vector<double> bus_v; // those there are
    Range power_w;
    Range speed_rpm; // rated
    int pole_pairs_min;
    int pole_pairs_max;
    Range copper_loss;   // at rated torque, of the rated power
    double saliency_max; // L_q/L_d is 1 to this
};
const std::vector<Class> &classes();

struct Motor {
    std::string name;
    int pole_pairs = 0;
    double resistance_ohm = 0;
    double inductance_d_h = 0;
    double inductance_q_h = 0;
    double flux_linkage_wb = 0;
    double rated_torque_nm = 0;
    double rated_speed_rpm = 0;
    double max_speed_rpm = 0;
    double max_current_a = 0;
    double inertia_kg_m2 = 0;
    double viscous_friction_nm_s = 0;
};

struct Board {
    std::string name;
    double pwm_frequency_hz = 0;
    double current_full_scale_a = 0;
    double bus_full_scale_v = 0;
    double bus_nominal_v = 0;
    double bus_min_v = 0;
    double bus_max_v = 0;
    double overcurrent_a = 0;
    double trip_a = 0;
    double offset_max_a = 0;
    double duty_margin_pct = 0;
    double dead_time_s = 0;
    double device_drop_v = 0;
    int offset_samples_log2 = 0;
    double settling_s = 0; // low side on before its shunt can be sampled
};

struct Specimen {
    Motor motor;
    Board board;
    double acceleration_s = 0; // from rest to rated speed with rated torque
};

// Copper loss of most motors at rated torque, a share of their rated power, W, above 0.
double usual_copper_loss(double power_w);

Specimen draw_specimen(const Draw &draw, const Class &kind);

} // namespace nf::zoo
