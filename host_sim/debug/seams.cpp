// SPDX-License-Identifier: MIT
// The seams of the instrumented drive: its calls of seam_f() in place of f() come here, are passed
// on, and what f() has computed is compared with the twin.
#include "diff.h"

#include "observer_roundings.h"
#include "twin_modulator.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nf::debug
{
namespace
{

using twin::CurrentLoop;
using twin::NnObserver;
using twin::Q13;
using twin::Q15;
using twin::Q27;
using twin::STEPS_PER_TURN;
using twin::TWO_PI;
using twin::Vector;

constexpr double Q12 = 4096.0;
constexpr double Q14 = 16384.0;
constexpr double Q26 = 67108864.0;
constexpr double Q30 = 1073741824.0;
constexpr double DEG_PER_STEP = 360.0 / STEPS_PER_TURN;
constexpr double DEG_PER_RAD = 360.0 / TWO_PI;

// Roundings of one call in LSB, as the modules' headers state them.
constexpr double CLARKE_LSB = 1.0;
constexpr double PARK_LSB = 0.5;
constexpr double PI_LSB = 2.0; // proportional part and integral
constexpr double INTEGRAL_LSB = 1.0 / 2048.0;
constexpr double CURRENT_LOOP_LSB = PI_LSB + 1.0 + INTEGRAL_LSB; // and the decoupling
constexpr double ROOT_LSB = 1.0;                                 // of the circle
constexpr double SPEED_LOOP_LSB = PI_LSB + 1.0;                  // and the feed-forward
constexpr double MIDDLE_LSB = 1.0; // of a range that is not symmetric: a half, and it counts twice
// α_r is good to 2^-17 turn; g·α_r is rounded down to 2^-32 turn by two shifts, the twin's radians
// to less.
constexpr double CURRENT_ANGLE_STEPS = 32768.0;
constexpr double FIRING_ANGLE_STEPS = 1.1;
constexpr double DUTY_LSB = 2.65; // β·√3/2 1.1, α/2 0.5, half the sum 1.05
constexpr double PHASE_LSB = 1.6; // of a ratio or a current
// Where the observer's integers saturate.
constexpr int32_t CURRENT_MAX = 16383;
constexpr int32_t ERROR_MAX = 8191;
constexpr int32_t GRADIENT_MAX = 32767;

// Of the tick that is being compared.
twin::PerUnit si;        // with the configuration that a module was given
const char *called = ""; // the module's function
std::vector<Comparison> rows;

// In a seam: the function that it is of.
#define CALL(function) (called = #function, function)

using Axes = std::array<const char *, 2>;

void add(const char *quantity, const char *unit, double drive, double reference, double tolerance)
{
    rows.push_back({called, quantity, unit, drive, reference, tolerance});
}

void add(Axes axes, const char *unit, const Vector &drive, const Vector &reference,
         const Vector &tolerance)
{
    add(axes[0], unit, drive.x(), reference.x(), tolerance.x());
    add(axes[1], unit, drive.y(), reference.y(), tolerance.y());
}

void add(Axes axes, const char *unit, const Vector &drive, const Vector &reference,
         double tolerance)
{
    add(axes, unit, drive, reference, Vector::Constant(tolerance));
}

void add_speed(const char *quantity, step_t drive, double rad_s, double tolerance_steps)
{
    const double rpm = si.bases.rpm_from_step(1);
    add(quantity, "rpm", drive * rpm, si.step_of_speed(rad_s) * rpm, tolerance_steps * rpm);
}

Vector current(ab_t i)
{
    return {si.current(i.alpha), si.current(i.beta)};
}

double radians(double steps)
{
    return steps / STEPS_PER_TURN * TWO_PI;
}

// The angle that this sine and cosine are those of.
double angle_of(sincos_t turn)
{
    return std::atan2(turn.sin, turn.cos);
}

// Their amplitude is a little below 1, and they are rounded.
double amplitude_error(const Vector &v)
{
    return v.norm() * 2 * twin::SINE_LSB;
}

Vector current_q30(dq_t i)
{
    return {si.current(i.d / Q15), si.current(i.q / Q15)};
}

int32_t signed_angle(angle_t angle)
{
    return static_cast<int32_t>(angle);
}

double gain(int32_t mantissa, uint32_t shift)
{
    return std::ldexp(mantissa, -static_cast<int>(shift));
}

// An error of one LSB, integrated, and the integral rounded down.
double integral_roundings(const pi_cfg_t &pi)
{
    return gain(pi.ki, pi.ki_shift + 11) + INTEGRAL_LSB;
}

// x̂, ŷ in A, in the frame at an angle.
Vector network_state(const nn_observer_t &obs, double angle)
{
    return twin::park(Vector(obs.alpha_q27, obs.beta_q27) * (si.state_base() / Q27), angle);
}

NnObserver observer_twin(const nn_observer_t &obs, const nn_observer_cfg_t &cfg,
                         const Vector &state)
{
    si.cfg.observer = cfg;
    NnObserver twin(twin::observer_params(si));
    twin.set(state, si.speed_of_step(obs.speed), si.speed_of_step(obs.speed_out),
             si.speed_of_step(obs.weight_step) * si.bases.control_period_s);
    twin.set_error(si.current(obs.error));
    twin.set_rho(obs.rho_q13 / Q13);
    return twin;
}

double gradient_lsb(const nn_observer_cfg_t &cfg)
{
    return si.bases.current_a * si.state_base() / Q30 * (1U << cfg.gradient_shift);
}

// A current as it saturates in the drive.
Vector limited(const Vector &i, int32_t highest_q15)
{
    return i.cwiseMax(si.current(-highest_q15 - 1)).cwiseMin(si.current(highest_q15));
}

void compare_network(const nn_observer_t &before, const nn_observer_t &after,
                     const nn_observer_cfg_t &cfg, const Vector &measured, const Vector &voltage,
                     double angle)
{
    const double advance = radians(before.speed_out);
    const Vector state = network_state(before, angle - advance);
    NnObserver twin = observer_twin(before, cfg, state);
    // What decays is taken from the current as it was stored: rounded, and a little turned where θ̂
    // was pulled. It is turned by half a step of the speed at the last refresh.
    const Vector error = twin.error();
    const double turned = std::abs(before.half_step_q15 / Q15 - advance / 2);
    const double restored = twin.decay().diagonal().maxCoeff() *
                                (twin.current() - si.current(before.current)).cwiseAbs().sum() +
                            turned * twin.drop(state, error).norm();
    const Vector network =
        twin::network_roundings(si, twin, twin.speed_out(), state, error).array() +
        twin::half_turn_error(si, twin, twin.speed_out(), state, error) + restored;

    twin.step(measured, twin::park(voltage, angle - advance / 2));
    const Vector output = network + twin::output_roundings(si, twin.state());
    add({"x", "y"}, "A", network_state(after, angle), twin.state(), network);
    add({"i_d", "i_q"}, "A", si.current(after.current), limited(twin.current(), CURRENT_MAX),
        output);
    add({"e_d", "e_q"}, "A", si.current(after.error), limited(twin.error(), ERROR_MAX), output);
}

// e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q): each product rounded down, that of e_q rotated again. Then
// b of (18).
void compare_gradient(const nn_observer_t &before, const nn_observer_t &after,
                      const nn_observer_cfg_t &cfg)
{
    const double rho = before.rho_q13 / Q13;
    const Vector e = si.current(after.error);
    const double error_q = cfg.saliency_q13 / Q13 * e.y();
    add({"e'_d", "e'_q"}, "A", si.current(after.rotated_error),
        limited({e.x() + rho * error_q, error_q - rho * e.x()}, ERROR_MAX),
        Vector(2.0 + std::abs(rho), 2.0) * si.current(1));

    const Vector x = si.current(before.state) * (si.state_base() / si.bases.current_a);
    const Vector e_rotated = si.current(after.rotated_error);
    const double one = gradient_lsb(cfg);
    add("gradient", "A2", after.gradient * one,
        std::clamp(e_rotated.y() * x.x() - e_rotated.x() * x.y(), -(GRADIENT_MAX + 1) * one,
                   GRADIENT_MAX * one),
        one);
}

// The gains are those at the reference that is asked for.
twin::SpeedLoop speed_twin(const speed_loop_t &loop, const speed_loop_cfg_t &cfg, step_t reference,
                           torque_range_t range)
{
    const bool soft = std::abs(reference) < cfg.soft_speed;
    const bool heavy = loop.inertia_q17 >= SPEED_LOOP_HEAVY_Q17;
    si.cfg.speed_loop = cfg;
    si.cfg.speed_loop.pi = soft ? cfg.soft : cfg.pi;
    twin::SpeedLoop::Params params = twin::speed_loop_params(si);
    params.current_min_a = si.current(range.lower);
    params.current_max_a = si.current(range.upper);
    const double inertia = std::ldexp(loop.inertia_q17 >> 4, -13);
    params.pi.kp /= std::ldexp(1.0, static_cast<int>(loop.halvings));
    params.pi.ki_t /= std::ldexp(heavy ? 2.0 : 1.0, 2 * static_cast<int>(loop.halvings));
    params.current_per_change *= inertia;
    twin::SpeedLoop twin(params);
    twin.reset(si.speed_of_step(loop.reference), loop.pi.integral_q26 / Q26 * si.bases.current_a);
    return twin;
}

// d away from its target in units u, with B = 2^30/braking_inverse and s = √(d/B + c²): d rounded
// down to a unit makes v_max/(2Bs), at its end v_max/(2Bc), the root v_max·2^-15, 2 steps more.
double profile_roundings(const position_loop_cfg_t &cfg, int64_t distance_q32)
{
    const double units = std::abs(static_cast<double>(distance_q32)) * gain(1, cfg.distance_shift);
    const double braking = Q30 / cfg.braking_inverse;
    const double root =
        std::hypot(std::sqrt(std::max(units - 1, 0.0) / braking), cfg.softness_q15 / Q15);
    return cfg.speed_max * (1 / (2 * braking * root) + 1 / Q15) + 2;
}

double ohm_of_reactance(int32_t q14)
{
    return q14 / Q14 * (si.bases.voltage_v / si.bases.current_a);
}

CurrentLoop::Plan plan_of(const current_loop_t &loop)
{
    return {{ohm_of_reactance(loop.reactance_q14.d), ohm_of_reactance(loop.reactance_q14.q)},
            si.voltage(loop.constant)};
}

// Both, V.
Vector integrals(const current_loop_t &loop)
{
    return Vector(loop.pi_d.integral_q26, loop.pi_q.integral_q26) * (si.bases.voltage_v / Q26);
}

// Of the dead-time compensation, LSB; drop and product rounded down. Never more than the whole of
// it, in either direction.
double compensation_roundings(const modulator_cfg_t &cfg, const Vector &ratio, double loss)
{
    const double crossing = 2 * PHASE_LSB + 9 * (2 * ratio.norm() * PHASE_LSB + 1);
    const double ripple = crossing * cfg.ripple_q15 / Q15 + 1;
    // z·(2 − z) has the slope 2 at most; two products are rounded down.
    const double share = std::min(2 * cfg.edge_slope * (ripple + PHASE_LSB) / Q15, 2.0);
    return share * loss * Q15 + 3 + PHASE_LSB;
}

// Counts are rounded to nearest; `more_lsb` comes on top of the duty's own roundings.
void add_duties(const modulator_cfg_t &cfg, const compare_t &out, const Eigen::Vector3d &exact,
                double more_lsb)
{
    constexpr std::array<const char *, 3> NAMES = {"duty_a", "duty_b", "duty_c"};
    const double lsb = DUTY_LSB + 0.5 * Q15 / cfg.timer_counts + more_lsb;
    for (int leg = 0; leg < 3; leg++) {
        const auto at = static_cast<std::size_t>(leg);
        add(NAMES[at], "", static_cast<double>(out.phase[at]) / cfg.timer_counts,
            std::clamp(exact(leg), 0.0, 1.0), lsb / Q15);
    }
}

} // namespace

extern "C" {

void instrumented_drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out);

decltype(trig_sincos) *seam_trig_sincos = [](auto angle) {
    const sincos_t turn = CALL(trig_sincos)(angle);
    const Vector exact(std::sin(radians(angle)), std::cos(radians(angle)));
    add({"sin", "cos"}, "", Vector(turn.sin, turn.cos) / Q15, exact * ((Q15 - 1) / Q15), 1 / Q15);
    return turn;
};

decltype(transforms_clarke) *seam_transforms_clarke = [](auto a, auto b) {
    const ab_t v = CALL(transforms_clarke)(a, b);
    add({"i_alpha", "i_beta"}, "A", current(v), twin::clarke(si.current(a), si.current(b)),
        CLARKE_LSB * si.current(1));
    return v;
};

decltype(transforms_park) *seam_transforms_park = [](auto v, auto turn) {
    const dq_t turned = CALL(transforms_park)(v, turn);
    add({"i_d", "i_q"}, "A", si.current(turned), twin::park(current(v), angle_of(turn)),
        PARK_LSB * si.current(1) + amplitude_error(current(v)));
    return turned;
};

// Of ratios and of currents.
decltype(transforms_park_inverse) *seam_transforms_park_inverse = [](auto v, auto turn) {
    const ab_t turned = CALL(transforms_park_inverse)(v, turn);
    const Vector from = Vector(v.d, v.q) / Q15;
    add({"alpha", "beta"}, "pu", Vector(turned.alpha, turned.beta) / Q15,
        twin::park_inverse(from, angle_of(turn)), PARK_LSB / Q15 + amplitude_error(from));
    return turned;
};

decltype(nn_observer_predict) *seam_nn_observer_predict = [](auto obs, auto cfg, auto measured,
                                                             auto voltage, auto turn) {
    const nn_observer_t before = *obs;
    CALL(nn_observer_predict)(obs, cfg, measured, voltage, turn);
    compare_network(before, *obs, *cfg, si.current(measured), si.voltage(voltage), angle_of(turn));
    compare_gradient(before, *obs, *cfg);
};

// Paper A (19)–(22). ΔW2 is rounded down to a step, its momentum to two; ω̂_out to another.
decltype(nn_observer_train) *seam_nn_observer_train = [](auto obs, auto cfg) {
    NnObserver twin = observer_twin(*obs, *cfg, Vector::Zero());
    twin.train(obs->gradient * gradient_lsb(*cfg));
    const double limit = si.speed_of_step(cfg->speed_limit);
    const double speed = std::clamp(twin.speed(), -limit, limit);
    const double steps = cfg->momentum_q15 != 0 ? 3.0 : 1.0;
    CALL(nn_observer_train)(obs, cfg);
    add_speed("speed", obs->speed, speed, steps);
    add_speed("speed_out", obs->speed_out, speed + twin.speed_out() - twin.speed(), steps + 1);
};

// Paper A (23), exact.
decltype(rotor_position_step) *seam_rotor_position_step = [](auto position, auto speed) {
    const int64_t before = position->turns_q32;
    CALL(rotor_position_step)(position, speed);
    add("advance", "deg el", static_cast<double>(position->turns_q32 - before) * DEG_PER_STEP,
        speed * DEG_PER_STEP, DEG_PER_STEP / 2);
};

// The reference adds the lag to the profile's speed: rounded down to 2^-16 turn, times the gain,
// and 1.
decltype(position_loop_step) *seam_position_loop_step = [](auto loop, auto cfg, auto target,
                                                           auto measured, auto ticks) {
    const auto rad = [](int64_t q32) { return radians(static_cast<double>(q32)); };
    si.cfg.position_loop = *cfg;
    si.cfg.slow_ticks = ticks;
    twin::PositionLoop twin(twin::position_loop_params(si));
    twin.reset(rad(loop->profile_q32), si.speed_of_step(loop->profile_speed));
    const double exact = twin.step(rad(target), rad(measured));
    const double steps = profile_roundings(*cfg, target - loop->profile_q32);
    const step_t reference = CALL(position_loop_step)(loop, cfg, target, measured, ticks);
    add_speed("profile's speed", loop->profile_speed, twin.speed(), steps);
    add_speed("reference", reference, exact, steps + gain(cfg->gain, cfg->gain_shift) + 1);
    return reference;
};

decltype(speed_loop_ramp) *seam_speed_loop_ramp = [](auto loop, auto cfg, auto target) {
    const double exact = speed_twin(*loop, *cfg, target, {0, 0}).ramp(si.speed_of_step(target));
    const step_t reference = CALL(speed_loop_ramp)(loop, cfg, target);
    add_speed("reference", reference, exact, 0.5);
    return reference;
};

decltype(speed_loop_accelerate) *seam_speed_loop_accelerate = [](auto loop, auto cfg,
                                                                 auto reference, auto range) {
    twin::SpeedLoop twin = speed_twin(*loop, *cfg, reference, range);
    const double exact = twin.accelerate(si.speed_of_step(reference));
    const int32_t torque = CALL(speed_loop_accelerate)(loop, cfg, reference, range);
    add_speed("reference", loop->reference, twin.reference(), 0.5);
    add("i_q", "A", si.current(torque), exact, 2 * si.current(1));
    return torque;
};

decltype(speed_loop_step) *seam_speed_loop_step = [](auto loop, auto cfg, auto reference,
                                                     auto measured, auto range) {
    twin::SpeedLoop twin = speed_twin(*loop, *cfg, reference, range);
    const double exact = twin.step(si.speed_of_step(reference), si.speed_of_step(measured));
    const double integral = integral_roundings(cfg->pi);
    const double middle = range.lower == -range.upper ? 0 : MIDDLE_LSB;
    const double before = loop->pi.integral_q26 / Q26 * si.bases.current_a;
    const int32_t torque = CALL(speed_loop_step)(loop, cfg, reference, measured, range);
    const double after = loop->pi.integral_q26 / Q26 * si.bases.current_a;
    const double current = SPEED_LOOP_LSB + middle + gain(cfg->pi.kp, cfg->pi.kp_shift) + integral;
    // At a limit the integral waits: of both, one may be there and not the other.
    const bool near = torque + current >= range.upper || torque - current <= range.lower;
    const double step = std::max(std::abs(after - before), std::abs(twin.pi().integral() - before));
    add("i_q", "A", si.current(torque), exact, current * si.current(1));
    add("integral", "A", after, twin.pi().integral(), integral * si.current(1) + (near ? step : 0));
    return torque;
};

// Of the voltage's magnitude.
decltype(pi_step) *seam_pi_step = [](auto pi, auto cfg, auto error, auto forward, auto limit) {
    twin::Pi twin(twin::pi_params(*cfg, 1, 1));
    twin.reset(pi->integral_q26 / Q26);
    const double exact = twin.step(error / Q15, forward / Q15, limit / Q15);
    const int32_t output = CALL(pi_step)(pi, cfg, error, forward, limit);
    add("output", "pu", output / Q15, exact, (PI_LSB + INTEGRAL_LSB) / Q15);
    add("integral", "pu", pi->integral_q26 / Q26, twin.integral(), INTEGRAL_LSB / Q15);
    return output;
};

// Paper B (40), (41), (43). Its angle beside that of the rotor.
decltype(phase_compensator_step) *seam_phase_compensator_step =
    [](auto comp, auto cfg, auto i, auto rotor, auto speed, auto forwards) {
        si.cfg.voltage_drive.compensator = *cfg;
        twin::PhaseCompensator twin(twin::phase_compensator_params(si));
        twin.set(radians(signed_angle(comp->angle - rotor)), radians(comp->current_angle));
        twin.step(si.current(i.d), si.current(i.q), 0, radians(speed), forwards ? 1 : -1);
        const int32_t lead = CALL(phase_compensator_step)(comp, cfg, i, rotor, speed, forwards);
        add("alpha_r", "deg el", comp->current_angle * DEG_PER_STEP,
            twin.current_angle() * DEG_PER_RAD, CURRENT_ANGLE_STEPS * DEG_PER_STEP);
        add("firing angle", "deg el", signed_angle(comp->angle - rotor) * DEG_PER_STEP,
            twin.angle() * DEG_PER_RAD, FIRING_ANGLE_STEPS * DEG_PER_STEP);
        return lead;
    };

decltype(virtual_resistance_step) *seam_virtual_resistance_step = [](auto res, auto cfg, auto i) {
    si.cfg.voltage_drive.damping = *cfg;
    twin::VirtualResistance twin(twin::virtual_resistance_params(si));
    twin.start(current_q30(res->mean_q30));
    const Vector exact = twin.step(si.current(i));
    const dq_t drop = CALL(virtual_resistance_step)(res, cfg, i);
    add({"v_d", "v_q"}, "V", {si.voltage(drop.d / Q15), si.voltage(drop.q / Q15)}, exact,
        gain(cfg->resistance_q15, 15) * si.voltage(1)); // the mean is rounded down
    add({"mean_d", "mean_q"}, "A", current_q30(res->mean_q30), twin.mean(),
        gain(cfg->mean_rate_q15, 15) * si.current(1));
    return drop;
};

// Each product is rounded down and then doubled: one of the low-pass, and in each part of the swing
// two of the turn and one of the share, which is turned as well.
decltype(torque_filter_step) *seam_torque_filter_step = [](auto filter, auto cfg, auto i) {
    const double q26 = si.bases.current_a / Q26;
    const auto swing = [&](dq_t z) { return std::complex<double>(z.d, z.q) * q26; };
    twin::TorqueFilter twin(twin::torque_filter_params(*cfg));
    twin.set(si.current(filter->origin), filter->smooth_q26 * q26, swing(filter->swing_q26));
    const double exact = twin.step(si.current(i));
    const int32_t current = CALL(torque_filter_step)(filter, cfg, i);
    const std::complex<double> turned = swing(filter->swing_q26);
    add("i_q", "A", si.current(current), exact, si.current(0.5) + 3 * q26);
    add("low-pass", "A", filter->smooth_q26 * q26, twin.smooth(), 2 * q26);
    add({"swing_d", "swing_q"}, "A", {turned.real(), turned.imag()},
        {twin.swing().real(), twin.swing().imag()}, 8 * q26);
    return current;
};

decltype(current_loop_plan) *seam_current_loop_plan = [](auto loop, auto cfg, auto reference,
                                                         auto speed) {
    si.cfg.current_loop = *cfg;
    const twin::CurrentLoop twin(twin::current_loop_params(si));
    const CurrentLoop::Plan exact = twin.plan(si.current(reference), si.speed_of_q15(speed));
    CALL(current_loop_plan)(loop, cfg, reference, speed);
    const CurrentLoop::Plan plan = plan_of(*loop);
    add({"omega L_d", "omega L_q"}, "ohm", plan.reactance_ohm, exact.reactance_ohm,
        ohm_of_reactance(1));
    add({"constant v_d", "constant v_q"}, "V", plan.constant_v, exact.constant_v,
        Vector(1, 2) * si.voltage(1));
};

decltype(current_loop_model) *seam_current_loop_model = [](auto loop, auto i) {
    const dq_t v = CALL(current_loop_model)(loop, i);
    add({"v_d", "v_q"}, "V", si.voltage(v), CurrentLoop::model(plan_of(*loop), si.current(i)),
        si.voltage(1));
    return v;
};

// At the circle the axis that comes second is √(limit² − other²): an error of the other one counts
// |other/second| times. What the circle takes is given back to the second one's integral.
decltype(current_loop_step) *seam_current_loop_step = [](auto loop, auto cfg, auto reference,
                                                         auto measured, auto limit) {
    si.cfg.current_loop = *cfg;
    CurrentLoop twin(twin::current_loop_params(si));
    twin.reset(integrals(*loop));
    const Vector exact =
        twin.step(plan_of(*loop), si.current(reference), si.current(measured), si.voltage(limit));
    const double lsb = si.voltage(1);
    const int second = twin.second();
    const double other = exact(1 - second);
    const double steepness = std::abs(exact(second)) > lsb ? std::abs(other / exact(second)) : 1.0;
    const double cut = twin.cut() ? CURRENT_LOOP_LSB * (1.0 + steepness) + ROOT_LSB : 0.0;
    Vector of_voltage = Vector::Constant(CURRENT_LOOP_LSB);
    Vector of_integral = Vector::Constant(INTEGRAL_LSB);
    of_voltage(second) += cut;
    of_integral(second) += twin.cut() ? CURRENT_LOOP_LSB + cut : 0.0;
    const dq_t v = CALL(current_loop_step)(loop, cfg, reference, measured, limit);
    add({"v_d", "v_q"}, "V", si.voltage(v), exact, of_voltage * lsb);
    add({"integral d", "integral q"}, "V", integrals(*loop),
        {twin.pi_d().integral(), twin.pi_q().integral()}, of_integral * lsb);
    return v;
};

// The error of the reciprocal rounded down, times the reciprocal; the step to nearest.
decltype(modulator_track_bus) *seam_modulator_track_bus = [](auto mod, auto bus) {
    const double inverse = mod->inverse_bus_q12 / Q12;
    const double next = inverse * (2.0 - inverse * (bus / Q15));
    CALL(modulator_track_bus)(mod, bus);
    add("1/bus", "pu", mod->inverse_bus_q12 / Q12,
        std::clamp(next, 1.0, MODULATOR_INVERSE_MAX_Q12 / Q12), (inverse + 0.5) / Q12);
};

decltype(modulator_limit) *seam_modulator_limit = [](auto cfg, auto bus) {
    const int32_t limit = CALL(modulator_limit)(cfg, bus);
    add("limit", "V", si.voltage(limit), si.voltage(bus * (cfg->ratio_max_q15 / Q15)),
        si.voltage(1));
    return limit;
};

decltype(modulator_ratio) *seam_modulator_ratio = [](auto mod, auto voltage) {
    const dq_t ratio = CALL(modulator_ratio)(mod, voltage);
    const Vector exact = Vector(voltage.d, voltage.q) / Q15 * (mod->inverse_bus_q12 / Q12);
    add({"ratio_d", "ratio_q"}, "", Vector(ratio.d, ratio.q) / Q15,
        exact.cwiseMax(-1.0).cwiseMin((Q15 - 1) / Q15), 1 / Q15);
    return ratio;
};

decltype(modulator_compare) *seam_modulator_compare = [](auto cfg, auto ratio, auto out) {
    const Eigen::Vector3d exact =
        twin::Modulator::duties(Vector(ratio.alpha, ratio.beta) / Q15, 1.0);
    CALL(modulator_compare)(cfg, ratio, out);
    add_duties(*cfg, *out, exact, 0.0);
};

decltype(modulator_compare_compensated) *seam_modulator_compare_compensated = [](auto mod, auto cfg,
                                                                                 auto ratio, auto i,
                                                                                 auto out) {
    const Vector share = Vector(ratio.alpha, ratio.beta) / Q15;
    const double bus_v = si.bases.voltage_v / (mod->inverse_bus_q12 / Q12);
    const twin::Modulator::Losses losses = {mod->dead_time_q15 / Q15, si.voltage(cfg->drop_q15),
                                            si.current(cfg->ripple_q15),
                                            cfg->edge_slope / si.bases.current_a};
    const Eigen::Vector3d exact =
        twin::Modulator::duties(share, 1.0) +
        twin::Modulator::compensation(losses, share * bus_v, bus_v, current(i));
    CALL(modulator_compare_compensated)(mod, cfg, ratio, i, out);
    add_duties(*cfg, *out, exact,
               compensation_roundings(*cfg, share, losses.dead_time_share + losses.drop_v / bus_v));
};

} // extern "C"

std::vector<Comparison> step_beside_twins(drive_t &drive, const drive_in_t &in, drive_out_t &out,
                                          const Bases &bases)
{
    si = {bases, *drive.cfg};
    rows.clear();
    instrumented_drive_step(&drive, &in, &out);
    return rows;
}

} // namespace nf::debug
