/* SPDX-License-Identifier: MIT */
#include "cobs.h"

#define LONGEST (255U) /* a distance of 255 stands for no 0 */

/* Returns the distance from place `at` of the code to the next 0 of the bytes, or to their end. */
static uint32_t cobs_distance(const uint8_t *bytes, uint32_t count, uint32_t at)
{
    uint32_t next = at;

    while ((next < count) && (bytes[next] != 0U)) {
        next++;
    }
    return (next + 1U) - at;
}

uint8_t cobs_encoded(const uint8_t *bytes, uint32_t count, uint32_t at)
{
    const bool is_distance = (at == 0U) || (bytes[at - 1U] == 0U);

    return is_distance ? (uint8_t)(cobs_distance(bytes, count, at) & 0xFFU) : bytes[at - 1U];
}

void cobs_start(cobs_decoder_t *decoder)
{
    *decoder = (cobs_decoder_t){.left = 0U, .zero = false};
}

bool cobs_decode(cobs_decoder_t *decoder, uint8_t in, uint8_t *out)
{
    bool gives = true;

    if (decoder->left > 0U) {
        decoder->left--;
        *out = in;
    } else {
        gives = decoder->zero;
        decoder->left = in;
        if (in > 0U) {
            decoder->left--;
        }
        decoder->zero = in < LONGEST;
        *out = 0U;
    }
    return gives;
}

bool cobs_may_end(const cobs_decoder_t *decoder)
{
    return decoder->left == 0U;
}
