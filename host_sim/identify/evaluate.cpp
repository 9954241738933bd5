// SPDX-License-Identifier: MIT
#include "evaluate.h"

#include "bars.h"
#include "modulator_units.h"
#include "motor_model.h"
#include "phases.h"
#include "pulse_model.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf::identify
{
namespace
{

constexpr double SCALE_OFF = 1e-3; // the files' scales and the records' are those of one board
// The mean change of a sensor from sample to sample is 2/√π of its standard deviation.
constexpr double CHANGE_TO_SIGMA = 0.88622692545275801365;
constexpr double KNEE_SEEN = 1e-3; // of the continuous current: a smaller one is none
// Of the noise: a converter's steps are no noise of their own where it is small, and the ripple
// adds to it.
constexpr double NOISE_UNSURE_LSB = 0.05;
constexpr double NOISE_UNSURE = 0.03;
constexpr double ROUNDING_NOISE_LSB = 0.28867513459481288225; // 1/√12, of a staircase
// Of what the correction of a low pass of the sensors changes.
constexpr double CORRECTION_UNSURE = 0.5;
constexpr double LOAD_RATIO_MOST =
    30; // over the rotor, of a load on a shaft; a heavier one swings in the ramps
constexpr double GAINS_ALIKE = 0.025; // of two sensors of 1 % each, and what their resistors add
constexpr double BUS_USED = 0.9;      // of the voltage circle, at the rated speed

void check_scale(const char *what, double file, double record)
{
    if (std::abs(file - record) > SCALE_OFF * file) {
        throw ConfigError(fmt::format("the records are of another board or motor: {} is {:.4g} in "
                                      "the files and {:.4g} in the records",
                                      what, file, record));
    }
}

void check_scales(const Scales &scales, const Config &plate)
{
    check_scale("the current's full scale, A,", plate.board.current_full_scale_a,
                scales.current_a / 2);
    check_scale("the bus's full scale, V,", plate.board.bus_full_scale_v, scales.voltage_v);
    check_scale("the PWM period, s,", 1 / plate.board.pwm_frequency_hz, scales.period_s);
    check_scale("the number of pole pairs", plate.motor.pole_pairs, scales.pole_pairs);
}

double pct(double part, double whole)
{
    return whole != 0 ? IN_PER_CENT * part / std::abs(whole) : 0;
}

// 1.5·P²·φ²/J: over L the square of the frequency with which the rotor swings against a current
// that it induces.
double rotor_h_s2(const Flux &flux, const Shaft &shaft, int pole_pairs)
{
    return 1.5 * pole_pairs * pole_pairs * flux.wb.value * flux.wb.value /
           shaft.inertia_kg_m2.value;
}

// Where EMF and R·i take what the bus leaves them, at most the highest speed; a round number.
double rated_speed_rpm(const MotorSettings &motor, const Config &plate, double current_a)
{
    const double circle = BUS_USED * largest_ratio(plate.board) * plate.board.bus_nominal_v;
    const double left = std::max(circle - motor.resistance_ohm * current_a, 0.1 * circle);
    const double x = motor.inductance_q_h * current_a / motor.flux_linkage_wb;
    const double rpm =
        left / (motor.flux_linkage_wb * std::hypot(1, x)) / motor.pole_pairs / RAD_S_PER_RPM;
    const double place = std::pow(10, std::floor(std::log10(rpm)) - 2);
    return std::min(std::floor(rpm / place) * place, motor.max_speed_rpm);
}

// The EMF at the highest speed has to leave the bus its margin, whatever φ is within its bar.
void bound_max_speed(MotorSettings &motor, const Config &plate, double flux_wb,
                     std::vector<std::string> &remarks)
{
    const double left_v = largest_ratio(plate.board) * plate.board.bus_nominal_v;
    const double rpm = left_v / flux_wb / motor.pole_pairs / RAD_S_PER_RPM;
    if (rpm < motor.max_speed_rpm) {
        remarks.push_back(fmt::format(
            "max_speed_rpm is lowered from {:g} to {:.0f}: above it the EMF exceeds the bus voltage",
            motor.max_speed_rpm, std::floor(rpm)));
        motor.max_speed_rpm = std::floor(rpm);
    }
}

void fill_motor(MotorSettings &motor, const Legs &legs, const Inductances &l, const Flux &flux,
                const Shaft &shaft)
{
    motor.resistance_ohm = legs.resistance_ohm.value;
    motor.inductance_d_h = l.d_h.value;
    motor.inductance_q_h = l.q_h.value;
    motor.flux_linkage_wb = flux.wb.value;
    motor.inertia_kg_m2 = shaft.inertia_kg_m2.value;
    motor.viscous_friction_nm_s = shaft.viscous_nm_s.value;
}

double bar_of(const Value &value)
{
    return error_bar(value.std, value.bound);
}

void fill_bars(MeasuredSettings &m, const Legs &legs, const Inductances &l, const Flux &flux,
               const Shaft &shaft, double current_a)
{
    const auto fill = [](const Value &value, double &std_pct, double &bound_pct) {
        std_pct = pct(value.std, value.value);
        bound_pct = pct(value.bound, value.value);
    };
    fill(legs.resistance_ohm, m.resistance_std_pct, m.resistance_bound_pct);
    fill(l.d_h, m.inductance_d_std_pct, m.inductance_d_bound_pct);
    fill(l.q_h, m.inductance_q_std_pct, m.inductance_q_bound_pct);
    fill(flux.wb, m.flux_linkage_std_pct, m.flux_linkage_bound_pct);
    fill(shaft.inertia_kg_m2, m.inertia_std_pct, m.inertia_bound_pct);
    m.viscous_friction_bar_nm_s = bar_of(shaft.viscous_nm_s);
    m.coulomb_friction_nm = shaft.coulomb_nm.value;
    m.coulomb_friction_bar_nm = bar_of(shaft.coulomb_nm);
    m.dead_time_s = legs.dead_time_s();
    m.dead_time_bar_s = bar_of(legs.loss_v) * legs.period_s / legs.bus_v;
    if (legs.knee_a.value > KNEE_SEEN * current_a) {
        m.knee_a = legs.knee_a.value;
        m.knee_bar_a = bar_of(legs.knee_a);
    }
}

// How much of a converter's rounding is left in a mean. Noise smooths the staircase: its first
// harmonic falls with the rms of the noise, here in counts.
double left_of_rounding(double noise_lsb)
{
    return std::exp(-2 * PI * PI * noise_lsb * noise_lsb);
}

// Rms, A; of both sensors and all levels.
double noise_a(const Records &records)
{
    double sum = 0;
    const std::vector<Record> levels = records.of("still");
    for (const Record &level : levels) {
        sum += CHANGE_TO_SIGMA * (level.noise_a[0] + level.noise_a[1]) / 2;
    }
    return sum / static_cast<double>(levels.size());
}

void fill_conditions(MeasuredSettings &m, const Records &records, const Config &plate,
                     const Legs &legs, const Inductances &l, const Flux &flux)
{
    m.bus_v = legs.bus_v;
    m.current_a = l.current_a;
    m.speed_rpm = flux.speed_el_rad_s / records.scales.pole_pairs / RAD_S_PER_RPM;
    const double count_a = records.scales.current_a / std::exp2(plate.board.adc_bits);
    m.current_noise_lsb = noise_a(records) / count_a;
}

// Two ways to φ that lie further apart than both bars.
void remark_flux(const Flux &flux, std::vector<std::string> &remarks)
{
    const char *const alone = "the flux linkage comes from the spin only";
    const double apart = std::abs(flux.turning_wb.value - flux.coasting_wb.value);
    if (!flux.has_coasted) {
        remarks.push_back(fmt::format("the rotor stops too fast without current: {}", alone));
    } else if (flux.disagreement_wb() > 0) {
        remarks.push_back(fmt::format("φ is {:.4g} Wb with current and {:.4g} Wb without: the two "
                                      "ways disagree by {:.1f} %",
                                      flux.turning_wb.value, flux.coasting_wb.value,
                                      pct(apart, flux.wb.value)));
        if (!flux.coasting_counts()) {
            remarks.back() += fmt::format(", {}", alone);
        }
    }
}

// The file has the edges to the digits of their bar. Without a measurement it keeps what the name
// plate says.
void fill_halls(const Halls &halls, Result &result)
{
    double bar = 0;
    for (const HallEdge &edge : halls.edges) {
        bar = std::max(bar, error_bar(edge.deg.std, edge.deg.bound));
    }
    for (std::size_t k = 0; k < halls.edges.size(); k++) {
        result.motor.sensor.hall_patterns[k] = halls.edges[k].pattern;
        result.motor.sensor.hall_edges_deg[k] =
            std::stod(within_bar(halls.edges[k].deg.value, bar));
    }
    result.motor.sensor.kind = SensorKind::hall;
    result.measured.hall_edges_bar_deg = bar;
}

// φ is the same at each speed. What R and the legs have wrong makes an error that falls with the
// speed.
void remark_trend(const Flux &flux, int pole_pairs, std::vector<std::string> &remarks)
{
    const auto slower = [](const FluxAtSpeed &a, const FluxAtSpeed &b) {
        return a.speed_el_rad_s < b.speed_el_rad_s;
    };
    if (flux.over_speed.empty()) {
        return;
    }
    const auto [low, high] =
        std::minmax_element(flux.over_speed.begin(), flux.over_speed.end(), slower);
    const double apart = high->wb.value - low->wb.value;
    if (std::abs(apart) > bar_of(low->wb) + bar_of(high->wb)) {
        const double rpm = 1 / RAD_S_PER_RPM / pole_pairs;
        remarks.push_back(fmt::format(
            "φ {} with the speed, {:.4g} Wb at {:.0f} rpm and {:.4g} Wb at {:.0f} rpm: R or what "
            "the legs lose differs from that at rest",
            apart > 0 ? "rises" : "falls", low->wb.value, low->speed_el_rad_s * rpm, high->wb.value,
            high->speed_el_rad_s * rpm));
    }
}

void widen_to(Value &value, const Value &other)
{
    value.bound += std::abs(value.value - other.value);
}

// The same measurement where the sensors' low pass is another one.
struct OtherLag {
    Records records;
    Legs legs;
};

OtherLag with_other_lag(const Records &sent, const Legs &legs, const Inductances &rough,
                        double lag_s)
{
    OtherLag other;
    other.records = without_lag(sent, legs, rough.d_h.value, lag_s);
    other.legs = fit_legs(other.records);
    return other;
}

// A low pass that does not show for sure may be there: what it would change is a bound.
void add_hidden_lag(const OtherLag &hidden, Legs &legs)
{
    widen_to(legs.resistance_ohm, hidden.legs.resistance_ohm);
    widen_to(legs.loss_v, hidden.legs.loss_v);
    widen_to(legs.knee_a, hidden.legs.knee_a);
}

// As sensors without a low pass would have shown the currents. Legs and inductances are found anew
// of them; what that changes is a bound of what is found, as the correction is good to a part of
// itself.
Records undo_lag(const Records &sent, Legs &legs, Inductances &rough, double current_a)
{
    if (rough.lag.s.value <= 0) {
        return sent;
    }
    const OtherLag undone = with_other_lag(sent, legs, rough, rough.lag.s.value);
    const double before_ohm = legs.resistance_ohm.value;
    legs = undone.legs;
    add_unsure_current(legs, std::abs(legs.resistance_ohm.value / before_ohm - 1));
    rough = fit_inductances(undone.records, legs, current_a);
    return undone.records;
}

// seen: of the records as they were sent.
void add_lag_bound(Flux &flux, const SensorLag &lag, const Flux &seen)
{
    flux.wb.bound +=
        (lag.s.value > 0 ? CORRECTION_UNSURE : 1) * std::abs(flux.wb.value - seen.wb.value);
}

std::string more_or_less(double share, const char *what)
{
    return fmt::format("{:.2g} % {} {}", IN_PER_CENT * std::abs(share), share > 0 ? "more" : "less",
                       what);
}

// A gain that both have in common shows in nothing, and is as likely as one by which they differ.
void remark_gains(const Value &mismatch, std::vector<std::string> &remarks)
{
    if (std::abs(mismatch.value) > GAINS_ALIKE + bar_of(mismatch)) {
        remarks.push_back(fmt::format(
            "the current sensors' gains differ: a over b is {:.3f} ± {:.3f}; R, L and the flux linkage are those for the "
            "mean of both, and a gain that both have too much or too little is in them",
            1 + mismatch.value, bar_of(mismatch)));
    }
}

void remark_phases(const Phases &phases, std::vector<std::string> &remarks)
{
    if (phases.are_unlike) {
        const std::string turns =
            phases.inductance_share != 0
                ? " and " + more_or_less(phases.inductance_share, "inductance")
                : "";
        remarks.push_back(fmt::format(
            "the phases differ: phase {} has {}{} than the other two; R and L are the means of the "
            "three",
            "abc"[phases.phase], more_or_less(phases.resistance_share, "resistance"), turns));
    }
}

// That which turns under the pulses across; 0: as much as in the ramps. With a load beyond
// LOAD_RATIO_MOST it is no rotor that shows there, and the bar of L_q alone has it.
double rotor_alone_kg_m2(const Flux &flux, const Shaft &shaft, const Inductances &inductances,
                         int pole_pairs)
{
    const double turned = 1.5 * pole_pairs * pole_pairs * flux.wb.value * flux.wb.value;
    const double alone = inductances.alone_h_s2 > 0 ? turned / inductances.alone_h_s2 : 0;
    return alone * LOAD_RATIO_MOST > shaft.inertia_kg_m2.value ? alone : 0;
}

// Ramps that agree may have the same error, of a load that the pulses show to swing.
void add_swing_bound(Shaft &shaft, double alone_kg_m2)
{
    if (alone_kg_m2 > 0 && !shaft.swings) {
        shaft.inertia_kg_m2.bound += shaft.swing_kg_m2;
    }
}

void remark_elastic(const Shaft &shaft, double alone_kg_m2, std::vector<std::string> &remarks)
{
    const double bar_kg_m2 = bar_of(shaft.inertia_kg_m2);
    if (alone_kg_m2 > 0) {
        remarks.push_back(fmt::format(
            "the load is on an elastic shaft and swings: quick pulses turn {:.2g} kg·m², ramps {:.2g} ± "
            "{:.2g} kg·m²",
            alone_kg_m2, shaft.inertia_kg_m2.value, bar_kg_m2));
    } else if (shaft.swings) {
        remarks.push_back(fmt::format(
            "the load swings: J is {:.2g} ± {:.2g} kg·m², as the ramps or the torque after them differ; is the "
            "load on an elastic shaft, or does it change?",
            shaft.inertia_kg_m2.value, bar_kg_m2));
    }
}

void remark_lag(const SensorLag &lag, std::vector<std::string> &remarks)
{
    constexpr double micro = 1e6;
    constexpr double kilo = 1e-3;
    if (lag.s.value > 0) {
        remarks.push_back(fmt::format(
            "the current sensors follow late, as behind a low pass of {:.2g} kHz ({:.2g} ± {:.1g} "
            "µs): pulses show it, and R, L and the flux linkage are corrected for it",
            kilo / (2 * PI * lag.s.value), micro * lag.s.value, micro * bar_of(lag.s)));
    }
}

} // namespace

Result evaluate(const Records &sent, const Config &plate, double temperature_c)
{
    check_scales(sent.scales, plate);
    const double current_a = continuous_current(plate.motor);
    Legs legs = fit_legs(sent);
    Inductances rough = fit_inductances(sent, legs, current_a);
    const Records records = undo_lag(sent, legs, rough, current_a);
    const OtherLag other = rough.lag.hidden_s > 0
                               ? with_other_lag(sent, legs, rough, rough.lag.hidden_s)
                               : OtherLag{sent, legs};
    if (rough.lag.hidden_s > 0) {
        add_hidden_lag(other, legs);
    }
    add_ripple_bounds(legs, rough.d_h.value);
    const double count_a = records.scales.current_a / std::exp2(plate.board.adc_bits);
    const double left = left_of_rounding(noise_a(records) / count_a);
    add_rounding_bounds(legs, left * count_a / 2);
    Flux flux = fit_flux(records, legs, rough);
    add_lag_bound(flux, rough.lag, fit_flux(other.records, other.legs, rough));
    Shaft shaft = fit_shaft(records, legs, flux);
    const Inductances inductances = fit_inductances(
        records, legs, current_a, {rotor_h_s2(flux, shaft, plate.motor.pole_pairs), shaft.swings});
    const double alone_kg_m2 = rotor_alone_kg_m2(flux, shaft, inductances, plate.motor.pole_pairs);
    add_swing_bound(shaft, alone_kg_m2);
    Result result;
    if (!records.remark.empty()) {
        result.remarks.push_back(records.remark);
    }
    result.motor = plate.motor;
    fill_motor(result.motor, legs, inductances, flux, shaft);
    bound_max_speed(result.motor, plate, flux.wb.value + bar_of(flux.wb), result.remarks);
    result.motor.rated_torque_nm = 1.5 * plate.motor.pole_pairs * flux.wb.value * current_a;
    result.motor.rated_speed_rpm = rated_speed_rpm(result.motor, plate, current_a);
    fill_bars(result.measured, legs, inductances, flux, shaft, current_a);
    fill_conditions(result.measured, records, plate, legs, inductances, flux);
    const Phases phases = fit_phases(legs, inductances);
    result.measured.gain_mismatch_pct = IN_PER_CENT * phases.mismatch.value;
    result.measured.gain_mismatch_bar_pct = IN_PER_CENT * bar_of(phases.mismatch);
    result.measured.temperature_c = temperature_c;
    result.lost_time_s = legs.lost_v(current_a) * legs.period_s / legs.bus_v;
    result.lost_time_bar_s = result.measured.dead_time_bar_s;
    result.knee_bar_a = bar_of(legs.knee_a);
    result.noise_bar_lsb = NOISE_UNSURE_LSB + NOISE_UNSURE * result.measured.current_noise_lsb +
                           left * ROUNDING_NOISE_LSB;
    result.inductances = inductances;
    result.flux = flux;
    if (plate.motor.sensor.kind == SensorKind::hall || !records.of("hall").empty()) {
        result.halls = fit_halls(records, legs, inductances, flux, shaft);
    }
    if (result.halls.measured) {
        fill_halls(result.halls, result);
    } else if (!result.halls.trouble.empty()) {
        result.remarks.push_back(result.halls.trouble);
    }
    remark_lag(inductances.lag, result.remarks);
    remark_phases(phases, result.remarks);
    remark_gains(phases.mismatch, result.remarks);
    remark_elastic(shaft, alone_kg_m2, result.remarks);
    remark_flux(flux, result.remarks);
    remark_trend(flux, plate.motor.pole_pairs, result.remarks);
    return result;
}

} // namespace nf::identify
