// SPDX-License-Identifier: MIT
#include "injection.h"

#include "si.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double ANGLE_PER_DEG = 65536.0 / 360.0; // of the frame
constexpr unsigned PHASE_A = 1;
constexpr unsigned PHASE_B = 2;
constexpr unsigned PHASE_C = 4;

unsigned wires(double value)
{
    return static_cast<unsigned>(std::lround(value));
}

void force(hal_host_channel_t &channel, uint16_t count)
{
    channel = {true, count};
}

} // namespace

Injection::Injection(const Config &config, double period_s, int64_t zero) : board_(config.board)
{
    const auto tick_of = [&](double time_s) {
        return std::max<int64_t>(zero + std::llround(time_s / period_s), 0);
    };
    for (const FaultEntry &entry : config.scenario.faults) {
        add(entry, tick_of(entry.time_s), entry.until_s ? tick_of(*entry.until_s) : NEVER);
    }
}

// Each is there for a tick at least, and what does not last for no more.
void Injection::add(const FaultEntry &entry, int64_t from, int64_t until)
{
    const bool lasts = entry.span == FaultSpan::lasting || entry.until_s;
    faults_.push_back(
        {entry, from, lasts ? std::max(until, from + 1) : from + 1, false, {}, {}, 0, 0});
    next_ = std::min(next_, from);
}

// What is over is forgotten, so that a person may go on for hours.
void Injection::begin(const FaultEntry &entry, int64_t tick)
{
    faults_.erase(
        std::remove_if(faults_.begin(), faults_.end(),
                       [tick](const Fault &fault) { return fault.begun && fault.until < tick; }),
        faults_.end());
    add(entry, tick, NEVER);
}

void Injection::end(FaultKind kind, int64_t tick)
{
    for (Fault &fault : faults_) {
        if (fault.entry.kind == kind && fault.until > tick) {
            fault.until = tick;
            next_ = std::min(next_, tick);
        }
    }
}

uint16_t Injection::count(double value) const
{
    const double largest = std::ldexp(1.0, board_.adc_bits) - 1.0;
    return static_cast<uint16_t>(std::clamp(std::floor(value + 0.5), 0.0, largest));
}

// As an ideal sensor would read it.
uint16_t Injection::current_count(double ampere) const
{
    return count(std::ldexp(1.0 + ampere / board_.current_full_scale_a, board_.adc_bits - 1));
}

uint16_t Injection::bus_count(double volt) const
{
    return count(std::ldexp(volt / board_.bus_full_scale_v, board_.adc_bits));
}

uint16_t Injection::duty_count(const Fault &fault, std::size_t leg)
{
    const std::optional<double> &percent = fault.entry.value;
    return percent ? static_cast<uint16_t>(std::lround(fault.timer_counts * *percent / 100))
                   : fault.last_out.compare.phase[leg];
}

// What happens once.
void Injection::strike(const Fault &fault, const Seam &seam)
{
    const double value = fault.entry.value.value_or(0);
    if (fault.entry.kind == FaultKind::rotor_jump) {
        plant_turn_rotor(&seam.plant, value * RAD_PER_DEG);
    }
    if (fault.entry.kind == FaultKind::config_corrupt) {
        reinterpret_cast<unsigned char *>(&seam.cfg)[static_cast<std::size_t>(value)] ^= 1U;
    }
}

// What the sensor of the shaft tells.
void Injection::impose_on_shaft(const Fault &fault, hal_host_faults_t &hal)
{
    const double value = fault.entry.value.value_or(0);
    switch (fault.entry.kind) {
    case FaultKind::angle_stuck:
        force(hal.angle, fault.last.angle);
        force(hal.shaft, fault.last_shaft);
        break;
    case FaultKind::sensor_high:
        hal.shaft_high = static_cast<uint16_t>(hal.shaft_high | wires(value));
        break;
    case FaultKind::sensor_low:
        hal.shaft_low = static_cast<uint16_t>(hal.shaft_low | wires(value));
        break;
    case FaultKind::sensor_flipped:
        hal.shaft_flip = static_cast<uint16_t>(hal.shaft_flip ^ wires(value));
        break;
    case FaultKind::encoder_slip:
        hal.shaft_slip = static_cast<uint16_t>(hal.shaft_slip + std::lround(value));
        break;
    case FaultKind::angle_offset:
        hal.angle_offset =
            static_cast<uint16_t>(hal.angle_offset + std::lround(value * ANGLE_PER_DEG));
        break;
    default:
        break;
    }
}

// What the drive is told as long as a fault lasts, on top of the faults before it in the list.
void Injection::impose_on_binding(const Fault &fault, hal_host_faults_t &hal) const
{
    const std::optional<double> &value = fault.entry.value;
    const double ampere = value.value_or(0);
    const double beyond_a = 2 * board_.current_full_scale_a;
    switch (fault.entry.kind) {
    case FaultKind::adc_a_stuck:
        force(hal.ia, value ? current_count(ampere) : fault.last.adc_ia);
        break;
    case FaultKind::adc_a_high:
        force(hal.ia, current_count(beyond_a));
        break;
    case FaultKind::adc_a_low:
        force(hal.ia, current_count(-beyond_a));
        break;
    case FaultKind::adc_b_stuck:
        force(hal.ib, value ? current_count(ampere) : fault.last.adc_ib);
        break;
    case FaultKind::adc_b_high:
        force(hal.ib, current_count(beyond_a));
        break;
    case FaultKind::adc_b_low:
        force(hal.ib, current_count(-beyond_a));
        break;
    case FaultKind::adc_bus_stuck:
        force(hal.bus, value ? bus_count(*value) : fault.last.adc_bus);
        break;
    case FaultKind::temperature_high:
        force(hal.temperature, count(std::ldexp(1.0, board_.adc_bits)));
        break;
    case FaultKind::temperature_low:
        force(hal.temperature, 0);
        break;
    case FaultKind::duty_a_stuck:
        force(hal.duty[0], duty_count(fault, 0));
        break;
    case FaultKind::duty_b_stuck:
        force(hal.duty[1], duty_count(fault, 1));
        break;
    case FaultKind::duty_c_stuck:
        force(hal.duty[2], duty_count(fault, 2));
        break;
    case FaultKind::overcurrent:
        force(hal.ia, current_count(ampere));
        force(hal.ib, current_count(-ampere));
        break;
    default:
        hal.broken = hal.broken || fault.entry.kind == FaultKind::break_input;
        hal.late = hal.late || fault.entry.kind == FaultKind::late_isr;
        break;
    }
}

// What is so in the power stage and the motor, likewise.
void Injection::impose_on_plant(const Fault &fault, plant_t &plant, Sensors &sensors)
{
    const double value = fault.entry.value.value_or(0);
    switch (fault.entry.kind) {
    case FaultKind::phase_a_open:
        plant_break_phases(&plant, plant.broken | PHASE_A);
        break;
    case FaultKind::phase_b_open:
        plant_break_phases(&plant, plant.broken | PHASE_B);
        break;
    case FaultKind::phase_c_open:
        plant_break_phases(&plant, plant.broken | PHASE_C);
        break;
    case FaultKind::bus_voltage:
        plant_set_supply(&plant, value);
        break;
    case FaultKind::temperature:
        plant_set_temperature(&plant, value);
        break;
    case FaultKind::adc_a_gain:
        sensors.current[0] = value;
        break;
    case FaultKind::adc_b_gain:
        sensors.current[1] = value;
        break;
    case FaultKind::adc_c_gain:
        sensors.current[2] = value;
        break;
    case FaultKind::adc_all_gain:
        sensors.current.fill(value);
        break;
    case FaultKind::adc_bus_gain:
        sensors.bus = value;
        break;
    case FaultKind::clock:
        plant_set_clock(&plant, value);
        break;
    case FaultKind::rotor_blocked:
        plant_block_rotor(&plant, true);
        break;
    default:
        break;
    }
}

// All that lasts, from a healthy state anew.
void Injection::impose(int64_t tick, const Seam &seam)
{
    binding_ = {};
    plant_break_phases(&seam.plant, 0);
    plant_set_supply(&seam.plant, board_.bus_nominal_v);
    plant_set_temperature(&seam.plant, PLANT_AMBIENT_C);
    plant_block_rotor(&seam.plant, false);
    plant_set_clock(&seam.plant, 1);
    Sensors sensors;
    for (const Fault &fault : faults_) {
        if (fault.begun && tick < fault.until) {
            impose_on_binding(fault, binding_);
            impose_on_shaft(fault, binding_);
            impose_on_plant(fault, seam.plant, sensors);
        }
    }
    plant_scale_sensors(&seam.plant, sensors.current.data(), sensors.bus);
    seam.hal = binding_;
}

void Injection::change(int64_t tick, Simulation &sim)
{
    const Seam seam = sim.seam();
    next_ = NEVER;
    for (Fault &fault : faults_) {
        if (!fault.begun && tick >= fault.from) {
            fault.begun = true;
            fault.last = sim.in();
            fault.last_out = sim.out();
            fault.last_shaft = sim.hal().seen_shaft.reading;
            fault.timer_counts = seam.plant.inverter.timer_counts;
            strike(fault, seam);
        }
        const int64_t coming = fault.begun ? fault.until : fault.from;
        if (coming > tick) {
            next_ = std::min(next_, coming);
        }
    }
    impose(tick, seam);
}

} // namespace nf
