// SPDX-License-Identifier: MIT
#include "machine.h"

#include "g4_shaft.h"
#include "si.h"

#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double DEG_PER_TURN = 360;
constexpr int COGGING_IN_TURN_EL = 6; // of a slot for each pole and phase

// Two masses on a spring: w² = k·(1/J_M + 1/J_L), damping ratio D = d/(2·w)·(1/J_M + 1/J_L). Both
// are of the inertia in cfg.
void share_inertia(plant_motor_cfg_t &cfg, const PlantSettings &real)
{
    const double w = 2.0 * PI * real.shaft_resonance_hz;
    const double all = cfg.inertia_kg_m2;
    cfg.inertia_kg_m2 = all / (1.0 + real.load_inertia_ratio);
    cfg.load_inertia_kg_m2 = all - cfg.inertia_kg_m2;
    const double reduced = cfg.inertia_kg_m2 * cfg.load_inertia_kg_m2 / all;
    cfg.shaft_stiffness_nm = reduced * w * w;
    cfg.shaft_damping_nm_s = 2.0 * real.shaft_damping_pct / 100.0 * reduced * w;
}

int pole_pairs(const Config &config)
{
    return config.plant.pole_pairs > 0 ? config.plant.pole_pairs : config.motor.pole_pairs;
}

plant_motor_cfg_t make_plant_motor(const Config &config)
{
    const MotorSettings &motor = config.motor;
    const PlantSettings &real = config.plant;
    plant_motor_cfg_t cfg{};
    cfg.pole_pairs = static_cast<unsigned>(pole_pairs(config));
    cfg.resistance_ohm = motor.resistance_ohm * real.resistance_scale;
    cfg.inductance_d_h = motor.inductance_d_h * real.inductance_scale;
    cfg.inductance_q_h = motor.inductance_q_h * real.inductance_scale * real.saliency_scale;
    cfg.flux_linkage_wb = motor.flux_linkage_wb * real.flux_scale;
    cfg.inertia_kg_m2 = motor.inertia_kg_m2 * real.inertia_scale;
    cfg.viscous_friction_nm_s = motor.viscous_friction_nm_s;
    cfg.coulomb_friction_nm = real.coulomb_friction_nm;
    cfg.emf_5th = real.emf_5th_pct / 100.0;
    cfg.emf_7th = real.emf_7th_pct / 100.0;
    cfg.saturation_d = real.saturation_d_pct / 100.0;
    cfg.saturation_q = real.saturation_q_pct / 100.0;
    cfg.saturation_shared = real.saturation_cross_pct / 100.0;
    cfg.saturation_a = motor.rated_torque_nm / (1.5 * pole_pairs(config) * motor.flux_linkage_wb);
    cfg.cogging_nm = real.cogging_pct / 100.0 * motor.rated_torque_nm;
    cfg.cogging_order = static_cast<unsigned>(
        real.cogging_order > 0 ? real.cogging_order : COGGING_IN_TURN_EL * pole_pairs(config));
    for (std::size_t phase = 0; phase < real.contact_ohm.size(); phase++) {
        cfg.shorted[phase] = real.shorted_turns_pct[phase] / 100.0;
        cfg.contact_ohm[phase] = real.contact_ohm[phase];
    }
    if (real.shaft_resonance_hz > 0) {
        share_inertia(cfg, real);
    }
    cfg.initial_angle_el_rad = config.scenario.initial_angle_el_deg * RAD_PER_DEG;
    cfg.initial_speed_mech_rad_s = config.scenario.initial_speed_rpm * RAD_S_PER_RPM;
    return cfg;
}

plant_sensor_cfg_t make_plant_sensor(const Config &config)
{
    const BoardSettings &board = config.board;
    const PlantSettings &real = config.plant;
    plant_sensor_cfg_t cfg{};
    cfg.adc_bits = static_cast<unsigned>(board.adc_bits);
    cfg.current_full_scale_a = board.current_full_scale_a;
    cfg.bus_full_scale_v = board.bus_full_scale_v;
    cfg.noise_lsb_rms = real.adc_noise_lsb;
    cfg.current_bandwidth_hz = real.sensor_bandwidth_hz;
    for (std::size_t phase = 0; phase < real.adc_offset_lsb.size(); phase++) {
        cfg.offset_lsb[phase] = real.adc_offset_lsb[phase];
        cfg.drift_lsb_s[phase] = real.adc_drift_lsb_s[phase];
        cfg.gain_error[phase] = real.adc_gain_error_pct[phase] / 100.0;
    }
    cfg.measures_c = board.current_sensors == PLANT_LEGS;
    cfg.gain_error[2] = real.adc_third_gain_error_pct / 100.0;
    cfg.temperature_points = static_cast<unsigned>(board.temperature_points_c.size());
    for (std::size_t k = 0; k < board.temperature_points_c.size(); k++) {
        cfg.temperature[k] = {board.temperature_points_c[k], board.temperature_points_pct[k] / 100};
    }
    cfg.angle_counts = static_cast<unsigned>(real.angle_counts);
    cfg.seed = config.scenario.seed;
    return cfg;
}

// As the motor file says, each Hall edge a little ahead.
plant_shaft_cfg_t make_plant_shaft(const Config &config)
{
    const SensorSettings &sensor = config.motor.sensor;
    plant_shaft_cfg_t cfg{};
    switch (sensor.kind) {
    case SensorKind::none:
        cfg.kind = PLANT_SHAFT_NONE;
        break;
    case SensorKind::hall:
        cfg.kind = PLANT_SHAFT_HALL;
        break;
    case SensorKind::absolute:
        cfg.kind = PLANT_SHAFT_ABSOLUTE;
        break;
    default:
        cfg.kind = PLANT_SHAFT_ENCODER;
        break;
    }
    cfg.reversed = sensor.reversed;
    cfg.counts = static_cast<uint32_t>(4 * sensor.lines);
    cfg.zero_turns = sensor.offset_deg / DEG_PER_TURN;
    cfg.pole_pairs = static_cast<unsigned>(pole_pairs(config));
    cfg.timed = config.hal.hall_pins.empty() || g4_hall_timer(config.hal) > 0;
    for (std::size_t k = 0; k < PLANT_HALL_SECTORS; k++) {
        cfg.patterns[k] = static_cast<uint8_t>(sensor.hall_patterns.at(k));
        cfg.edges_turns[k] =
            (sensor.hall_edges_deg.at(k) + config.plant.hall_error_deg.at(k)) / DEG_PER_TURN;
    }
    return cfg;
}

// The phase at each terminal, as the word says it.
void connect(plant_cfg_t &cfg, Wires wires)
{
    static const unsigned PHASES[][PLANT_LEGS] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                                  {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (std::size_t leg = 0; leg < PLANT_LEGS; leg++) {
        cfg.wire[leg] = (PHASES[static_cast<std::size_t>(wires)][leg] + PLANT_LEGS -
                         static_cast<unsigned>(leg)) %
                        PLANT_LEGS;
    }
}

void check_cross(const Config &config, const plant_motor_cfg_t &cfg)
{
    const char *const key = "plant.saturation_cross_pct";
    const double most = plant_motor_shared_max(&cfg);
    if (cfg.saturation_shared > most) {
        fail(
            config.origins.at(key), key, fmt::format("{}", config.plant.saturation_cross_pct),
            "makes L_q infinite for some i_d < 0, with plant.saturation_d_pct, saturation_q_pct and "
            "this L_d/L_q",
            fmt::format("0 to {:.0f} %", std::floor(100.0 * most)));
    }
}

void check_knee(const Config &config, const plant_cfg_t &cfg)
{
    const char *const key = "plant.commutation_knee_a";
    const double knee = cfg.supply.commutation_knee_a;
    const double least = plant_least_knee(&cfg);
    if (knee > 0 && knee < least) {
        fail(config.origins.at(key), key, fmt::format("{}", knee),
             "is too small to be followed with this dead time, drop and inductance",
             fmt::format("0, or at least {:.2g} A", 1.05 * least));
    }
}

} // namespace

plant_cfg_t make_plant_cfg(const Config &config, const drive_cfg_t &drive)
{
    plant_cfg_t cfg{};
    cfg.motor = make_plant_motor(config);
    cfg.inverter.pwm_frequency_hz = config.board.pwm_frequency_hz;
    cfg.inverter.timer_counts = static_cast<uint32_t>(drive.modulator.timer_counts);
    cfg.inverter.dead_time_s = config.plant.dead_time_s;
    cfg.supply.voltage_v = config.board.bus_nominal_v;
    cfg.supply.ripple_fraction = config.plant.bus_ripple_pct / 100.0;
    cfg.supply.ripple_hz = config.plant.bus_ripple_hz;
    cfg.supply.device_drop_v = config.plant.device_drop_v;
    cfg.supply.commutation_knee_a = config.plant.commutation_knee_a;
    cfg.supply.capacitance_f = config.plant.bus_capacitance_f;
    cfg.supply.resistance_ohm = config.plant.bus_source_resistance_ohm;
    cfg.sensor = make_plant_sensor(config);
    cfg.shaft = make_plant_shaft(config);
    cfg.trip_a = config.board.trip_a;
    const double rated_rad_s = config.motor.rated_speed_rpm * RAD_S_PER_RPM;
    cfg.fan_nm_s2 = config.plant.fan_torque_nm / (rated_rad_s * rated_rad_s);
    connect(cfg, config.plant.wires);
    check_cross(config, cfg.motor);
    check_knee(config, cfg);
    return cfg;
}

} // namespace nf
