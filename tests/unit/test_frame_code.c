/* SPDX-License-Identifier: MIT */
/*
 * The code of frames: what was coded comes back, it is short where it should be, and no bytes do
 * harm.
 */
#include "frame_code.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <string.h>

#define MAX FRAME_CODE_ENTRIES_MAX
#define ROOM (4096U)
#define ROOM_MIN (32U)
#define CHANGE_MARK (0x8000U)
#define TURN_RAD (6.283185307179586)

/*
 * In bits: five modes; the first frame with a bit in front and five lengths; an escape for each
 * channel.
 */
#define MODES (5U * 6U)
#define FIRST_MAX (1U + (5U * (5U + 16U)))
#define NEXT_MAX (5U * (11U + 16U))
#define CHANGE_MAX (11U + (3U * 32U))

static seeded_t chance;
static recorder_entry_t entries[MAX];
static recorder_entry_t back[MAX];
static uint8_t code[ROOM];

void setUp(void)
{
    chance = (seeded_t){99U};
    memset(entries, 0, sizeof entries);
    memset(code, 0xA5, sizeof code);
}

static recorder_entry_t frame(uint32_t ia, uint32_t ib, uint32_t bus, uint32_t flags,
                              uint32_t angle)
{
    return (recorder_entry_t){{ia | (ib << 16U), bus | (flags << 16U), 0U, angle << 16U}};
}

static recorder_entry_t change(void)
{
    return (recorder_entry_t){
        {seeded_u32(&chance), seeded_u32(&chance), CHANGE_MARK, seeded_u32(&chance)}};
}

static recorder_entry_t any_frame(void)
{
    const uint32_t outputs = seeded_u32(&chance);
    recorder_entry_t entry = {
        {seeded_u32(&chance), seeded_u32(&chance), outputs & 0x7FFF7FFFU, seeded_u32(&chance)}};

    return entry;
}

/* As it comes back: without outputs. */
static recorder_entry_t inputs_of(const recorder_entry_t *entry)
{
    recorder_entry_t inputs = *entry;

    if ((entry->word[2] & CHANGE_MARK) == 0U) {
        inputs.word[2] = 0U;
        inputs.word[3] &= 0xFFFF0000U;
    }
    return inputs;
}

static void assert_back(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        const recorder_entry_t inputs = inputs_of(&entries[k]);

        TEST_ASSERT_EQUAL_HEX32_ARRAY(inputs.word, back[k].word, 4U);
    }
}

/* Returns the length of the code of all of them. */
static uint32_t round_trip(uint32_t count)
{
    uint32_t length = 0U;

    TEST_ASSERT_EQUAL_UINT32(count, frame_code_encode(entries, count, code, ROOM, &length));
    memset(back, 0x5A, sizeof back);
    TEST_ASSERT_TRUE(frame_code_decode(code, length, back, count));
    assert_back(count);
    return length;
}

TEST(test_any_frames_and_changes_come_back_and_stay_below_the_longest_code)
{
    for (uint32_t run = 0U; run < 500U; run++) {
        const uint32_t count = 1U + (seeded_u32(&chance) % MAX);
        uint32_t most = MODES + FIRST_MAX + CHANGE_MAX;

        for (uint32_t k = 0U; k < count; k++) {
            const bool changes = (seeded_u32(&chance) % 8U) == 0U;

            entries[k] = changes ? change() : any_frame();
            most += changes ? CHANGE_MAX : NEXT_MAX;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT32((most + 7U) / 8U, round_trip(count));
    }
}

TEST(test_each_single_channel_comes_back_over_all_sizes_of_its_steps)
{
    for (uint32_t channel = 0U; channel < 5U; channel++) {
        for (uint32_t bits = 0U; bits <= 16U; bits++) {
            for (uint32_t k = 0U; k < MAX; k++) {
                uint32_t v[5] = {2048U, 2048U, 3000U, 0U, 0U};

                v[channel] = seeded_u32(&chance) & ((1U << bits) - 1U);
                entries[k] = frame(v[0], v[1], v[2], v[3], v[4]);
            }
            (void)round_trip(MAX);
        }
    }
}

/* 6 bits for each channel and 5 + 16 for its first value, and nothing for 63 frames. */
TEST(test_frames_that_do_not_change_take_no_more_than_the_first_one)
{
    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = frame(0xFFFFU, 2048U, 2822U, 0xFFFFU, 0x8000U);
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32((MODES + FIRST_MAX + 7U) / 8U, round_trip(MAX));
}

/*
 * As with a sensor at a constant speed: a bit for each frame, and some more where the second
 * differs from the first.
 */
TEST(test_an_angle_that_advances_evenly_takes_a_bit_a_frame)
{
    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = frame(2048U, 2048U, 2822U, 0U, (65000U + (k * 200U)) & 0xFFFFU);
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32((MODES + FIRST_MAX + 27U + MAX + 7U) / 8U, round_trip(MAX));
}

/* The sum of 12 bytes is nearly normal; rms 1 count. */
static double noise(void)
{
    double sum = 0.0;

    for (uint32_t k = 0U; k < 12U; k++) {
        sum += (double)(seeded_u32(&chance) % 256U) / 255.0;
    }
    return sum - 6.0;
}

static uint32_t count_of(double value)
{
    return (uint32_t)lround(value);
}

/*
 * 4 A of 20 A at 50 Hz of 10 kHz, 12 bits, noise of 1 count rms on currents and bus. A difference
 * of two such values has 2.55 bits (log2(√2·√(2πe))) and a Rice code of a normal one some 0.2 more:
 * 3 channels are 1.03 bytes; what the sine bends and the first values, 0.12 bytes, come on top of
 * it. What the line bears is 1.9.
 */
TEST(test_a_running_motor_with_noise_takes_no_more_than_1_9_bytes_a_tick)
{
    const uint32_t tenths_of_a_byte = 19U;
    uint32_t length = 0U;

    for (uint32_t k = 0U; k < (10U * MAX); k++) {
        const double angle = TURN_RAD * 50.0 * (double)k / 10000.0;

        entries[k % MAX] =
            frame(count_of(2048.0 + (410.0 * cos(angle)) + noise()),
                  count_of(2048.0 + (410.0 * cos(angle - (TURN_RAD / 3.0))) + noise()),
                  count_of(2822.0 + noise()), 0U, 0U);
        if (((k + 1U) % MAX) == 0U) {
            length += round_trip(MAX);
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(tenths_of_a_byte * MAX, length);
}

TEST(test_a_change_comes_back_wherever_it_stands)
{
    for (uint32_t at = 0U; at < MAX; at++) {
        for (uint32_t k = 0U; k < MAX; k++) {
            entries[k] = frame(2048U, 2048U, 2822U, 0U, 0U);
        }
        entries[at] = change();
        (void)round_trip(MAX);
        entries[MAX - 1U - at] = change();
        (void)round_trip(MAX);
    }
}

TEST(test_changes_without_a_frame_come_back)
{
    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = change();
    }
    (void)round_trip(MAX);
}

/* Behind the room nothing is written, and one entry always fits into the smallest. */
TEST(test_as_many_entries_are_coded_as_fit_and_no_byte_is_written_behind)
{
    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = ((k % 16U) == 0U) ? change() : any_frame();
    }
    for (uint32_t room = ROOM_MIN; room < 1400U; room++) {
        uint32_t length = 0U;
        uint32_t next = 0U;

        memset(code, 0xA5, sizeof code);
        const uint32_t done = frame_code_encode(entries, MAX, code, room, &length);

        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(1U, done);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(room, length);
        TEST_ASSERT_EACH_EQUAL_UINT8(0xA5U, &code[room], ROOM - room);
        TEST_ASSERT_TRUE(frame_code_decode(code, length, back, done));
        assert_back(done);
        if (done < MAX) {
            uint8_t longer[ROOM];

            (void)frame_code_encode(entries, done + 1U, longer, ROOM, &next);
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(length, next);
        }
    }
}

/* From memory of exactly that size, so that the address sanitizer sees a byte too many. */
static bool decodes_alone(const uint8_t *bytes, uint32_t length, uint32_t count)
{
    uint8_t exact[ROOM];

    memcpy(&exact[ROOM - length], bytes, length);
    return frame_code_decode(&exact[ROOM - length], length, back, count);
}

TEST(test_a_code_that_is_cut_or_longer_or_of_another_number_is_refused)
{
    uint32_t length;

    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = any_frame();
    }
    length = round_trip(MAX);
    for (uint32_t cut = 0U; cut < length; cut++) {
        TEST_ASSERT_FALSE(decodes_alone(code, cut, MAX));
    }
    code[length] = 0U;
    TEST_ASSERT_FALSE(decodes_alone(code, length + 1U, MAX));
    TEST_ASSERT_FALSE(decodes_alone(code, length, MAX - 1U));
    TEST_ASSERT_FALSE(decodes_alone(code, length, 0U));
    TEST_ASSERT_FALSE(decodes_alone(code, length, MAX + 1U));
}

/* What decodes is a code: the encoder's, or one with the same meaning. */
TEST(test_a_flipped_bit_is_refused_or_gives_entries_and_harms_nothing)
{
    uint32_t length;
    uint32_t refused = 0U;

    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = (k == 9U) ? change() : any_frame();
    }
    length = round_trip(MAX);
    for (uint32_t bit = 0U; bit < (8U * length); bit++) {
        code[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        refused += decodes_alone(code, length, MAX) ? 0U : 1U;
        code[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, refused);
    TEST_ASSERT_TRUE(decodes_alone(code, length, MAX));
}

TEST(test_any_bytes_are_decoded_without_harm)
{
    for (uint32_t run = 0U; run < 20000U; run++) {
        const uint32_t length = seeded_u32(&chance) % 200U;

        for (uint32_t k = 0U; k < length; k++) {
            code[k] = (uint8_t)seeded_u32(&chance);
        }
        (void)decodes_alone(code, length, 1U + (seeded_u32(&chance) % MAX));
    }
}

TEST(test_a_mode_that_there_is_not_and_a_value_of_17_bits_are_refused)
{
    const uint8_t mode_46[] = {46U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};
    /* 30 bits of modes, a 0, and 17 as the length of the first value */
    const uint8_t bits_17[] = {0U, 0U, 0U, (uint8_t)(17U << 7U), (uint8_t)(17U >> 1U), 0U, 0U,
                               0U, 0U, 0U};

    for (uint32_t length = 1U; length <= sizeof mode_46; length++) {
        TEST_ASSERT_FALSE(decodes_alone(mode_46, length, 1U));
    }
    for (uint32_t length = 1U; length <= sizeof bits_17; length++) {
        TEST_ASSERT_FALSE(decodes_alone(bits_17, length, 1U));
    }
}

/* ---- codes that are written by hand, bit by bit ---- */

static uint32_t written; /* bits */

/* More than the value has are zeros. */
static void write_bits(uint32_t value, uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        const uint8_t mask = (uint8_t)(1U << (written % 8U));
        uint8_t *const byte = &code[written / 8U];
        const bool is_one = (k < 32U) && (((value >> k) & 1U) != 0U);

        *byte = is_one ? (uint8_t)(*byte | mask) : (uint8_t)(*byte & ~mask);
        written++;
    }
}

#define BEFORE_0 (1U)               /* the value before, Rice parameter 0 */
#define SMOOTH_14 (15U + 30U)       /* the last mode */
#define FIRST_ZERO (1U + (5U * 5U)) /* a frame whose values have no bits */

/* Modes, and a first frame that is zero. */
static void write_begin(uint32_t channel, uint32_t mode)
{
    memset(code, 0, sizeof code);
    written = 0U;
    for (uint32_t k = 0U; k < 5U; k++) {
        write_bits((k == channel) ? mode : 0U, 6U);
    }
    write_bits(0U, FIRST_ZERO);
}

static bool written_decodes(uint32_t count)
{
    return decodes_alone(code, (written + 7U) / 8U, count);
}

TEST(test_the_last_mode_there_is_has_a_code)
{
    const uint32_t five = 10U; /* z of it */

    write_begin(4U, SMOOTH_14);
    write_bits(0U, 1U);
    write_bits(five, 14U);
    TEST_ASSERT_TRUE(written_decodes(2U));
    TEST_ASSERT_EQUAL_HEX32(5U << 16U, back[1].word[3]);
}

#define BEFORE_14 (15U)
#define LINE_14 (15U + 15U)

/*
 * The prediction as the head of frame_code.c says it, of what the last values are: before[0] is the
 * value before.
 */
static int32_t predicted(uint32_t mode, const int32_t before[4])
{
    int32_t value = before[0];

    if (mode == LINE_14) {
        value = (2 * before[0]) - before[1];
    } else if (mode == SMOOTH_14) {
        value = before[0] + (int32_t)floor((before[1] - before[3]) / 2.0);
    }
    return value;
}

/*
 * A board of before sends the code to a PC of today: the values that these differences make stay
 * the same.
 */
TEST(test_each_prediction_makes_the_values_that_it_is_said_to_make)
{
    static const uint32_t modes[] = {BEFORE_14, LINE_14, SMOOTH_14};
    static const int32_t differences[] = {100, -7, 33, 1, -250, 18, 5, -90};

    for (uint32_t m = 0U; m < (sizeof modes / sizeof modes[0]); m++) {
        int32_t before[4] = {0};

        write_begin(4U, modes[m]);
        for (uint32_t k = 0U; k < (sizeof differences / sizeof differences[0]); k++) {
            const int32_t d = differences[k];

            write_bits(0U, 1U);
            write_bits((uint32_t)((d < 0) ? ((-2 * d) - 1) : (2 * d)), 14U);
        }
        TEST_ASSERT_TRUE(written_decodes(1U + (sizeof differences / sizeof differences[0])));
        for (uint32_t k = 0U; k < (sizeof differences / sizeof differences[0]); k++) {
            const int32_t value = predicted(modes[m], before) + differences[k];

            TEST_ASSERT_EQUAL_HEX32((uint32_t)value & 0xFFFFU, back[k + 1U].word[3] >> 16U);
            before[3] = before[2];
            before[2] = before[1];
            before[1] = before[0];
            before[0] = value;
        }
    }
}

TEST(test_the_escape_of_a_change_is_one_in_the_first_channel_only)
{
    for (uint32_t channel = 0U; channel < 5U; channel++) {
        write_begin(channel, BEFORE_0);
        write_bits(0x7FFU, 11U);
        for (uint32_t word = 0U; word < 3U; word++) {
            write_bits(0xFFFFU, 16U);
            write_bits(0U, 16U);
        }
        TEST_ASSERT_EQUAL(channel == 0U, written_decodes(2U));
    }
    write_begin(0U, BEFORE_0);
    write_bits(0x7FFU, 11U);
    write_bits(0U, 3U * 32U);
    TEST_ASSERT_TRUE(written_decodes(2U));
    TEST_ASSERT_EQUAL_HEX32(CHANGE_MARK, back[1].word[2]);
}

/* Entries that do not change take no bits: the length does not tell their number. */
TEST(test_a_code_of_no_entry_or_of_more_than_the_most_is_refused)
{
    static recorder_entry_t one_more[MAX + 1U];

    write_begin(0U, 0U);
    TEST_ASSERT_TRUE(written_decodes(1U));
    TEST_ASSERT_TRUE(written_decodes(MAX));
    TEST_ASSERT_FALSE(frame_code_decode(code, (written + 7U) / 8U, one_more, MAX + 1U));
    TEST_ASSERT_FALSE_MESSAGE(decodes_alone(code, (MODES + 7U) / 8U, 0U), "modes alone");
}

/* Two changes end with a byte, one does not. */
TEST(test_behind_the_last_entry_there_are_zeros_to_the_end_of_the_byte_and_nothing_else)
{
    entries[0] = change();
    entries[1] = change();
    TEST_ASSERT_EQUAL_UINT32((MODES + (2U * (1U + (3U * 32U)))) / 8U, round_trip(2U));
    code[28] = 0U;
    TEST_ASSERT_FALSE(decodes_alone(code, 28U + 1U, 2U));
    write_begin(0U, BEFORE_0);
    write_bits(0U, 1U); /* and 7 bits up to the end of the byte */
    TEST_ASSERT_TRUE(written_decodes(2U));
    for (uint32_t bit = 1U; bit < 8U; bit++) {
        code[written / 8U] = (uint8_t)(1U << bit);
        TEST_ASSERT_FALSE(written_decodes(2U));
    }
}

/* A step behind values that are 0: 9 ones and a 0 for z = 9; for z = 10 the escape and 16 bits. */
TEST(test_a_value_is_escaped_from_10_ones_on_and_not_before)
{
    const uint32_t others = MODES + FIRST_ZERO + (MAX - 3U); /* a bit each */

    entries[MAX - 2U] = frame(0U, 0U, 0U, 0U, 0xFFFBU); /* by −5: z is 9 */
    entries[MAX - 1U] = entries[MAX - 2U];
    TEST_ASSERT_EQUAL_UINT32((others + 10U + 1U + 7U) / 8U, round_trip(MAX));
    entries[MAX - 2U] = frame(0U, 0U, 0U, 0U, 5U); /* z is 10 */
    entries[MAX - 1U] = entries[MAX - 2U];
    TEST_ASSERT_EQUAL_UINT32((others + 27U + 1U + 7U) / 8U, round_trip(MAX));
}

/* A change is 97 bits where no frame is before it. */
TEST(test_a_code_takes_all_of_the_room)
{
    for (uint32_t k = 0U; k < MAX; k++) {
        entries[k] = change();
    }
    for (uint32_t count = 3U; count < MAX; count++) {
        const uint32_t room = (MODES + (count * (1U + (3U * 32U))) + 7U) / 8U;
        uint32_t length = 0U;

        TEST_ASSERT_EQUAL_UINT32(count, frame_code_encode(entries, MAX, code, room, &length));
        TEST_ASSERT_EQUAL_UINT32(room, length);
        TEST_ASSERT_EQUAL_UINT32(count - 1U,
                                 frame_code_encode(entries, MAX, code, room - 1U, &length));
    }
}
