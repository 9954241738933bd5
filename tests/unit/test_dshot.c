/* SPDX-License-Identifier: MIT */
/*
 * DShot frames: of all three speeds, of every value, and frames that are none.
 *
 * Facts, as the public descriptions of the protocol have them (Betaflight, AM32, DShotRMT). A bit
 * of DShot150, 300, 600 takes 6.67, 3.33, 1.67 µs; a 1 is high for 5.00, 2.50, 1.25 µs, a 0 for
 * 2.50, 1.25, 0.625 µs. With v = value and telemetry bit, the checksum is v ^ (v >> 4) ^ (v >> 8),
 * and its complement in bidirectional DShot, whose line is high between the frames. 1046 without
 * telemetry is the frame 1000001011000110.
 */
#include "dshot.h"
#include "seeded.h"
#include "testing.h"

#define NS (100.0) /* of a unit of time */
#define SPEEDS (3U)

static const double BIT_NS[SPEEDS] = {6666.7, 3333.3, 1666.7};
static const double ONE_NS[SPEEDS] = {5000.0, 2500.0, 1250.0};
static const double ZERO_NS[SPEEDS] = {2500.0, 1250.0, 625.0};

static dshot_t dshot;
static input_signal_t signal;
static double now_ns;
static uint32_t got; /* good frames */

void setUp(void)
{
    dshot = (dshot_t){0};
    input_signal_init(&signal, 0U);
    now_ns = 1e6;
    got = 0U;
}

static void count(bool good)
{
    if (good) {
        got++;
        input_signal_good(&signal, dshot.frame.value, 1U);
    }
}

/* The capture's time wraps. */
static uint32_t units_of(double ns)
{
    return (uint32_t)(uint64_t)(ns / NS);
}

/* A pulse of the capture: times are rounded to its unit. */
static void pulse(double start_ns, double width_ns)
{
    const uint32_t start = units_of(start_ns);
    const uint32_t end = units_of(start_ns + width_ns);

    count(dshot_take(&dshot, &(hal_pulse_t){.start = start, .width = end - start}, &signal));
}

static uint32_t checksum(uint32_t v)
{
    return (v ^ (v >> 4U) ^ (v >> 8U)) & 15U;
}

static uint32_t bits_of(uint32_t value, bool telemetry)
{
    const uint32_t v = (value << 1U) | (telemetry ? 1U : 0U);

    return (v << 4U) | checksum(v);
}

/* So many bits from the highest one on, at `scale` times the nominal speed's period. Beyond 32 they
 * are 0. */
static void send(uint32_t bits, uint32_t length, uint32_t speed, double scale)
{
    for (uint32_t k = 0U; k < length; k++) {
        const uint32_t place = length - 1U - k;
        const bool one = (place < 32U) && (((bits >> place) & 1U) != 0U);

        pulse(now_ns, scale * (one ? ONE_NS[speed] : ZERO_NS[speed]));
        now_ns += scale * BIT_NS[speed];
    }
}

/* A pause, at whose end the background has looked. */
static void pause_ns(double ns)
{
    now_ns += ns;
    count(dshot_step(&dshot, units_of(now_ns), &signal));
}

static void send_frame(uint32_t bits, uint32_t speed)
{
    send(bits, 16U, speed, 1.0);
    pause_ns(50000.0);
}

TEST(test_the_example_of_the_descriptions_is_read)
{
    TEST_ASSERT_EQUAL_HEX32(0x82C6U, bits_of(1046U, false)); /* 1000001011000110 */
    for (uint32_t speed = 0U; speed < SPEEDS; speed++) {
        setUp();
        send_frame(0x82C6U, speed);
        TEST_ASSERT_EQUAL_UINT32(1U, got);
        TEST_ASSERT_EQUAL_UINT16(1046U, dshot.frame.value);
        TEST_ASSERT_FALSE(dshot.frame.telemetry);
    }
}

TEST(test_every_value_is_read_at_every_speed_with_and_without_telemetry)
{
    for (uint32_t k = 0U; k < (2048U * 2U * SPEEDS); k++) {
        const uint32_t value = k % 2048U;
        const bool telemetry = ((k / 2048U) % 2U) != 0U;

        send_frame(bits_of(value, telemetry), k / 4096U);
        TEST_ASSERT_EQUAL_UINT16(value, dshot.frame.value);
        TEST_ASSERT_EQUAL(telemetry, dshot.frame.telemetry);
    }
    TEST_ASSERT_EQUAL_UINT32(2048U * 2U * SPEEDS, got);
    TEST_ASSERT_FALSE(signal.noisy);
}

/* 32 kHz of DShot600: 4.5 µs between two frames. */
TEST(test_frames_that_follow_each_other_closely_are_told_apart_by_the_next_pulse)
{
    for (uint32_t k = 0U; k < 100U; k++) {
        send(bits_of(48U + k, false), 16U, 2U, 1.0);
        now_ns += 4500.0;
    }
    TEST_ASSERT_EQUAL_UINT32(99U, got); /* the last one has no next pulse */
    TEST_ASSERT_EQUAL_UINT16(48U + 98U, dshot.frame.value);
    pause_ns(30000.0);
    TEST_ASSERT_EQUAL_UINT32(100U, got);
}

/* A clock that is off by 10 %: beyond both ends by 20 %. */
TEST(test_a_speed_that_is_none_of_the_three_is_refused)
{
    for (uint32_t speed = 0U; speed < SPEEDS; speed++) {
        static const double off[] = {0.8, 0.9, 1.1, 1.2};

        for (uint32_t k = 0U; k < 4U; k++) {
            setUp();
            send(bits_of(1046U, false), 16U, speed, off[k]);
            pause_ns(50000.0);
            TEST_ASSERT_EQUAL_UINT32(((k == 1U) || (k == 2U)) ? 1U : 0U, got);
        }
    }
}

TEST(test_a_frame_with_any_one_wrong_bit_is_refused)
{
    for (uint32_t k = 0U; k < 16U; k++) {
        send_frame(0x82C6U ^ (1U << k), k % SPEEDS);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_CHECKSUM, signal.why);
}

TEST(test_a_frame_with_too_few_or_too_many_pulses_is_refused)
{
    for (uint32_t length = 1U; length <= 40U; length++) {
        if (length != 16U) {
            send(bits_of(1046U, false) | (bits_of(1046U, false) << 16U), length, length % SPEEDS,
                 1.0);
            pause_ns(50000.0);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SHAPE, signal.why);
}

TEST(test_a_pulse_within_a_frame_that_is_a_runt_or_too_wide_spoils_it)
{
    for (uint32_t at = 0U; at < 16U; at++) {
        static const double share[] = {0.1, 0.97};

        for (uint32_t k = 0U; k < 32U; k++) {
            const double bit_ns = BIT_NS[0];
            const bool odd = (k % 16U) == at;

            pulse(now_ns, odd ? (share[k / 16U] * bit_ns) : ZERO_NS[0]);
            now_ns += bit_ns;
            if ((k % 16U) == 15U) {
                pause_ns(50000.0);
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

/* A frame of value 0 is 16 pulses of a 0, so each missing one shows in a period. */
TEST(test_a_frame_that_lacks_a_pulse_or_has_a_glitch_is_refused)
{
    for (uint32_t at = 0U; at < 16U; at++) {
        for (uint32_t k = 0U; k < 16U; k++) {
            if (k != at) {
                pulse(now_ns + (k * BIT_NS[1]), ZERO_NS[1]);
            }
        }
        now_ns += 16.0 * BIT_NS[1];
        pause_ns(50000.0);
        for (uint32_t k = 0U; k < 16U; k++) {
            pulse(now_ns + (k * BIT_NS[1]), ZERO_NS[1]);
            if (k == at) {
                pulse(now_ns + ((k + 0.6) * BIT_NS[1]), 300.0);
            }
        }
        now_ns += 16.0 * BIT_NS[1];
        pause_ns(50000.0);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

TEST(test_the_inverted_checksum_of_bidirectional_dshot_is_named)
{
    for (uint32_t k = 0U; k < 2048U; k++) {
        send_frame(bits_of(k, false) ^ 15U, k % SPEEDS);
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_INVERTED, signal.lost);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

/* What is high there is the rest of each bit, and the pause. */
TEST(test_an_inverted_line_is_named_and_gives_no_frame)
{
    for (uint32_t k = 0U; k < (50U * SPEEDS); k++) {
        const uint32_t speed = k / 50U;
        const uint32_t bits = bits_of(48U + (37U * k) % 2000U, false) ^ 15U;

        for (uint32_t at = 0U; at < 16U; at++) {
            const bool one = ((bits >> (15U - at)) & 1U) != 0U;
            const double low_ns = one ? ONE_NS[speed] : ZERO_NS[speed];
            const double high_ns = BIT_NS[speed] - low_ns;

            pulse(now_ns + low_ns, (at == 15U) ? 200000.0 : high_ns);
            now_ns += BIT_NS[speed];
        }
        now_ns += 200000.0;
        count(dshot_step(&dshot, units_of(now_ns), &signal));
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_INVERTED, signal.lost);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

/* Servo pulses at an input for DShot. */
TEST(test_servo_pulses_are_no_frames)
{
    for (uint32_t k = 0U; k < 100U; k++) {
        pulse(now_ns, 1500000.0);
        pause_ns(20000000.0);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
    TEST_ASSERT_NOT_EQUAL(INPUT_LOST_NOT, signal.lost);
}

/* Without waiting for a time-out: one of 16 wrong frames has a good checksum. */
TEST(test_eight_bad_frames_in_a_row_lose_the_signal)
{
    for (uint32_t k = 0U; k < 8U; k++) {
        send_frame(bits_of(1046U, false), 2U);
    }
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
    for (uint32_t k = 0U; k < 7U; k++) {
        send_frame(bits_of(1046U, false) ^ 1U, 2U);
    }
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
    send_frame(bits_of(1046U, false) ^ 1U, 2U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_CHECKSUM, signal.lost);
}

/*
 * Any pulses: how many pass as frames is bounded by what a checksum of four bits can tell. 16
 * pulses of one period and of good widths are needed first, so of such random ones none passes.
 */
TEST(test_random_pulses_are_no_frames)
{
    seeded_t seed = {20241U};
    const uint32_t runs = testing_runs(200000U, 20000000U);

    for (uint32_t k = 0U; k < runs; k++) {
        now_ns += seeded_in(&seed, 300, 12000);
        pulse(now_ns, seeded_in(&seed, 100, 6000));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

/* Edges that jitter by up to 1/16 of a bit are still read, and as what was sent. */
TEST(test_jitter_of_a_sixteenth_of_a_bit_changes_no_value)
{
    seeded_t seed = {77U};

    for (uint32_t k = 0U; k < 3000U; k++) {
        const uint32_t speed = k % SPEEDS;
        const uint32_t value = (uint32_t)seeded_in(&seed, 0, 2047);
        const uint32_t bits = bits_of(value, false);
        const int32_t most_ns = (int32_t)(BIT_NS[speed] / 32.0);

        for (uint32_t at = 0U; at < 16U; at++) {
            const bool one = ((bits >> (15U - at)) & 1U) != 0U;
            const double early_ns = seeded_in(&seed, -most_ns, most_ns);
            const double late_ns = seeded_in(&seed, -most_ns, most_ns);

            pulse(now_ns + early_ns, (one ? ONE_NS[speed] : ZERO_NS[speed]) + late_ns - early_ns);
            now_ns += BIT_NS[speed];
        }
        pause_ns(50000.0);
        TEST_ASSERT_EQUAL_UINT32(k + 1U, got);
        TEST_ASSERT_EQUAL_UINT16(value, dshot.frame.value);
    }
}

TEST(test_the_time_of_the_pulses_may_wrap)
{
    now_ns = (4294967296.0 - 250.0) * NS; /* within the frame */
    dshot.last = units_of(now_ns) - 1000U;
    send(bits_of(1046U, false), 16U, 0U, 1.0);
    for (uint32_t k = 0U; k < 3U; k++) {
        now_ns -= (k == 0U) ? (4294967296.0 * NS) : 0.0;
        pause_ns(50000.0);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, got);
}

TEST(test_a_frame_with_a_pulse_a_third_of_a_bit_late_is_refused)
{
    for (uint32_t late = 2U; late < 16U; late++) {
        for (uint32_t k = 0U; k < 16U; k++) {
            const double off_ns = (k == late) ? (0.35 * BIT_NS[0]) : 0.0;

            pulse(now_ns + off_ns, ZERO_NS[0]);
            now_ns += BIT_NS[0];
        }
        pause_ns(50000.0);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, got);
}

TEST(test_a_frame_has_not_ended_before_the_line_has_been_silent_for_20_us)
{
    const double after_last_start_ns = 20000.0 - BIT_NS[0];

    send(bits_of(1046U, false), 16U, 0U, 1.0);
    pause_ns(after_last_start_ns - 200.0);
    TEST_ASSERT_EQUAL_UINT32(0U, got);
    pause_ns(400.0);
    TEST_ASSERT_EQUAL_UINT32(1U, got);
}
