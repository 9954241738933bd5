/* SPDX-License-Identifier: MIT */
#include "check.h"

#include "image.h"
#include "pace.h"
#include "pins.h"
#include "settings.h"

#include <stddef.h>
#include <stdint.h>

/* Room for the longest text: "register ", a name, " is not as it was set". */
#define REASON_ROOM (48U)

static char reason[REASON_ROOM];

static uint32_t append(uint32_t length, const char *text)
{
    uint32_t k = 0U;

    while (text[k] != '\0') {
        reason[length + k] = text[k];
        k++;
    }
    reason[length + k] = '\0';
    return length + k;
}

static const char *changed(const char *kind, const char *name)
{
    (void)append(append(append(0U, kind), name), " is not as it was set");
    return reason;
}

static const char *check_row(uint32_t row)
{
    const uint32_t pin = row - settings_count();
    const char *why = NULL;

    if (row < settings_count()) {
        why = settings_hold(row) ? NULL : changed("register ", settings_name(row));
    } else {
        why = pins_hold(pin) ? NULL : changed("pin ", pins_name(pin));
    }
    return why;
}

const char *check_all(void)
{
    const uint32_t rows = settings_count() + pins_count();
    const char *why = NULL;

    for (uint32_t row = 0U; (why == NULL) && (row < rows); row++) {
        why = check_row(row);
    }
    return why;
}

static const char *check_next_row(void)
{
    static uint32_t row; /* index of a setting; after the settings, of a pin */
    const uint32_t rows = settings_count() + pins_count();

    row = ((row + 1U) < rows) ? (row + 1U) : 0U;
    return check_row(row);
}

const char *check_step(uint32_t tick)
{
    const char *why = pace_step(tick);

    if (why != NULL) {
        /* one fault is enough */
    } else if (!image_step()) {
        why = CHECK_IMAGE;
    } else {
        why = check_next_row();
    }
    return why;
}
