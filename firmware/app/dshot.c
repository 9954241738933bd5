/* SPDX-License-Identifier: MIT */
#include "dshot.h"

#define CHECK_MASK (0xFU)
#define CHECK_BITS (4U)
#define PERIODS (DSHOT_BITS - 1U)
#define SPEEDS (3U)
#define WIDTH_MAX (255U) /* 25.5 µs: no pulse of a frame is so long */
/* A frame has ended when no edge has come for twice the longest period and its longest pulse. */
#define END (HAL_PULSE_HZ / 50000U) /* 20 µs */

/* Returns the exclusive or of the groups of four bits of value and telemetry bit. */
static uint32_t checksum_of(uint32_t twelve)
{
    return (twelve ^ (twelve >> CHECK_BITS) ^ (twelve >> (2U * CHECK_BITS))) & CHECK_MASK;
}

/* Whether 15 periods of a frame are within 1/8 of those of one of the speeds. */
static bool is_a_speed(uint32_t span)
{
    static const uint32_t rates[SPEEDS] = {150000U, 300000U, 600000U};
    bool known = false;

    for (uint32_t k = 0U; k < SPEEDS; k++) {
        const uint32_t right = (PERIODS * HAL_PULSE_HZ) / rates[k];

        known = known || ((span >= (right - (right / 8U))) && (span <= (right + (right / 8U))));
    }
    return known;
}

/*
 * Reads the bits of 16 widths; span: 15 periods. Returns false if a width is none of a bit. The
 * widths are compared in sixteenths of the mean period: 16·15·width with limit·span.
 */
static bool read_bits(const dshot_t *dshot, uint32_t span, uint32_t *bits)
{
    bool good = true;
    uint32_t read = 0U;

    for (uint32_t k = 0U; k < DSHOT_BITS; k++) {
        const uint32_t width = 16U * PERIODS * dshot->widths[k];

        good = good && (width >= (3U * span)) && (width <= (15U * span));
        read = (read << 1U) | ((width > (9U * span)) ? 1U : 0U);
    }
    *bits = read;
    return good;
}

/* Judges the frame that has ended. Returns what is wrong with it. */
static input_lost_t judge_frame(dshot_t *dshot)
{
    const uint32_t span = dshot->last - dshot->start;
    input_lost_t wrong = INPUT_LOST_SHAPE;
    uint32_t bits = 0U;

    if ((dshot->count == DSHOT_BITS) && !dshot->spoilt && is_a_speed(span) &&
        read_bits(dshot, span, &bits)) {
        const uint32_t twelve = bits >> CHECK_BITS;
        const uint32_t differs = checksum_of(twelve) ^ (bits & CHECK_MASK);

        if (differs == 0U) {
            wrong = INPUT_LOST_NOT;
            dshot->frame = (dshot_frame_t){.value = (uint16_t)(twelve >> 1U),
                                           .telemetry = (twelve & 1U) != 0U};
        } else {
            wrong = (differs == CHECK_MASK) ? INPUT_LOST_INVERTED : INPUT_LOST_CHECKSUM;
        }
    }
    return wrong;
}

/* On a line that is high between the frames, what lies between two such levels has no shape. */
static void count_bad(input_signal_t *signal, input_lost_t wrong)
{
    const bool inverted =
        (wrong == INPUT_LOST_SHAPE) && (signal->why == (uint8_t)INPUT_LOST_INVERTED);

    input_signal_bad(signal, inverted ? INPUT_LOST_INVERTED : wrong, INPUT_SIGNAL_BAD);
}

/* Ends the frame, if one has begun. Returns whether it is good. */
static bool end_frame(dshot_t *dshot, input_signal_t *signal)
{
    bool good = false;

    if (dshot->count > 0U) {
        const input_lost_t wrong = judge_frame(dshot);

        dshot->count = 0U;
        good = wrong == INPUT_LOST_NOT;
        if (!good) {
            count_bad(signal, wrong);
        }
    }
    return good;
}

/* Whether a pulse that begins `gap` after the last one begins another frame. */
static bool begins(const dshot_t *dshot, uint32_t gap)
{
    return (gap > END) || ((dshot->count > 1U) && ((2U * gap) >= (3U * dshot->first_period)));
}

static void add_pulse(dshot_t *dshot, const hal_pulse_t *pulse)
{
    const uint32_t period = pulse->start - dshot->last;

    if (dshot->count == 0U) {
        dshot->start = pulse->start;
        dshot->spoilt = false;
    } else if (dshot->count == 1U) {
        dshot->first_period = period;
    } else {
        const uint32_t first = dshot->first_period;

        dshot->spoilt =
            dshot->spoilt || ((4U * period) < (3U * first)) || ((4U * period) > (5U * first));
    }
    if (dshot->count < DSHOT_BITS) {
        dshot->widths[dshot->count] = (uint8_t)pulse->width;
    }
    if (dshot->count <= DSHOT_BITS) {
        dshot->count++;
    }
    dshot->last = pulse->start;
}

bool dshot_take(dshot_t *dshot, const hal_pulse_t *pulse, input_signal_t *signal)
{
    bool good = false;

    if (begins(dshot, pulse->start - dshot->last)) {
        good = end_frame(dshot, signal);
    }
    if (pulse->width > WIDTH_MAX) {
        dshot->count = 0U; /* the line is high between two frames */
        count_bad(signal, INPUT_LOST_INVERTED);
        good = false;
    } else {
        add_pulse(dshot, pulse);
    }
    return good;
}

bool dshot_step(dshot_t *dshot, uint32_t now, input_signal_t *signal)
{
    return ((now - dshot->last) > END) && end_frame(dshot, signal);
}
