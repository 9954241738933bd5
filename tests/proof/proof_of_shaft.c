/* SPDX-License-Identifier: MIT */
/*
 * One tick of each decoder of a sensor of the shaft, from any state within its ranges, with any
 * reading and any configuration: no run-time error, and the state stays within. Read by Eva, see
 * proof.py.
 */
#include "../../firmware/control/absolute.c"
#undef MEAN_SHIFT
#undef MEAN_TICKS
#undef Q16_MASK
#undef HALF_TURN
#undef SPEED_MAX
#include "../../firmware/control/encoder.c"
#undef MEAN_SHIFT
#undef MEAN_TICKS
#undef SPEED_MAX
#include "../../firmware/control/hall.c"

#include <__fc_builtin.h>

#define TURN (65535)           /* of a configuration, and counts of an encoder */
#define STEP_MAX (0x1FFFFFFF)  /* of step_t */
#define MEAN_MAX (0x8000 * 16) /* mean over 16 ticks */

static hall_t hall;
static encoder_t encoder;
static absolute_t absolute;

/*@ requires lowest <= value <= highest;
    assigns \nothing; */
void within(int64_t value, int64_t lowest, int64_t highest);

static bool any_bool(void)
{
    return Frama_C_interval(0, 1) != 0;
}

static uint32_t any_word(void)
{
    return Frama_C_unsigned_int_interval(0U, UINT32_MAX);
}

static uint32_t up_to(uint32_t most)
{
    return Frama_C_unsigned_int_interval(0U, most);
}

static void choose_hall(void)
{
    hall.angle = any_word();
    hall.edge = any_word();
    hall.speed = Frama_C_interval(-STEP_MAX, STEP_MAX);
    hall.pace = Frama_C_interval(-STEP_MAX, STEP_MAX);
    hall.ticks = up_to(TICKS_MAX);
    hall.patience = up_to(TICKS_MAX);
    hall.span = (hall_span_t){(uint8_t)up_to(HALL_SECTORS - 1U), (uint8_t)up_to(HALL_SECTORS)};
    hall.edge_age_q8 = (uint16_t)up_to(TICK_Q8);
    hall.seen_age_q8 = (uint16_t)up_to(TICK_Q8);
    hall.direction = (int8_t)Frama_C_interval(-1, 1);
    hall.seen = (uint8_t)up_to(NO_PATTERN);
    hall.taken = (uint8_t)up_to(NO_PATTERN);
    hall.unlike = (uint8_t)up_to(UNLIKE_TICKS);
    hall.dead = (uint8_t)up_to(4U);
    hall.turned = any_bool();
    hall.timed = any_bool();
    hall.paced = any_bool();
    hall.steady = any_bool();
    hall.fast = any_bool();
    hall.known = any_bool();
}

static void choose_encoder(void)
{
    encoder.count = Frama_C_interval(-TURN, TURN);
    encoder.since = Frama_C_interval(-SINCE_MAX, SINCE_MAX);
    encoder.index_at = Frama_C_interval(-TURN, TURN);
    encoder.odd_at = Frama_C_interval(-TURN, TURN);
    encoder.speed = Frama_C_interval(-MEAN_MAX, MEAN_MAX);
    encoder.counter = (uint16_t)up_to(UINT16_MAX);
    encoder.begun = any_bool();
    encoder.strange = (uint8_t)up_to(STRANGE_TICKS - 1U);
}

static void choose_absolute(void)
{
    absolute.angle = (uint16_t)up_to(UINT16_MAX);
    absolute.reading = (uint16_t)up_to(UINT16_MAX);
    absolute.speed = Frama_C_interval(-MEAN_MAX, MEAN_MAX);
    absolute.bad = up_to(ABSOLUTE_BRIDGE_TICKS);
    absolute.good = up_to(ABSOLUTE_BRIDGE_TICKS);
    absolute.known = any_bool();
}

static void check_state(void)
{
    within(hall.speed, -STEP_MAX, STEP_MAX);
    within(hall.pace, -STEP_MAX, STEP_MAX);
    within(hall.ticks, 0, TICKS_MAX);
    within(hall.patience, 0, TICKS_MAX);
    within(hall.span.first, 0, HALL_SECTORS - 1U);
    within(hall.span.count, 0, HALL_SECTORS);
    within(hall.edge_age_q8, 0, TICK_Q8);
    within(hall.seen_age_q8, 0, TICK_Q8);
    within(hall.direction, -1, 1);
    within(hall.unlike, 0, UNLIKE_TICKS);
    within(encoder.count, -TURN, TURN);
    within(encoder.since, -SINCE_MAX, SINCE_MAX);
    within(encoder.index_at, -TURN, TURN);
    within(encoder.odd_at, -TURN, TURN);
    within(encoder.speed, -MEAN_MAX, MEAN_MAX);
    within(encoder.strange, 0, STRANGE_TICKS - 1U);
    within(absolute.speed, -MEAN_MAX, MEAN_MAX);
}

void proof_hall(void)
{
    hall_cfg_t cfg = {.patterns = any_word(), .fast_speed = Frama_C_interval(1, 0x20000000)};

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        cfg.edges_q16[k] = up_to(TURN);
    }
    hall_start(&hall);
    check_state();
    choose_hall();
    (void)hall_step(&hall, &cfg, (hall_reading_t){up_to(7U), up_to(UINT16_MAX)});
    (void)hall_order_holds(cfg.patterns);
    check_state();
}

void proof_encoder(void)
{
    const encoder_cfg_t cfg = {.counts = Frama_C_interval(4, 65532),
                               .scale_q32 = Frama_C_unsigned_int_interval(65537U, 0x40000000U),
                               .reversed = up_to(1U),
                               .has_index = up_to(1U)};

    encoder_start(&encoder);
    check_state();
    choose_encoder();
    (void)encoder_step(
        &encoder, &cfg,
        (encoder_reading_t){(uint16_t)up_to(UINT16_MAX), (uint16_t)up_to(UINT16_MAX), any_bool()});
    check_state();
}

void proof_absolute(void)
{
    const absolute_cfg_t cfg = {.zero = up_to(TURN), .reversed = up_to(1U)};

    absolute_start(&absolute);
    check_state();
    choose_absolute();
    (void)absolute_step(&absolute, &cfg, (uint16_t)up_to(UINT16_MAX));
    check_state();
}
