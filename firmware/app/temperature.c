/* SPDX-License-Identifier: MIT */
#include "temperature.h"

#include <stdbool.h>

#define MC_PER_C (1000)

/*
 * Whether a count lies beyond a point, on the point's hot side. The ends of the line say whether
 * counts rise or fall with the temperature, because two neighbours may round to one count.
 */
static bool is_beyond(const temperature_line_t *line, const temperature_point_t *point,
                      int32_t count)
{
    const bool rises = line->at[line->points - 1U].count > line->at[0].count;

    return rises ? (count > point->count) : (count < point->count);
}

static int32_t between(const temperature_point_t *from, const temperature_point_t *to,
                       int32_t count)
{
    const int32_t span = to->count - from->count;

    /* Two points of the file may have the same count. */
    return (span == 0) ? to->mc
                       : (from->mc + (((count - from->count) * (to->mc - from->mc)) / span));
}

static int32_t rounded(int32_t mc)
{
    const int32_t half = (mc < 0) ? -(MC_PER_C / 2) : (MC_PER_C / 2);

    return (mc + half) / MC_PER_C;
}

int32_t temperature_celsius(const temperature_line_t *line, uint16_t count)
{
    const int32_t counts = (int32_t)count;
    uint32_t k = 0U;
    int32_t mc = line->at[0].mc;

    while ((k < line->points) && is_beyond(line, &line->at[k], counts)) {
        k++;
    }
    if (k == line->points) {
        mc = line->at[k - 1U].mc;
    } else if (k > 0U) {
        mc = between(&line->at[k - 1U], &line->at[k], counts);
    } else {
        /* colder than the first point: the temperature of this point */
    }
    return rounded(mc);
}
