/* SPDX-License-Identifier: MIT */
// The sensorless drive of paper A from its equations alone, in double precision and SI units. It
// knows nothing of the firmware, its twins and the plant: what agrees with it agrees with the
// paper.
//
// What the paper does not print has its plainest form: an inverter without loss, whose voltage is
// constant in a period and one period late; PI loops; a speed ramp; a position profile.
#pragma once

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace paper_a
{

constexpr double TWO_PI = 6.283185307179586476925;

using Vector = Eigen::Vector2d; // (d, q) or (α, β)

// Angles and speeds are electrical.
struct Settings {
    // Table 1; inertia and friction are not printed.
    double resistance = 2.125;
    double inductance = 0.0116;
    double flux = 0.387;
    double pole_pairs = 2;
    double inertia = 0.003;
    double friction = 0.001;

    double period = 1e-4;
    double kappa = 0.025;    // η·(φ/L)², with α = 0
    bool newer_speed = true; // W2 and θ̂ take ω̂(k+1); false: ω̂(k), as (14) and (23) are printed

    int slow_samples = 10; // of the speed and position loops
    double current_bandwidth = TWO_PI * 500;
    double speed_bandwidth = TWO_PI * 20;
    double position_bandwidth = TWO_PI * 5;
    double current_max = 10;
    double ramp = TWO_PI * 10000 / 60 * 2; // rad/s²
    double profile_speed = TWO_PI * 900 / 60 * 2;
    double profile_acceleration = 800 * 2;
    double profile_softness = 0.01; // s

    double slow_period() const
    {
        return period * slow_samples;
    }
    double flux_current() const
    {
        return flux / inductance;
    }
    // rad/s² for an ampere of i_q
    double acceleration() const
    {
        return 1.5 * pole_pairs * pole_pairs * flux / inertia;
    }
};

inline Vector turned(const Vector &v, double angle)
{
    return Eigen::Rotation2Dd(angle) * v;
}

// (1) to (4), the torque, and the shaft.
struct Machine {
    using State = Eigen::Vector4d; // i_d, i_q, ω, θ

    State state = State::Zero();

    static State derivative(const Settings &s, const State &x, const Vector &voltage, double load)
    {
        const Vector v = turned(voltage, -x(3));
        const double drag = (load + s.friction * x(2) / s.pole_pairs) / s.inertia * s.pole_pairs;
        return {(v.x() - s.resistance * x(0)) / s.inductance + x(2) * x(1),
                (v.y() - s.resistance * x(1) - x(2) * s.flux) / s.inductance - x(2) * x(0),
                s.acceleration() * x(1) - drag, x(2)};
    }

    // A period of constant voltage in the stationary frame, by Runge and Kutta.
    void run(const Settings &s, const Vector &voltage, double load)
    {
        constexpr int STEPS = 4;
        const double h = s.period / STEPS;
        for (int n = 0; n < STEPS; n++) {
            const State a = derivative(s, state, voltage, load);
            const State b = derivative(s, state + h / 2 * a, voltage, load);
            const State c = derivative(s, state + h / 2 * b, voltage, load);
            const State d = derivative(s, state + h * c, voltage, load);
            state += h / 6 * (a + 2 * b + 2 * c + d);
        }
    }

    Vector current() const
    {
        return state.head<2>();
    }
    double speed() const
    {
        return state(2);
    }
    double angle() const
    {
        return state(3);
    }
};

// (12) to (23).
struct Estimator {
    explicit Estimator(const Settings &s) : network(s.flux_current(), 0)
    {
    }

    Vector network;          // î_x, î_y
    double speed = 0;        // ω̂, (22)
    double speed_taken = 0;  // −W2/T
    double angle = 0;        // θ̂
    double angle_before = 0; // a sample ago

    // A sample: the current at it and the voltage of the period before it, both in the stationary
    // frame.
    void step(const Settings &s, const Vector &current, const Vector &voltage)
    {
        const Vector before = network;
        const Vector shift(s.flux_current(), 0);
        const Vector v = turned(voltage, -(angle_before + angle) / 2) / s.inductance +
                         shift * s.resistance / s.inductance; // (8)
        const double w1 = 1 - s.period * s.resistance / s.inductance;
        const double w2 = -s.period * speed_taken;
        network = w1 * before + w2 * Vector(-before.y(), before.x()) + s.period * v; // (14)–(16)
        const Vector error = turned(current, -angle) - (network - shift);            // (17)
        const double eta = s.kappa / shift.squaredNorm();
        const double change = eta * (error.y() * before.x() - error.x() * before.y()); // (21)
        const double speed_before = speed;
        speed -= change / s.period; // (22)
        speed_taken = s.newer_speed ? speed : speed_before;
        angle_before = angle;
        angle += s.period * speed_taken; // (23)
    }
};

// Machine, estimator and loops; fig. 4 of the paper.
class Drive
{
public:
    explicit Drive(const Settings &settings) : estimator(settings), s(settings)
    {
    }

    // A sample under speed control, and under position control.
    void follow_speed(double command, double load)
    {
        if (slow_loop_is_due()) {
            const double change = s.ramp * s.slow_period();
            control_speed(reference + std::clamp(command - reference, -change, change));
        }
        sample(load);
    }
    void follow_position(double command, double load)
    {
        if (slow_loop_is_due()) {
            control_position(command);
        }
        sample(load);
    }

    Machine machine;
    Estimator estimator;

private:
    bool slow_loop_is_due()
    {
        return samples++ % s.slow_samples == 0;
    }

    void control_position(double command)
    {
        const double lag = profile - estimator.angle;
        const double distance = command - profile;
        const double soft = 0.9 * s.profile_acceleration * s.profile_softness;
        const double brake =
            std::sqrt(2 * 0.9 * s.profile_acceleration * std::abs(distance) + soft * soft) - soft;
        const double wanted = std::copysign(std::min(brake, s.profile_speed), distance);
        const double change = s.profile_acceleration * s.slow_period();
        profile_speed += std::clamp(wanted - profile_speed, -change, change);
        profile += profile_speed * s.slow_period();
        control_speed(profile_speed + s.position_bandwidth * lag);
    }

    // Critically damped, with the torque of the reference's change fed forward.
    void control_speed(double next)
    {
        const double change = (next - reference) / s.slow_period();
        reference = next;
        const double error = reference - estimator.speed;
        speed_integral += s.speed_bandwidth * s.speed_bandwidth * s.slow_period() * error;
        const double wanted = 2 * s.speed_bandwidth * error + speed_integral + change;
        torque_current = std::clamp(wanted / s.acceleration(), -s.current_max, s.current_max);
    }

    // The demand in the rotor frame: the winding's pole cancelled, (1) and (2) decoupled.
    Vector control_current(const Vector &measured)
    {
        const Vector error = Vector(0, torque_current) - measured;
        current_integral += s.current_bandwidth * s.resistance * s.period * error;
        const double w = estimator.speed;
        const Vector emf(-w * s.inductance * measured.y(),
                         w * (s.inductance * measured.x() + s.flux));
        return s.current_bandwidth * s.inductance * error + current_integral + emf;
    }

    // The demand of a sample acts in the period after the next sample.
    void sample(double load)
    {
        const Vector current = turned(machine.current(), machine.angle());
        const double angle = estimator.angle;
        estimator.step(s, current, acting);
        acting = pending;
        pending = turned(control_current(turned(current, -angle)),
                         angle + 1.5 * s.period * estimator.speed);
        machine.run(s, acting, load);
    }

    Settings s;
    int64_t samples = 0;
    double profile = 0;
    double profile_speed = 0;
    double reference = 0;
    double speed_integral = 0;
    double torque_current = 0;
    Vector current_integral = Vector::Zero();
    Vector pending = Vector::Zero();
    Vector acting = Vector::Zero();
};

} // namespace paper_a
