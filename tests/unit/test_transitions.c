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
    {DRIVE_STATE_HOLD, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_FAST, DRIVE_STATE_HANDOVER},
    {DRIVE_STATE_IF_RAMP, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_DRAGGED, DRIVE_STATE_IF_RAMP},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_SEARCH, DRIVE_STATE_FLYING_START},
    {DRIVE_STATE_HANDOVER, DRIVE_EVENT_TRACKED, DRIVE_STATE_RUN},
    {DRIVE_STATE_RUN, DRIVE_EVENT_HELD, DRIVE_STATE_HOLD},
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
    for (int state = (int)DRIVE_STATE_INIT; state <= (int)DRIVE_STATE_FAULT; state++) {
        for (int event = (int)DRIVE_EVENT_NONE; event < (int)DRIVE_EVENTS; event++) {
            TEST_ASSERT_EQUAL(expected((drive_state_t)state, (drive_event_t)event),
                              transitions_next((drive_state_t)state, (drive_event_t)event));
        }
    }
}
