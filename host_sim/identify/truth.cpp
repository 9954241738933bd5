// SPDX-License-Identifier: MIT
#include "truth.h"

#include "legs_fit.h"
#include "machine.h"
#include "numbers.h"

namespace nf::identify
{
namespace
{

// Flux over current of the q axis.
double chord_q_h(const plant_motor_cfg_t &motor, double current_a)
{
    const plant_iron_cfg_t cfg = {motor.inductance_d_h, motor.inductance_q_h,
                                  motor.saturation_a,   motor.saturation_d,
                                  motor.saturation_q,   motor.saturation_shared};
    if (motor.saturation_d <= 0 && motor.saturation_q <= 0) {
        return motor.inductance_q_h;
    }
    plant_iron_t iron{};
    plant_iron_init(&iron, &cfg);
    return plant_iron_flux(&iron, {0, current_a}).q / current_a;
}

} // namespace

Truth truth_of(const Config &config)
{
    const drive_cfg_t drive = build(config);
    const plant_cfg_t plant = make_plant_cfg(config, drive);
    const plant_motor_cfg_t &motor = plant.motor;
    const double period_s = 1 / config.board.pwm_frequency_hz;
    Truth truth;
    truth.resistance_ohm = motor.resistance_ohm;
    truth.inductance_d_h = motor.inductance_d_h;
    truth.inductance_q_h = chord_q_h(motor, continuous_current(config.motor));
    truth.flux_linkage_wb = motor.flux_linkage_wb;
    truth.inertia_kg_m2 = motor.inertia_kg_m2 + motor.load_inertia_kg_m2;
    truth.viscous_friction_nm_s = motor.viscous_friction_nm_s;
    truth.coulomb_friction_nm = motor.coulomb_friction_nm;
    truth.dead_time_s = config.plant.dead_time_s +
                        config.plant.device_drop_v / config.board.bus_nominal_v * period_s;
    truth.current_a = continuous_current(config.motor);
    truth.knee_a = plant.supply.commutation_knee_a;
    return truth;
}

double lost_time_s(double dead_time_s, double knee_a, double current_a)
{
    return knee_a > 0 ? dead_time_s * lost_share(current_a / knee_a) : dead_time_s;
}

} // namespace nf::identify
