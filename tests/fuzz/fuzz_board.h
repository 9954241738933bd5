/* SPDX-License-Identifier: MIT */
/*
 * The board that console and link run on when they are fed any bytes: a binding that measures what
 * it is told, and what is left of the fed bytes.
 *
 * The program brings what belongs to its line and its store: hal_receive(), hal_send(),
 * hal_store_read() and its like.
 */
#ifndef FUZZ_BOARD_H
#define FUZZ_BOARD_H

#include "drive_cfg.h"
#include "hal.h"

#include <stddef.h>
#include <stdint.h>

#define TICKS_MAX (4096U) /* of an input; a calibration takes some 1000 */
#define TICKS_OF_A_BYTE (16U)

struct hal {
    uint32_t ticks;
    hal_health_t health;
    uint32_t kept[HAL_KEPT_WORDS];
    drive_in_t measured;
    drive_out_t demanded;
};

typedef struct {
    const uint8_t *at;
    size_t left;
} fed_t;

/* The next bytes, the lower one first; 0 after the last one. */
uint8_t fed_byte(fed_t *fed);
uint16_t fed_half(fed_t *fed);
/* A count of a converter of 12 bits. */
uint16_t fed_count(fed_t *fed);

/* No current, a bus of 24 V of 55.3 V. */
void fuzz_board_rests(hal_t *hal, const drive_cfg_t *cfg);

/* The currents and the bus are what is fed next. */
void fuzz_board_measures(hal_t *hal, fed_t *fed);

#endif
