// SPDX-License-Identifier: MIT
// Least squares against results that are known by hand.
#include "least_squares.h"

#include <cmath>

#include "testing.h"

namespace
{

using namespace nf::identify;

constexpr double ROUNDED = 1e-12;
constexpr double STEPPED = 1e-6; // derivatives by differences of 1e-6

// 1, 2, 3: the mean is 2, its standard deviation 1/√3.
TEST(test_a_mean_has_its_standard_deviation)
{
    const Fit fit = fit_linear(Eigen::MatrixXd::Ones(3, 1), Eigen::Vector3d(1, 2, 3));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 2, fit.value[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 1 / std::sqrt(3.0), fit.std[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 1, fit.rms);
}

TEST(test_a_line_without_scatter_is_exact)
{
    Eigen::MatrixXd rows(4, 2);
    rows << 1, 0, 1, 1, 1, 2, 1, 3;
    const Fit fit = fit_linear(rows, Eigen::Vector4d(5, 3, 1, -1));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 5, fit.value[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, -2, fit.value[1]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDED, 0, fit.std[1]);
}

TEST(test_a_curve_is_found_from_far)
{
    const auto residuals = [](const Eigen::VectorXd &p) {
        Eigen::VectorXd r(8);
        for (int k = 0; k < 8; k++) {
            r[k] = p[0] * std::exp(-p[1] * k) - 3 * std::exp(-0.5 * k);
        }
        return r;
    };
    const Fit fit = fit_curve(residuals, Eigen::Vector2d(1, 0.1));
    TEST_ASSERT_DOUBLE_WITHIN(STEPPED, 3, fit.value[0]);
    TEST_ASSERT_DOUBLE_WITHIN(STEPPED, 0.5, fit.value[1]);
}

// A step of the derivative is a share of the parameter's size, whatever its sign.
TEST(test_a_curve_that_is_a_line_has_its_deviations)
{
    Eigen::MatrixXd rows(4, 2);
    rows << 1, 0, 1, 1, 1, 2, 1, 3;
    const Eigen::Vector4d measured(-3.01, -4.99, -7.02, -8.98);
    const Fit line = fit_linear(rows, measured);
    const Fit curve =
        fit_curve([&](const Eigen::VectorXd &p) { return Eigen::VectorXd(rows * p - measured); },
                  Eigen::Vector2d(-1, -1));
    for (const int k : {0, 1}) {
        TEST_ASSERT_TRUE(line.value[k] < 0);
        TEST_ASSERT_DOUBLE_WITHIN(STEPPED, line.value[k], curve.value[k]);
        TEST_ASSERT_DOUBLE_WITHIN(STEPPED * line.std[k], line.std[k], curve.std[k]);
    }
}

// A parameter that nothing depends on does not spoil the others.
TEST(test_a_parameter_without_effect_stays)
{
    const auto residuals = [](const Eigen::VectorXd &p) {
        return Eigen::VectorXd(Eigen::Vector3d(p[0] - 1, p[0] - 1, p[0] - 1));
    };
    const Fit fit = fit_curve(residuals, Eigen::Vector2d(4, 7));
    TEST_ASSERT_DOUBLE_WITHIN(STEPPED, 1, fit.value[0]);
    TEST_ASSERT_TRUE(std::isfinite(fit.value[1]));
}

} // namespace
