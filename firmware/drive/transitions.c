/* SPDX-License-Identifier: MIT */
#include "transitions.h"

#define NUMBER_SHIFT (4U) /* the upper four bits of a code are the number (state.h) */
#define IN(state) (1UL << ((uint32_t)(state) >> NUMBER_SHIFT))
#define FROM_HOLD_TO_HANDOVER \
    (IN(DRIVE_STATE_HOLD) | IN(DRIVE_STATE_IF_RAMP) | IN(DRIVE_STATE_HANDOVER))
#define DRIVING \
    (FROM_HOLD_TO_HANDOVER | IN(DRIVE_STATE_FLYING_START) | IN(DRIVE_STATE_PROBE) | \
     IN(DRIVE_STATE_ALIGN) | IN(DRIVE_STATE_RUN))
#define ANY_BUT_FAULT \
    (DRIVING | IN(DRIVE_STATE_INIT) | IN(DRIVE_STATE_OFFSET_CAL) | IN(DRIVE_STATE_READY))

drive_state_t transitions_state(uint32_t number)
{
    static const drive_state_t states[DRIVE_STATES] = {
        DRIVE_STATE_INIT,     DRIVE_STATE_OFFSET_CAL, DRIVE_STATE_READY, DRIVE_STATE_FLYING_START,
        DRIVE_STATE_PROBE,    DRIVE_STATE_ALIGN,      DRIVE_STATE_HOLD,  DRIVE_STATE_IF_RAMP,
        DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN,        DRIVE_STATE_FAULT,
    };

    return states[(number < DRIVE_STATES) ? number : (DRIVE_STATES - 1U)];
}

uint32_t transitions_number(drive_state_t state)
{
    const uint32_t number = (uint32_t)state >> NUMBER_SHIFT;

    return (transitions_state(number) == state) ? number : DRIVE_STATES;
}

bool transitions_is_state(drive_state_t state)
{
    return transitions_number(state) < DRIVE_STATES;
}

drive_state_t transitions_next(drive_state_t state, drive_event_t event)
{
    static const struct {
        drive_state_t next;
        /* states in which the event acts, one bit each; in others it changes nothing */
        uint32_t from;
    } table[DRIVE_EVENTS] = {
        [DRIVE_EVENT_NONE] = {DRIVE_STATE_INIT, 0U},
        [DRIVE_EVENT_CALIBRATE] = {DRIVE_STATE_OFFSET_CAL,
                                   IN(DRIVE_STATE_INIT) | IN(DRIVE_STATE_FAULT)},
        [DRIVE_EVENT_CALIBRATED] = {DRIVE_STATE_READY, IN(DRIVE_STATE_OFFSET_CAL)},
        [DRIVE_EVENT_STOP] = {DRIVE_STATE_READY, DRIVING},
        [DRIVE_EVENT_SEARCH] = {DRIVE_STATE_FLYING_START, IN(DRIVE_STATE_READY) |
                                                              IN(DRIVE_STATE_ALIGN) |
                                                              FROM_HOLD_TO_HANDOVER},
        [DRIVE_EVENT_PROBE] = {DRIVE_STATE_PROBE, IN(DRIVE_STATE_READY)},
        [DRIVE_EVENT_STANDS] = {DRIVE_STATE_ALIGN,
                                IN(DRIVE_STATE_FLYING_START) | IN(DRIVE_STATE_HOLD)},
        [DRIVE_EVENT_HELD] = {DRIVE_STATE_HOLD, IN(DRIVE_STATE_ALIGN) | FROM_HOLD_TO_HANDOVER},
        [DRIVE_EVENT_SLOW] = {DRIVE_STATE_HOLD, IN(DRIVE_STATE_RUN)},
        [DRIVE_EVENT_DRAGGED] = {DRIVE_STATE_IF_RAMP,
                                 IN(DRIVE_STATE_FLYING_START) | FROM_HOLD_TO_HANDOVER},
        [DRIVE_EVENT_FAST] = {DRIVE_STATE_HANDOVER, FROM_HOLD_TO_HANDOVER},
        [DRIVE_EVENT_TRACKED] = {DRIVE_STATE_RUN,
                                 IN(DRIVE_STATE_READY) | IN(DRIVE_STATE_FLYING_START) |
                                     IN(DRIVE_STATE_HOLD) | IN(DRIVE_STATE_HANDOVER)},
        [DRIVE_EVENT_FAULT] = {DRIVE_STATE_FAULT, ANY_BUT_FAULT},
    };
    const uint32_t number = transitions_number(state);
    drive_state_t next = state;

    /*@ split number; */
    /*@ split event; */
    if (number == DRIVE_STATES) {
        next = DRIVE_STATE_FAULT;
    } else if (((table[event].from >> number) & 1U) != 0U) {
        next = table[event].next;
    } else {
        /* nothing follows */
    }
    return next;
}
