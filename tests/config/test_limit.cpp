// SPDX-License-Identifier: MIT
// The limit of a value as a text.
#include "limit.h"
#include "setting_error.h"

extern "C" {
#include "testing.h"
}

#include <cmath>
#include <cstdlib>

namespace
{

double number_of(const nf::SettingLimit &limit, int digits)
{
    return std::strtod(nf::limit_number(limit, digits).c_str(), nullptr);
}

TEST(a_limit_that_is_written_is_allowed_itself)
{
    constexpr double DIGIT = 1e-3; // of four digits: what the text may leave out
    for (double value = 1e-9; value < 1e12; value *= 1.37) {
        for (const double limit : {value, -value}) {
            const double most = number_of({true, limit}, 4);
            const double least = number_of({false, limit}, 4);
            TEST_ASSERT_TRUE(most <= limit && most > limit - DIGIT * value);
            TEST_ASSERT_TRUE(least >= limit && least < limit + DIGIT * value);
        }
    }
}

TEST(a_limit_that_has_no_more_digits_is_written_as_it_is)
{
    TEST_ASSERT_EQUAL_STRING("-80 to 79.99755859",
                             nf::limits_text(-80, 79.99755859375, 10).c_str());
    TEST_ASSERT_EQUAL_STRING("0 to 0.3", nf::limits_text(0, 0.3).c_str());
    TEST_ASSERT_EQUAL_STRING("-0.07 to 655300000", nf::limits_text(-0.07, 655300000).c_str());
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
