/* SPDX-License-Identifier: MIT */
// Settings in SI units, as read from the motor, board, tuning, scenario and imperfection files.
// The unit of each number is the end of its name; keys in the files have the same names.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

// What is on the shaft, as sensor_kind_t.
enum class SensorKind {
    none,
    hall,
    encoder,
    encoder_index,
    absolute
};

// [sensor] The sensor of the shaft. Angles are electrical, but for the absolute sensor's.
struct SensorSettings {
    SensorKind kind = SensorKind::none;
    int lines = 1024;      // of an encoder, in a turn
    bool reversed = false; // it counts down while the motor turns forwards
    double offset_deg = 0; // an absolute sensor reads this where the flux is along phase a
    // The patterns of the Hall signals in their order forwards, bit 0 is sensor 1, and the angle at
    // which each begins.
    std::vector<double> hall_patterns = {5, 1, 3, 2, 6, 4};
    std::vector<double> hall_edges_deg = {0, 60, 120, 180, 240, 300};
};

// [motor] What the nameplate and a data sheet say. The plant is built from it, and so is the
// controller's model unless [model] says otherwise.
struct MotorSettings {
    std::string name;
    int pole_pairs = 0;
    double resistance_ohm = 0;
    double inductance_d_h = 0;
    double inductance_q_h = 0;
    double flux_linkage_wb = 0;
    double rated_torque_nm = 0;
    double rated_speed_rpm = 0;
    double max_speed_rpm = 0;            // the controller never asks for more
    double max_current_a = 0;            // peak phase current that the controller may ask for
    double continuous_current_a = 0;     // peak phase current for ever; 0: that of rated torque
    double thermal_time_constant_s = 20; // of the winding
    double demagnetising_current_a = 0;  // peak phase current that the magnets bear; 0: not stated
    double inertia_kg_m2 = 0;            // with the load
    double viscous_friction_nm_s = 0;
    SensorSettings sensor;
};

// No value: nothing was measured.
constexpr double NOT_MEASURED = -1;

// [measured] What an identification found out beside the values of [motor]: how far each may be
// wrong, what the legs lose, and in which conditions. `…_std_pct` is a standard deviation and
// `…_bound_pct` a systematic bound, both in % of the value; `…_bar_…` is both together, in the
// value's own unit. A bar of 0 is one that nobody states.
struct MeasuredSettings {
    double resistance_std_pct = 0;
    double resistance_bound_pct = 0;
    double inductance_d_std_pct = 0;
    double inductance_d_bound_pct = 0;
    double inductance_q_std_pct = 0;
    double inductance_q_bound_pct = 0;
    double flux_linkage_std_pct = 0;
    double flux_linkage_bound_pct = 0;
    double inertia_std_pct = 0;
    double inertia_bound_pct = 0;
    // Friction may be near zero, where a share of it says nothing.
    double viscous_friction_bar_nm_s = 0;
    double coulomb_friction_nm = 0; // torque that turns against the motion, whatever the speed
    double coulomb_friction_bar_nm = 0;
    // What a leg loses in a period, with its current the other way: dead_time_s · bus for a large
    // current, half of it at the current knee_a (host_sim/plant/knee.h). The drive believes both.
    double dead_time_s = NOT_MEASURED;
    double dead_time_bar_s = 0;
    double knee_a = NOT_MEASURED;
    double knee_bar_a = 0;
    double temperature_c = 25;    // of the winding
    double bus_v = 0;             // 0: board.bus_nominal_v
    double current_a = 0;         // of the q axis, peak: where L_q is stated
    double speed_rpm = 0;         // highest
    double current_noise_lsb = 0; // rms
    double gain_mismatch_pct = 0; // of current sensor a over b, less one
    double gain_mismatch_bar_pct = 0;
    double hall_edges_bar_deg = 0; // of the edges of the Hall signals, the widest
};

// What the gates do at a stop or a fault where the rotor is too fast for open gates.
enum class SafeState {
    open,
    shorted
};

// [board] Power stage and sensing.
struct BoardSettings {
    std::string name;
    double pwm_frequency_hz = 0; // also the control rate
    double timer_clock_hz = 0;
    int adc_bits = 0;
    double current_full_scale_a = 0; // ± at the ends of the converter; half the current base I_b
    double bus_full_scale_v = 0;     // the voltage base U_b
    double bus_nominal_v = 0;
    double bus_min_v = 0;   // under-voltage fault while running
    double bus_max_v = 0;   // what the bus bears
    double bus_low_v = 0;   // below it motoring is derated; 0: a quarter of the way up to nominal
    double bus_brake_v = 0; // above it braking is derated; 0: half way from nominal to the fault
    double bus_current_max_a = 0;       // of the supply, motoring; 0: no limit
    double bus_regeneration_max_a = -1; // back into it, braking; 0: none; -1: no limit
    double overcurrent_a = 0;
    double trip_a = 0; // the power stage's comparators open the gates by themselves; 0: it has none
    SafeState safe_state = SafeState::open;
    double bus_capacitance_f = 0;          // of the bus; 0: unknown
    int current_sensors = 2;               // of the phases a and b, or of all three
    double current_gain_tolerance_pct = 2; // of each current sensor
    double offset_max_a = 0;               // largest sensor offset that calibration accepts
    double duty_margin_pct = 0;       // share of the period kept free for sampling and dead time
    double dead_time_s = 0;           // both switches of a leg off at each edge
    double device_drop_v = 0;         // across a conducting switch or diode, whatever the current
    double output_capacitance_f = -1; // of a leg with its cable; -1: a typical one
    double bootstrap_charge_s = 0;    // all low sides on before the first high side of a start
    int offset_samples_log2 = 0;      // calibration averages 2^n samples
    // The power stage's sensor: temperatures that rise, and what the converter reads there, in % of
    // its full scale, which rises or falls. Linear in between.
    std::vector<double> temperature_points_c = {-50, 150};
    std::vector<double> temperature_points_pct = {0, 100};
    double temperature_warn_c = 0;  // derating begins; 0: 20 °C below the maximum
    double temperature_max_c = 100; // the drive stops above it
    int recorder_entries = 1408;    // ring of the flight recorder, 16 bytes each
    int baud = 115200;              // bits a second of the serial line, 10 a byte
};

// What controls the motor in RUN.
enum class ControlMethod {
    current,      // regulators of i_d and i_q
    voltage_phase // paper B: magnitude by the speed PI, angle by the phase compensator
};

// Where the rotor's angle is from.
enum class AngleSource {
    observer,
    sensor,
    both // the sensor, and the observer at high speed and when the sensor fails
};

constexpr double BY_KIND = -1;

// What follows when the drive swings; as oscillation_act_t.
enum class OscillationAct {
    off,
    lower,
    fault
};

// What commands the drive without a PC; as input_kind_t.
enum class InputKind {
    none,
    voltage,
    rc_pulse,
    dshot
};

// As input_commands_t.
enum class InputCommands {
    speed,
    torque
};

// As input_button_t.
enum class InputButton {
    none,
    enable,
    start_stop
};

// [input]
struct InputSettings {
    InputKind kind = InputKind::none;
    InputCommands commands = InputCommands::speed;
    InputButton button = InputButton::none;
    bool both_ways = false;
    bool reversed = false;
    double largest_pct = 100;       // at full throttle, of the highest speed or largest torque
    double dead_band_pct = 3;       // of each side
    double expo_pct = 0;            // share of the cube
    double slope_pct_s = 200;       // the demand changes by so much in a second
    double voltage_low_pct = 5;     // of the converter's full scale: no throttle
    double voltage_high_pct = 95;   // likewise: full throttle
    double voltage_margin_pct = 1;  // of it, at both of its ends: an open or shorted wire
    double voltage_filter_s = 0.01; // time constant
    double pulse_low_s = 1e-3;      // no throttle
    double pulse_high_s = 2e-3;     // full throttle
    double pulse_margin_s = 2e-4;   // beyond both: no servo pulse
    double timeout_s = 0; // without a good reading the input is lost; 0: as input_units.cpp chooses
    double arm_s = 0.5;   // seen at rest
};

// [drive], [observer], [startup], [adaptation], [current_loop], [speed_loop], [position_loop],
// [voltage_loop], [phase_compensator], [supervision]
struct TuningSettings {
    std::string name;
    // So long without a message of a PC that has commanded, and the drive stops; 0: it never does.
    double command_timeout_s = 1;
    // Likewise of a person at the console, who types nothing.
    double console_timeout_s = 10;
    InputSettings input;
    ControlMethod method = ControlMethod::current;
    AngleSource angle_source = AngleSource::observer;
    double observer_above_pct = BY_KIND; // of rated speed; 0: only when the sensor fails
    double sensor_below_pct = BY_KIND;   // -1: 3/4 of observer_above_pct
    double observer_kappa = 0;           // share of the speed error removed per sample
    double observer_kappa_p = 0;         // proportional path; 0 is the published law
    double observer_momentum = 0;        // alpha of paper A (19)
    double observer_rho_max =
        0; // largest R/(ωL) by which the error is rotated; 0 is the published law
    double observer_feedback =
        0; // share of the current error that the network takes over; 0 is the published law
    double low_speed_bandwidth_hz = 0; // of the speed loop, where that is less; 0: the same
    double observer_frame_share =
        0; // 0…1, of the measured current's turn with the frame, in the gradient
    double observer_acceleration =
        0; // 0…1, share of the acceleration of reference or torque that ω̂ takes on
    double pace_speed_pct = 0;  // of rated speed: the gains are whole from it on; 0: always
    double pace_least = 0.25;   // share of them that is left below
    double kappa_speed_pct = 0; // likewise κ alone
    double kappa_least = 0.5;
    double startup_current_pct =
        0; // imposed below the hand-over speed, of the continuous current; 0: no
           // start-up, RUN begins with the rotor taken to be at angle 0
    double align_current_pct = 0;    // likewise in the alignment; 0: as startup_current_pct
    double handover_speed_pct = 10;  // of rated speed
    double loaded_speed_pct = 0;     // likewise, down to it RUN carries a load; 0: as without one
    double adapt_resistance_pct = 0; // how far the model may be corrected; 0: not at all
    double adapt_inductance_pct = 0;
    double adapt_saliency_pct = 0;
    double adapt_flux_pct = 0;
    double adapt_dead_time_pct = 0;
    double adapt_inertia_pct = 0;
    double current_bandwidth_hz = 0;
    double current_floor_pct =
        0; // least current in RUN, of the continuous current, where there is dead time
    int most_torque = 1;       // 1: MTPA where L_q > L_d; 0: i_d = 0
    double weakening_pct = 95; // largest i_d of field weakening, of motor.max_current_a; 0: none
    double speed_bandwidth_hz = 0;
    double speed_damping = 0; // of the closed speed loop
    double speed_ramp_rpm_s = 0;
    double inertia_feed_forward = 0; // 0…1, share of J·dω/dt fed to the torque demand
    double notch_hz = 0;             // taken out of the torque current; 0: nothing
    double notch_width_pct = 70;     // of notch_hz
    double torque_slope_nm_s = 0;    // how fast the torque asked for changes; 0: by the motor
    double torque_forward_rpm = -1;  // where the speed loop takes over; -1: motor.max_speed_rpm
    double torque_backward_rpm = -1; // likewise the other way, a magnitude
    double torque_filter_hz = 0;     // corner of the low-pass of the torque current; 0: none
    double position_bandwidth_hz = 0;
    double position_speed_rpm = 0;           // profile limits
    double position_acceleration_rad_s2 = 0; // mechanical
    double position_softness_s = 0;          // time constant with which the profile settles
    int slow_ticks = 0;                      // control ticks in a slow period
    double voltage_kp_v_s_per_rad = 0;       // volts for an electrical speed error; 0: by the motor
    double voltage_ki_v_per_rad = 0;         // volts a second for one; 0: by the motor
    double voltage_speed_pct = 20;           // of rated speed: current control below it
    double voltage_settle_s = 0.1;           // for which all has to be calm before
    double virtual_resistance_ohm = -1;      // against changes of the current; -1: by the motor
    double virtual_mean_s = 0;               // of the current it leaves alone; 0: by the motor
    double compensator_gain = 0.003;         // g of paper B (43), a sample
    double lead_max_deg = 40;                // largest lead of the voltage, electrical
    double brake_max_deg = 0;                // largest lag; 0: by the motor
    double compensator_current_pct =
        25; // of the continuous current: a vector small against it has no angle
    OscillationAct oscillation = OscillationAct::fault;
    double oscillation_amplitude_pct = 30; // of the torque current, of the continuous one
    int oscillation_half_waves = 10;       // in a row
};

// Which wire of the motor hangs at the terminals a, b, c of the board.
enum class Wires {
    abc,
    acb,
    bac,
    bca,
    cab,
    cba
};

// Dead time and device drop are one value unless a file tells them apart: the real board has what
// its file says, and the drive believes what was measured, else what is real. Complete once a
// configuration is loaded.
constexpr double AS_BOARD = -1;
constexpr double AS_PLANT = -1;

// [model] How the controller's belief differs from the motor file, as factors, and from the plant.
struct ModelScales {
    double resistance = 1;
    double inductance = 1;
    double flux = 1;
    double inertia = 1;
    // Compensated by the drive. By default the dead time of [measured], if there is one.
    double dead_time_s = AS_PLANT;
    double device_drop_v = AS_PLANT;
    // By default what the knee of [measured] says, if there is one.
    double output_capacitance_f = AS_BOARD;
};

// [plant] How the real machine differs from the motor file, and what disturbs it.
struct PlantSettings {
    double resistance_scale = 1;
    double inductance_scale = 1;
    double saliency_scale = 1; // of L_q/L_d
    double flux_scale = 1;
    double inertia_scale = 1;
    double coulomb_friction_nm = 0;
    double fan_torque_nm = 0; // of a load that grows with the square of the speed, at rated speed
    int pole_pairs = 0;       // of the real motor; 0: those of the motor file
    Wires wires = Wires::abc;
    double emf_5th_pct = 0; // of the fundamental
    double emf_7th_pct = 0;
    double saturation_d_pct = 0; // fall of L_d at rated current
    double saturation_q_pct = 0;
    double saturation_cross_pct = 0; // share of the iron that both axes have in common
    double cogging_pct = 0;          // peak, of rated torque
    int cogging_order = 0;           // periods in a turn of the shaft; 0: six in an electrical one
    std::array<double, 3> shorted_turns_pct = {0, 0, 0}; // of the windings a, b, c
    std::array<double, 3> contact_ohm = {0, 0, 0};       // in series with them
    double shaft_resonance_hz = 0;                       // 0: a rigid shaft
    double shaft_damping_pct = 2;                        // of critical
    double load_inertia_ratio = 1;                       // load behind the shaft / rotor
    double dead_time_s = AS_BOARD;
    double device_drop_v = AS_BOARD;
    double commutation_knee_a = 0; // 0: a leg loses all or nothing, as with ideal diodes
    double bus_ripple_pct = 0;     // peak, of the nominal bus voltage
    double bus_ripple_hz = 300;
    double bus_capacitance_f = 0;         // 0: the bus is the supply, stiff both ways
    double bus_source_resistance_ohm = 0; // between supply and capacitor
    double adc_noise_lsb = 0;             // rms
    std::array<double, 2> adc_offset_lsb = {0, 0};
    std::array<double, 2> adc_drift_lsb_s = {0, 0}; // of the offset
    std::array<double, 2> adc_gain_error_pct = {0, 0};
    double adc_third_gain_error_pct = 0; // of a third sensor
    double sensor_bandwidth_hz = 0;      // of the low pass before the converter; 0: none
    int angle_counts = 0; // of the angle sensor in a turn of the shaft; 0: as fine as the frame
    // Where the Hall sensors sit: the edges of the real motor, ahead of those of the motor file.
    std::vector<double> hall_error_deg = {0, 0, 0, 0, 0, 0};
};

} // namespace nf
