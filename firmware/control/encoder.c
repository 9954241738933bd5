/* SPDX-License-Identifier: MIT */
#include "encoder.h"

#include "fx.h"
#include "inlining.h"

#define NOWHERE (-1)
#define HALF_COUNTER (0x8000U)
#define COUNTER_MASK (0xFFFFU)
#define Q32_TO_Q16_SHIFT (16U)
#define INDEX_WIDTH (2)      /* counts by which an index may differ between both directions */
#define SAME_PLACE_LOG2 (4U) /* two indexes within 1/16 turn have come at the same place */
#define TURNS_WITHOUT (2)
#define MEAN_SHIFT (4U)
#define MEAN_TICKS (16)
#define SPEED_MAX ((int32_t)HALF_COUNTER * MEAN_TICKS) /* half the counter's range a tick */
#define SINCE_MAX (3 * 65532) /* three turns of an encoder with the most counts */
/* A counter at a steady speed differs by up to 2 counts from tick to tick. */
#define STRANGE_COUNTS (2 * MEAN_TICKS)
/*
 * Within the 16 ticks of the mean a motor changes its speed by less than 1/4096 turn a tick:
 * 38000 rad/s² at 20 kHz.
 */
#define STRANGE_TURN_LOG2 (12U - MEAN_SHIFT)
#define STRANGE_TICKS (4U)
#define QUARTER_LOG2 (2U)

void encoder_start(encoder_t *encoder)
{
    *encoder = (encoder_t){.index_at = NOWHERE, .odd_at = NOWHERE};
}

/* Returns a difference of two counters, ±2^15. */
static int32_t counter_way(uint16_t to, uint16_t from)
{
    const uint32_t way = ((uint32_t)to - from) & COUNTER_MASK;

    return fx_signed(way ^ HALF_COUNTER) - fx_signed(HALF_COUNTER);
}

/* Returns a count within its turn. count: −2^17…2^17. */
static int32_t within_turn(int32_t count, int32_t counts)
{
    int32_t within = count;

    if ((count < 0) || (count >= counts)) {
        within = count % counts;
        within += (within < 0) ? counts : 0;
    }
    return within;
}

/* Returns how far a count lies ahead of another one, −counts/2…counts/2. */
static int32_t ahead(int32_t count, int32_t of, int32_t counts)
{
    const int32_t way = within_turn(count - of, counts);

    return (way > (counts / 2)) ? (way - counts) : way;
}

/*
 * Whether this index is one turn from the odd one before it, either way. Pulses of a disturbance
 * follow each other within less, or come anywhere.
 */
static bool is_confirmed(const encoder_t *encoder, int32_t counts, int32_t at)
{
    const int32_t near = fx_max(fx_asr(counts, SAME_PLACE_LOG2), INDEX_WIDTH);
    const bool turned = fx_abs(encoder->since) > (counts / 2);

    return (encoder->odd_at != NOWHERE) && turned &&
           (fx_abs(ahead(at, encoder->odd_at, counts)) <= near);
}

/* An index off the known place, or the place is not known: waits for the index to come there again.
 */
static void take_odd(encoder_t *encoder, int32_t counts, int32_t at)
{
    const bool known = encoder->index_at != NOWHERE;
    const bool again = is_confirmed(encoder, counts, at);

    encoder->odd_at = again ? NOWHERE : at;
    if (!known) {
        encoder->index_at = again ? at : NOWHERE;
    } else if (again) {
        encoder->count = within_turn(encoder->count - ahead(at, encoder->index_at, counts), counts);
        encoder->trouble = (uint8_t)SHAFT_TROUBLE_COUNTS;
    } else {
        encoder->trouble = (uint8_t)SHAFT_TROUBLE_INDEX;
    }
}

RARE static void take_index(encoder_t *encoder, const encoder_cfg_t *cfg, uint16_t index)
{
    const int32_t way = counter_way(encoder->counter, index);
    const int32_t at =
        within_turn(encoder->count - ((cfg->reversed != 0U) ? -way : way), cfg->counts);
    const int32_t off = ahead(at, encoder->index_at, cfg->counts);

    if ((encoder->index_at != NOWHERE) && (fx_abs(off) <= INDEX_WIDTH)) {
        encoder->odd_at = NOWHERE;
    } else {
        take_odd(encoder, cfg->counts, at);
    }
    encoder->since = 0;
}

/* Whether the counter goes the way of a shaft that has had a speed up to now. */
static bool goes_on(encoder_t *encoder, int32_t counts, int32_t way)
{
    const int32_t off = (way * MEAN_TICKS) - encoder->speed;
    const int32_t least = STRANGE_COUNTS + fx_asr(counts, STRANGE_TURN_LOG2);
    const int32_t most = fx_max(fx_asr(fx_abs(encoder->speed), 1U), least);

    encoder->strange = (fx_abs(off) > most) ? (uint8_t)(encoder->strange + 1U) : 0U;
    encoder->speed = fx_clamp(encoder->speed + fx_asr(off, MEAN_SHIFT), -SPEED_MAX, SPEED_MAX);
    return encoder->strange < STRANGE_TICKS;
}

/* The counter does not follow the shaft: what it tells from now on has another zero. */
RARE static void lose_counts(encoder_t *encoder)
{
    encoder->strange = 0U;
    encoder->speed = 0;
    encoder->index_at = NOWHERE;
    encoder->odd_at = NOWHERE;
    encoder->trouble = (uint8_t)SHAFT_TROUBLE_COUNTS;
}

/* Names an index that has not come for two turns; it is waited for anew then. */
static void miss_index(encoder_t *encoder, const encoder_cfg_t *cfg)
{
    if (fx_abs(encoder->since) > (TURNS_WITHOUT * cfg->counts)) {
        encoder->since = 0;
        encoder->trouble = (uint8_t)SHAFT_TROUBLE_INDEX;
    }
}

/* way: of the shaft in this tick. */
static void look_for_index(encoder_t *encoder, const encoder_cfg_t *cfg, encoder_reading_t reading,
                           int32_t way)
{
    encoder->since = fx_clamp(encoder->since + way, -SINCE_MAX, SINCE_MAX);
    if (reading.indexed) {
        take_index(encoder, cfg, reading.index);
    } else {
        miss_index(encoder, cfg);
    }
}

uint16_t encoder_step(encoder_t *encoder, const encoder_cfg_t *cfg, encoder_reading_t reading)
{
    const int32_t counted = encoder->begun ? counter_way(reading.counter, encoder->counter) : 0;
    const int32_t way = (cfg->reversed != 0U) ? -counted : counted;

    encoder->counter = reading.counter;
    encoder->begun = true;
    encoder->trouble = (uint8_t)SHAFT_TROUBLE_NONE;
    if (fx_abs(way) > fx_asr(cfg->counts, QUARTER_LOG2)) {
        encoder->trouble = (uint8_t)SHAFT_TROUBLE_COUNTS;
    }
    encoder->known = goes_on(encoder, cfg->counts, way);
    encoder->count = within_turn(encoder->count + way, cfg->counts);
    if (cfg->has_index != 0U) {
        look_for_index(encoder, cfg, reading, fx_clamp(way, -cfg->counts, cfg->counts));
    }
    if (encoder->strange >= STRANGE_TICKS) {
        lose_counts(encoder);
    }
    return (uint16_t)((fx_unsigned(encoder->count) * cfg->scale_q32) >> Q32_TO_Q16_SHIFT);
}
