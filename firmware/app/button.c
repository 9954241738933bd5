/* SPDX-License-Identifier: MIT */
#include "button.h"

bool button_step(button_t *button, bool raw, uint32_t tick, uint32_t bounce_ticks)
{
    bool becomes_pressed = false;

    if (raw != button->raw) {
        button->raw = raw;
        button->since = tick;
    } else if ((raw != button->pressed) && ((tick - button->since) >= bounce_ticks)) {
        button->pressed = raw;
        becomes_pressed = raw;
    } else {
        /* nothing new, or not long enough */
    }
    return becomes_pressed;
}
