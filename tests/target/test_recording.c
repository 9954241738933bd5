/* SPDX-License-Identifier: MIT */
/*
 * The recording's format: bytes where the header says.
 */
#include "drive_words.h"
#include "recording.h"
#include "testing.h"

#include <string.h>

TEST(test_header_bytes)
{
    const uint8_t expected[RECORDING_HEADER_BYTES] = {'N',  'F',  'F',  'R',  4U, 0U, 18U, 0U,
                                                      0x44, 0x33, 0x22, 0x11, 5U, 0U, 0U,  0U};
    const recording_header_t header = recording_header(RECORDING_FRAMES, 0x11223344U, 5U);
    uint8_t bytes[RECORDING_HEADER_BYTES];
    recording_header_t back;

    recording_put_header(bytes, &header);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, sizeof(bytes));
    back = recording_get_header(bytes);
    TEST_ASSERT_EQUAL_HEX32(header.magic, back.magic);
    TEST_ASSERT_EQUAL_HEX32(header.config_hash, back.config_hash);
    TEST_ASSERT_EQUAL_UINT32(header.ticks, back.ticks);
    TEST_ASSERT_NULL(recording_refuse(&back, 0x11223344U));
}

TEST(test_header_is_refused)
{
    const recording_header_t good = recording_header(RECORDING_FRAMES, 7U, 1U);
    recording_header_t bad = recording_header(RECORDING_RESULTS, 7U, 1U);

    TEST_ASSERT_NOT_NULL(recording_refuse(&bad, 7U));
    bad = good;
    bad.version++;
    TEST_ASSERT_NOT_NULL(recording_refuse(&bad, 7U));
    bad = good;
    bad.record_bytes++;
    TEST_ASSERT_NOT_NULL(recording_refuse(&bad, 7U));
    TEST_ASSERT_NOT_NULL(recording_refuse(&good, 8U));
}

TEST(test_frame_bytes)
{
    const drive_in_t in = {0x0201U, 0x0403U, 0x0605U, 0x0C0BU, {-2, 0x0FU, 0x10U},
                           0x0807U, 0x0A09U};
    const uint8_t expected[RECORDING_FRAME_BYTES] = {1U,    2U,    3U,    4U,    5U,    6U,
                                                     7U,    8U,    9U,    10U,   11U,   12U,
                                                     0xFEU, 0xFFU, 0xFFU, 0xFFU, 0x0FU, 0x10U};
    uint8_t bytes[RECORDING_FRAME_BYTES];
    uint8_t again[RECORDING_FRAME_BYTES];
    drive_in_t back;

    recording_put_frame(bytes, &in);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, sizeof(bytes));
    back = recording_get_frame(bytes);
    recording_put_frame(again, &back);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, again, sizeof(again));
    TEST_ASSERT_EQUAL_INT32(-2, back.command.target);
}

TEST(test_result_bytes)
{
    const drive_out_t out = {{{0x0201U, 0x0403U, 0x0605U}}, true};
    const drive_t drive = {.state = DRIVE_STATE_RUN};
    const uint32_t hash = drive_words_hash(&drive);
    const uint8_t expected[] = {1U, 2U, 3U, 4U, 5U, 6U, 1U, (uint8_t)DRIVE_STATE_RUN};
    uint8_t bytes[RECORDING_RESULT_BYTES];

    recording_put_result(bytes, &out, &drive);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, sizeof(expected));
    for (uint32_t k = 0U; k < 4U; k++) {
        TEST_ASSERT_EQUAL_HEX8((hash >> (8U * k)) & 0xFFU, bytes[8U + k]);
    }
}

TEST(test_config_hash_sees_every_byte)
{
    drive_cfg_t cfg;
    uint8_t bytes[sizeof(cfg)] = {0};
    uint32_t hash;

    (void)memset(&cfg, 0, sizeof(cfg));
    hash = recording_config_hash(&cfg);
    for (size_t k = 0U; k < sizeof(cfg); k++) {
        bytes[k] = 1U;
        (void)memcpy(&cfg, bytes, sizeof(cfg));
        TEST_ASSERT_NOT_EQUAL(hash, recording_config_hash(&cfg));
        bytes[k] = 0U;
    }
}
