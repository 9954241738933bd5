/* SPDX-License-Identifier: MIT */
#include "crc32.h"

#include "words.h"

#define BYTES_AT_ONCE (4U)

static uint32_t nibble(uint32_t crc)
{
    static const uint32_t table[16] = {
        0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU, 0x76DC4190U, 0x6B6B51F4U,
        0x4DB26158U, 0x5005713CU, 0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
        0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU,
    };

    return (crc >> 4U) ^ table[crc & 0xFU];
}

uint32_t crc32_byte(uint32_t before, uint8_t byte)
{
    return nibble(nibble(before ^ byte));
}

uint32_t crc32_step(uint32_t before, const uint8_t *bytes)
{
    uint32_t crc = before;

    for (uint32_t k = 0U; k < BYTES_AT_ONCE; k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    return crc;
}

uint32_t crc32_word(uint32_t before, uint32_t word)
{
    uint8_t bytes[WORDS_BYTES];

    words_put(bytes, word);
    return crc32_step(before, bytes);
}
