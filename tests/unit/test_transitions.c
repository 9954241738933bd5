/* SPDX-License-Identifier: MIT */
#include "testing.h"
#include "transitions.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

/* All that may follow; whatever is not here changes nothing. */
static const struct {
    drive_state_t from;
    drive_event_t event;
    drive_state_t to;
} edges[] = {
    {DRIVE_STATE_INIT, DRIVE_EVENT_CALIBRATE, DRIVE_STATE_OFFSET_CAL},
    {DRIVE_STATE_OFFSET_CAL, DRIVE_EVENT_CALIBRATED, DRIVE_STATE_READY},
    {DRIVE_STATE_READY, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_READY, DRIVE_EVENT_PROBE, DRIVE_STATE_PROBE},
    {DRIVE_STATE_READY, DRIVE_EVENT_TRACKED, DRIVE_STATE_RUN},
    {DRIVE_STATE_READY, DRIVE_EVENT_PROBE, DRIVE_STATE_PROBE},
    {DRIVE_STATE_FLYING_START, DRIVE_EVENT_STANDS, DRIVE_STATE_ALIGN},
    {DRIVE_STATE_FLYING_START, DRIVE_EVENT_DRAGGED, DRIVE_STATE_IF_RAMP},
    {DRIVE_STATE_FLYING_START, DRIVE_EVENT_TRACKED, DRIVE_STATE_RUN},
    {DRIVE_STATE_ALIGN, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
    {DRIVE_STATE_ALIGN, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_HOLD, DRIVE_EVENT_STANDS, DRIVE_STATE_ALIGN},
    {DRIVE_STATE_HOLD, DRIVE_EVENT_DRAGGED, DRIVE_STATE_IF_RAMP},
    {DRIVE_STATE_HOLD, DRIVE_EVENT_FAST, DRIVE_STATE_HANDOVER},
    {DRIVE_STATE_HOLD, DRIVE_EVENT_TRACKED, DRIVE_STATE_RUN},
    {DRIVE_STATE_HOLD, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_FAST, DRIVE_STATE_HANDOVER},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_DRAGGED, DRIVE_STATE_IF_RAMP},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_TRACKED, DRIVE_STATE_RUN},
    {DRIVE_STATE_RUN, DRIVE_EVENT_SLOW, DRIVE_STATE_HOLD},
    {DRIVE_STATE_FAULT, DRIVE_EVENT_CALIBRATE, DRIVE_STATE_OFFSET_CAL},
};

static drive_state_t expected(drive_state_t from, drive_event_t event)
{
    drive_state_t to = from;

    for (uint32_t k = 0U; k < COUNT(edges); k++) {
        if ((edges[k].from == from) && (edges[k].event == event)) {
            to = edges[k].to;
        }
    }
    if (event == DRIVE_EVENT_FAULT) {
        to = DRIVE_STATE_FAULT;
    }
    if ((event == DRIVE_EVENT_STOP) && drive_is_driving(from)) {
        to = DRIVE_STATE_READY;
    }
    return to;
}

TEST(test_each_pair_of_state_and_event_leads_where_the_state_machine_says)
{
    for (uint32_t number = 0U; number < DRIVE_STATES; number++) {
        const drive_state_t state = transitions_state(number);

        for (int event = (int)DRIVE_EVENT_NONE; event < (int)DRIVE_EVENTS; event++) {
            TEST_ASSERT_EQUAL(expected(state, (drive_event_t)event),
                              transitions_next(state, (drive_event_t)event));
        }
    }
}

static uint32_t bits_of(uint32_t word)
{
    uint32_t bits = 0U;

    for (uint32_t k = 0U; k < 32U; k++) {
        bits += (word >> k) & 1U;
    }
    return bits;
}

TEST(test_the_codes_of_two_states_differ_in_four_bits_and_ascend)
{
    for (uint32_t k = 0U; k < DRIVE_STATES; k++) {
        for (uint32_t other = 0U; other < k; other++) {
            const uint32_t code = (uint32_t)transitions_state(k);
            const uint32_t below = (uint32_t)transitions_state(other);

            TEST_ASSERT_TRUE(code > below);
            TEST_ASSERT_TRUE(bits_of(code ^ below) >= 4U);
        }
    }
}

TEST(test_each_state_has_the_number_of_its_place)
{
    for (uint32_t k = 0U; k < DRIVE_STATES; k++) {
        TEST_ASSERT_EQUAL_UINT32(k, transitions_number(transitions_state(k)));
        TEST_ASSERT_TRUE(transitions_is_state(transitions_state(k)));
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, transitions_state(DRIVE_STATES));
}

TEST(test_from_up_to_three_flipped_bits_of_a_state_every_event_leads_to_a_fault)
{
    for (uint32_t number = 0U; number < DRIVE_STATES; number++) {
        for (uint32_t first = 0U; first < 32U; first++) {
            for (uint32_t last = first; last < 32U; last++) {
                const uint32_t flips = (1U << first) | (1U << last) | (1U << (last / 2U));
                const drive_state_t code =
                    (drive_state_t)((uint32_t)transitions_state(number) ^ flips);

                TEST_ASSERT_EQUAL_UINT32(DRIVE_STATES, transitions_number(code));
                for (int event = (int)DRIVE_EVENT_NONE; event < (int)DRIVE_EVENTS; event++) {
                    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT,
                                      transitions_next(code, (drive_event_t)event));
                }
            }
        }
    }
}
