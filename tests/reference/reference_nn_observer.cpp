// SPDX-License-Identifier: MIT
// Speed observer beside its twin.
//
// The difference of the two is itself a linear system around the operating point, driven by the
// roundings of each tick. Its bound is the sum over k of |F^k·G| times the largest rounding of each
// source: what every rounding, at its worst and with the worst sign, can add up to before it has
// decayed.
#include "observer_roundings.h"
#include "settings_under_test.h"
#include "twin_nn_observer.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>
#include <complex>

using nf::reference::Q13;
using nf::reference::Q14;
using nf::reference::Q15;
using nf::reference::Q27;
using nf::reference::Seeded;
using nf::reference::Setup;
using nf::reference::SINE_LSB;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;
using nf::twin::effect_on_gradient;
using nf::twin::half_turn_error;
using nf::twin::network_roundings;
using nf::twin::NnObserver;
using nf::twin::training_roundings;
using nf::twin::Vector;

// Each rounding at its worst with the worst sign in every tick is far from what happens.
static constexpr double LEAST_SHARE = 0.02;
// Without feedback the error of the tick before is not taken.
static const Vector NO_ERROR = Vector::Zero();
// Σ |F^k·G|·r, until nothing is added any more.
template <typename State, typename Input>
static auto worst_sum(const State &f, const Input &g,
                      const Eigen::Matrix<double, Input::ColsAtCompileTime, 1> &r)
{
    using Vec = Eigen::Matrix<double, State::RowsAtCompileTime, 1>;
    Input response = g;
    Vec sum = Vec::Zero();
    for (int k = 0; k < 100000; k++) {
        const Vec term = response.cwiseAbs() * r;
        sum += term;
        if (k > 1000 && (term.array() <= 1e-9 * sum.array()).all()) {
            break;
        }
        response = (f * response).eval();
    }
    return sum;
}

// The firmware's observer with the angle that its speed makes, (23).
struct Observer {
    nn_observer_t obs{};
    angle_t angle = 0;

    void predict(const Setup &s, const dq_t &measured, const ab_t &voltage)
    {
        angle += static_cast<angle_t>(obs.speed_out);
        nn_observer_predict(&obs, &s.cfg.observer, measured, voltage, trig_sincos(angle));
    }

    double radians() const
    {
        return angle / STEPS_PER_TURN * TWO_PI;
    }

    // The middle of the period that begins at this angle.
    double middle() const
    {
        return (angle + 0.5 * obs.speed_out) / STEPS_PER_TURN * TWO_PI;
    }

    // x̂, ŷ in A.
    Vector state(const Setup &s) const
    {
        return nf::twin::park(
            {obs.alpha_q27 / Q27 * s.state_base(), obs.beta_q27 / Q27 * s.state_base()}, radians());
    }
};

static ab_t rounded_ab(const Vector &v)
{
    return {static_cast<int32_t>(std::lround(v.x())), static_cast<int32_t>(std::lround(v.y()))};
}

static dq_t rounded(const Vector &v)
{
    return {static_cast<int32_t>(std::lround(v.x())), static_cast<int32_t>(std::lround(v.y()))};
}

// Firmware and twin at the same point in a frame at angle 0, with the same ρ.
static void start_both(const Setup &s, const Vector &state, double speed, Observer &own,
                       NnObserver &twin)
{
    const double base_x = s.state_base();
    const auto step = static_cast<step_t>(std::lround(s.step_of_speed(speed)));
    nn_observer_t &obs = own.obs;

    own.angle = 0;
    nn_observer_start(&obs, &s.cfg.observer, step, dq_t{0, 0}, trig_sincos(0));
    obs.speed = step;
    obs.speed_out = step;
    obs.alpha_q27 = static_cast<int32_t>(std::lround(state.x() / base_x * Q27));
    obs.beta_q27 = static_cast<int32_t>(std::lround(state.y() / base_x * Q27));
    obs.state = {obs.alpha_q27 >> 12, obs.beta_q27 >> 12};
    const Vector exact = own.state(s);
    obs.current = rounded(
        Vector(exact.x() - twin.flux_current(), exact.y() * s.cfg.observer.iq_gain_q14 / Q14) /
        s.current(1));
    nn_observer_refresh(&obs, &s.cfg.observer, obs.speed);
    twin.set(exact, s.speed_of_step(step), s.speed_of_step(step));
    twin.set_rho(obs.rho_q13 / Q13);
}

// The network alone: speed prescribed, nothing trained. For L_d = L_q its sum is the rounding over
// 1 − |W|.
static double compare_network(const Setup &base, double speed, double *bound)
{
    Setup s = base;
    s.cfg.observer.eta = 0;
    s.cfg.observer.kappa_p = 0;
    NnObserver twin(nf::reference::observer_params(s));
    Observer own;
    Seeded seeded(1);
    Vector demand = Vector::Zero();
    Vector largest = Vector::Zero();
    double worst = 0;

    start_both(s, twin.state(), speed, own, twin);
    const double exact_speed = twin.speed();
    for (int k = 0; k < 5000; k++) {
        if (k % 40 == 0) {
            // The EMF, and up to 9 V beside it.
            const double emf = exact_speed * nf::reference::observer_params(s).flux_wb;
            demand = Vector(s.voltage(seeded.in(-650, 650)), emf + s.voltage(seeded.in(-650, 650)));
        }
        const double middle = own.middle();
        const ab_t voltage = rounded_ab(nf::twin::park_inverse(demand, middle) / s.voltage(1));
        own.predict(s, dq_t{0, 0}, voltage);
        twin.step(Vector::Zero(), nf::twin::park(s.voltage(voltage), middle));
        TEST_ASSERT_TRUE(std::max(std::abs(own.obs.alpha_q27), std::abs(own.obs.beta_q27)) <
                         0x7FFFFFF);
        largest = largest.cwiseMax(twin.state().cwiseAbs());
        worst = std::max(worst, (own.state(s) - twin.state()).cwiseAbs().maxCoeff());
    }
    const Vector error = -twin.current(largest); // nothing is measured
    const Vector sum = worst_sum(
        Eigen::Matrix2d(twin.weights(exact_speed)), Eigen::Matrix2d(Eigen::Matrix2d::Identity()),
        Vector(network_roundings(s, twin, exact_speed, largest, error).array() +
               half_turn_error(s, twin, exact_speed, largest, error)));
    *bound = sum.maxCoeff();
    return worst;
}

static void check_network(const char *name, const Setup &s, double top_speed)
{
    double share = 0;

    for (const double speed : {0.0, 0.1, -0.1, 0.5, -0.5, 1.0, -1.0}) {
        double bound = 0;
        const double worst = compare_network(s, speed * top_speed, &bound);
        share = std::max(share, worst / bound);
    }
    figure_check(name, share, 1.0, LEAST_SHARE);
}

TEST(test_network_stays_within_the_contracted_roundings_of_the_twin)
{
    check_network("network of motor A beside its twin, share of the bound",
                  {nf::reference::motor_a(), nf::reference::board(), nf::reference::tuning()},
                  410.0);
    check_network("network of motor B beside its twin, share of the bound",
                  {nf::reference::motor_b(), nf::reference::board(20000), nf::reference::tuning()},
                  280.0);
}

// A motor of constant speed in its own frame, with exactly the observer's parameters.
struct Motor {
    NnObserver::Params p;
    double speed;
    double angle = 0;
    Vector current = Vector::Zero();
    int steps = 40;

    // The voltage that keeps i_d = 0 and this i_q.
    Vector steady_voltage(double current_q) const
    {
        return {-speed * p.inductance_q_h * current_q,
                p.resistance_ohm * current_q + speed * p.flux_wb};
    }

    // One period of a voltage that is constant in the stationary frame, in steps of Heun's method.
    void run(const Vector &stationary)
    {
        const double h = p.period_s / steps;
        for (int i = 0; i < steps; i++) {
            const Vector first = slope(current, stationary, angle);
            const Vector second = slope(current + h * first, stationary, angle + h * speed);
            current += h / 2 * (first + second);
            angle += h * speed;
        }
    }

    Vector slope(const Vector &i, const Vector &stationary, double theta) const
    {
        const Vector v = nf::twin::park(stationary, theta);
        return {
            (v.x() - p.resistance_ohm * i.x() + speed * p.inductance_q_h * i.y()) /
                p.inductance_d_h,
            (v.y() - p.resistance_ohm * i.y() - speed * (p.inductance_d_h * i.x() + p.flux_wb)) /
                p.inductance_q_h};
    }
};

// What a small deviation of ω_out by 1 does to the network's next state around a steady one: d/dω
// of R(−ωT)·z + R(−ωT/2)·c, with R(−ωT/2)·c = z − R(−ωT)·z.
static Vector effect_of_speed(const NnObserver &twin, const NnObserver::Params &p, double speed,
                              const Vector &state)
{
    const Vector middle = 0.5 * (state + twin.rotation(speed, 1.0) * state);
    return p.period_s * Vector(middle.y(), -middle.x());
}

// Difference of observer and twin: states δx, δy, δω, δω_out, δ(ΔW2); inputs the roundings of x, y,
// i_d, i_q, b, ΔW2, ω_out. Both see the same measurement, so θ̂ does not close this loop.
struct Difference {
    Eigen::Matrix<double, 5, 5> f;
    Eigen::Matrix<double, 5, 7> g;
};

static Difference difference_system(const NnObserver &twin, const NnObserver::Params &p, double rho,
                                    double speed, const Vector &state)
{
    const Vector gain(1.0, p.inductance_d_h / p.inductance_q_h);
    const double flux2 = twin.flux_current() * twin.flux_current();
    const Eigen::RowVector2d gradient = effect_on_gradient(p, rho, state);
    Difference d;
    d.f.setZero();
    d.g.setZero();
    d.f.topLeftCorner<2, 2>() = twin.weights(speed);
    d.f.block<2, 1>(0, 3) = effect_of_speed(twin, p, speed, state);
    d.g(0, 0) = 1;
    d.g(1, 1) = 1;
    // δe = −(δx, δy·L_d/L_q) with the new states; the roundings of the currents and of b.
    const Eigen::RowVector2d of_state = -gradient * gain.asDiagonal();
    const auto f_b = (of_state * d.f.topRows<2>()).eval();
    auto g_b = (of_state * d.g.topRows<2>()).eval();
    g_b.segment<2>(2) += gradient;
    g_b(4) += 1;
    d.f.row(4) = p.eta * f_b;
    d.f(4, 4) += p.alpha;
    d.g.row(4) = p.eta * g_b;
    d.g(4, 5) += 1;
    d.f.row(2) = -d.f.row(4) / p.period_s;
    d.f(2, 2) += 1;
    d.g.row(2) = -d.g.row(4) / p.period_s;
    d.f.row(3) = d.f.row(2) - p.kappa_p / p.period_s / flux2 * f_b;
    d.g.row(3) = d.g.row(2) - p.kappa_p / p.period_s / flux2 * g_b;
    d.g(3, 6) += 1;
    return d;
}

struct Comparison {
    double speed;     // largest difference of ω̂, as a share of its bound
    double speed_out; // of ω̂_out
    double current;   // of the states
};

// Motor and inverter as the firmware sees them with the angle that it has estimated.
struct Bench {
    dq_t measured;
    ab_t voltage; // of the last period
    double middle;

    // One period, in which the voltage that keeps current_q acts and the estimate goes on.
    Bench(const Setup &s, Motor &motor, double current_q, const Observer &own)
        : middle(own.middle())
    {
        const double next =
            (own.angle + static_cast<angle_t>(own.obs.speed_out)) / STEPS_PER_TURN * TWO_PI;
        voltage =
            rounded_ab(nf::twin::park_inverse(motor.steady_voltage(current_q),
                                              motor.angle + 0.5 * motor.speed * motor.p.period_s) /
                       s.voltage(1));
        motor.run(s.voltage(voltage));
        measured =
            rounded(nf::twin::park(nf::twin::park_inverse(motor.current, motor.angle), next) /
                    s.current(1));
    }
};

static Comparison compare_running(const Setup &s, double speed, double current_q)
{
    const NnObserver::Params p = nf::reference::observer_params(s);
    NnObserver twin(p);
    Observer own;
    Motor motor{p, speed};
    const Vector state(twin.flux_current(), current_q * p.inductance_q_h / p.inductance_d_h);
    double largest_error = 0;
    Vector largest_unturned = Vector::Zero();
    Vector worst_state = Vector::Zero();
    double worst_speed = 0;
    double worst_out = 0;

    motor.current = {0, current_q};
    start_both(s, state, speed, own, twin);
    for (int k = 0; k < 8000; k++) {
        const Bench bench(s, motor, current_q, own);
        own.predict(s, bench.measured, bench.voltage);
        nn_observer_train(&own.obs, &s.cfg.observer);
        twin.step(s.current(bench.measured),
                  nf::twin::park(s.voltage(bench.voltage), bench.middle));
        worst_state = worst_state.cwiseMax((own.state(s) - twin.state()).cwiseAbs());
        worst_speed =
            std::max(worst_speed, std::abs(s.speed_of_step(own.obs.speed) - twin.speed()));
        worst_out =
            std::max(worst_out, std::abs(s.speed_of_step(own.obs.speed_out) - twin.speed_out()));
        largest_error = std::max(largest_error, twin.rotated_error().cwiseAbs().maxCoeff());
        largest_unturned = largest_unturned.cwiseMax(twin.error().cwiseAbs());
    }
    const double rho = own.obs.rho_q13 / Q13;
    Eigen::Matrix<double, 7, 1> r;
    const Vector error = -largest_unturned; // adds to i_q ≥ 0
    r << network_roundings(s, twin, speed, state, error).array() +
             half_turn_error(s, twin, speed, state, error),
        training_roundings(s, p, rho, state, largest_error);
    const Difference d = difference_system(twin, p, rho, speed, state);
    const auto bound = worst_sum(d.f, d.g, r);
    return {worst_speed / bound(2), worst_out / bound(3),
            std::max(worst_state.x() / bound(0), worst_state.y() / bound(1))};
}

static void check_running(const char *name, const nf::MotorSettings &motor,
                          const nf::TuningSettings &tuning, double top_speed, double pwm_hz)
{
    const Setup s(motor, nf::reference::board(pwm_hz), tuning);
    Comparison share{0, 0, 0};
    char text[120];

    for (const double speed : {0.2, -0.2, 0.5, -0.5, 1.0, -1.0}) {
        for (const double current : {0.0, 4.0}) {
            const Comparison one = compare_running(s, speed * top_speed, current);
            share = {std::max(share.speed, one.speed), std::max(share.speed_out, one.speed_out),
                     std::max(share.current, one.current)};
        }
    }
    std::snprintf(text, sizeof text, "%s: speed beside its twin, share of the bound", name);
    figure_check(text, share.speed, 1.0, LEAST_SHARE);
    std::snprintf(text, sizeof text, "%s: inner speed beside its twin, share of the bound", name);
    figure_check(text, share.speed_out, 1.0, LEAST_SHARE);
    std::snprintf(text, sizeof text, "%s: states beside their twins, share of the bound", name);
    figure_check(text, share.current, 1.0, LEAST_SHARE);
}

TEST(test_trained_network_stays_within_the_contracted_roundings_of_the_twin)
{
    check_running("motor A", nf::reference::motor_a(), nf::reference::tuning(), 377.0, 10000);
    check_running("motor B", nf::reference::motor_b(), nf::reference::tuning(), 251.0, 20000);
}

TEST(test_momentum_stays_within_the_contracted_roundings_of_the_twin)
{
    nf::TuningSettings tuning = nf::reference::tuning();

    tuning.observer_momentum = 0.5;
    check_running("motor A with momentum", nf::reference::motor_a(), tuning, 377.0, 10000);
}

TEST(test_fed_back_error_stays_within_the_contracted_roundings_of_the_twin)
{
    nf::TuningSettings tuning = nf::reference::tuning();

    tuning.observer_feedback = 0.08;
    tuning.observer_rho_max = 1.25;
    const Setup a(nf::reference::motor_a(), nf::reference::board(), tuning);
    check_network("fed-back network beside its twin, share of the bound", a, 410.0);
    check_running("motor A with feedback", nf::reference::motor_a(), tuning, 377.0, 10000);
    check_running("motor B with feedback", nf::reference::motor_b(), tuning, 251.0, 20000);
}

TEST(test_turned_error_stays_within_the_contracted_roundings_of_the_twin)
{
    nf::TuningSettings tuning = nf::reference::tuning();

    tuning.observer_rho_max = 2;
    check_running("motor A with its error turned", nf::reference::motor_a(), tuning, 377.0, 10000);
    check_running("motor B with its error turned", nf::reference::motor_b(), tuning, 251.0, 20000);
}

// ρ in units of 2^-13: rounded towards zero, 1; corner and speed in units of 1024 steps, 1 each.
TEST(test_rho_stays_within_the_roundings_of_the_twin)
{
    nf::TuningSettings tuning = nf::reference::tuning();
    tuning.observer_rho_max = 2;
    const Setup s(nf::reference::motor_a(), nf::reference::board(), tuning);
    const nn_observer_cfg_t &c = s.cfg.observer;
    const NnObserver twin(nf::reference::observer_params(s));
    nn_observer_t obs{};
    Seeded seeded(1);
    double share = 0;

    for (int k = 0; k < 20000; k++) {
        const step_t speed = seeded.in(-c.speed_limit, c.speed_limit);
        nn_observer_refresh(&obs, &c, speed);
        const double exact = twin.rho_at(s.speed_of_step(speed)) * Q13;
        const double units = std::max(std::abs(speed) / 1024.0 - 1.0, 1.0);
        const double bound = 1.0 + std::abs(exact) * (1024.0 / c.corner + 1.0 / units);
        share = std::max(share, std::abs(obs.rho_q13 - exact) / bound);
    }
    figure_check("rho beside its twin, share of the bound", share, 1.0, LEAST_SHARE);
}

// The weights of (14)–(16) are the first order of the rotation's: with Δ = ω·T the largest
// difference of a step is
//     |R(−Δ)·z − (1 + Δ·J)·z| ≤ Δ²/2·|z|   and   |R(−Δ/2)·c − c| ≤ Δ/2·|c|,
// c the change by resistance and voltage in a period, itself of first order in T.
TEST(test_paper_weights_are_those_of_the_network_to_first_order)
{
    const Setup s(nf::reference::motor_a(), nf::reference::board(), nf::reference::tuning());
    NnObserver twin(nf::reference::observer_params(s));
    Seeded seeded(1);

    for (const double turn : {0.01, 0.02, 0.04, -0.04}) {
        const double speed = turn / s.bases.control_period_s;
        double worst = 0;

        for (int k = 0; k < 2000; k++) {
            const Vector start(twin.flux_current() + seeded.in(-10000, 10000) * 1e-3,
                               seeded.in(-20000, 20000) * 1e-3);
            const ab_t voltage = {seeded.in(-9000, 9000), seeded.in(-9000, 9000)};
            Observer own;
            start_both(s, start, speed, own, twin);
            const Vector before = twin.state();
            const double exact_speed = twin.speed();
            const Vector acting = nf::twin::park(s.voltage(voltage), own.middle());
            const Vector printed = twin.paper_predicted(before, acting, exact_speed);
            own.predict(s, dq_t{0, 0}, voltage);
            // δ of the current that start_both rounds to nearest
            const double start_rounding = twin.decay()(0, 0) * s.current(1);
            const double bound = turn * turn / 2 * before.norm() +
                                 std::abs(turn) / 2 * twin.change(before, acting).norm() +
                                 network_roundings(s, twin, exact_speed, before, NO_ERROR).norm() +
                                 half_turn_error(s, twin, exact_speed, before, NO_ERROR) +
                                 start_rounding;
            const Vector after = own.state(s);
            worst = std::max(worst, (after - printed).norm() / bound);
        }
        char text[80];
        std::snprintf(text, sizeof text, "network beside the printed one, turn %g, share", turn);
        figure_check(text, worst, 1.0, 0.5);
    }
}

// Observer and motor around the steady state z of the motor, with the estimated angle in the loop:
// states δx, δy, δω, δω_out, δθ; inputs as above, and first what the network does not know of the
// motor, in x and y.
struct ClosedLoop {
    Eigen::Matrix<double, 5, 5> f;
    Eigen::Matrix<double, 5, 7> g;
};

static ClosedLoop closed_loop(const NnObserver &twin, const NnObserver::Params &p, double speed,
                              const Vector &state, const Vector &current, const Vector &voltage)
{
    const double flux2 = twin.flux_current() * twin.flux_current();
    const double gain = p.period_s / p.inductance_d_h;
    // A frame ahead by δθ sees a vector turned back.
    const Vector voltage_turned =
        gain * twin.rotation(speed, 0.5) * Vector(voltage.y(), -voltage.x());
    const Vector current_turned(current.y(), -current.x());
    const Vector scale(1.0, p.inductance_d_h / p.inductance_q_h);
    const Eigen::RowVector2d gradient = effect_on_gradient(p, 0.0, state);
    ClosedLoop c;
    c.f.setZero();
    c.g.setZero();
    c.f.topLeftCorner<2, 2>() = twin.weights(speed);
    c.f.block<2, 1>(0, 3) =
        effect_of_speed(twin, p, speed, state) + 0.5 * p.period_s * voltage_turned;
    c.f.block<2, 1>(0, 4) = voltage_turned;
    c.f.row(4) << 0, 0, 0, p.period_s, 1;
    c.g.topLeftCorner<2, 2>().setIdentity();
    Eigen::Matrix<double, 2, 5> f_e = -(scale.asDiagonal() * c.f.topRows<2>());
    Eigen::Matrix<double, 2, 7> g_e = -(scale.asDiagonal() * c.g.topRows<2>());
    f_e += current_turned * c.f.row(4);
    g_e.middleCols<2>(2) += Eigen::Matrix2d::Identity();
    const auto f_b = (gradient * f_e).eval();
    auto g_b = (gradient * g_e).eval();
    g_b(4) += 1;
    c.f.row(2) = -p.eta / p.period_s * f_b;
    c.f(2, 2) += 1;
    c.g.row(2) = -p.eta / p.period_s * g_b;
    c.g(2, 5) -= 1 / p.period_s;
    c.f.row(3) = c.f.row(2) - p.kappa_p / p.period_s / flux2 * f_b;
    c.g.row(3) = c.g.row(2) - p.kappa_p / p.period_s / flux2 * g_b;
    c.g(3, 6) += 1;
    return c;
}

// Motor A sixteen times as fast: R, L and φ a sixteenth, so that τ and φ/L stay; J a 256th, so that
// it accelerates sixteen times as fast too. ω·T = 0.7 at its highest speed.
static nf::MotorSettings fast_motor()
{
    nf::MotorSettings m = nf::reference::motor_a();
    m.resistance_ohm /= 16;
    m.inductance_d_h /= 16;
    m.inductance_q_h /= 16;
    m.flux_linkage_wb /= 16;
    m.inertia_kg_m2 /= 256;
    m.max_speed_rpm = 33420;
    m.rated_speed_rpm = 30000;
    return m;
}

// What the network does not know of the motor in a tick, the same in each: resistance acts on the
// current of k − 1 at the middle of the turn, while the current differs from it in between. The
// voltage stands still in the stationary frame and turns by ±h = ±Δ/2 against the rotor, which
// moves the current by at most T/L·|v|·h/4 at the middle; and the drop itself turns, h²/6 of it.
static double unknown_to_the_network(const NnObserver &twin, const NnObserver::Params &p,
                                     double turn, const Vector &current, const Vector &voltage)
{
    const double h = turn / 2;
    const double ripple = p.period_s / p.inductance_d_h * voltage.norm() * h / 4;
    return twin.decay()(0, 0) * (ripple + h * h / 6 * current.norm());
}

// At 0.7 rad in a period the observer, trained and with its own angle in the loop, holds the
// motor's state: constant errors count by the closed loop's steady gain, roundings by their worst
// sum. Forward Euler, as printed, stretches the state by √((1 − T/τ)² + 0.49) = 1.2 in each period
// and is lost.
TEST(test_state_is_kept_at_the_largest_turn_in_a_period_and_euler_diverges)
{
    const double current_q = 4;
    const Setup s(fast_motor(), nf::reference::board(), nf::reference::tuning());
    const NnObserver::Params p = nf::reference::observer_params(s);
    const double turn = 0.7;
    const double speed = turn / p.period_s;
    NnObserver twin(p);
    Observer own;
    Motor motor{p, speed};
    Vector printed(twin.flux_current(), current_q);
    double largest_error = 0;
    double worst = 0;

    motor.steps = 400;
    motor.current = {0, current_q};
    start_both(s, printed + Vector(1, -1), speed, own, twin);
    for (int k = 0; k < 6000; k++) {
        const Bench bench(s, motor, current_q, own);
        own.predict(s, bench.measured, bench.voltage);
        nn_observer_train(&own.obs, &s.cfg.observer);
        if (printed.norm() < 1e6) {
            printed = twin.paper_predicted(
                printed, nf::twin::park(s.voltage(bench.voltage), bench.middle), speed);
        }
        if (k >= 3000) {
            const Vector true_state = motor.current + Vector(twin.flux_current(), 0);
            worst = std::max(worst, (own.state(s) - true_state).cwiseAbs().maxCoeff());
            largest_error = std::max({largest_error, s.current(std::abs(own.obs.rotated_error.d)),
                                      s.current(std::abs(own.obs.rotated_error.q))});
        }
    }
    const Vector voltage = motor.steady_voltage(current_q);
    const Vector state = motor.current + Vector(twin.flux_current(), 0);
    const ClosedLoop loop = closed_loop(twin, p, speed, state, motor.current, voltage);
    const double constant = unknown_to_the_network(twin, p, turn, motor.current, voltage) +
                            half_turn_error(s, twin, speed, state, NO_ERROR);
    const auto steady =
        ((Eigen::Matrix<double, 5, 5>::Identity() - loop.f).inverse() * loop.g.leftCols<2>())
            .eval();
    const double of_voltage = p.period_s / p.inductance_d_h * s.voltage(1);
    Eigen::Matrix<double, 7, 1> r;
    // Samples are rounded to nearest, ½ LSB; the voltage in both axes, which turn into each other.
    r << network_roundings(s, twin, speed, state, NO_ERROR) + Vector::Constant(of_voltage),
        training_roundings(s, p, 0.0, state, largest_error);
    r.segment<2>(2).array() += 0.5 * s.current(1);
    const auto noise = worst_sum(loop.f, loop.g, r);
    const double bound =
        (steady.cwiseAbs() * Vector::Constant(constant) + noise).head<2>().maxCoeff();
    TEST_ASSERT_TRUE(printed.norm() > 1e6);
    figure_check("state at 0.7 rad in a period beside the motor, A", worst, bound, LEAST_SHARE);
}
