/* SPDX-License-Identifier: MIT */
/*
 * The owner of the serial line: a person's console, or the link of a PC (link_messages.h,
 * docs/link.md).
 *
 * It begins as a console. A person never types a 0x00, so a 0x00 begins a frame. LINK_HELLO gives
 * the line to the PC: the console's text then travels in frames. LINK_BYE, or LINK_PAUSE_MS without
 * a good frame, gives the line back to the person. If no tick runs, passes are counted instead, for
 * about as long.
 *
 * It needs only the functions of hal.h, and no chip. It runs in the background and never waits: a
 * frame goes out in as many passes as the line needs.
 */
#ifndef LINK_H
#define LINK_H

#include "link_state.h"

#define LINK_PAUSE_MS (2000U)

/*
 * Call once, when the serial line works and live_config_init() has chosen the configuration. The
 * application of `live` may be all zero: it may be initialised later, or never if that fails. So
 * the console can say why it failed. The recorder, if there is one, comes from app_record(). `live`
 * must outlive the link.
 */
void link_init(link_t *link, live_config_t *live);

/*
 * Adds a line to the console's text that is to be sent. Characters that do not fit there are lost.
 */
void link_say(link_t *link, const char *line);

/*
 * One pass of the background: bytes in and out, a question, an announcement. Call as often as
 * possible, once a tick or more, between two calls of recorder_service(). A pass takes at most some
 * 20000 instructions.
 */
void link_step(link_t *link);

#endif
