/* SPDX-License-Identifier: MIT */
/*
 * The angle of the shaft from the counter of an incremental encoder.
 *
 * The counter has four counts a line and wraps at 16 bits. The angle counts from where the shaft
 * was at the first call. So it is known but for a constant, which an alignment finds.
 *
 * The index comes once a turn at the same angle. Where that is, and whether counts were lost or
 * gained, two indexes tell that come a turn apart at the same place, within 1/16 turn. Until then
 * an index off its place changes nothing and is named, as it may be a disturbance. Two turns
 * without an index are named too.
 *
 * Within 4 ticks a shaft does not change its speed by half, and by 2 counts and 1/4096 turn a tick.
 * If the counter does, a wire is open or shorted. The angle is lost then: it counts on from
 * anywhere.
 *
 * Pure, total; call from the control interrupt.
 */
#ifndef ENCODER_H
#define ENCODER_H

#include "shaft_trouble.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t counts;     /* of a turn, 4 a line: 4…65532 */
    uint32_t scale_q32; /* 2^32 / counts, rounded down: 65537…2^30 */
    uint32_t reversed;  /* 1: counts up while the shaft turns from b towards a */
    uint32_t has_index; /* 1: there is an index; 0: what is read of it does not count */
} encoder_cfg_t;

/* Reading of a tick. */
typedef struct {
    uint16_t counter;
    uint16_t index; /* counter at the last index */
    bool indexed;   /* an index has come since the last tick */
} encoder_reading_t;

typedef struct {
    int32_t count; /* of the turn, 0…counts − 1 */
    int32_t since; /* counts from the last index, or from the start; ±3·counts; 0: no index */
    /* count of the index; odd_at: of one that came elsewhere and is not yet confirmed; −1: none */
    int32_t index_at;
    int32_t odd_at;
    int32_t speed;    /* 1/16 counts a tick, mean over some 16 ticks */
    uint16_t counter; /* of the last tick */
    bool begun;
    bool known;      /* the angle goes on from that of the last tick */
    uint8_t strange; /* ticks in a row with another way than the speed's, 0…4 */
    uint8_t trouble; /* shaft_trouble_t that was found in this tick */
} encoder_t;

/* Forgets the count and the index. */
void encoder_start(encoder_t *encoder);

/*
 * One tick. Returns the angle of the shaft, 2^16 = one turn; it is off by at most one unit of the
 * result. A counter that moves by more than a quarter turn in a tick is counted as it is, and named
 * COUNTS.
 */
uint16_t encoder_step(encoder_t *encoder, const encoder_cfg_t *cfg, encoder_reading_t reading);

#endif
