/* SPDX-License-Identifier: MIT */
/*
 * Answers the questions of link_messages.h. After HELLO and BYE, link.c changes the owner of the
 * line.
 *
 * Context: background, between two calls of recorder_service().
 */
#ifndef LINK_ANSWERS_H
#define LINK_ANSWERS_H

#include "link_state.h"

#include <stdint.h>

/*
 * Carries out the message of `length` bytes in link->in, and writes the answer to link->out, which
 * must be free. A message of an unknown type or a wrong length does nothing and is answered with
 * LINK_REFUSED. Returns the message's type, or LINK_REFUSED.
 */
uint8_t link_answer(link_t *link, uint32_t length);

#endif
