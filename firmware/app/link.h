/* SPDX-License-Identifier: MIT */
/*
 * Shares the serial line between two owners: the console of a person, and the link of a PC
 * (link_messages.h, docs/link.md).
 *
 * At the start the console has the line. A person never types a 0x00, so a 0x00 begins a frame.
 * LINK_HELLO gives the line to the PC: the console's text then travels in frames. LINK_BYE, or
 * LINK_PAUSE_MS without a good frame, gives the line back to the person. If no tick runs, passes of
 * link_step() are counted instead, for about the same time.
 *
 * The link uses only the functions of hal.h, and is the same for every chip. It runs in the
 * background and never waits: a frame goes out in as many passes as the line needs.
 */
#ifndef LINK_H
#define LINK_H

#include "link_state.h"

#define LINK_PAUSE_MS (2000U)

/*
 * Call once, when the serial line works and live_config_init() has chosen the configuration. The
 * application of `live` may be all zero, because app_init() may follow later, or may fail. So the
 * console can say why app_init() failed. The recorder, if there is one, comes from app_record().
 * `live` must outlive the link.
 */
void link_init(link_t *link, live_config_t *live);

/*
 * Adds a line to the console's text that is to be sent. Characters that do not fit there are lost.
 */
void link_say(link_t *link, const char *line);

/*
 * One pass of the background: receives and sends bytes, answers a question, shows a new state. Call
 * as often as possible, once a tick or more, between two calls of recorder_service(). A pass takes
 * at most some 20000 instructions.
 */
void link_step(link_t *link);

#endif
