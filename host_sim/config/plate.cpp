// SPDX-License-Identifier: MIT
#include "plate.h"

#include "motor_model.h"
#include "numbers.h"
#include "schema.h"
#include "specimen.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Within what the zoo draws: host_sim/zoo/specimen.cpp.
constexpr double EMF_SHARE = 0.6; // at the highest speed, of bus/√3
constexpr double REACTANCE = 0.13;
constexpr double ACCELERATION_S = 0.1;
constexpr double FRICTION = 0.02;
constexpr double RESISTANCE_HELD =
    1.999; // of bus over current full scale: the firmware holds 2, per_unit.cpp

double within_range(const char *key, double value)
{
    const Field &field = *find_field(key);
    return std::clamp(value, field.min, field.max);
}

} // namespace

const std::vector<std::string> &unknown_of_plate()
{
    static const std::vector<std::string> keys = {
        "motor.resistance_ohm",  "motor.inductance_d_h",       "motor.inductance_q_h",
        "motor.flux_linkage_wb", "motor.rated_torque_nm",      "motor.rated_speed_rpm",
        "motor.inertia_kg_m2",   "motor.viscous_friction_nm_s"};
    return keys;
}

bool is_plate(const MotorSettings &motor)
{
    Config config;
    config.motor = motor;
    const std::vector<std::string> &unknown = unknown_of_plate();
    // the friction, the last of them, is 0 in some complete files too
    return std::all_of(unknown.begin(), unknown.end() - 1, [&](const std::string &key) {
        return *std::get<double *>(find_field(key)->target(config)) <= 0;
    });
}

MotorSettings plate_of(const MotorSettings &motor)
{
    MotorSettings plate;
    plate.name = motor.name;
    plate.pole_pairs = motor.pole_pairs;
    plate.max_speed_rpm = motor.max_speed_rpm;
    plate.max_current_a = motor.max_current_a;
    plate.continuous_current_a = is_plate(motor)
                                     ? std::min(motor.continuous_current_a, motor.max_current_a)
                                     : continuous_current(motor);
    plate.thermal_time_constant_s = motor.thermal_time_constant_s;
    plate.sensor = motor.sensor;
    return plate;
}

MotorSettings typical(const MotorSettings &plate, const BoardSettings &board)
{
    const double speed_mech = rad_s_from_rpm(plate.max_speed_rpm);
    const double speed_el = speed_mech * plate.pole_pairs;
    const double current_a = plate.continuous_current_a;
    MotorSettings motor = plate;
    motor.rated_speed_rpm = plate.max_speed_rpm;
    motor.flux_linkage_wb = within_range("motor.flux_linkage_wb", EMF_SHARE * board.bus_nominal_v /
                                                                      std::sqrt(3.0) / speed_el);
    const double emf_v = motor.flux_linkage_wb * speed_el;
    const double copper_loss = zoo::usual_copper_loss(1.5 * emf_v * current_a);
    const double held_ohm = RESISTANCE_HELD * board.bus_full_scale_v / board.current_full_scale_a;
    motor.resistance_ohm =
        within_range("motor.resistance_ohm", std::min(copper_loss * emf_v / current_a, held_ohm));
    motor.inductance_d_h =
        within_range("motor.inductance_d_h", REACTANCE * emf_v / (speed_el * current_a));
    motor.inductance_q_h = motor.inductance_d_h;
    motor.rated_torque_nm = within_range(
        "motor.rated_torque_nm", 1.5 * plate.pole_pairs * motor.flux_linkage_wb * current_a);
    motor.inertia_kg_m2 =
        within_range("motor.inertia_kg_m2", motor.rated_torque_nm * ACCELERATION_S / speed_mech);
    motor.viscous_friction_nm_s =
        within_range("motor.viscous_friction_nm_s", FRICTION * motor.rated_torque_nm / speed_mech);
    return motor;
}

Config known_from_plate(const Config &config)
{
    Config plate = config;
    plate.motor = plate_of(config.motor);
    plate.model.resistance = 1;
    plate.model.inductance = 1;
    plate.model.flux = 1;
    plate.model.inertia = 1;
    return plate;
}

Config with_typical(const Config &plate)
{
    Config config = plate;
    config.motor = typical(plate.motor, plate.board);
    if (config.motor.sensor.kind == SensorKind::hall &&
        config.tuning.angle_source == AngleSource::observer) {
        // so that the drive reads it; both sources take a start-up
        config.tuning.angle_source =
            config.tuning.startup_current_pct > 0 ? AngleSource::both : AngleSource::sensor;
    }
    // Whoever wrote a line of the plate is rather to blame than who assumed a value.
    const Origin assumed = {plate.origins.at("motor.name").file + " (typical value)", 0,
                            Author::tuning};
    for (const std::string &key : unknown_of_plate()) {
        config.origins[key] = assumed;
    }
    return config;
}

} // namespace nf
