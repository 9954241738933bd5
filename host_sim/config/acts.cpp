// SPDX-License-Identifier: MIT
#include "acts.h"

#include "configuration.h"
#include "voltage_drive_units.h"

#include <algorithm>
#include <vector>

namespace nf
{

bool has_observer(const Config &config)
{
    return config.tuning.angle_source != AngleSource::sensor;
}

bool has_startup(const Config &config)
{
    return has_observer(config) && config.tuning.startup_current_pct > 0;
}

bool has_handover(const Config &config)
{
    return has_startup(config) || config.tuning.observer_rho_max > 0 ||
           (has_voltage_drive(config) && !has_voltage_speed(config));
}

bool has_dead_time(const Config &config)
{
    return config.model.dead_time_s > 0 || config.model.device_drop_v > 0;
}

bool has_voltage_drive(const Config &config)
{
    return config.tuning.method == ControlMethod::voltage_phase;
}

bool has_no_voltage_drive(const Config &config)
{
    return !has_voltage_drive(config);
}

bool has_voltage_speed(const Config &config)
{
    return has_voltage_drive(config) &&
           config.tuning.voltage_speed_pct >= ABOVE_HANDOVER * config.tuning.handover_speed_pct;
}

// Of the file, or of what a start measures.
bool has_saliency(const Config &config)
{
    const bool written = config.motor.inductance_q_h > config.motor.inductance_d_h;
    const bool measured = has_startup(config) && config.tuning.adapt_saliency_pct > 0;
    return (written || measured) && !has_voltage_drive(config);
}

bool has_notch(const Config &config)
{
    return config.tuning.notch_hz > 0;
}

bool has_input(const Config &config)
{
    return config.tuning.input.kind != InputKind::none;
}

bool has_voltage_input(const Config &config)
{
    return config.tuning.input.kind == InputKind::voltage;
}

bool has_pulse_input(const Config &config)
{
    return config.tuning.input.kind == InputKind::rc_pulse;
}

bool has_oscillation(const Config &config)
{
    return config.tuning.oscillation != OscillationAct::off;
}

bool has_angle_sensor(const Config &config)
{
    return config.tuning.angle_source != AngleSource::observer;
}

bool has_both(const Config &config)
{
    return config.tuning.angle_source == AngleSource::both;
}

bool has_ideal_sensor(const Config &config)
{
    return has_angle_sensor(config) && config.motor.sensor.kind == SensorKind::none;
}

bool has_hall(const Config &config)
{
    return has_angle_sensor(config) && config.motor.sensor.kind == SensorKind::hall;
}

bool has_absolute(const Config &config)
{
    return has_angle_sensor(config) && config.motor.sensor.kind == SensorKind::absolute;
}

bool has_encoder(const Config &config)
{
    const SensorKind kind = config.motor.sensor.kind;
    return has_angle_sensor(config) &&
           (kind == SensorKind::encoder || kind == SensorKind::encoder_index);
}

bool has_counting_sensor(const Config &config)
{
    return has_encoder(config) || has_absolute(config);
}

bool has_noise(const Config &config)
{
    return config.plant.adc_noise_lsb > 0;
}

bool has_ripple(const Config &config)
{
    return config.plant.bus_ripple_pct > 0;
}

bool has_two_saturations(const Config &config)
{
    return config.plant.saturation_d_pct > 0 && config.plant.saturation_q_pct > 0;
}

bool has_cogging(const Config &config)
{
    return config.plant.cogging_pct > 0;
}

bool has_elastic_shaft(const Config &config)
{
    return config.plant.shaft_resonance_hz > 0;
}

bool has_leg_loss(const Config &config)
{
    return config.plant.dead_time_s > 0 || config.plant.device_drop_v > 0;
}

bool has_capacitor(const Config &config)
{
    return config.plant.bus_capacitance_f > 0;
}

bool has_low_side_shunts(const Config &config)
{
    return config.hal.current_position == CurrentPosition::low_side;
}

bool has_load(const Config &config)
{
    const std::vector<TimedValue> &load = config.scenario.load;
    return std::any_of(load.begin(), load.end(),
                       [](const TimedValue &step) { return step.value != 0; });
}

bool has_no_model_dead_time(const Config &config)
{
    return config.origins.count("model.dead_time_s") == 0;
}

bool has_measured_dead_time(const Config &config)
{
    return config.measured.dead_time_s > 0 &&
           config.origins.count("model.output_capacitance_f") == 0;
}

bool has_no_measured_knee(const Config &config)
{
    return config.measured.dead_time_s <= 0 || config.measured.knee_a < 0;
}

} // namespace nf
