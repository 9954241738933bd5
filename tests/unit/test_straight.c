/* SPDX-License-Identifier: MIT */
/*
 * The straight way of an ordinary tick does what the general way does: from any state within state.def, with any frame, in
 * each word of the state and of the output.
 */
#include "drive.h"
#include "example_cfg.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"
#include "transitions.h"

#include <stddef.h>
#include <string.h>

#define STATES (40000)
#define CURRENT_MAX_COUNT (3891) /* (16384 + protection.current_max) / 8 = 3891.25 */
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

typedef struct {
    const char *name;
    size_t offset;
    size_t size;
    int64_t lo;
    int64_t hi;
} word_t;

#define FIELD(path, lo, hi, quantity) \
    {#path, offsetof(drive_t, path), sizeof(((drive_t *)NULL)->path), lo, hi},
#define FREE(path, quantity) \
    {#path, offsetof(drive_t, path), sizeof(((drive_t *)NULL)->path), INT64_MIN, INT64_MAX},
static const word_t WORDS[] = {
#include "state.def"
};

static drive_cfg_t cfg;
static seeded_t seed;

void setUp(void)
{
    seed = (seeded_t){0x57A16U};
}

static uint64_t any_word(void)
{
    const uint64_t high = seeded_u32(&seed);

    return (high << 32U) | seeded_u32(&seed);
}

/* An end of the range as often as a quarter of the time. */
static int64_t within(int64_t lo, int64_t hi)
{
    const uint64_t span = ((uint64_t)hi - (uint64_t)lo) + 1U;
    const uint64_t inside = (span == 0U) ? any_word() : (any_word() % span);
    const int32_t choice = seeded_in(&seed, 0, 7);
    int64_t value = (int64_t)((uint64_t)lo + inside);

    if (choice == 0) {
        value = lo;
    } else if (choice == 1) {
        value = hi;
    } else {
        /* inside */
    }
    return value;
}

static drive_t any_state(void)
{
    drive_t drive;

    memset(&drive, 0, sizeof drive);
    for (size_t i = 0; i < COUNT(WORDS); i++) {
        const int64_t value = within(WORDS[i].lo, WORDS[i].hi);

        memcpy((char *)&drive + WORDS[i].offset, &value,
               WORDS[i].size); /* the low bytes come first */
    }
    drive.cfg = &cfg;
    drive.state = transitions_state(seeded_u32(&seed) % DRIVE_STATES);
    drive.guard.at = 0U;
    return drive;
}

static drive_in_t any_frame(void)
{
    return (drive_in_t){
        .command = {.target = seeded_i32(&seed),
                    .mode = (uint8_t)seeded_in(&seed, 0, 255),
                    .request = (uint8_t)seeded_in(&seed, 0, 255)},
        .adc_ia = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_ib = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_bus = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_temperature = (uint16_t)seeded_in(&seed, 0, 65535),
        .angle = (uint16_t)seeded_in(&seed, 0, 65535),
        .flags = (uint16_t)seeded_in(&seed, 0, 65535),
    };
}

/* In RUN, with nothing in state or frame that ends it at once. What the slow part finds still may. */
static void make_ordinary(drive_t *drive, drive_in_t *in)
{
    drive->state = DRIVE_STATE_RUN;
    drive->limits = protection_limits(&cfg.protection, true);
    drive->offset_a = 16384;
    drive->offset_b = 16384;
    state_guard_keep_measured(drive);
    in->command.request = DRIVE_REQUEST_RUN;
    in->flags = 0U;
    in->adc_ia = (uint16_t)seeded_in(&seed, 1400, 2700);
    in->adc_ib = (uint16_t)seeded_in(&seed, 1400, 2700);
    in->adc_bus = (uint16_t)seeded_in(&seed, 2700, 2900);
    if (seeded_in(&seed, 0, 7) == 0) {
        in->adc_ia = (uint16_t)(CURRENT_MAX_COUNT + seeded_in(&seed, 0, 1));
        in->adc_ib = 2048U;
    }
}

static void assert_same(const drive_t *straight, const drive_t *general)
{
    for (size_t i = 0; i < COUNT(WORDS); i++) {
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE((const char *)general + WORDS[i].offset,
                                         (const char *)straight + WORDS[i].offset, WORDS[i].size,
                                         WORDS[i].name);
    }
    TEST_ASSERT_EQUAL(general->state, straight->state);
    TEST_ASSERT_EQUAL(general->fault.id, straight->fault.id);
}

/* Returns whether the drive goes on in RUN. */
static bool step_both_ways(const drive_t *from, const drive_in_t *in)
{
    drive_t straight = *from;
    drive_t general = *from;
    drive_out_t out = {0};
    drive_out_t expected = {0};

    drive_step(&straight, in, &out);
    drive_step_general(&general, in, &expected);
    assert_same(&straight, &general);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(expected.compare.phase, out.compare.phase, 3U);
    TEST_ASSERT_EQUAL(expected.gate_enable, out.gate_enable);
    return (from->state == DRIVE_STATE_RUN) && (general.state == DRIVE_STATE_RUN);
}

/* Any state holds those of an alignment too, which divides by the number of its samples. */
static drive_cfg_t cfg_without_startup(void)
{
    drive_cfg_t plain = example_drive_cfg();

    plain.startup.align.measure_log2 = 6U;
    return plain;
}

TEST(test_any_frame_in_any_state_does_the_same_on_both_ways)
{
    for (int32_t with = 0; with < 2; with++) {
        cfg = (with == 0) ? cfg_without_startup() : example_drive_cfg_with_startup();
        for (int32_t k = 0; k < STATES; k++) {
            const drive_t from = any_state();
            const drive_in_t in = any_frame();

            (void)step_both_ways(&from, &in);
        }
    }
}

/* With and without start-up, compensation of the inverter, voltage drive, saliency, sensor. */
TEST(test_an_ordinary_tick_of_any_state_does_the_same_on_both_ways)
{
    int32_t stayed = 0;

    for (int32_t k = 0; k < STATES; k++) {
        const bool starts = (k & 1) != 0;
        drive_t from;
        drive_in_t in;

        cfg = starts ? example_drive_cfg_with_startup() : cfg_without_startup();
        if ((k & 2) != 0) {
            cfg.modulator = example_modulator_cfg_with_dead_time();
        }
        if ((k & 4) != 0) {
            cfg.voltage_drive = example_voltage_drive_cfg();
        }
        if ((k & 8) != 0) {
            cfg.observer.saliency_q13 = 12000;
        }
        if (!starts && ((k & 16) != 0)) {
            cfg.sampling.sensor_pole_pairs = 2U;
        }
        from = any_state();
        in = any_frame();
        make_ordinary(&from, &in);
        stayed += step_both_ways(&from, &in) ? 1 : 0;
    }
    TEST_ASSERT_GREATER_THAN_INT32(STATES / 2, stayed);
}
