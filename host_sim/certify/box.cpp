// SPDX-License-Identifier: MIT
#include "box.h"

#include "bars.h"
#include "modulator_units.h"
#include "si.h"
#include "timetable.h"

#include <algorithm>
#include <cmath>

namespace nf::certify
{
namespace
{

constexpr double MICRO = 1e-6;
constexpr double MILLI = 1e-3;
const char *const INERTIA = "motor.inertia_kg_m2";
const char *const LOAD_INERTIA = "load.inertia_pct";

// What is assumed where nobody states it.
constexpr double LEAST = 0.1;             // of any value of the motor file
constexpr double COULOMB_TYPICAL = 0.05;  // of rated torque, at most
constexpr double DEAD_TIME_TYPICAL = 0.2; // either way
constexpr double KNEE_TYPICAL = 2;        // or one over it
constexpr double NOISE_TYPICAL_LSB = 1;   // and half of it either way
constexpr double NOISE_SPREAD = 0.5;
constexpr double MISMATCH_TYPICAL_PCT = 1; // either way
constexpr double CURRENT_GAIN_PCT = 2;     // shunt and amplifier, 1 % each
constexpr double BUS_GAIN_PCT = 2;         // a divider of two resistors, 1 % each
constexpr double SUPPLY_PCT = 5;
constexpr double CLOCK_PCT = 1;       // an RC oscillator over temperature
constexpr double START_LOAD_PCT = 50; // what the alignment holds at any angle
constexpr double STEP_LOAD_PCT = 100;
constexpr double LOAD_INERTIA_PCT = 100;

// A value of the motor file.
struct MotorRow {
    const char *key;
    const char *title;
    const char *unit;
    double scale; // of the unit, in SI
    double MotorSettings::*value;
    double typical_pct;                    // where no bar is stated
    const char *better;                    // how to know it better
    const char *better_measured = nullptr; // once it was identified; nullptr: the same
};
using M = MotorSettings;
const MotorRow MOTOR[] = {
    {"motor.resistance_ohm", "resistance R", "ohm", 1, &M::resistance_ohm, 10,
     "Measure R with four wires between two terminals, and halve it, at the temperature of use: copper gains 39 % "
     "in 100 K."},
    {"motor.inductance_d_h", "inductance L_d", "mH", MILLI, &M::inductance_d_h, 20,
     "Measure L between two terminals with an LCR bridge at 1 kHz while you turn the shaft: half of the smallest value "
     "is L_d."},
    {"motor.inductance_q_h", "inductance L_q", "mH", MILLI, &M::inductance_q_h, 20,
     "Measure L between two terminals as you turn the shaft: half of the largest value is L_q; repeat it with the rated "
     "current, where iron saturates."},
    {"motor.flux_linkage_wb", "flux linkage", "mWb", MILLI, &M::flux_linkage_wb, 5,
     "Turn the shaft with a drill and measure peak voltage and frequency between two terminals: V/(1.732*2*pi*f) is the "
     "flux linkage, within 1 % with an ordinary oscilloscope."},
    {INERTIA, "inertia J", "kg cm2", 1e-4, &M::inertia_kg_m2, 30,
     "Let the drive accelerate with a constant torque current and take J from the slope of the speed; motorsim identify "
     "does this, with the load coupled.",
     "Repeat the identification with steeper ramps, which a larger continuous_current_a of the name plate gives if the motor "
     "bears it, or weigh the rotor and compute J from its shape."},
    {"motor.viscous_friction_nm_s", "viscous friction", "mN m s", MILLI, &M::viscous_friction_nm_s,
     50, "Let the shaft coast from high speed and take the friction from how fast it slows down.",
     "Repeat the identification with a larger max_speed_rpm of the name plate, if the motor bears it: the shaft then coasts from "
     "a higher speed."},
};

double bar_or(double bar, double typical)
{
    return bar > 0 ? bar : typical;
}

Ground ground_of(double bar)
{
    return bar > 0 ? Ground::measured : Ground::typical;
}

using Axes = std::vector<Axis>;

// How to know a value better; an identification that is done need not be named again.
const char *advice(double stated, const char *better, const char *better_measured)
{
    return stated > 0 && better_measured != nullptr ? better_measured : better;
}

void add_motor(const Config &config, Axes &axes)
{
    for (const MotorRow &row : MOTOR) {
        const double value = config.motor.*row.value;
        const double stated = bar_of(config.motor, config.measured, row.key);
        const double bar = bar_or(stated, value * row.typical_pct * PER_CENT);
        const double least = value * LEAST; // a bar may be wider than the value
        const auto set = [&row](Config &real, double now) {
            real.motor.*row.value = now * row.scale;
        };
        axes.push_back({row.key, row.title, row.unit, std::max(value - bar, least) / row.scale,
                        (value + bar) / row.scale, ground_of(stated),
                        advice(stated, row.better, row.better_measured), set});
    }
}

void add_coulomb(const Config &config, Axes &axes)
{
    const char *const key = "measured.coulomb_friction_nm";
    const double stated = bar_of(config.motor, config.measured, key);
    const double value = config.measured.coulomb_friction_nm;
    const double low = stated > 0 ? std::max(value - stated, 0.0) : 0;
    const double high = stated > 0
                            ? value + stated
                            : std::max(2 * value, COULOMB_TYPICAL * config.motor.rated_torque_nm);
    axes.push_back(
        {key, "Coulomb friction", "mN m", low / MILLI, high / MILLI, ground_of(stated),
         "Measure the smallest torque that keeps the shaft turning slowly.",
         [](Config &real, double now) { real.plant.coulomb_friction_nm = now * MILLI; }});
}

// Only what shows the legs themselves knows more of them than an identification does.
const char *const LEGS_MEASURED =
    "An identification can say no more; an oscilloscope at the leg's output shows both edges at several currents.";

// The drive believes what a leg loses as one time, without a drop; the plant has its drop apart, so
// the rest is its dead time.
void add_dead_time(const Config &config, Axes &axes)
{
    const MeasuredSettings &m = config.measured;
    const bool is_measured = m.dead_time_s > 0;
    const double bus_v = m.bus_v > 0 ? m.bus_v : config.board.bus_nominal_v;
    const double drop_s = config.plant.device_drop_v / bus_v / config.board.pwm_frequency_hz;
    const double value = is_measured ? m.dead_time_s - drop_s : config.plant.dead_time_s;
    const double stated = is_measured ? bar_of(config.motor, m, "measured.dead_time_s") : 0;
    const double bar = bar_or(stated, DEAD_TIME_TYPICAL * value);
    axes.push_back(
        {is_measured ? "measured.dead_time_s" : "board.dead_time_s", "dead time", "us",
         std::max(value - bar, 0.0) / MICRO, std::max(value + bar, 0.0) / MICRO, ground_of(stated),
         advice(
             stated,
             "Measure at the leg's output with an oscilloscope, or let motorsim identify find what a leg loses.",
             LEGS_MEASURED),
         [](Config &real, double now) { real.plant.dead_time_s = now * MICRO; }});
}

void add_knee(const Config &config, Axes &axes)
{
    const MeasuredSettings &m = config.measured;
    const double stated = m.knee_a > 0 ? bar_of(config.motor, m, "measured.knee_a") : 0;
    const double value = m.knee_a > 0 ? m.knee_a : commutation_knee_a(config.board, config.model);
    const double low = stated > 0 ? std::max(value - stated, 0.0) : value / KNEE_TYPICAL;
    const double high = stated > 0 ? value + stated : value * KNEE_TYPICAL;
    axes.push_back(
        {m.knee_a > 0 ? "measured.knee_a" : "board.output_capacitance_f", "commutation knee", "A",
         low, high, ground_of(stated),
         advice(
             stated,
             "Let motorsim identify find the knee, or add up output capacitance of the switches and of the "
             "motor cable.",
             LEGS_MEASURED),
         [](Config &real, double now) { real.plant.commutation_knee_a = now; }});
}

void add_sensing(const Config &config, Axes &axes)
{
    const MeasuredSettings &m = config.measured;
    const double noise = bar_or(m.current_noise_lsb, NOISE_TYPICAL_LSB);
    axes.push_back({"plant.adc_noise_lsb", "noise of the current", "LSB",
                    noise * (1 - NOISE_SPREAD), noise * (1 + NOISE_SPREAD),
                    ground_of(m.current_noise_lsb),
                    "Look at the converter's readings while the gates are open.",
                    [](Config &real, double now) { real.plant.adc_noise_lsb = now; }});
    axes.push_back({"board.current_gain_pct", "gain of the current sensors", "%", -CURRENT_GAIN_PCT,
                    CURRENT_GAIN_PCT, Ground::typical,
                    "Send a known direct current through two phases and compare the reading.",
                    [](Config &real, double now) { real.plant.adc_gain_error_pct = {now, now}; }});
    const double stated = bar_of(config.motor, m, "measured.gain_mismatch_pct");
    const double bar = bar_or(stated, MISMATCH_TYPICAL_PCT);
    axes.push_back(
        {"measured.gain_mismatch_pct", "current sensor a over b", "%", m.gain_mismatch_pct - bar,
         m.gain_mismatch_pct + bar, ground_of(stated),
         "Send one direct current through phases a and b in series and compare the two readings.",
         [](Config &real, double now) {
             real.plant.adc_gain_error_pct[0] += now / 2;
             real.plant.adc_gain_error_pct[1] -= now / 2;
         }});
}

// The converter of the real board has another full scale than the drive takes it for.
void add_board(Axes &axes)
{
    axes.push_back(
        {"board.bus_gain_pct", "gain of the bus measurement", "%", -BUS_GAIN_PCT, BUS_GAIN_PCT,
         Ground::typical, "Compare the drive's reading of the bus with a voltmeter.",
         [](Config &real, double now) { real.board.bus_full_scale_v /= 1 + now * PER_CENT; }});
    axes.push_back(
        {"board.bus_nominal_v", "supply voltage, off nominal", "%", -SUPPLY_PCT, SUPPLY_PCT,
         Ground::typical, "Measure the bus with a voltmeter, at no load and at rated load.",
         [](Config &real, double now) { real.board.bus_nominal_v *= 1 + now * PER_CENT; }});
    axes.push_back(
        {"board.pwm_frequency_hz", "oscillator", "%", -CLOCK_PCT, CLOCK_PCT, Ground::typical,
         "Measure the PWM frequency with a counter, or use a crystal.",
         [](Config &real, double now) { real.board.pwm_frequency_hz *= 1 + now * PER_CENT; }});
}

void add_operation(const Config &config, Axes &axes)
{
    const double torque_nm = config.motor.rated_torque_nm * PER_CENT;
    const auto load = [torque_nm](std::size_t step) {
        return [torque_nm, step](Config &real, double now) {
            real.scenario.load[step].value = now * torque_nm;
        };
    };
    axes.push_back({"load.start_pct", "load from the start on", "% of rated torque", 0,
                    START_LOAD_PCT, Ground::operation, "", load(START_LOAD)});
    axes.push_back({"load.step_pct", "load step", "% of rated torque", 0, STEP_LOAD_PCT,
                    Ground::operation, "", load(STEP_LOAD)});
    axes.push_back(
        {LOAD_INERTIA, "inertia of a load added", "% of J", 0, LOAD_INERTIA_PCT, Ground::operation,
         "", [](Config &real, double now) { real.motor.inertia_kg_m2 *= 1 + now * PER_CENT; }});
    axes.push_back({"start.angle_el_deg", "rotor angle at the start", "deg", -180, 180,
                    Ground::operation, "",
                    [](Config &real, double now) { real.scenario.initial_angle_el_deg = now; }});
}

const Axis &axis_of(const Axes &box, const char *key)
{
    return *std::find_if(box.begin(), box.end(), [&](const Axis &axis) { return axis.key == key; });
}

} // namespace

const char *ground_text(Ground ground)
{
    switch (ground) {
    case Ground::measured:
        return "measured";
    case Ground::typical:
        return "typical";
    case Ground::operation:
        break;
    }
    return "operation";
}

std::vector<Axis> box_of(const Config &config)
{
    Axes axes;
    add_motor(config, axes);
    add_coulomb(config, axes);
    add_dead_time(config, axes);
    add_knee(config, axes);
    add_sensing(config, axes);
    add_board(axes);
    add_operation(config, axes);
    axes.erase(std::remove_if(axes.begin(), axes.end(),
                              [](const Axis &axis) { return axis.high <= axis.low; }),
               axes.end());
    return axes;
}

double most_inertia(const std::vector<Axis> &box)
{
    Config most;
    axis_of(box, INERTIA).set(most, axis_of(box, INERTIA).high);
    axis_of(box, LOAD_INERTIA).set(most, axis_of(box, LOAD_INERTIA).high);
    return most.motor.inertia_kg_m2;
}

} // namespace nf::certify
