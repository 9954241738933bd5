/* SPDX-License-Identifier: MIT */
// A complete configuration: what the files say together, and from which line each value is.
// config.h reads it.
#pragma once

#include "hal_settings.h"
#include "origin.h"
#include "settings.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

enum class DriveMode {
    speed,
    position,
    torque
};

// A command of the user and a load are at most so large, either sign, in a scenario and from a
// person.
constexpr double SPEED_COMMAND_MAX_RPM = 200000;
constexpr double POSITION_COMMAND_MAX_RAD = 4000; // a command holds it with 50 pole pairs
constexpr double LOAD_MAX_NM = 10000;
constexpr double SPEED_COMMAND_MAX_PCT = 200; // of rated speed
constexpr double LOAD_MAX_PCT = 300;          // of rated torque

struct TimedValue {
    double time_s;
    double value;
};

// What can go wrong in a run: the words of scenario.fault.what.
enum class FaultKind {
    adc_a_stuck, // a channel's counts: those of a value in SI, or what it read last
    adc_a_high,  // at the converter's end
    adc_a_low,
    adc_b_stuck,
    adc_b_high,
    adc_b_low,
    adc_bus_stuck,
    adc_a_gain, // a sensor reads so many times as much as it should
    adc_b_gain,
    adc_c_gain,
    adc_all_gain, // all current sensors, as behind a wrong reference
    adc_bus_gain,
    temperature_high, // its channel at an end of the converter, as with an open or shorted wire
    temperature_low,
    duty_a_stuck, // a leg's compare value, in % of the period; without a value the last one
    duty_b_stuck,
    duty_c_stuck,
    clock,        // of chip and timer, of what it should be
    angle_stuck,  // the sensor, at what it read last
    angle_offset, // the sensor has turned on the shaft
    sensor_high,  // wires of the sensor of the shaft, as bits of its reading
    sensor_low,
    sensor_flipped,
    encoder_slip, // counts that an encoder gains
    overcurrent,  // as if it flowed into phase a and back out of b
    phase_a_open, // the wire to the motor
    phase_b_open,
    phase_c_open,
    bus_voltage,    // of the supply
    temperature,    // of the power stage
    rotor_blocked,  // stands at once and cannot move
    rotor_jump,     // by an electrical angle
    break_input,    // the power stage opens the gates by itself
    late_isr,       // ticks end too late for their compare values
    config_corrupt, // a bit of the drive's configuration: the lowest of a byte
};

// How long a fault is there without `until_s`.
enum class FaultSpan {
    lasting, // to the end of the run
    tick,    // for one control tick
    instant  // it has no end
};

struct FaultEntry {
    double time_s;
    FaultKind kind;
    FaultSpan span;
    std::optional<double> value;
    std::optional<double> until_s;
};

// What the user asks for. RUN is wanted from the start on, until an entry says otherwise; a clear
// ends the wish unless its entry says run = true.
struct RequestEntry {
    double time_s;
    std::optional<bool> run;
    bool clear;
};

// One [accept.SELECTION] table.
struct AcceptLimits {
    std::map<std::string, double> upper; // metric name to its largest accepted value
    std::map<std::string, bool> flags;   // of a metric that is true or false: what it has to be
};

// [scenario] What happens in a run. Times count from the end of the prelude.
struct ScenarioSettings {
    std::string id; // file name without its ending
    std::string title;
    std::string paper_figure;
    DriveMode mode = DriveMode::speed;
    double duration_s = 0;
    double prelude_s = 0;       // calibration and run-up before t = 0, not in the metrics; in a
                                // file, 0 is as long as the calibration takes
    double evaluate_from_s = 0; // the metrics start here
    unsigned seed = 1;          // of the sensor noise
    double initial_angle_el_deg = 0;
    double initial_speed_rpm = 0;
    double load_scale = 1;           // on every torque of the load
    std::vector<TimedValue> command; // rpm, or mechanical rad in position mode; times rise
    std::vector<TimedValue> load;    // N·m; times rise
    std::vector<FaultEntry> faults;
    std::vector<RequestEntry> requests; // times rise
    bool inherit_limits = true;         // false: limits that a file before it states do not count
    std::map<std::string, AcceptLimits> accept; // by selection, see selection_name()
    std::vector<std::string> notes;             // what will not happen as written, a line each

    // The limits for a selection: those under its name, else those under `any`, else none.
    const AcceptLimits *limits(const std::string &selection) const;
};

// The files that a configuration was read from, as shown to the user and in generated headers:
// relative to the data folder when they are in it, else the bare file name.
struct SourceFiles {
    std::string motor;
    // It comes with the project: that says nothing of what is connected.
    bool motor_is_example = false;
    std::string board;
    std::string tuning;
    std::string scenario; // empty without one
    std::vector<std::string> imperfections;
    std::vector<std::string> overrides;      // the texts of --set
    std::vector<std::filesystem::path> read; // every file, as it was opened
};

struct Config {
    MotorSettings motor;
    MeasuredSettings measured; // at its defaults without [measured]
    BoardSettings board;
    HalSettings hal; // empty without [hal]
    TuningSettings tuning;
    ModelScales model;
    PlantSettings plant;
    ScenarioSettings scenario; // empty after load_parts()
    SourceFiles sources;
    std::map<std::string, Origin> origins; // of "section.key"; keys at their default are absent
};

// What a choice of imperfection sets is called in [accept.*]: the names joined with '+', `ideal`
// for none. A path counts as its file name without the ending.
std::string selection_name(const std::vector<std::string> &with);

} // namespace nf
