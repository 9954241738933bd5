/* SPDX-License-Identifier: MIT */
/*
 * The questions of link_messages.h and their answers. What HELLO and BYE do to the line is
 * link.h's.
 *
 * Context: background, between two calls of recorder_service().
 */
#ifndef LINK_ANSWERS_H
#define LINK_ANSWERS_H

#include "link_state.h"

#include <stdint.h>

/*
 * Does what a message of `length` bytes in link->in asks for, and writes the answer to link->out,
 * which is free. A message that is none, or of a wrong length, does nothing and is answered with
 * LINK_REFUSED. Returns its type, or LINK_REFUSED.
 */
uint8_t link_answer(link_t *link, uint32_t length);

#endif
