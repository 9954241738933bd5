// SPDX-License-Identifier: MIT
// What a sample of runs says of all.
#include "statistics.h"

#include <cmath>
#include <vector>

#include "testing.h"

namespace
{

using namespace nf::certify;

constexpr double EXACT = 1e-12;

// n of n: n/(n + z²), z = 1.6449; 50 of 100 by the formula of Wilson.
TEST(test_a_share_of_all_is_surer_with_more_runs)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10 / (10 + 2.7057), least_share(10, 10));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 200 / (200 + 2.7057), least_share(200, 200));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.4188, least_share(50, 100));
}

TEST(test_without_a_good_run_or_any_run_the_share_is_0)
{
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, least_share(0, 20));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, least_share(0, 0));
}

TEST(test_a_quantile_lies_between_two_values)
{
    const std::vector<double> values = {4, 1, 3, 2};
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1, quantile(values, 0));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 2.5, quantile(values, 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 4, quantile(values, 1));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, quantile({}, 0.5));
}

TEST(test_a_range_has_four_quarters)
{
    TEST_ASSERT_EQUAL_INT(0, quarter_of(-1, -1, 1));
    TEST_ASSERT_EQUAL_INT(1, quarter_of(-0.1, -1, 1));
    TEST_ASSERT_EQUAL_INT(3, quarter_of(1, -1, 1));
}

TEST(test_groups_that_decide_explain_all)
{
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1, explained_share({0, 0, 1, 1, 2}, {1, 1, 5, 5, 2}));
}

// (12, 10, 8) in each group: nothing is between groups, and chance would make more.
TEST(test_groups_that_do_not_matter_explain_nothing)
{
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0,
                              explained_share({0, 0, 0, 1, 1, 1}, {12, 10, 8, 12, 10, 8}));
}

TEST(test_without_variance_or_groups_nothing_is_explained)
{
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, explained_share({0, 1, 2, 3, 0}, {7, 7, 7, 7, 7}));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, explained_share({0, 0, 0}, {1, 2, 3}));
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, explained_share({0, 1}, {1, 2}));
}

// ±1 between the groups and ±1 within them: half each, less what chance explains, 1 of 398.
TEST(test_half_of_the_variance_is_half)
{
    std::vector<int> groups;
    std::vector<double> values;
    for (int k = 0; k < 400; k++) {
        groups.push_back(k % 2);
        values.push_back((k % 2 == 0 ? 1 : -1) + (k % 4 < 2 ? 1 : -1));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.5, explained_share(groups, values));
}

} // namespace
