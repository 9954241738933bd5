/* SPDX-License-Identifier: MIT */
// Where a key acts: some do only together with another one.
#pragma once

namespace nf
{

struct Config;

// Of a complete configuration, see load_scenario().
struct Acting {
    const char *when = ""; // "only …", for a person; "": everywhere
    bool (*in)(const Config &config) = nullptr;
    bool is_record = false; // somebody's finding, kept for a reader: nothing has to follow from it

    bool holds(const Config &config) const
    {
        return in == nullptr || in(config);
    }
};

bool has_observer(const Config &config);
bool has_startup(const Config &config);
bool has_handover(const Config &config);
bool has_dead_time(const Config &config);
bool has_voltage_drive(const Config &config);
bool has_no_voltage_drive(const Config &config);
bool has_voltage_speed(const Config &config);
bool has_saliency(const Config &config);
bool has_notch(const Config &config);
bool has_oscillation(const Config &config);
bool has_input(const Config &config);
bool has_voltage_input(const Config &config);
bool has_pulse_input(const Config &config);
bool has_angle_sensor(const Config &config);
bool has_both(const Config &config);
bool has_ideal_sensor(const Config &config);
bool has_hall(const Config &config);
bool has_absolute(const Config &config);
bool has_encoder(const Config &config);
bool has_counting_sensor(const Config &config);
bool has_noise(const Config &config);
bool has_ripple(const Config &config);
bool has_two_saturations(const Config &config);
bool has_cogging(const Config &config);
bool has_elastic_shaft(const Config &config);
bool has_leg_loss(const Config &config);
bool has_capacitor(const Config &config);
bool has_load(const Config &config);
bool has_low_side_shunts(const Config &config);
bool has_no_model_dead_time(const Config &config);
bool has_measured_dead_time(const Config &config);
bool has_no_measured_knee(const Config &config);

constexpr Acting WITH_OBSERVER = {"only with drive.angle_source other than \"sensor\"",
                                  has_observer};
constexpr Acting WITH_STARTUP = {
    "only with drive.angle_source other than \"sensor\" and startup.current_pct above 0",
    has_startup};
constexpr Acting WITH_HANDOVER = {
    "only with a start-up, observer.rho_max above 0 or a voltage drive that it keeps from starting",
    has_handover};
constexpr Acting WITH_DEAD_TIME = {
    "only with model.dead_time_s or model.device_drop_v above 0, each by default that of the board",
    has_dead_time};
constexpr Acting WITH_VOLTAGE_DRIVE = {"only with drive.method = \"voltage_phase\"",
                                       has_voltage_drive};
constexpr Acting WITHOUT_VOLTAGE_DRIVE = {"only with drive.method = \"current\"",
                                          has_no_voltage_drive};
constexpr Acting WITH_VOLTAGE_SPEED = {"only with drive.method = \"voltage_phase\" and from 1.5 "
                                       "times startup.handover_speed_pct on",
                                       has_voltage_speed};
constexpr Acting WITH_SALIENCY = {
    "only with drive.method = \"current\", and motor.inductance_q_h above motor.inductance_d_h or a start that measures it, "
    "adaptation.saliency_pct above 0",
    has_saliency};
constexpr Acting WITH_NOTCH = {"only with speed_loop.notch_hz above 0", has_notch};
constexpr Acting WITH_OSCILLATION = {"only with supervision.oscillation other than \"off\"",
                                     has_oscillation};
constexpr Acting WITH_INPUT = {"only with input.kind other than \"none\"", has_input};
constexpr Acting WITH_VOLTAGE_INPUT = {"only with input.kind = \"voltage\"", has_voltage_input};
constexpr Acting WITH_PULSE_INPUT = {"only with input.kind = \"rc_pulse\"", has_pulse_input};
constexpr Acting WITH_ANGLE_SENSOR = {"only with drive.angle_source other than \"observer\"",
                                      has_angle_sensor};
constexpr Acting WITH_BOTH = {"only with drive.angle_source = \"both\"", has_both};
constexpr Acting WITH_IDEAL_SENSOR = {
    "only with drive.angle_source other than \"observer\" and sensor.kind = \"none\"",
    has_ideal_sensor};
constexpr Acting WITH_HALL = {"only with a sensor of sensor.kind = \"hall\" that is used",
                              has_hall};
constexpr Acting WITH_ABSOLUTE = {"only with a sensor of sensor.kind = \"absolute\" that is used",
                                  has_absolute};
constexpr Acting WITH_ENCODER = {"only with an encoder in sensor.kind that is used", has_encoder};
constexpr Acting WITH_COUNTING_SENSOR = {
    "only with an encoder or an absolute sensor in sensor.kind that is used", has_counting_sensor};
constexpr Acting WITH_NOISE = {"only with plant.adc_noise_lsb above 0", has_noise};
constexpr Acting WITH_RIPPLE = {"only with plant.bus_ripple_pct above 0", has_ripple};
constexpr Acting WITH_TWO_SATURATIONS = {
    "only with plant.saturation_d_pct and plant.saturation_q_pct above 0", has_two_saturations};
constexpr Acting WITH_COGGING = {"only with plant.cogging_pct above 0", has_cogging};
constexpr Acting WITH_ELASTIC_SHAFT = {"only with plant.shaft_resonance_hz above 0",
                                       has_elastic_shaft};
constexpr Acting WITH_LEG_LOSS = {
    "only with plant.dead_time_s or plant.device_drop_v above 0, each by default that of the board",
    has_leg_loss};
constexpr Acting WITH_CAPACITOR = {"only with plant.bus_capacitance_f above 0", has_capacitor};
constexpr Acting WITH_LOAD = {"only with a load other than 0", has_load};
constexpr Acting WITH_LOW_SIDE_SHUNTS = {"only with hal.current_position = \"low_side\"",
                                         has_low_side_shunts};

constexpr Acting RECORD = {"", nullptr, true};
constexpr Acting WITHOUT_MODEL_DEAD_TIME = {"only without model.dead_time_s",
                                            has_no_model_dead_time};
constexpr Acting WITH_MEASURED_DEAD_TIME = {
    "only with measured.dead_time_s above 0 and without model.output_capacitance_f",
    has_measured_dead_time};
constexpr Acting WITHOUT_MEASURED_KNEE = {
    "only without a measured.knee_a beside measured.dead_time_s above 0", has_no_measured_knee};

} // namespace nf
