// Speed observer beside its twin.
//
// The difference of the two is itself a linear system around the operating point, driven by the roundings
// of each tick. Its bound is the sum over k of |F^k·G| times the largest rounding of each source: what
// every rounding, at its worst and with the worst sign, can add up to before it has decayed.
#include "settings_under_test.h"
#include "twin_nn_observer.h"

#include "figure.h"

#include <algorithm>
#include <cmath>
#include <complex>

using nf::reference::Q14;
using nf::reference::Q15;
using nf::reference::Q27;
using nf::reference::Seeded;
using nf::reference::Setup;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;
using nf::twin::NnObserver;
using nf::twin::Vector;

static constexpr double LEAST_SHARE = 0.05;
// 25736 stands for 2π·4096 in the weight W2.
static constexpr double WEIGHT_MISMATCH = 25736.0 / (TWO_PI * 4096.0) - 1.0;

void setUp()
{
}

void tearDown()
{
}

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

// Roundings of one tick of the network, A of x and y. States of k − 1 enter the products rounded down to Q15 of
// I_x (4096 units of Q27), times 1 − W1 and W2; the products are rounded down, 1 unit each, and W2 in
// Q28 by ½; then constants that do not agree as integers: W2's own, the flux drive with decay
// times flux, decay_q with decay_d·L_d/L_q.
static Vector network_roundings(const Setup &s, const NnObserver &twin, double speed,
                                const Vector &state)
{
    const nn_observer_cfg_t &c = s.cfg.observer;
    const double weight = std::ldexp(1.0, -12 - static_cast<int>(c.weight_shift));
    const double unit = s.state_base() / Q27;
    const double decay_d = c.decay_d * weight;
    const double decay_q = c.decay_q * weight;
    const double w2 = std::abs(twin.weights(speed)(0, 1));
    const double drive = std::abs(c.flux_drive_q27 - decay_d * c.flux_q27);
    const double mismatch = std::abs(decay_q - decay_d * c.iq_gain_q14 / Q14);
    const Vector size = state.cwiseAbs();
    return {unit * (4096.0 * (decay_d + w2) + 2.5 + drive) + w2 * WEIGHT_MISMATCH * size.y(),
            unit * (4096.0 * (decay_q + w2) + 2.5) + w2 * WEIGHT_MISMATCH * size.x() +
                mismatch * size.y()};
}

// The network alone: speed prescribed, nothing trained. For L_d = L_q its sum is the rounding over
// 1 − |W1 + jW2|.
static double compare_network(const Setup &base, double speed, double *bound)
{
    Setup s = base;
    s.cfg.observer.rate = 0;
    s.cfg.observer.proportional = 0;
    NnObserver twin(nf::reference::observer_params(s));
    nn_observer_t obs;
    Seeded seeded(1);
    const auto step = static_cast<step_t>(std::lround(s.step_of_speed(speed)));
    const double exact_speed = s.speed_of_step(step);
    dq_t voltage = {0, 0};
    Vector largest = Vector::Zero();
    double worst = 0;

    nn_observer_reset(&obs, &s.cfg.observer);
    obs.speed = step;
    obs.speed_out = step;
    twin.set(twin.state(), exact_speed, exact_speed);
    for (int k = 0; k < 5000; k++) {
        if (k % 40 == 0) {
            // The EMF, and up to 9 V beside it.
            const double emf = exact_speed * nf::reference::observer_params(s).flux_wb;
            voltage.d = seeded.in(-650, 650);
            voltage.q =
                static_cast<int32_t>(std::lround(emf / s.voltage(1))) + seeded.in(-650, 650);
        }
        nn_observer_step(&obs, &s.cfg.observer, dq_t{0, 0}, voltage);
        twin.step(Vector::Zero(), s.voltage(voltage));
        const Vector state(obs.x_q27 / Q27 * s.state_base(), obs.y_q27 / Q27 * s.state_base());
        TEST_ASSERT_TRUE(std::max(std::abs(obs.x_q27), std::abs(obs.y_q27)) < 0x7FFFFFF);
        largest = largest.cwiseMax(twin.state().cwiseAbs());
        worst = std::max(worst, (state - twin.state()).cwiseAbs().maxCoeff());
    }
    const Vector sum = worst_sum(Eigen::Matrix2d(twin.weights(exact_speed)),
                                 Eigen::Matrix2d(Eigen::Matrix2d::Identity()),
                                 network_roundings(s, twin, exact_speed, largest));
    *bound = sum.maxCoeff();
    return worst;
}

static void check_network(const char *name, const nf::MotorSettings &motor, double top_speed,
                          double pwm_hz)
{
    const Setup s(motor, nf::reference::board(pwm_hz), nf::reference::tuning());
    double share = 0;

    for (const double speed : {0.0, 0.1, -0.1, 0.5, -0.5, 1.0, -1.0}) {
        double bound = 0;
        const double worst = compare_network(s, speed * top_speed, &bound);
        share = std::max(share, worst / bound);
    }
    figure_check(name, share, 1.0, LEAST_SHARE);
}

static void test_network_stays_within_the_contracted_roundings_of_the_twin()
{
    check_network("network of motor A beside its twin, share of the bound",
                  nf::reference::motor_a(), 410.0, 10000);
    check_network("network of motor B beside its twin, share of the bound",
                  nf::reference::motor_b(), 280.0, 20000);
}

// A motor of constant speed in its own frame, with exactly the observer's parameters.
struct Motor {
    NnObserver::Params p;
    double speed;
    double angle = 0;
    Vector current = Vector::Zero();

    // The voltage that keeps i_d = 0 and this i_q.
    Vector steady_voltage(double current_q) const
    {
        return {-speed * p.inductance_q_h * current_q,
                p.resistance_ohm * current_q + speed * p.flux_wb};
    }

    // One period of a voltage that is constant in the stationary frame; 40 steps of Heun's method.
    void run(const Vector &stationary)
    {
        const double h = p.period_s / 40;
        for (int i = 0; i < 40; i++) {
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

// Difference of observer and twin: states δx, δy, δω, δω_out, δ(ΔW2); inputs the roundings of x, y, i_d,
// i_q, b, ΔW2, ω_out. Both see the same measurement, so θ̂ does not close this loop.
struct Difference {
    Eigen::Matrix<double, 5, 5> f;
    Eigen::Matrix<double, 5, 7> g;
};

static Difference difference_system(const NnObserver &twin, const NnObserver::Params &p,
                                    double speed, const Vector &state)
{
    const double gain_q = p.inductance_d_h / p.inductance_q_h;
    const double flux2 = twin.flux_current() * twin.flux_current();
    Difference d;
    d.f.setZero();
    d.g.setZero();
    d.f.topLeftCorner<2, 2>() = twin.weights(speed);
    d.f(0, 3) = p.period_s * state.y();
    d.f(1, 3) = -p.period_s * state.x();
    d.g(0, 0) = 1;
    d.g(1, 1) = 1;
    // δb = −L_d/L_q·δy·x + δx·y with the new states, and the roundings of the currents and of b.
    const auto f_b = (-gain_q * state.x() * d.f.row(1) + state.y() * d.f.row(0)).eval();
    auto g_b = (-gain_q * state.x() * d.g.row(1) + state.y() * d.g.row(0)).eval();
    g_b(2) += state.y();
    g_b(3) += state.x();
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

static Comparison compare_running(const Setup &s, double speed, double current_q)
{
    const nn_observer_cfg_t &c = s.cfg.observer;
    const NnObserver::Params p = nf::reference::observer_params(s);
    const double base_x = s.state_base();
    NnObserver twin(p);
    nn_observer_t obs;
    Motor motor{p, speed};
    const Vector state(twin.flux_current(), current_q * p.inductance_q_h / p.inductance_d_h);
    angle_t angle = 0;
    Vector stationary = Vector::Zero();
    double largest_error = 0;
    Vector worst_state = Vector::Zero();
    double worst_speed = 0;
    double worst_out = 0;

    motor.current = {0, current_q};
    nn_observer_reset(&obs, &c);
    obs.x_q27 = static_cast<int32_t>(std::lround(state.x() / base_x * Q27));
    obs.y_q27 = static_cast<int32_t>(std::lround(state.y() / base_x * Q27));
    obs.speed = static_cast<step_t>(std::lround(s.step_of_speed(speed)));
    obs.speed_out = obs.speed;
    twin.set({obs.x_q27 / Q27 * base_x, obs.y_q27 / Q27 * base_x}, s.speed_of_step(obs.speed),
             s.speed_of_step(obs.speed));
    stationary = nf::twin::park_inverse(motor.steady_voltage(current_q), 0.5 * speed * p.period_s);
    for (int k = 0; k < 8000; k++) {
        const double middle =
            angle / STEPS_PER_TURN * TWO_PI + 0.5 * obs.speed_out / STEPS_PER_TURN * TWO_PI;
        motor.run(stationary);
        angle += static_cast<angle_t>(obs.speed_out);
        const Vector i = nf::twin::park(nf::twin::park_inverse(motor.current, motor.angle),
                                        angle / STEPS_PER_TURN * TWO_PI) /
                         s.current(1);
        const Vector v = nf::twin::park(stationary, middle) / s.voltage(1);
        const dq_t measured = {static_cast<int32_t>(std::lround(i.x())),
                               static_cast<int32_t>(std::lround(i.y()))};
        const dq_t voltage = {static_cast<int32_t>(std::lround(v.x())),
                              static_cast<int32_t>(std::lround(v.y()))};
        nn_observer_step(&obs, &c, measured, voltage);
        twin.step(s.current(measured), s.voltage(voltage));
        stationary = nf::twin::park_inverse(motor.steady_voltage(current_q),
                                            motor.angle + 0.5 * speed * p.period_s);
        const Vector own(obs.x_q27 / Q27 * base_x, obs.y_q27 / Q27 * base_x);
        worst_state = worst_state.cwiseMax((own - twin.state()).cwiseAbs());
        worst_speed = std::max(worst_speed, std::abs(s.speed_of_step(obs.speed) - twin.speed()));
        worst_out =
            std::max(worst_out, std::abs(s.speed_of_step(obs.speed_out) - twin.speed_out()));
        largest_error = std::max(largest_error, twin.error().cwiseAbs().maxCoeff());
    }
    const Vector network = network_roundings(s, twin, speed, state);
    const double step = s.speed_of_step(1);
    Eigen::Matrix<double, 7, 1> r;
    // î rounded down 1 LSB (i_q twice); b >> 14, and x, y in b as Q15 of I_x times the error; ΔW2 rounded down
    // to a step, its momentum to two; ω_out to a step.
    r << network.x(), network.y(), s.current(1), s.current(1) + base_x / Q27,
        16384.0 * s.current(1) * base_x / Q15 + 2.0 * largest_error * base_x / Q15,
        (p.alpha > 0 ? 3.0 : 1.0) * step * p.period_s, step;
    const Difference d = difference_system(twin, p, speed, state);
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

static void test_trained_network_stays_within_the_contracted_roundings_of_the_twin()
{
    check_running("motor A", nf::reference::motor_a(), nf::reference::tuning(), 377.0, 10000);
    check_running("motor B", nf::reference::motor_b(), nf::reference::tuning(), 251.0, 20000);
}

static void test_momentum_stays_within_the_contracted_roundings_of_the_twin()
{
    nf::TuningSettings tuning = nf::reference::tuning();

    tuning.observer_momentum = 0.5;
    check_running("motor A with momentum", nf::reference::motor_a(), tuning, 377.0, 10000);
}

int main()
{
    UNITY_BEGIN();
    RUN_TEST(test_network_stays_within_the_contracted_roundings_of_the_twin);
    RUN_TEST(test_trained_network_stays_within_the_contracted_roundings_of_the_twin);
    RUN_TEST(test_momentum_stays_within_the_contracted_roundings_of_the_twin);
    return UNITY_END();
}
