// SPDX-License-Identifier: MIT
#include "truth.h"

#include "legs_fit.h"
#include "machine.h"
#include "modulator_units.h"
#include "motor_model.h"

#include <cmath>
#include <limits>

namespace nf::identify
{
namespace
{

bool saturates(const plant_iron_cfg_t &iron)
{
    return iron.fall_d > 0 || iron.fall_q > 0;
}

double mean_of(const double (&of_phases)[PLANT_LEGS])
{
    return (of_phases[0] + of_phases[1] + of_phases[2]) / 3;
}

// What is left of the turns of three windings (windings.h), over all directions of a vector: as in
// EMF and R, and as in L.
struct Turns {
    double mean;
    double mean_square;
};

Turns turns_of(const double (&shorted)[PLANT_LEGS])
{
    const double mean = 1 - mean_of(shorted);
    double squares = 0;
    for (const double share : shorted) {
        squares += std::pow(1 - share - mean, 2);
    }
    return {mean, mean * mean + squares / 6};
}

std::array<double, 8> halls_of(const Config &config)
{
    std::array<double, 8> begins;
    begins.fill(std::numeric_limits<double>::quiet_NaN());
    const SensorSettings &sensor = config.motor.sensor;
    for (std::size_t k = 0; k < sensor.hall_patterns.size(); k++) {
        const double deg = sensor.hall_edges_deg.at(k) + config.plant.hall_error_deg.at(k);
        begins.at(static_cast<std::size_t>(sensor.hall_patterns[k])) =
            deg - 360 * std::floor(deg / 360);
    }
    return begins;
}

// What a converter adds to the noise: its error is as likely anywhere within a count.
double with_count(double noise_lsb)
{
    return std::sqrt(noise_lsb * noise_lsb + 1.0 / 12);
}

} // namespace

double inductance_d_h(const Truth &truth, double current_a)
{
    if (!saturates(truth.iron)) {
        return truth.inductance_d_h;
    }
    plant_iron_t iron{};
    plant_iron_init(&iron, &truth.iron);
    return 1 / plant_iron_stiffness(&iron, plant_iron_flux(&iron, {current_a, 0})).straight.d;
}

double inductance_q_h(const Truth &truth, double current_a)
{
    if (!saturates(truth.iron)) {
        return truth.iron.inductance_q_h;
    }
    plant_iron_t iron{};
    plant_iron_init(&iron, &truth.iron);
    return plant_iron_flux(&iron, {0, current_a}).q / current_a;
}

Truth truth_of(const Config &config)
{
    const drive_cfg_t drive = build(config);
    const plant_cfg_t plant = make_plant_cfg(config, drive);
    const plant_motor_cfg_t &motor = plant.motor;
    const double period_s = 1 / config.board.pwm_frequency_hz;
    const Turns turns = turns_of(motor.shorted);
    Truth truth;
    truth.resistance_ohm = motor.resistance_ohm * turns.mean + mean_of(motor.contact_ohm);
    truth.inductance_d_h = motor.inductance_d_h * turns.mean_square;
    truth.flux_linkage_wb = motor.flux_linkage_wb * turns.mean;
    truth.inertia_kg_m2 = motor.inertia_kg_m2 + motor.load_inertia_kg_m2;
    truth.viscous_friction_nm_s = motor.viscous_friction_nm_s;
    truth.coulomb_friction_nm = motor.coulomb_friction_nm;
    truth.dead_time_s = config.plant.dead_time_s +
                        config.plant.device_drop_v / config.board.bus_nominal_v * period_s;
    truth.current_a = continuous_current(config.motor);
    truth.iron = {truth.inductance_d_h, motor.inductance_q_h * turns.mean_square,
                  motor.saturation_a,   motor.saturation_d,
                  motor.saturation_q,   motor.saturation_shared};
    truth.inductance_q_h = inductance_q_h(truth, truth.current_a);
    const auto &gain_pct = config.plant.adc_gain_error_pct;
    truth.gain_mismatch_pct =
        IN_PER_CENT * ((IN_PER_CENT + gain_pct[0]) / (IN_PER_CENT + gain_pct[1]) - 1);
    truth.current_noise_lsb = with_count(config.plant.adc_noise_lsb);
    truth.knee_a = plant.supply.commutation_knee_a;
    truth.halls_deg = halls_of(config);
    return truth;
}

double lost_time_s(double dead_time_s, double knee_a, double current_a)
{
    return knee_a > 0 ? dead_time_s * lost_share(current_a / knee_a) : dead_time_s;
}

} // namespace nf::identify
