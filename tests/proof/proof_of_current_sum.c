/* SPDX-License-Identifier: MIT */
/*
 * One sample of the sum of the currents, from any state within its ranges, with any currents and
 * any configuration: no run-time error. Read by Eva, see proof.py.
 *
 * The ranges are by count. Proven is that a sample adds at most LARGEST_JUDGED to a sum that is
 * empty, and that a window or a zero ends with CURRENT_SUM_SAMPLES_MAX samples. That a sum of n
 * samples is then at most n times as large is not asked of Eva, which would need a case for each n.
 */
#include "../../firmware/protect/current_sum.c"

#include <__fc_builtin.h>

#define LARGEST_SUM (0x20000)            /* of current_sum_in_t */
#define LARGEST_JUDGED (2 * LARGEST_SUM) /* with a zero that is as large, of the other sign */
#define LARGEST_FLOWING (LARGEST_JUDGED + (4 * 16384)) /* c is the judged sum without a and b */
#define SAMPLES ((int32_t)CURRENT_SUM_SAMPLES_MAX)

static current_sum_t state;
static supervision_cfg_t cfg;
static current_sum_in_t in;
static fault_t fault;

/*@ requires lowest <= value <= highest;
    assigns \nothing; */
void within(int64_t value, int64_t lowest, int64_t highest);

static void choose_sample(void)
{
    cfg.sum_max = Frama_C_interval(1, 65535);
    cfg.sum_share_q15 = Frama_C_interval(0, 32767);
    in.a = Frama_C_interval(-16384, 16384);
    in.b = Frama_C_interval(-16384, 16384);
    in.sum = Frama_C_interval(-LARGEST_SUM, LARGEST_SUM);
}

static void choose_window(void)
{
    state.samples = Frama_C_unsigned_int_interval(0U, CURRENT_SUM_SAMPLES_MAX - 1U);
    state.sum = Frama_C_unsigned_int_interval(0U, (SAMPLES - 1) * LARGEST_JUDGED);
    state.flowing = Frama_C_unsigned_int_interval(0U, (uint32_t)(SAMPLES - 1) * LARGEST_FLOWING);
}

/* Of the zero the step reads the mean alone, and one sample has every mean. */
static void choose_mean(void)
{
    state.zeros = Frama_C_interval(0, 1);
    state.zero_sum = Frama_C_interval(-LARGEST_SUM, LARGEST_SUM);
}

static void check_state(int32_t samples)
{
    within(state.zeros, 0, SAMPLES);
    within(state.zero_sum, -SAMPLES * LARGEST_SUM, SAMPLES * LARGEST_SUM);
    within(state.samples, 0, SAMPLES - 1);
    within(state.sum, 0, (int64_t)samples * LARGEST_JUDGED);
    within(state.flowing, 0, (int64_t)samples * LARGEST_FLOWING);
}

static void take_zero(void)
{
    state.zeros = Frama_C_interval(0, SAMPLES);
    state.zero_sum = Frama_C_interval(-(SAMPLES - 1) * LARGEST_SUM, (SAMPLES - 1) * LARGEST_SUM);
    choose_sample();
    current_sum_zero(&state, in.sum);
    check_state(0);
}

void proof_current_sum(void)
{
    current_sum_reset(&state);
    check_state(0);
    take_zero();
    current_sum_reset(&state);
    choose_mean();
    choose_sample();
    (void)current_sum_step(&state, &cfg, &in, Frama_C_interval(0, 1) != 0, &fault);
    check_state(1);
    choose_window();
    choose_sample();
    (void)current_sum_step(&state, &cfg, &in, Frama_C_interval(0, 1) != 0, &fault);
    check_state(SAMPLES);
}
