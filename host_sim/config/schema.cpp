// SPDX-License-Identifier: MIT
#include "schema.h"

#include "readable.h"

extern "C" {
#include "recorder.h"
}

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf
{
namespace
{

template <auto Part, auto Member> Target at(Config &config)
{
    return &(config.*Part.*Member);
}

template <auto Member> constexpr auto motor = at<&Config::motor, Member>;
template <auto Member> Target in_sensor(Config &config)
{
    return &(config.motor.sensor.*Member);
}
template <auto Member> constexpr auto sensor = in_sensor<Member>;
template <auto Member> constexpr auto measured = at<&Config::measured, Member>;
template <auto Member> constexpr auto board = at<&Config::board, Member>;
template <auto Member> constexpr auto hal = at<&Config::hal, Member>;
template <auto Member> constexpr auto tuning = at<&Config::tuning, Member>;
template <auto Member> Target in_input(Config &config)
{
    return &(config.tuning.input.*Member);
}

template <auto Member> constexpr auto input = in_input<Member>;
template <auto Member> constexpr auto model = at<&Config::model, Member>;
template <auto Member> constexpr auto plant = at<&Config::plant, Member>;
template <auto Member> constexpr auto scenario = at<&Config::scenario, Member>;

using M = MotorSettings;
using N = SensorSettings;
using E = MeasuredSettings;
using B = BoardSettings;
using H = HalSettings;
using T = TuningSettings;
using I = InputSettings;
using S = ScenarioSettings;
using P = PlantSettings;

constexpr double NAME_CHARS_MAX = 80;
constexpr double PIN_CHARS_MAX = 4;
constexpr std::size_t POINTS_MAX = 16; // of a sensor's line
constexpr double PCT_MAX = 1000;       // of a bar: a value that is not known at all
constexpr double SEED_MAX = 4294967295.0;
constexpr bool NEEDED = true;
constexpr bool OPTIONAL = false;

// The ranges hold every motor from a drone's to a servo's; what a combination allows beyond them is
// checked when it is turned into the firmware's numbers.
// clang-format off
const std::vector<Field> FIELDS = {
    {"motor", "name", "", 1, NAME_CHARS_MAX, NEEDED, motor<&M::name>, "what it is called in reports"},
    {"motor", "pole_pairs", "", 1, 50, NEEDED, motor<&M::pole_pairs>, "pole pairs, half the number of poles"},
    {"motor", "resistance_ohm", "Ω", 0.001, 50, NEEDED, motor<&M::resistance_ohm>, "phase resistance"},
    {"motor", "inductance_d_h", "H", 5e-7, 1, NEEDED, motor<&M::inductance_d_h>, "phase inductance, d axis"},
    {"motor", "inductance_q_h", "H", 5e-7, 1, NEEDED, motor<&M::inductance_q_h>, "phase inductance, q axis"},
    {"motor", "flux_linkage_wb", "Wb", 1e-5, 10, NEEDED, motor<&M::flux_linkage_wb>, "magnet flux linkage, peak"},
    {"motor", "rated_torque_nm", "N·m", 1e-5, 1e4, NEEDED, motor<&M::rated_torque_nm>, "rated torque"},
    {"motor", "rated_speed_rpm", "rpm", 1, 200000, NEEDED, motor<&M::rated_speed_rpm>, "rated speed; metrics in % refer to it"},
    {"motor", "max_speed_rpm", "rpm", 1, 200000, NEEDED, motor<&M::max_speed_rpm>, "the controller never asks for more"},
    {"motor", "max_current_a", "A", 0.01, 1000, NEEDED, motor<&M::max_current_a>, "peak phase current the controller may ask for"},
    {"motor", "continuous_current_a", "A", 0, 1000, OPTIONAL, motor<&M::continuous_current_a>, "peak phase current for ever; 0: that of rated torque"},
    {"motor", "thermal_time_constant_s", "s", 0.1, 300, OPTIONAL, motor<&M::thermal_time_constant_s>, "of the winding, for the limit by i²t"},
    {"motor", "demagnetising_current_a", "A", 0, 5000, OPTIONAL, motor<&M::demagnetising_current_a>, "largest phase current that does not demagnetise the magnets; 0: not stated", RECORD},
    {"motor", "inertia_kg_m2", "kg·m²", 1e-7, 100, NEEDED, motor<&M::inertia_kg_m2>, "moment of inertia with the load"},
    {"motor", "viscous_friction_nm_s", "N·m·s", 0, 100, NEEDED, motor<&M::viscous_friction_nm_s>, "friction torque per rad/s"},

    {"sensor", "kind", "", 0, 0, OPTIONAL, sensor<&N::kind>, "what is on the shaft; with none the simulation's frames have an ideal angle", WITH_ANGLE_SENSOR},
    {"sensor", "lines", "", 1, 16383, OPTIONAL, sensor<&N::lines>, "lines of the encoder in a turn, four counts each", WITH_ENCODER},
    {"sensor", "reversed", "", 0, 1, OPTIONAL, sensor<&N::reversed>, "the sensor counts down while the motor turns forwards", WITH_COUNTING_SENSOR},
    {"sensor", "offset_deg", "°", -360, 360, OPTIONAL, sensor<&N::offset_deg>, "mechanical angle that an absolute sensor reads where the magnet flux is along phase a", WITH_ABSOLUTE},
    {"sensor", "hall_patterns", "", 1, 6, OPTIONAL, sensor<&N::hall_patterns>, "the six patterns of the Hall signals in their order forwards, bit 0 is sensor 1", WITH_HALL},
    {"sensor", "hall_edges_deg", "°", -360, 720, OPTIONAL, sensor<&N::hall_edges_deg>, "electrical angle at which each of these patterns begins, rising", WITH_HALL},

    {"measured", "resistance_std_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::resistance_std_pct>, "standard deviation of motor.resistance_ohm; 0: not stated", RECORD},
    {"measured", "resistance_bound_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::resistance_bound_pct>, "systematic error of motor.resistance_ohm, at most; 0: not stated", RECORD},
    {"measured", "inductance_d_std_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inductance_d_std_pct>, "standard deviation of motor.inductance_d_h; 0: not stated", RECORD},
    {"measured", "inductance_d_bound_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inductance_d_bound_pct>, "systematic error of motor.inductance_d_h, at most; 0: not stated", RECORD},
    {"measured", "inductance_q_std_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inductance_q_std_pct>, "standard deviation of motor.inductance_q_h; 0: not stated", RECORD},
    {"measured", "inductance_q_bound_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inductance_q_bound_pct>, "systematic error of motor.inductance_q_h, at most; 0: not stated", RECORD},
    {"measured", "flux_linkage_std_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::flux_linkage_std_pct>, "standard deviation of motor.flux_linkage_wb; 0: not stated", RECORD},
    {"measured", "flux_linkage_bound_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::flux_linkage_bound_pct>, "systematic error of motor.flux_linkage_wb, at most; 0: not stated", RECORD},
    {"measured", "inertia_std_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inertia_std_pct>, "standard deviation of motor.inertia_kg_m2; 0: not stated", RECORD},
    {"measured", "inertia_bound_pct", "%", 0, PCT_MAX, OPTIONAL, measured<&E::inertia_bound_pct>, "systematic error of motor.inertia_kg_m2, at most; 0: not stated", RECORD},
    {"measured", "viscous_friction_bar_nm_s", "N·m·s", 0, 100, OPTIONAL, measured<&E::viscous_friction_bar_nm_s>, "error of motor.viscous_friction_nm_s, at most; 0: not stated", RECORD},
    {"measured", "coulomb_friction_nm", "N·m", 0, 1e4, OPTIONAL, measured<&E::coulomb_friction_nm>, "friction torque that does not depend on the speed", RECORD},
    {"measured", "coulomb_friction_bar_nm", "N·m", 0, 1e4, OPTIONAL, measured<&E::coulomb_friction_bar_nm>, "its error, at most; 0: not stated", RECORD},
    {"measured", "dead_time_s", "s", -1, 1e-5, OPTIONAL, measured<&E::dead_time_s>, "what a leg loses at a large current, a period, of the bus, device drop included: the drive's model.dead_time_s, with a drop of 0; -1: not measured", WITHOUT_MODEL_DEAD_TIME},
    {"measured", "dead_time_bar_s", "s", 0, 1e-5, OPTIONAL, measured<&E::dead_time_bar_s>, "its error, at most; 0: not stated", RECORD},
    {"measured", "knee_a", "A", -1, 1000, OPTIONAL, measured<&E::knee_a>, "current at which a leg loses half of that: gives the drive's model.output_capacitance_f; -1: not measured", WITH_MEASURED_DEAD_TIME},
    {"measured", "knee_bar_a", "A", 0, 1000, OPTIONAL, measured<&E::knee_bar_a>, "its error, at most; 0: not stated", RECORD},
    {"measured", "temperature_c", "°C", -100, 300, OPTIONAL, measured<&E::temperature_c>, "temperature of the winding at which R and φ are stated", RECORD},
    {"measured", "bus_v", "V", 0, 1500, OPTIONAL, measured<&E::bus_v>, "bus voltage at which the knee is stated; 0: board.bus_nominal_v", RECORD},
    {"measured", "current_a", "A", 0, 1000, OPTIONAL, measured<&E::current_a>, "peak current of the q axis at which L_q is stated; 0: not stated", RECORD},
    {"measured", "speed_rpm", "rpm", 0, 200000, OPTIONAL, measured<&E::speed_rpm>, "highest speed of the measurement; 0: not stated", RECORD},
    {"measured", "current_noise_lsb", "LSB", 0, 1000, OPTIONAL, measured<&E::current_noise_lsb>, "noise of the current sensors, rms; 0: not stated", RECORD},
    {"measured", "gain_mismatch_pct", "%", -50, 50, OPTIONAL, measured<&E::gain_mismatch_pct>, "gain of current sensor a over that of b, less one", RECORD},
    {"measured", "gain_mismatch_bar_pct", "%", 0, 50, OPTIONAL, measured<&E::gain_mismatch_bar_pct>, "its error, at most, in % of the gain; 0: not stated", RECORD},
    {"measured", "hall_edges_bar_deg", "°", 0, 180, OPTIONAL, measured<&E::hall_edges_bar_deg>, "error of sensor.hall_edges_deg, at most; 0: not stated", RECORD},

    {"board", "name", "", 1, NAME_CHARS_MAX, NEEDED, board<&B::name>, "what it is called in reports"},
    {"board", "pwm_frequency_hz", "Hz", 2000, 100000, NEEDED, board<&B::pwm_frequency_hz>, "PWM frequency and control rate"},
    {"board", "timer_clock_hz", "Hz", 1e6, 1e9, NEEDED, board<&B::timer_clock_hz>, "clock of the PWM timer, centre-aligned"},
    {"board", "adc_bits", "bit", 8, 15, NEEDED, board<&B::adc_bits>, "resolution of the converter"},
    {"board", "current_full_scale_a", "A", 0.1, 2000, NEEDED, board<&B::current_full_scale_a>, "± current at the ends of the converter, base I_b"},
    {"board", "bus_full_scale_v", "V", 5, 2000, NEEDED, board<&B::bus_full_scale_v>, "bus voltage at full scale, base U_b"},
    {"board", "bus_nominal_v", "V", 5, 1000, NEEDED, board<&B::bus_nominal_v>, "bus voltage"},
    {"board", "bus_min_v", "V", 1, 1000, NEEDED, board<&B::bus_min_v>, "under-voltage fault while running"},
    {"board", "bus_max_v", "V", 5, 1500, NEEDED, board<&B::bus_max_v>, "what the bus bears: the over-voltage fault, which comes below it with safe_state = \"short\""},
    {"board", "bus_low_v", "V", 0, 1000, OPTIONAL, board<&B::bus_low_v>, "motoring is derated below; 0: bus_min_v and a quarter of the way to nominal"},
    {"board", "bus_brake_v", "V", 0, 1500, OPTIONAL, board<&B::bus_brake_v>, "braking is derated above; 0: half way from nominal to where the over-voltage fault comes"},
    {"board", "bus_current_max_a", "A", 0, 2000, OPTIONAL, board<&B::bus_current_max_a>, "from the supply: motoring is derated to it; 0: no limit"},
    {"board", "bus_regeneration_max_a", "A", -1, 2000, OPTIONAL, board<&B::bus_regeneration_max_a>, "back into the supply: braking is derated to it; 0: it takes nothing back; -1: no limit"},
    {"board", "overcurrent_a", "A", 0.01, 2000, NEEDED, board<&B::overcurrent_a>, "phase current that opens the gates"},
    {"board", "trip_a", "A", 0, 5000, OPTIONAL, board<&B::trip_a>, "comparators open the gates by themselves at this phase current; 0: there are none"},
    {"board", "safe_state", "", 0, 0, OPTIONAL, board<&B::safe_state>, "at a stop or a fault of a rotor that is too fast for open gates: open, which refuses such a speed, or short, which turns all low sides on until it is slow"},
    {"board", "bus_capacitance_f", "F", 0, 1, OPTIONAL, board<&B::bus_capacitance_f>, "of the bus: what it bears when the gates open; 0: unknown", RECORD},
    {"board", "current_sensors", "", 2, 3, OPTIONAL, board<&B::current_sensors>, "2: of the phases a and b; 3: of all phases, so that the sum of the currents shows a sensor that is wrong"},
    {"board", "current_gain_tolerance_pct", "%", 0.1, 20, OPTIONAL, board<&B::current_gain_tolerance_pct>, "gain error of a healthy current sensor: shunt and amplifier"},
    {"board", "offset_max_a", "A", 0, 200, NEEDED, board<&B::offset_max_a>, "largest sensor offset that calibration accepts"},
    {"board", "duty_margin_pct", "%", 0, 50, NEEDED, board<&B::duty_margin_pct>, "share of the period kept free for sampling and dead time"},
    {"board", "dead_time_s", "s", 0, 1e-5, OPTIONAL, board<&B::dead_time_s>, "both switches of a leg off at each edge"},
    {"board", "device_drop_v", "V", 0, 10, OPTIONAL, board<&B::device_drop_v>, "voltage across a conducting switch or diode, whatever the current"},
    {"board", "output_capacitance_f", "F", -1, 1e-6, OPTIONAL, board<&B::output_capacitance_f>, "of a leg's output with its motor cable: small currents charge it only in part within the dead time; 0: none; -1: typical for bus and current", WITHOUT_MEASURED_KNEE},
    {"board", "bootstrap_charge_s", "s", 0, 0.1, OPTIONAL, board<&B::bootstrap_charge_s>, "start-up of a standing rotor: all low sides on for so long before the first high side", WITH_STARTUP},
    {"board", "offset_samples_log2", "", 0, 12, NEEDED, board<&B::offset_samples_log2>, "calibration averages 2^n samples"},
    {"board", "temperature_points_c", "°C", -250, 250, OPTIONAL, board<&B::temperature_points_c>, "temperatures of the power stage, rising, at which its sensor's reading is known; linear in between"},
    {"board", "temperature_points_pct", "%", 0, 100, OPTIONAL, board<&B::temperature_points_pct>, "the sensor's reading at each of them, of the converter's full scale, rising or falling"},
    {"board", "temperature_warn_c", "°C", 0, 200, OPTIONAL, board<&B::temperature_warn_c>, "torque is derated above, down to nothing at the maximum; 0: 20 °C below it"},
    {"board", "temperature_max_c", "°C", 0, 200, OPTIONAL, board<&B::temperature_max_c>, "the drive stops above it"},
    {"board", "recorder_entries", "", RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN, 65536, OPTIONAL, board<&B::recorder_entries>, "ring of the flight recorder, 16 bytes an entry, about one a tick"},
    {"board", "baud", "bit/s", 9600, 4000000, OPTIONAL, board<&B::baud>, "of the serial line, 10 bits a byte; the sampled currents of all ticks need some 2 bytes a tick"},

    {"hal", "chip", "", 1, NAME_CHARS_MAX, OPTIONAL, hal<&H::chip>, "chip that hal/stm32g4 serves, with the letters of package and flash, such as stm32g431cb; with other the pins below do not count, and nothing is checked against the chip"},
    {"hal", "crystal_hz", "Hz", 0, 48e6, OPTIONAL, hal<&H::crystal_hz>, "crystal of the chip; 0: the oscillator in the chip, which is off by 1 % at most"},
    {"hal", "gate_high_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::gate_high_pins>, "high gates of the phases a, b, c; with gate_enable_pins the inputs of the driver"},
    {"hal", "gate_low_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::gate_low_pins>, "low gates of the phases a, b, c"},
    {"hal", "gate_enable_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::gate_enable_pins>, "in place of gate_low_pins: enables of a driver that has one input a phase and makes the dead time"},
    {"hal", "gate_high_polarity", "", 0, 0, OPTIONAL, hal<&H::gate_high_polarity>, "level at which a high gate is on"},
    {"hal", "gate_low_polarity", "", 0, 0, OPTIONAL, hal<&H::gate_low_polarity>, "level at which a low gate is on"},
    {"hal", "shunt_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::shunt_pins>, "currents of the phases a, b and, with three sensors, c: inputs of converters, or with pga_gain above 1 plus inputs of the chip's amplifiers"},
    {"hal", "shunt_ground_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::shunt_ground_pins>, "minus inputs of the chip's amplifiers, with pga_gain above 1"},
    {"hal", "current_position", "", 0, 0, OPTIONAL, hal<&H::current_position>, "shunts below the low sides, which show the current while these are on, or in line with the motor"},
    {"hal", "bus_pin", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::bus_pin>, "bus voltage: input of a converter"},
    {"hal", "temperature_pin", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::temperature_pin>, "temperature of the power stage: input of a converter"},
    {"hal", "break_pin", "", 0, PIN_CHARS_MAX, OPTIONAL, hal<&H::break_pin>, "line of the gate driver that opens the gates; without it the chip's comparators do, at board.trip_a"},
    {"hal", "high_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::high_pins>, "outputs that are high from the start on: enable or standby of a gate driver"},
    {"hal", "low_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::low_pins>, "outputs that are low from the start on"},
    {"hal", "driver_wake_us", "µs", 0, 20000, OPTIONAL, hal<&H::driver_wake_us>, "the gate driver needs so long after high_pins and low_pins are set"},
    {"hal", "serial_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::serial_pins>, "TX and RX of the serial line"},
    {"hal", "throttle_pin", "", 0, PIN_CHARS_MAX, OPTIONAL, hal<&H::throttle_pin>, "voltage that commands the drive, such as that of a potentiometer: input of a converter"},
    {"hal", "pulse_pin", "", 0, PIN_CHARS_MAX, OPTIONAL, hal<&H::pulse_pin>, "pulses that command the drive, of a servo receiver or DShot: a channel of timer 2"},
    {"hal", "button_pin", "", 0, PIN_CHARS_MAX, OPTIONAL, hal<&H::button_pin>, "button, or a line that enables the drive"},
    {"hal", "button_polarity", "", 0, 0, OPTIONAL, hal<&H::button_polarity>, "level while the button is pressed; the chip pulls the pin to the other one"},
    {"hal", "hall_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::hall_pins>, "Hall sensors 1, 2 and 3; they may be pins of encoder_pins too, where one connector is for either"},
    {"hal", "encoder_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::encoder_pins>, "A, B and, if there is one, Z of an incremental encoder: channels 1, 2 and 3 or 4 of timer 3, or of timer 4"},
    {"hal", "spi_encoder_pins", "", 2, PIN_CHARS_MAX, OPTIONAL, hal<&H::spi_encoder_pins>, "SCK, MISO, MOSI and CS of an absolute encoder with frames of 16 bits, such as the AS5047"},
    {"hal", "led_pin", "", 0, PIN_CHARS_MAX, OPTIONAL, hal<&H::led_pin>, "LED that shows the state"},
    {"hal", "led_polarity", "", 0, 0, OPTIONAL, hal<&H::led_polarity>, "level at which the LED is on"},
    {"hal", "adc_settling_ns", "ns", 0, 100000, OPTIONAL, hal<&H::adc_settling_ns>, "low side on before its shunt can be sampled", WITH_LOW_SIDE_SHUNTS},
    {"hal", "adc_sampling_ns", "ns", 10, 100000, OPTIONAL, hal<&H::adc_sampling_ns>, "the converter's sample switch closed at least as long"},
    {"hal", "break_polarity", "", 0, 0, OPTIONAL, hal<&H::break_polarity>, "level that opens the gates: of the line at break_pin; without it comparators trip above (active_high) or below (active_low) their level"},
    {"hal", "shunt_ohm", "Ω", 1e-5, 1, OPTIONAL, hal<&H::shunt_ohm>, "shunts"},
    {"hal", "amplifier_gain", "", -1000, 1000, OPTIONAL, hal<&H::amplifier_gain>, "shunt to converter; negative where a current into the motor counts down"},
    {"hal", "amplifier_zero_v", "V", 0, 5, OPTIONAL, hal<&H::amplifier_zero_v>, "at the converter without current"},
    {"hal", "pga_gain", "", 1, 64, OPTIONAL, hal<&H::pga_gain>, "the part of the gain behind the comparators' inputs; 1: all of it is an external amplifier's"},
    {"hal", "adc_reference_v", "V", 1, 5, OPTIONAL, hal<&H::adc_reference_v>, "full scale of the converters"},
    {"hal", "bus_divider", "", 1e-4, 1, OPTIONAL, hal<&H::bus_divider>, "bus voltage to converter"},

    {"tuning", "name", "", 1, NAME_CHARS_MAX, NEEDED, tuning<&T::name>, "what it is called in reports"},
    {"tuning", "command_timeout_s", "s", 0, 3600, OPTIONAL, tuning<&T::command_timeout_s>, "the drive ramps to a stop when a PC that has commanded it by the link sends no message for so long; 0: it never does"},
    {"tuning", "console_timeout_s", "s", 0, 3600, OPTIONAL, tuning<&T::console_timeout_s>, "the drive ramps to a stop when a person who has commanded it at the console types nothing for so long; 0: it never does"},
    {"drive", "method", "", 0, 0, OPTIONAL, tuning<&T::method>, "what controls the motor in RUN"},
    {"drive", "angle_source", "", 0, 0, OPTIONAL, tuning<&T::angle_source>, "where the rotor's angle is from; with a sensor alone there is no start-up; with both the observer takes over at high speed and when the sensor fails"},
    {"drive", "observer_above_pct", "%", -1, 1000, OPTIONAL, tuning<&T::observer_above_pct>, "of motor.rated_speed_rpm: the observer takes over from the sensor above it; 0: only when the sensor fails; -1: by the sensor, 30 with Hall and else 0", WITH_BOTH},
    {"drive", "sensor_below_pct", "%", -1, 1000, OPTIONAL, tuning<&T::sensor_below_pct>, "likewise the sensor takes over again below it; -1: 3/4 of observer_above_pct", WITH_BOTH},
    {"observer", "kappa", "", 0, 0.5, NEEDED, tuning<&T::observer_kappa>, "κ = η·(φ/L)²/(1−α): speed error removed per sample; 0: by rule", WITH_OBSERVER},
    {"observer", "kappa_p", "", -1, 0.5, NEEDED, tuning<&T::observer_kappa_p>, "proportional path; 0 is the published law; -1: by rule", WITH_OBSERVER},
    {"observer", "momentum", "", 0, 0.99, NEEDED, tuning<&T::observer_momentum>, "α of paper A (19)", WITH_OBSERVER},
    {"observer", "rho_max", "", -1, 3.9, OPTIONAL, tuning<&T::observer_rho_max>, "largest ρ = R/(ωL) by which the error is rotated; 0 is the published law; -1: by rule"},
    {"observer", "feedback", "", -1, 0.3, OPTIONAL, tuning<&T::observer_feedback>, "share of the current error that the network takes over in a sample; 0 is the published law; -1: by rule", WITH_OBSERVER},
    {"observer", "frame_share", "", 0, 1, OPTIONAL, tuning<&T::observer_frame_share>, "share of the turn of the measured current with the frame that the gradient counts; 0 is the published law", WITH_OBSERVER},
    {"observer", "acceleration_feed_forward", "", 0, 1, OPTIONAL, tuning<&T::observer_acceleration>, "share of the acceleration of the speed reference, in torque control of the torque, that the estimate takes on; 0 is the published law", WITH_STARTUP},
    {"observer", "kappa_speed_pct", "%", 0, 100, OPTIONAL, tuning<&T::kappa_speed_pct>, "of motor.rated_speed_rpm: below it κ falls with the speed; 0: never", WITH_STARTUP},
    {"observer", "kappa_least", "", 0.1, 1, OPTIONAL, tuning<&T::kappa_least>, "to this share of it at least", WITH_STARTUP},
    {"observer", "pace_speed_pct", "%", 0, 100, OPTIONAL, tuning<&T::pace_speed_pct>, "of motor.rated_speed_rpm: below it κ_p, ρ and the current loop's bandwidth fall with the speed, κ with its square; 0: never", WITH_STARTUP},
    {"observer", "pace_least", "", 0.1, 1, OPTIONAL, tuning<&T::pace_least>, "to this share of them at least", WITH_STARTUP},
    {"startup", "current_pct", "%", 0, 200, OPTIONAL, tuning<&T::startup_current_pct>, "imposed at low speed, of motor.continuous_current_a; 0: no start-up", WITH_OBSERVER},
    {"startup", "align_current_pct", "%", 0, 300, OPTIONAL, tuning<&T::align_current_pct>, "imposed in the alignment, of motor.continuous_current_a; 0: as startup.current_pct", WITH_STARTUP},
    {"startup", "handover_speed_pct", "%", 1, 50, OPTIONAL, tuning<&T::handover_speed_pct>, "of motor.rated_speed_rpm: the observer takes over", WITH_HANDOVER},
    {"startup", "loaded_speed_pct", "%", 0, 50, OPTIONAL, tuning<&T::loaded_speed_pct>, "likewise: with a load the observer runs down to this speed; 0: as without a load", WITH_STARTUP},
    {"adaptation", "resistance_pct", "%", 0, 90, OPTIONAL, tuning<&T::adapt_resistance_pct>, "how far R may be corrected by what is measured; 0: not at all", WITH_STARTUP},
    {"adaptation", "inductance_pct", "%", 0, 50, OPTIONAL, tuning<&T::adapt_inductance_pct>, "likewise L_d", WITH_STARTUP},
    {"adaptation", "saliency_pct", "%", 0, 100, OPTIONAL, tuning<&T::adapt_saliency_pct>, "likewise L_q/L_d, by a factor of up to 1 + this, either way", WITH_STARTUP},
    {"adaptation", "flux_pct", "%", 0, 50, OPTIONAL, tuning<&T::adapt_flux_pct>, "likewise φ"},
    {"adaptation", "inertia_pct", "%", 0, 300, OPTIONAL, tuning<&T::adapt_inertia_pct>, "how far J may be corrected by what ramps of the speed need, by a factor of up to 1 + this, either way; 0: not at all"},
    {"adaptation", "dead_time_pct", "%", 0, 50, OPTIONAL, tuning<&T::adapt_dead_time_pct>, "how far the compensated dead time may be corrected by what is measured; 0: not at all", WITH_DEAD_TIME},
    {"current_loop", "bandwidth_hz", "Hz", 0, 10000, NEEDED, tuning<&T::current_bandwidth_hz>, "of the closed current loop; 0: by the PWM frequency"},
    {"current_loop", "floor_pct", "%", -1, 50, OPTIONAL, tuning<&T::current_floor_pct>, "least current in RUN, of motor.continuous_current_a; -1: by the dead time", WITH_DEAD_TIME},
    {"current_loop", "most_torque", "", 0, 1, OPTIONAL, tuning<&T::most_torque>, "1: i_d makes the most torque of a current (MTPA) where inductance_q_h is above inductance_d_h; 0: i_d = 0", WITH_SALIENCY},
    {"current_loop", "weakening_pct", "%", 0, 100, OPTIONAL, tuning<&T::weakening_pct>, "largest i_d of field weakening, of motor.max_current_a; 0: the field is not weakened", WITHOUT_VOLTAGE_DRIVE},
    {"speed_loop", "bandwidth_hz", "Hz", 0, 1000, OPTIONAL, tuning<&T::speed_bandwidth_hz>, "of the closed speed loop; 0: by the motor"},
    {"speed_loop", "low_speed_bandwidth_hz", "Hz", -1, 1000, OPTIONAL, tuning<&T::low_speed_bandwidth_hz>, "likewise at low speed, where dead time makes more ripple; 0: the same; -1: by rule", WITH_STARTUP},
    {"speed_loop", "damping", "", 0.1, 10, NEEDED, tuning<&T::speed_damping>, "of the closed speed loop"},
    {"speed_loop", "ramp_rpm_s", "rpm/s", 0, 1e7, OPTIONAL, tuning<&T::speed_ramp_rpm_s>, "how fast the speed reference changes; 0: by the motor"},
    {"speed_loop", "inertia_feed_forward", "", 0, 1, NEEDED, tuning<&T::inertia_feed_forward>, "share of J·dω/dt fed to the torque demand"},
    {"speed_loop", "notch_hz", "Hz", 0, 5000, OPTIONAL, tuning<&T::notch_hz>, "a resonance of the shaft, taken out of the torque current; 0: none"},
    {"speed_loop", "notch_width_pct", "%", 10, 100, OPTIONAL, tuning<&T::notch_width_pct>, "band that loses half of its power and more, of speed_loop.notch_hz; at most a quarter of the speed loop's rate", WITH_NOTCH},
    {"speed_loop", "torque_filter_hz", "Hz", 0, 5000, OPTIONAL, tuning<&T::torque_filter_hz>, "corner of a first-order low-pass of the torque current; 0: none"},
    {"speed_loop", "slow_ticks", "", 6, 100, NEEDED, tuning<&T::slow_ticks>, "control ticks in a period of the speed and position loop"},
    {"torque_loop", "slope_nm_s", "N·m/s", 0, 1e9, OPTIONAL, tuning<&T::torque_slope_nm_s>, "how fast the torque of torque control changes; 0: by the motor"},
    {"torque_loop", "speed_forward_rpm", "rpm", -1, 200000, OPTIONAL, tuning<&T::torque_forward_rpm>, "torque control turns the motor no faster; -1: motor.max_speed_rpm"},
    {"torque_loop", "speed_backward_rpm", "rpm", -1, 200000, OPTIONAL, tuning<&T::torque_backward_rpm>, "likewise backwards, a magnitude"},
    {"position_loop", "bandwidth_hz", "Hz", 0, 500, OPTIONAL, tuning<&T::position_bandwidth_hz>, "of the position loop; 0: by the motor"},
    {"position_loop", "speed_rpm", "rpm", 0, 200000, OPTIONAL, tuning<&T::position_speed_rpm>, "speed limit of the profile; 0: by the motor"},
    {"position_loop", "acceleration_rad_s2", "rad/s²", 0, 1e7, OPTIONAL, tuning<&T::position_acceleration_rad_s2>, "acceleration limit of the profile, mechanical; 0: by the motor"},
    {"position_loop", "softness_s", "s", 0, 10, OPTIONAL, tuning<&T::position_softness_s>, "time constant with which the profile settles; 0: by the motor"},

    {"voltage_loop", "kp_v_s_per_rad", "V·s/rad", 0, 1000, OPTIONAL, tuning<&T::voltage_kp_v_s_per_rad>, "voltage for an electrical speed error; 0: by the motor", WITH_VOLTAGE_DRIVE},
    {"voltage_loop", "ki_v_per_rad", "V/rad", 0, 1e5, OPTIONAL, tuning<&T::voltage_ki_v_per_rad>, "voltage a second for an electrical speed error; 0: by the motor", WITH_VOLTAGE_DRIVE},
    {"voltage_loop", "speed_min_pct", "%", 1, 100, OPTIONAL, tuning<&T::voltage_speed_pct>, "of motor.rated_speed_rpm: current control below it", WITH_VOLTAGE_SPEED},
    {"voltage_loop", "settle_s", "s", 0.001, 10, OPTIONAL, tuning<&T::voltage_settle_s>, "for which speed and currents have to be calm before the change from current control", WITH_VOLTAGE_DRIVE},
    {"voltage_loop", "virtual_resistance_ohm", "Ω", -1, 50, OPTIONAL, tuning<&T::virtual_resistance_ohm>, "voltage taken off for a change of the current: damps the currents' own mode; 0: none; -1: by the motor", WITH_VOLTAGE_DRIVE},
    {"voltage_loop", "virtual_mean_s", "s", 0, 10, OPTIONAL, tuning<&T::virtual_mean_s>, "time constant of the mean from which a change counts; 0: by the motor", WITH_VOLTAGE_DRIVE},
    {"phase_compensator", "gain", "", 0, 0.1, OPTIONAL, tuning<&T::compensator_gain>, "g of paper B (43), a sample; 0: the lead stays as it was", WITH_VOLTAGE_DRIVE},
    {"phase_compensator", "lead_max_deg", "°", 0, 90, OPTIONAL, tuning<&T::lead_max_deg>, "largest lead of the voltage, electrical", WITH_VOLTAGE_DRIVE},
    {"phase_compensator", "brake_max_deg", "°", 0, 90, OPTIONAL, tuning<&T::brake_max_deg>, "largest lag of the voltage; 0: by the motor", WITH_VOLTAGE_DRIVE},
    {"phase_compensator", "current_min_pct", "%", 1, 100, OPTIONAL, tuning<&T::compensator_current_pct>, "of motor.continuous_current_a: a vector small against it has no angle", WITH_VOLTAGE_DRIVE},
    {"supervision", "oscillation", "", 0, 0, OPTIONAL, tuning<&T::oscillation>, "what follows when the torque current swings at a constant command: nothing, half the speed bandwidth and if that does not help a fault, or a fault"},
    {"supervision", "oscillation_amplitude_pct", "%", 1, 200, OPTIONAL, tuning<&T::oscillation_amplitude_pct>, "amplitude of the torque current that is a swing, of motor.continuous_current_a", WITH_OSCILLATION},
    {"supervision", "oscillation_half_waves", "", 4, 1000, OPTIONAL, tuning<&T::oscillation_half_waves>, "half-waves in a row that are a swing", WITH_OSCILLATION},

    {"input", "kind", "", 0, 0, OPTIONAL, input<&I::kind>, "what commands the drive without a PC: nothing, a voltage as of a potentiometer, servo pulses of a receiver, or DShot"},
    {"input", "commands", "", 0, 0, OPTIONAL, input<&I::commands>, "of what full throttle commands the largest", WITH_INPUT},
    {"input", "button", "", 0, 0, OPTIONAL, input<&I::button>, "what the button does: nothing; the motor runs only while it is pressed; a press starts and the next one stops", WITH_INPUT},
    {"input", "both_ways", "", 0, 0, OPTIONAL, input<&I::both_ways>, "the middle is no throttle, and below it the motor turns backwards", WITH_INPUT},
    {"input", "reversed", "", 0, 0, OPTIONAL, input<&I::reversed>, "the motor turns the other way", WITH_INPUT},
    {"input", "largest_pct", "%", 1, 100, OPTIONAL, input<&I::largest_pct>, "at full throttle, of motor.max_speed_rpm or of the torque at motor.max_current_a", WITH_INPUT},
    {"input", "dead_band_pct", "%", 0.5, 50, OPTIONAL, input<&I::dead_band_pct>, "of the way from no to full throttle that still is no throttle", WITH_INPUT},
    {"input", "expo_pct", "%", 0, 100, OPTIONAL, input<&I::expo_pct>, "share of a cube in the curve from throttle to demand: finer at small demands", WITH_INPUT},
    {"input", "slope_pct_s", "%/s", 1, 1e5, OPTIONAL, input<&I::slope_pct_s>, "the demand follows the throttle with at most so much of the largest in a second", WITH_INPUT},
    {"input", "voltage_low_pct", "%", 0, 99, OPTIONAL, input<&I::voltage_low_pct>, "of the converter's full scale: no throttle", WITH_VOLTAGE_INPUT},
    {"input", "voltage_high_pct", "%", 1, 100, OPTIONAL, input<&I::voltage_high_pct>, "of the converter's full scale: full throttle", WITH_VOLTAGE_INPUT},
    {"input", "voltage_margin_pct", "%", 0, 20, OPTIONAL, input<&I::voltage_margin_pct>, "of the converter's full scale, at both of its ends: a wire is open or shorted, and the input is lost; 0: that is not told from the ends of a potentiometer", WITH_VOLTAGE_INPUT},
    {"input", "voltage_filter_s", "s", 0, 1, OPTIONAL, input<&I::voltage_filter_s>, "time constant of the voltage's low-pass; 0: none", WITH_VOLTAGE_INPUT},
    {"input", "pulse_low_s", "s", 0.0006, 0.002, OPTIONAL, input<&I::pulse_low_s>, "servo pulse that is no throttle", WITH_PULSE_INPUT},
    {"input", "pulse_high_s", "s", 0.001, 0.0024, OPTIONAL, input<&I::pulse_high_s>, "servo pulse that is full throttle", WITH_PULSE_INPUT},
    {"input", "pulse_margin_s", "s", 0.00005, 0.0004, OPTIONAL, input<&I::pulse_margin_s>, "beyond both a pulse is no servo pulse", WITH_PULSE_INPUT},
    {"input", "timeout_s", "s", 0, 2, OPTIONAL, input<&I::timeout_s>, "without a good reading for so long the input is lost, and the drive ramps to a stop; at least 0.05 s, and 400 periods of the PWM with a voltage; 0: 0.1 s, or 400 periods if that is longer", WITH_INPUT},
    {"input", "arm_s", "s", 0.2, 10, OPTIONAL, input<&I::arm_s>, "the input has to be seen at rest for so long before it may start the motor", WITH_INPUT},

    {"model", "resistance", "", 0.1, 10, OPTIONAL, model<&ModelScales::resistance>, "controller's belief / motor file"},
    {"model", "inductance", "", 0.1, 10, OPTIONAL, model<&ModelScales::inductance>, "controller's belief / motor file"},
    {"model", "flux", "", 0.1, 10, OPTIONAL, model<&ModelScales::flux>, "controller's belief / motor file"},
    {"model", "inertia", "", 0.01, 100, OPTIONAL, model<&ModelScales::inertia>, "controller's belief / motor file"},

    {"model", "dead_time_s", "s", -1, 1e-5, OPTIONAL, model<&ModelScales::dead_time_s>, "dead time that the drive compensates; -1: measured.dead_time_s, else plant.dead_time_s"},
    {"model", "output_capacitance_f", "F", -1, 1e-6, OPTIONAL, model<&ModelScales::output_capacitance_f>, "capacitance of a leg's output that the drive reckons with; -1: by measured.knee_a, else board.output_capacitance_f"},
    {"model", "device_drop_v", "V", -1, 10, OPTIONAL, model<&ModelScales::device_drop_v>, "device drop that the drive compensates; -1: plant.device_drop_v, or 0 with a measured dead time, which has it"},

    {"plant", "resistance_scale", "", 0.1, 10, OPTIONAL, plant<&P::resistance_scale>, "real motor / motor file"},
    {"plant", "inductance_scale", "", 0.1, 10, OPTIONAL, plant<&P::inductance_scale>, "real motor / motor file"},
    {"plant", "saliency_scale", "", 0.1, 10, OPTIONAL, plant<&P::saliency_scale>, "real L_q/L_d / motor file"},
    {"plant", "flux_scale", "", 0.1, 10, OPTIONAL, plant<&P::flux_scale>, "real motor / motor file"},
    {"plant", "inertia_scale", "", 0.01, 100, OPTIONAL, plant<&P::inertia_scale>, "real motor / motor file"},
    {"plant", "coulomb_friction_nm", "N·m", 0, 1000, OPTIONAL, plant<&P::coulomb_friction_nm>, "constant friction torque"},
    {"plant", "fan_torque_nm", "N·m", 0, 10000, OPTIONAL, plant<&P::fan_torque_nm>, "at motor.rated_speed_rpm, of a load that grows with the square of the speed: a propeller, a fan, a pump"},
    {"plant", "pole_pairs", "", 0, 50, OPTIONAL, plant<&P::pole_pairs>, "of the real motor; 0: motor.pole_pairs"},
    {"plant", "wires", "", 0, 0, OPTIONAL, plant<&P::wires>, "of the motor at the terminals a, b, c of the board: bac exchanges the first two, so it turns the other way"},
    {"plant", "emf_5th_pct", "%", -30, 30, OPTIONAL, plant<&P::emf_5th_pct>, "5th harmonic of the EMF, of its fundamental; the torque has it as well"},
    {"plant", "emf_7th_pct", "%", -30, 30, OPTIONAL, plant<&P::emf_7th_pct>, "likewise the 7th"},
    {"plant", "saturation_d_pct", "%", 0, 30, OPTIONAL, plant<&P::saturation_d_pct>, "fall of L_d at an i_d as large as the current of motor.rated_torque_nm; with as much i_d < 0 it rises"},
    {"plant", "saturation_q_pct", "%", 0, 50, OPTIONAL, plant<&P::saturation_q_pct>, "likewise of L_q, at an i_q of either sign"},
    {"plant", "saturation_cross_pct", "%", 0, 100, OPTIONAL, plant<&P::saturation_cross_pct>, "share of the saturated iron that both axes have in common: i_q takes flux from the d axis", WITH_TWO_SATURATIONS},
    {"plant", "cogging_pct", "%", 0, 50, OPTIONAL, plant<&P::cogging_pct>, "peak of the cogging torque, of motor.rated_torque_nm"},
    {"plant", "cogging_order", "", 0, 1000, OPTIONAL, plant<&P::cogging_order>, "its periods in a turn of the shaft, the least common multiple of slots and poles; 0: 6·motor.pole_pairs", WITH_COGGING},
    {"plant", "shorted_turns_pct", "%", 0, 90, OPTIONAL, plant<&P::shorted_turns_pct>, "shorted turns of the windings of phases a, b, c, of all their turns: less R, L and EMF"},
    {"plant", "contact_ohm", "Ω", 0, 1000, OPTIONAL, plant<&P::contact_ohm>, "in series with the windings of phases a, b, c: bad contacts"},
    {"plant", "shaft_resonance_hz", "Hz", 0, 5000, OPTIONAL, plant<&P::shaft_resonance_hz>, "frequency at which rotor and load swing against each other on an elastic shaft; 0: rigid"},
    {"plant", "shaft_damping_pct", "%", 0, 100, OPTIONAL, plant<&P::shaft_damping_pct>, "damping of these swings, of the critical one", WITH_ELASTIC_SHAFT},
    {"plant", "load_inertia_ratio", "", 0.01, 100, OPTIONAL, plant<&P::load_inertia_ratio>, "inertia of the load behind the shaft / inertia of the rotor; together they are motor.inertia_kg_m2", WITH_ELASTIC_SHAFT},
    {"plant", "dead_time_s", "s", -1, 1e-5, OPTIONAL, plant<&P::dead_time_s>, "that of the real board; -1: board.dead_time_s"},
    {"plant", "device_drop_v", "V", -1, 10, OPTIONAL, plant<&P::device_drop_v>, "that of the real board; -1: board.device_drop_v"},
    {"plant", "commutation_knee_a", "A", 0, 100, OPTIONAL, plant<&P::commutation_knee_a>, "current at which a leg loses half of what dead time and drop take, more of it beyond and less below; 0: all or nothing, by the current's sign", WITH_LEG_LOSS},
    {"plant", "bus_ripple_pct", "%", 0, 50, OPTIONAL, plant<&P::bus_ripple_pct>, "peak of the bus ripple, of the nominal voltage"},
    {"plant", "bus_ripple_hz", "Hz", 0, 5000, OPTIONAL, plant<&P::bus_ripple_hz>, "frequency of the bus ripple", WITH_RIPPLE},
    {"plant", "bus_capacitance_f", "F", 0, 1, OPTIONAL, plant<&P::bus_capacitance_f>, "capacitor of the bus behind a rectifier; 0: a stiff bus that takes current back"},
    {"plant", "bus_source_resistance_ohm", "Ω", 0, 1000, OPTIONAL, plant<&P::bus_source_resistance_ohm>, "between rectifier and capacitor", WITH_CAPACITOR},
    {"plant", "adc_noise_lsb", "LSB", 0, 1000, OPTIONAL, plant<&P::adc_noise_lsb>, "Gaussian noise of the current sensors, rms"},
    {"plant", "adc_offset_lsb", "LSB", -10000, 10000, OPTIONAL, plant<&P::adc_offset_lsb>, "offset of the current sensors a, b before calibration"},
    {"plant", "adc_drift_lsb_s", "LSB/s", -10000, 10000, OPTIONAL, plant<&P::adc_drift_lsb_s>, "change of the offset in a second, of the current sensors a, b, from power-up on: calibration sees what has come before it only"},
    {"plant", "adc_gain_error_pct", "%", -50, 50, OPTIONAL, plant<&P::adc_gain_error_pct>, "gain error of the current sensors a, b"},
    {"plant", "adc_third_gain_error_pct", "%", -50, 50, OPTIONAL, plant<&P::adc_third_gain_error_pct>, "gain error of the current sensor c, where board.current_sensors is 3"},
    {"plant", "sensor_bandwidth_hz", "Hz", 0, 1e6, OPTIONAL, plant<&P::sensor_bandwidth_hz>, "corner of the current sensors' first-order low pass; 0: none"},
    {"plant", "angle_counts", "", 0, 65536, OPTIONAL, plant<&P::angle_counts>, "of the angle sensor in a turn of the shaft; 0: as fine as the frame, 65536", WITH_IDEAL_SENSOR},
    {"plant", "hall_error_deg", "°", -30, 30, OPTIONAL, plant<&P::hall_error_deg>, "by how much each edge of the real Hall sensors lies ahead of sensor.hall_edges_deg", WITH_HALL},

    {"scenario", "title", "", 1, NAME_CHARS_MAX, NEEDED, scenario<&S::title>, "one line for reports"},
    {"scenario", "paper_figure", "", 0, NAME_CHARS_MAX, OPTIONAL, scenario<&S::paper_figure>, "figure of the papers that shows the same"},
    {"scenario", "mode", "", 0, 0, NEEDED, scenario<&S::mode>, "what the command is"},
    {"scenario", "duration_s", "s", 0.001, 3600, NEEDED, scenario<&S::duration_s>, "from t = 0 to the end"},
    {"scenario", "prelude_s", "s", 0, 60, OPTIONAL, scenario<&S::prelude_s>, "simulated before t = 0, not in the metrics; 0: as long as the calibration"},
    {"scenario", "evaluate_from_s", "s", 0, 3600, OPTIONAL, scenario<&S::evaluate_from_s>, "the metrics start here"},
    {"scenario", "seed", "", 0, SEED_MAX, OPTIONAL, scenario<&S::seed>, "of the random numbers", WITH_NOISE},
    {"scenario", "initial_angle_el_deg", "°", -360, 360, OPTIONAL, scenario<&S::initial_angle_el_deg>, "electrical rotor angle at the start of the prelude"},
    {"scenario", "initial_speed_rpm", "rpm", -200000, 200000, OPTIONAL, scenario<&S::initial_speed_rpm>, "speed at the start of the prelude"},
    {"scenario", "load_scale", "", -10, 10, OPTIONAL, scenario<&S::load_scale>, "factor on every torque of the load", WITH_LOAD},
    {"scenario", "inherit_limits", "", 0, 1, OPTIONAL, scenario<&S::inherit_limits>, "false: the limits of [accept] that the base states do not count"},
};
// clang-format on

struct Section {
    const char *name;
    std::vector<FileKind> kinds; // that may hold it
};

const std::vector<Section> SECTIONS = {
    {"motor", {FileKind::motor}},
    {"sensor", {FileKind::motor, FileKind::scenario}},
    {"measured", {FileKind::motor}},
    {"board", {FileKind::board, FileKind::imperfection}},
    {"hal", {FileKind::board}},
    {"tuning", {FileKind::tuning}},
    {"drive", {FileKind::tuning, FileKind::scenario}},
    {"observer", {FileKind::tuning, FileKind::scenario}},
    {"startup", {FileKind::tuning, FileKind::scenario}},
    {"adaptation", {FileKind::tuning, FileKind::scenario}},
    {"current_loop", {FileKind::tuning, FileKind::scenario}},
    {"speed_loop", {FileKind::tuning, FileKind::scenario}},
    {"torque_loop", {FileKind::tuning, FileKind::scenario}},
    {"position_loop", {FileKind::tuning, FileKind::scenario}},
    {"voltage_loop", {FileKind::tuning, FileKind::scenario}},
    {"phase_compensator", {FileKind::tuning, FileKind::scenario}},
    {"supervision", {FileKind::tuning, FileKind::scenario}},
    {"input", {FileKind::board, FileKind::tuning, FileKind::scenario}},
    {"model", {FileKind::scenario, FileKind::imperfection}},
    {"plant", {FileKind::scenario, FileKind::imperfection}},
    {"scenario", {FileKind::scenario}},
    {"accept", {FileKind::scenario}},
};

// What the keys with a choice can be, in the order of the enumerators.
using Words = std::vector<const char *>;

Words words_of(const DriveMode *)
{
    return {"speed", "position", "torque"};
}

Words words_of(const ControlMethod *)
{
    return {"current", "voltage_phase"};
}

Words words_of(const AngleSource *)
{
    return {"observer", "sensor", "both"};
}

Words words_of(const SensorKind *)
{
    return {"none", "hall", "encoder", "encoder_index", "absolute"};
}

Words words_of(const OscillationAct *)
{
    return {"off", "lower", "fault"};
}

Words words_of(const SafeState *)
{
    return {"open", "short"};
}

Words words_of(const Wires *)
{
    return {"abc", "acb", "bac", "bca", "cab", "cba"};
}

Words words_of(const Polarity *)
{
    return {"active_high", "active_low"};
}

Words words_of(const CurrentPosition *)
{
    return {"low_side", "in_line"};
}

Words words_of(const InputKind *)
{
    return {"none", "voltage", "rc_pulse", "dshot"};
}

Words words_of(const InputCommands *)
{
    return {"speed", "torque"};
}

Words words_of(const InputButton *)
{
    return {"none", "enable", "start_stop"};
}

template <typename... Visitors> struct Overloaded : Visitors... {
    using Visitors::operator()...;
};
template <typename... Visitors> Overloaded(Visitors...) -> Overloaded<Visitors...>;

Target type_of(const Field &field)
{
    static Config any;
    return field.target(any);
}

[[noreturn]] void wrong(const Field &field, const Node &value, const std::string &problem)
{
    fail(value.origin, field.name(), shown(value), problem, field.allowed());
}

void check_real(const Field &field, const Node &value)
{
    check_number(field.name(), value, field.min, field.max, field.allowed());
}

void check_whole(const Field &field, const Node &value)
{
    if (!value.whole()) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
    check_real(field, value);
}

void check_list(const Field &field, const Node &value, std::size_t least, std::size_t most)
{
    if (value.kind != Node::Kind::list) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
    if (value.items.size() < least || value.items.size() > most) {
        wrong(field, value, fmt::format("has {} items", value.items.size()));
    }
    for (Node item : value.items) {
        item.origin = value.origin;
        check_real(field, item);
    }
}

void check_boolean(const Field &field, const Node &value)
{
    if (value.kind != Node::Kind::boolean) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
}

bool is_printable(const std::string &text)
{
    return std::none_of(text.begin(), text.end(),
                        [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

std::size_t length_of(const std::string &text)
{
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; // not inside a UTF-8 character
    }));
}

void check_string(const Field &field, const Node &value)
{
    if (value.kind != Node::Kind::text) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
    const auto length = static_cast<double>(length_of(value.text));
    if (length < field.min || length > field.max) {
        wrong(field, value, fmt::format("has {} characters", length));
    }
    if (!is_printable(value.text)) {
        wrong(field, value, "has a control character");
    }
}

// Any number of pins: what a board needs is known when all its keys are.
void check_pins(const Field &field, const Node &value)
{
    if (value.kind != Node::Kind::list) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
    for (Node item : value.items) {
        item.origin = value.origin;
        check_string(field, item);
    }
}

void check_choice(const Field &field, const Node &value, const Words &words)
{
    if (value.kind != Node::Kind::text) {
        wrong(field, value, std::string("is ") + kind_name(value));
    }
    if (std::count(words.begin(), words.end(), value.text) == 0) {
        wrong(field, value, fmt::format("is no {}", field.key));
    }
}

std::string choice_text(const Words &words)
{
    std::string text = fmt::format(R"("{}")", words.front());
    for (std::size_t k = 1; k < words.size(); k++) {
        text += fmt::format(R"({}"{}")", k + 1 == words.size() ? " or " : ", ", words[k]);
    }
    return text;
}

// A checked value.
template <typename Choice> void choose(Choice *place, const Node &value)
{
    const Words words = words_of(place);
    *place = static_cast<Choice>(std::find(words.begin(), words.end(), value.text) - words.begin());
}

// Of a choice or a number.
template <typename Value> std::string plain_text(const Value *value)
{
    if constexpr (std::is_enum_v<Value>) {
        return fmt::format(R"("{}")", words_of(value)[static_cast<std::size_t>(*value)]);
    } else {
        return fmt::format("{}", *value);
    }
}

} // namespace

const char *kind_name(FileKind kind)
{
    switch (kind) {
    case FileKind::motor:
        return "motor";
    case FileKind::board:
        return "board";
    case FileKind::tuning:
        return "tuning";
    case FileKind::scenario:
        return "scenario";
    case FileKind::imperfection:
        break;
    }
    return "imperfection";
}

std::string Field::name() const
{
    return fmt::format("{}.{}", section, key);
}

std::string Field::allowed() const
{
    const std::string range = range_text(min, max, unit);
    return std::visit(Overloaded{
                          [&](const double *) { return std::string(range); },
                          [&](const int *) { return "a whole number, " + range; },
                          [&](const unsigned *) { return "a whole number, " + range; },
                          [&](const bool *) { return std::string("true or false"); },
                          [&](const std::string *) {
                              return max == PIN_CHARS_MAX
                                         ? std::string(R"(a pin, such as "PA0")")
                                         : fmt::format("a string of {} to {} characters", min, max);
                          },
                          [&](const std::array<double, 2> *) { return "[a, b], each " + range; },
                          [&](const std::array<double, 3> *) { return "[a, b, c], each " + range; },
                          [&](const std::vector<double> *) {
                              return fmt::format("[a, b, …], 2 to {} of them, each {}", POINTS_MAX,
                                                 range);
                          },
                          [&](const std::vector<std::string> *) {
                              return std::string(R"(a list of pins, such as ["PA0", "PA1"])");
                          },
                          [&](const auto *choice) { return choice_text(words_of(choice)); },
                      },
                      type_of(*this));
}

std::string Field::meaning() const
{
    const std::string when = acting.when;
    return when.empty() ? help : fmt::format("{}; acts {}", help, when);
}

std::string Field::number_text(const Config &config) const
{
    Config copy = config;
    return std::visit(
        [](const auto *value) -> std::string {
            if constexpr (std::is_arithmetic_v<std::remove_reference_t<decltype(*value)>>) {
                return fmt::format("{}", *value);
            }
            return "";
        },
        target(copy));
}

std::string Field::default_text() const
{
    return required ? "required" : value_text(Config{});
}

std::string Field::value_text(const Config &config) const
{
    Config copy = config;
    return std::visit(Overloaded{
                          [](const std::string *text) { return '"' + readable(*text) + '"'; },
                          [](const std::array<double, 2> *pair) {
                              return fmt::format("[{}, {}]", (*pair)[0], (*pair)[1]);
                          },
                          [](const std::array<double, 3> *phases) {
                              return fmt::format("[{}]", fmt::join(*phases, ", "));
                          },
                          [](const std::vector<double> *points) {
                              return fmt::format("[{}]", fmt::join(*points, ", "));
                          },
                          [](const std::vector<std::string> *pins) {
                              return pins->empty()
                                         ? std::string("[]")
                                         : fmt::format(R"(["{}"])", fmt::join(*pins, R"(", ")"));
                          },
                          [](const auto *other) { return plain_text(other); },
                      },
                      target(copy));
}

const std::vector<Field> &schema()
{
    return FIELDS;
}

const Field *find_field(const std::string &name)
{
    static const auto by_name = [] {
        std::unordered_map<std::string, const Field *> all;
        for (const Field &field : FIELDS) {
            all.emplace(field.name(), &field);
        }
        return all;
    }();
    const auto found = by_name.find(name);
    return found == by_name.end() ? nullptr : found->second;
}

bool may_hold(FileKind kind, const std::string &section)
{
    return std::any_of(SECTIONS.begin(), SECTIONS.end(), [&](const Section &s) {
        return s.name == section && std::count(s.kinds.begin(), s.kinds.end(), kind) != 0;
    });
}

std::vector<std::string> sections_of(FileKind kind)
{
    std::vector<std::string> names;
    for (const Section &section : SECTIONS) {
        if (may_hold(kind, section.name)) {
            names.emplace_back(section.name);
        }
    }
    return names;
}

void refuse_missing(const Origin &place, const std::vector<const Field *> &fields,
                    const std::string &need)
{
    if (fields.size() == 1) {
        fail(place, fields.front()->name(), "", "is missing" + (need.empty() ? need : need + "it"),
             fields.front()->allowed());
    }
    std::vector<std::string> names;
    names.reserve(fields.size());
    for (const Field *field : fields) {
        names.push_back(fmt::format("{} ({})", field->name(), field->allowed()));
    }
    fail(place, fmt::format("{}", fmt::join(names, ", ")), "",
         "are missing" + (need.empty() ? need : need + "them"), "");
}

std::string range_text(double min, double max, const std::string &unit)
{
    return fmt::format("{} to {}{}{}", min, max, unit.empty() ? "" : " ", unit);
}

void check_number(const std::string &key, const Node &value, double min, double max,
                  const std::string &allowed)
{
    std::string problem;
    if (!value.is_number()) {
        problem = std::string("is ") + kind_name(value);
    } else if (!std::isfinite(value.number())) {
        problem = "is not a finite number";
    } else if (value.number() < min) {
        problem = "is too small";
    } else if (value.number() > max) {
        problem = "is too large";
    }
    if (!problem.empty()) {
        fail(value.origin, key, shown(value), problem, allowed);
    }
}

void check_value(const Field &field, const Node &value)
{
    std::visit(Overloaded{
                   [&](const double *) { check_real(field, value); },
                   [&](const int *) { check_whole(field, value); },
                   [&](const unsigned *) { check_whole(field, value); },
                   [&](const bool *) { check_boolean(field, value); },
                   [&](const std::string *) { check_string(field, value); },
                   [&](const std::array<double, 2> *) { check_list(field, value, 2, 2); },
                   [&](const std::array<double, 3> *) { check_list(field, value, 3, 3); },
                   [&](const std::vector<double> *) { check_list(field, value, 2, POINTS_MAX); },
                   [&](const std::vector<std::string> *) { check_pins(field, value); },
                   [&](const auto *choice) { check_choice(field, value, words_of(choice)); },
               },
               type_of(field));
}

void apply_value(const Field &field, const Node &value, Config &config)
{
    std::visit(Overloaded{
                   [&](double *place) { *place = value.number(); },
                   [&](int *place) { *place = static_cast<int>(*value.whole()); },
                   [&](unsigned *place) { *place = static_cast<unsigned>(*value.whole()); },
                   [&](bool *place) { *place = value.boolean; },
                   [&](std::string *place) { *place = value.text; },
                   [&](std::array<double, 2> *place) {
                       *place = {value.items[0].number(), value.items[1].number()};
                   },
                   [&](std::array<double, 3> *place) {
                       *place = {value.items[0].number(), value.items[1].number(),
                                 value.items[2].number()};
                   },
                   [&](std::vector<double> *place) {
                       place->clear();
                       for (const Node &item : value.items) {
                           place->push_back(item.number());
                       }
                   },
                   [&](std::vector<std::string> *place) {
                       place->clear();
                       for (const Node &item : value.items) {
                           place->push_back(item.text);
                       }
                   },
                   [&](auto *place) { choose(place, value); },
               },
               field.target(config));
    config.origins[field.name()] = value.origin;
}

} // namespace nf
