/* SPDX-License-Identifier: MIT */
/*
 * The owner of the serial line: a person's console, or the link of a PC (link_messages.h,
 * docs/link.md).
 *
 * It begins as a console. A person never types a 0x00, so that one begins a frame. LINK_HELLO makes
 * the line the PC's: what the console says travels in frames then. LINK_BYE, or LINK_PAUSE_MS
 * without a good frame, gives it back to the person. Where no tick runs, passes are counted
 * instead, for about as long.
 *
 * It needs hal_receive(), hal_send() and hal_health() of the binding, and no chip. It runs in the
 * background, and never waits: a frame goes out in as many passes as the line takes.
 */
#ifndef LINK_H
#define LINK_H

#include "link_state.h"

#define LINK_PAUSE_MS (2000U)

/*
 * Call once, when the serial line works and live_config_init() has chosen the configuration. The
 * application of `live` may be initialised later, and never if that fails: it is zero before. So
 * the console can say why. The recorder, where there is one, is that of app_record(). `live`
 * outlives the link.
 */
void link_init(link_t *link, live_config_t *live);

/* A line of the console. What does not fit behind what is still to be sent is lost. */
void link_say(link_t *link, const char *line);

/*
 * One pass of the background: bytes in and out, a question, an announcement. Call as often as
 * possible, once a tick or more, between two calls of recorder_service(). A pass takes at most some
 * 20000 instructions.
 */
void link_step(link_t *link);

#endif
