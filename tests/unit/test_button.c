/* SPDX-License-Identifier: MIT */
/* A button that bounces is pressed once. */
#include "button.h"
#include "testing.h"

#define BOUNCE (20U)

static button_t button;
static uint32_t tick;

void setUp(void)
{
    button = (button_t){0};
    tick = 0U;
}

/* Returns how often it has become pressed. */
static uint32_t hold(bool raw, uint32_t ticks)
{
    uint32_t presses = 0U;

    for (uint32_t k = 0U; k < ticks; k++) {
        tick++;
        presses += button_step(&button, raw, tick, BOUNCE) ? 1U : 0U;
    }
    return presses;
}

TEST(test_it_is_pressed_after_it_has_been_so_for_its_time)
{
    TEST_ASSERT_EQUAL_UINT32(0U, hold(true, BOUNCE));
    TEST_ASSERT_FALSE(button.pressed);
    TEST_ASSERT_EQUAL_UINT32(1U, hold(true, 1U));
    TEST_ASSERT_TRUE(button.pressed);
    TEST_ASSERT_EQUAL_UINT32(0U, hold(true, 1000U));
}

TEST(test_bounces_are_no_presses)
{
    for (uint32_t k = 1U; k < BOUNCE; k++) {
        TEST_ASSERT_EQUAL_UINT32(0U, hold(true, k) + hold(false, 1U));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, hold(true, BOUNCE + 1U));
    for (uint32_t k = 1U; k < BOUNCE; k++) {
        TEST_ASSERT_EQUAL_UINT32(0U, hold(false, k) + hold(true, 1U));
    }
    TEST_ASSERT_TRUE(button.pressed);
    TEST_ASSERT_EQUAL_UINT32(0U, hold(false, BOUNCE + 1U));
    TEST_ASSERT_FALSE(button.pressed);
}
