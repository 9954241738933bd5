/* SPDX-License-Identifier: MIT */
/*
 * The angle of the shaft from the frames of an absolute sensor of the AS5047 class.
 *
 * A frame has 16 bits: the angle in bits 13…0, an error flag in bit 14, and in bit 15 the parity
 * that makes the number of ones even. A frame with a wrong parity or with the error flag is bad.
 * So is an angle that is off the expected one by more than 0.35° and by more than half of the
 * speed. So is one that is the last one again, though the shaft turns by two steps of it a tick or
 * more: no shaft stops within a tick. The angle goes on with the last speed then. After more than
 * ABSOLUTE_BRIDGE_TICKS bad frames in a row the angle is lost. It is known again after as many good
 * frames in a row, each 1/16 turn or less from the one before.
 *
 * A wire that is low for ever is a good frame of angle 0. It is found once the shaft turns.
 *
 * A frame is transferred while the tick before runs, so it is the angle of the last tick. `ahead`
 * is one tick of the speed further.
 *
 * Pure, total; call from the control interrupt.
 */
#ifndef ABSOLUTE_H
#define ABSOLUTE_H

#include "shaft_trouble.h"

#include <stdbool.h>
#include <stdint.h>

#define ABSOLUTE_BRIDGE_TICKS (8U)

typedef struct {
    uint32_t zero;     /* angle of the sensor where the flux is along phase a, 2^16 a turn */
    uint32_t reversed; /* 1: the angle falls while the shaft turns from a towards b */
} absolute_cfg_t;

typedef struct {
    uint16_t ahead;   /* angle of the shaft in this tick, 2^16 = one turn */
    uint16_t angle;   /* one tick before */
    uint16_t reading; /* angle of the last frame, good or bad */
    int32_t speed;    /* advance of the angle a tick, 2^20 = one turn, mean over some 16 ticks */
    uint32_t bad;     /* bad frames in a row, 0…ABSOLUTE_BRIDGE_TICKS + 1 */
    uint32_t good; /* good frames in a row while the angle is not known, 0…ABSOLUTE_BRIDGE_TICKS */
    bool known;
    uint8_t trouble; /* shaft_trouble_t that was found in this tick */
} absolute_t;

/* The angle is not known. */
void absolute_start(absolute_t *absolute);

/* One tick with the received frame. Returns whether `ahead` is known. */
bool absolute_step(absolute_t *absolute, const absolute_cfg_t *cfg, uint16_t frame);

#endif
