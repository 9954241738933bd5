/* SPDX-License-Identifier: MIT */
#include "absolute.h"

#include "fx.h"

#define ANGLE_MASK (0x3FFFU)
#define ERROR_FLAG (0x4000U)
#define TO_Q16_SHIFT (2U)
#define JUMP_Q16 (4096) /* 1/16 turn */
#define MOVING_Q16 (8)  /* two LSB of a frame in a tick */
#define OFF_Q16 (64)    /* 16 LSB of a frame, 0.35° */
/* The speed is a mean over some 16 ticks; its unit is 1/16 of the angle's. */
#define MEAN_SHIFT (4U)
#define MEAN_TICKS (16)
#define SPEED_MAX (0x8000 * MEAN_TICKS) /* half a turn a tick */
#define Q16_MASK (0xFFFFU)
#define HALF_TURN (0x8000U)

void absolute_start(absolute_t *absolute)
{
    *absolute = (absolute_t){.known = false};
}

/* Whether the number of ones is even. */
static bool has_even_parity(uint32_t frame)
{
    uint32_t folded = frame ^ (frame >> 8U);

    folded ^= folded >> 4U;
    /* bit k of the constant is the parity of the number k */
    return ((0x6996UL >> (folded & 0xFU)) & 1U) == 0U;
}

/* Returns the difference of two angles, ±2^15. */
static int32_t angle_way(uint32_t to, uint32_t from)
{
    return fx_signed(((to - from) & Q16_MASK) ^ HALF_TURN) - fx_signed(HALF_TURN);
}

static shaft_trouble_t absolute_judge(uint32_t frame)
{
    shaft_trouble_t trouble = SHAFT_TROUBLE_NONE;

    if (!has_even_parity(frame)) {
        trouble = SHAFT_TROUBLE_FRAME;
    } else if ((frame & ERROR_FLAG) != 0U) {
        trouble = SHAFT_TROUBLE_FLAGGED;
    } else {
        /* the frame is good */
    }
    return trouble;
}

/* A tick while the angle is not known: it has to be steady for some ticks. */
static void absolute_find(absolute_t *absolute, uint32_t reading)
{
    const int32_t way = angle_way(reading, absolute->reading);
    const bool steady =
        (absolute->trouble == (uint8_t)SHAFT_TROUBLE_NONE) && (fx_abs(way) <= JUMP_Q16);

    absolute->good = steady ? (absolute->good + 1U) : 0U;
    absolute->speed = way * MEAN_TICKS;
    absolute->angle = (uint16_t)reading;
    if (absolute->good >= ABSOLUTE_BRIDGE_TICKS) {
        absolute->known = true;
        absolute->bad = 0U;
    }
}

/* Whether the frame is that of the tick before, though the shaft turns. */
static bool is_frozen(const absolute_t *absolute, uint32_t reading, int32_t step)
{
    return (reading == absolute->reading) && (fx_abs(step) >= MOVING_Q16);
}

/* A tick while the angle is known: follows the sensor, or goes on with its speed. */
static void absolute_follow(absolute_t *absolute, uint32_t reading)
{
    const int32_t step = fx_asr(absolute->speed, MEAN_SHIFT);
    const uint32_t expected = (absolute->angle + fx_unsigned(step)) & Q16_MASK;
    const int32_t off = angle_way(reading, expected);

    if ((absolute->trouble == (uint8_t)SHAFT_TROUBLE_NONE) &&
        ((fx_abs(off) > fx_max(fx_asr(fx_abs(step), 1U), OFF_Q16)) ||
         is_frozen(absolute, reading, step))) {
        absolute->trouble = (uint8_t)SHAFT_TROUBLE_FRAME;
    }
    if (absolute->trouble == (uint8_t)SHAFT_TROUBLE_NONE) {
        absolute->speed = fx_clamp(absolute->speed + off, -SPEED_MAX, SPEED_MAX);
        absolute->angle = (uint16_t)reading;
        absolute->bad = 0U;
    } else {
        absolute->angle = (uint16_t)expected;
        absolute->bad++;
        absolute->known = absolute->bad <= ABSOLUTE_BRIDGE_TICKS;
        absolute->good = 0U;
    }
}

bool absolute_step(absolute_t *absolute, const absolute_cfg_t *cfg, uint16_t frame)
{
    const uint32_t raw = ((uint32_t)frame & ANGLE_MASK) << TO_Q16_SHIFT;
    const uint32_t turned = ((cfg->reversed != 0U) ? (0U - raw) : raw) & Q16_MASK;
    const uint32_t zero = (cfg->reversed != 0U) ? (0U - cfg->zero) : cfg->zero;
    const uint32_t reading = (turned - zero) & Q16_MASK;

    absolute->trouble = (uint8_t)absolute_judge(frame);
    if (absolute->known) {
        absolute_follow(absolute, reading);
    } else {
        absolute_find(absolute, reading);
    }
    absolute->reading = (uint16_t)reading;
    absolute->ahead =
        (uint16_t)((absolute->angle + fx_unsigned(fx_asr(absolute->speed, MEAN_SHIFT))) & Q16_MASK);
    return absolute->known;
}
