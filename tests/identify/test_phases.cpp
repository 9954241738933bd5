// SPDX-License-Identifier: MIT
// What a contact, a winding and a sensor make of R and L on the three axes, told apart again.
#include "phases.h"

#include "testing.h"

namespace
{

using namespace nf::identify;

constexpr double EXACT = 1e-9;

// A share of R more in phase a alone: its axis has half of the phase and half of the mean, 2/3
// more, the others 1/6, the mean 1/3.
constexpr double CONTACT = 0.1;
constexpr double AXIS = CONTACT / 3 / (1 + CONTACT / 3); // of axis a over the mean, less one

// As fit_legs finds it, for which an axis of more R has a sensor that sees less.
Legs legs_of_contact()
{
    Legs legs;
    legs.mismatch.value = -1.5 * AXIS;
    legs.third.value = -AXIS / 2;
    return legs;
}

TEST(test_a_contact_is_no_difference_of_the_gains)
{
    // L of axis a, with the gains of the legs taken off, is too small by what the sensor does not
    // have
    Inductances inductances;
    inductances.axes.share[0] = -0.75 * AXIS;
    inductances.axes.share[1] = 0.75 * AXIS;
    const Phases found = fit_phases(legs_of_contact(), inductances);
    TEST_ASSERT_TRUE(found.are_unlike);
    TEST_ASSERT_EQUAL_INT(0, found.phase);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, CONTACT, found.resistance_share);
    TEST_ASSERT_EQUAL_DOUBLE(0, found.inductance_share);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, found.mismatch.value);
}

} // namespace
