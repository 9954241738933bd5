// SPDX-License-Identifier: MIT
// Motor equations, their linearisation and its discretisation.
#include "discretise.h"
#include "shipped.h"
#include "testing.h"

#include <cmath>

#include <unsupported/Eigen/MatrixFunctions>

using namespace test;

namespace
{

constexpr double PI = 3.14159265358979323846;
// Rounding of a few dozen operations on numbers of the compared size.
constexpr double ROUNDING = 1e-13;
// Central differences with step h lose h²/6 of the third derivative and 1e-16/h to rounding: with
// h = 1e-4 and derivatives of the compared size, below 1e-8.
constexpr double STEP = 1e-4;
constexpr double DIFFERENCES = 1e-7;

const NominalPoint &nominal()
{
    return shipped().nominal;
}

Machine machine()
{
    return make_machine(shipped().inputs.motor, nominal().inertia_kg_m2);
}

Eigen::Vector4d nominal_state()
{
    return {nominal().i_q_a, nominal().i_d_a, nominal().speed_rad_s,
            nominal().torque_angle_deg * PI / 180};
}

void expect_near(const Eigen::MatrixXd &expected, const Eigen::MatrixXd &actual, double share)
{
    const double size = expected.cwiseAbs().maxCoeff();
    TEST_ASSERT_DOUBLE_WITHIN(share * size, 0, (expected - actual).cwiseAbs().maxCoeff());
}

TEST(the_nominal_point_is_the_papers)
{
    TEST_ASSERT_EQUAL_DOUBLE(251.2, nominal().speed_rad_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.11, nominal().inertia_kg_m2);
    TEST_ASSERT_EQUAL_DOUBLE(0.0235, machine().inductance_q_h);
    TEST_ASSERT_EQUAL_DOUBLE(3, machine().torque_factor); // two pole pairs
}

TEST(steady_voltages_and_currents_are_each_others_inverse)
{
    const Currents i = steady_currents(machine(), {95, -24}, 251.2);
    const Voltages v = steady_voltages(machine(), i, 251.2);
    TEST_ASSERT_DOUBLE_WITHIN(100 * ROUNDING, 95, v.q_v);
    TEST_ASSERT_DOUBLE_WITHIN(100 * ROUNDING, -24, v.d_v);
}

TEST(without_resistance_torque_by_angle_is_torque_by_currents)
{
    Machine ideal = machine();
    ideal.resistance_ohm = 0;
    for (const double lead_rad : {0.1, 0.4, 1.2}) {
        const Voltages v = voltages_at(200, -lead_rad); // the angle of (19) lags
        const double expected = torque(ideal, steady_currents(ideal, v, 251.2));
        TEST_ASSERT_DOUBLE_WITHIN(std::abs(expected) * ROUNDING * 100, expected,
                                  torque_of_angle(ideal, 2, 200, lead_rad, 251.2));
    }
}

TEST(a_point_that_is_held_does_not_move)
{
    const Machine m = machine();
    const Currents i = {4.197, -0.1465};
    const Voltages v = steady_voltages(m, i, 251.2);
    const Eigen::Vector4d rate = derivative(m, {i.q_a, i.d_a, 251.2, std::atan2(v.d_v, v.q_v)},
                                            {std::hypot(v.q_v, v.d_v), torque(m, i), 251.2});
    TEST_ASSERT_DOUBLE_WITHIN(1e4 * ROUNDING, 0,
                              rate.cwiseAbs().maxCoeff()); // volts over millihenries
}

TEST(f_is_the_derivative_of_the_motor_equations_by_the_state)
{
    const Drive drive = {nominal().voltage_v, 3, nominal().speed_rad_s};
    MotorMatrix differences;
    for (int k = 0; k < MOTOR_STATES; k++) {
        const Eigen::Vector4d step = STEP * Eigen::Vector4d::Unit(k);
        differences.col(k) = (derivative(machine(), nominal_state() + step, drive) -
                              derivative(machine(), nominal_state() - step, drive)) /
                             (2 * STEP);
    }
    expect_near(differences, linearise(machine(), nominal()).f, DIFFERENCES);
}

TEST(g_is_the_derivative_by_load_and_supply_where_the_voltage_follows_the_supply_along_q)
{
    const MotorInputs g = linearise(machine(), nominal()).g;
    const auto rate = [](double load_nm, double supply_rad_s) {
        // (22), (23): all of the voltage's change is in v_q.
        const double volts = nominal().voltage_per_speed_v_s_per_rad * supply_rad_s;
        Eigen::Vector4d x =
            derivative(machine(), nominal_state(),
                       {nominal().voltage_v, load_nm, nominal().speed_rad_s + supply_rad_s});
        x[I_Q] += volts / machine().inductance_q_h;
        return x;
    };
    MotorInputs differences;
    differences.col(LOAD) = (rate(STEP, 0) - rate(-STEP, 0)) / (2 * STEP);
    differences.col(SUPPLY) = (rate(0, STEP) - rate(0, -STEP)) / (2 * STEP);
    expect_near(differences, g, DIFFERENCES);
}

TEST(the_exponential_is_eigens)
{
    for (const double time_s : {1e-4, 0.01, 0.1}) {
        const Eigen::MatrixXd a = linearise(machine(), nominal()).f * time_s;
        const Eigen::MatrixXd eigens = a.exp();
        // Both lose about a bit with each squaring; 15 of them at most.
        expect_near(eigens, exponential(a), 1e-11);
    }
}

TEST(the_exponential_of_a_rotation_is_sine_and_cosine)
{
    const double angle = 2.512;
    Eigen::Matrix2d turn;
    turn << 0, -angle, angle, 0;
    Eigen::Matrix2d expected;
    expected << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    expect_near(expected, exponential(turn), ROUNDING);
}

TEST(the_exponential_of_a_nilpotent_matrix_ends_after_its_terms)
{
    Eigen::Matrix3d a;
    a << 0, 2, 3, 0, 0, 5, 0, 0, 0;
    const Eigen::Matrix3d expected = Eigen::Matrix3d::Identity() + a + a * a / 2;
    expect_near(expected, exponential(a), ROUNDING);
}

TEST(theta_is_the_integral_of_the_response_to_a_held_input)
{
    const Continuous c = linearise(machine(), nominal());
    const Discrete d = discretise(c, 0.01);
    // F·Θ = (Φ − 1)·G is the integral's closed form, without dividing by F.
    expect_near((d.phi - MotorMatrix::Identity()) * c.g, c.f * d.theta, 1e-11);
}

TEST(two_half_samples_make_a_sample)
{
    const Continuous c = linearise(machine(), nominal());
    const Discrete half = discretise(c, 0.005);
    const Discrete whole = discretise(c, 0.01);
    expect_near(whole.phi, half.phi * half.phi, 1e-12);
    expect_near(whole.theta, half.phi * half.theta + half.theta, 1e-12);
}

} // namespace
