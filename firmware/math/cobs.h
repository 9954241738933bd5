/* SPDX-License-Identifier: MIT */
/*
 * COBS (Cheshire and Baker 1999): bytes without a 0, so that a 0 can stand between two frames. Each
 * 0 is replaced by the distance to the next one, and one byte in front of all gives the distance to
 * the first.
 *
 * Encoder and decoder go byte by byte, so that neither needs a second buffer. Pure, any context; no
 * input makes them fail.
 */
#ifndef COBS_H
#define COBS_H

#include <stdbool.h>
#include <stdint.h>

#define COBS_BYTES_MAX (253U) /* most bytes to encode: each distance fits into a byte */

/*
 * Returns byte `at` of the code of `count` bytes, 0…COBS_BYTES_MAX; `at` is 0…count: the code is
 * one byte longer.
 */
uint8_t cobs_encoded(const uint8_t *bytes, uint32_t count, uint32_t at);

/* A code that is being read. */
typedef struct {
    uint32_t left; /* bytes up to the next distance */
    bool zero;     /* that distance stands for a 0 */
} cobs_decoder_t;

/* Begin a code. */
void cobs_start(cobs_decoder_t *decoder);

/*
 * Takes the next byte of the code, which is not 0. Returns true if that gives a byte, which is then
 * in *out.
 */
bool cobs_decode(cobs_decoder_t *decoder, uint8_t in, uint8_t *out);

/* Whether a code may end here. */
bool cobs_may_end(const cobs_decoder_t *decoder);

#endif
