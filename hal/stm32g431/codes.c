/* SPDX-License-Identifier: MIT */
#include "codes.h"

#define HALF_CYCLES_PER_US (85U) /* half cycles of the 42.5 MHz clock */

uint32_t codes_dead_time(uint32_t ticks)
{
    uint32_t code = 0xE0U | (((ticks + 15U) / 16U) - 32U);

    if (ticks <= 127U) {
        code = ticks;
    } else if (ticks <= 254U) {
        code = 0x80U | (((ticks + 1U) / 2U) - 64U);
    } else if (ticks <= 504U) {
        code = 0xC0U | (((ticks + 7U) / 8U) - 32U);
    } else {
        /* as initialised */
    }
    return code;
}

uint32_t codes_sampling(uint32_t ns)
{
    /* The sampling times in half cycles of the converters' clock, in the order of their codes. */
    static const uint32_t half_cycles[CODES_SAMPLING_MAX] = {5U, 13U, 25U, 49U};
    const uint32_t wanted = ((ns * HALF_CYCLES_PER_US) + 999U) / 1000U;
    uint32_t code = 0U;

    while ((code < CODES_SAMPLING_MAX) && (half_cycles[code] < wanted)) {
        code++;
    }
    return code;
}
