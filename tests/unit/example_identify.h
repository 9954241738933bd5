/* SPDX-License-Identifier: MIT */
/*
 * An identification on the application of example_app.h. A test of a plan puts the sums of the
 * window that has ended where the drive would have them.
 */
#ifndef EXAMPLE_IDENTIFY_H
#define EXAMPLE_IDENTIFY_H

#include "example_app.h"
#include "identify.h"
#include "identify_aim.h"

#include <string.h>

#define CONTINUOUS (5504) /* 6.719 A of 40 A */
#define TARGET (-4321)    /* the user's, before */
#define MS (10)           /* ticks */

static identify_t identify;

static inline void identify_example(void)
{
    const drive_command_t before = {
        .target = TARGET, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};

    power_on();
    calibrate();
    command_mailbox_post(&app.mailbox, &before);
    identify_init(&identify, &app, &ABOUT);
}

static inline void start(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_TRUE(identify_is_busy(&identify));
}

static inline int32_t word(probe_word_t which)
{
    return identify_aim_word(&identify, which);
}

static inline probe_sums_t *sums(void)
{
    return &app.drive.probe.sums;
}

static inline void assert_refused(const char *why)
{
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_EQUAL_STRING(why, identify.why);
}

#endif
