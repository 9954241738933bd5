/* SPDX-License-Identifier: MIT */
/*
 * COBS (Cheshire and Baker 1999) codes bytes so that none of them is 0, and a 0 can separate two
 * frames. Each 0 is replaced by the distance to the next 0. One byte in front gives the distance to
 * the first 0.
 *
 * Encoder and decoder go byte by byte, so that neither needs a second buffer. Pure, any context; no
 * input makes them fail.
 */
#ifndef COBS_H
#define COBS_H

#include <stdbool.h>
#include <stdint.h>

/* largest number of bytes to encode: each distance fits into a byte */
#define COBS_BYTES_MAX (253U)

/*
 * Returns byte `at` of the code of `bytes`. count: number of bytes, 0…COBS_BYTES_MAX. at: 0…count,
 * because the code is one byte longer than `bytes`.
 */
uint8_t cobs_encoded(const uint8_t *bytes, uint32_t count, uint32_t at);

/* State of the decoder. */
typedef struct {
    uint32_t left; /* bytes before the next distance */
    bool zero;     /* the next distance stands for a 0 */
} cobs_decoder_t;

/* Begins a new code. */
void cobs_start(cobs_decoder_t *decoder);

/*
 * Takes the next byte of the code, which is not 0. Returns true if this gives a decoded byte, which
 * is then in *out.
 */
bool cobs_decode(cobs_decoder_t *decoder, uint8_t in, uint8_t *out);

/* Whether the code may end here: no byte is missing before the next distance. */
bool cobs_may_end(const cobs_decoder_t *decoder);

#endif
