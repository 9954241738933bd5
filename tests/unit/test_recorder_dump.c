/* SPDX-License-Identifier: MIT */
/* The recording as text: bytes where the header says, each line by itself as good as its CRC. */
#include "crc32.h"
#include "drive_words.h"
#include "recorded_run.h"
#include "recorder_dump.h"
#include "recorder_pack.h"
#include "testing.h"

#include <string.h>

#define WORD_BYTES (4U)
#define LINE_WORDS (RECORDER_LINE_WORDS + 2U)
#define WORDS_MAX (8192U)
#define CONFIG_WORDS ((uint32_t)(sizeof(drive_cfg_t) / WORD_BYTES))

static recorded_run_t run;
static recorder_dump_t dump;
static recorder_about_t about;
static uint32_t words[WORDS_MAX];

void setUp(void)
{
    recorded_run_start(&run);
    recorded_run_ticks(&run, 3000U);
    recorded_run_fail(&run);
    recorded_run_ticks(&run, RUN_POST_TICKS + 1U);
    about = (recorder_about_t){.tick_ps = 1U,
                               .current_full_scale_ua = 2U,
                               .bus_full_scale_uv = 3U,
                               .pole_pairs = 4U,
                               .build = {5U, 6U, 7U, 8U, 9U},
                               .name = {10U}};
    recorder_dump_start(&dump, &run.recorder, &about);
}

static uint32_t digit_of(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *const at = strchr(digits, c);

    TEST_ASSERT_NOT_NULL(at);
    return (uint32_t)(at - digits);
}

/* Number, words, CRC. */
static void decode(const char *line, uint32_t out[LINE_WORDS])
{
    uint8_t bytes[LINE_WORDS * WORD_BYTES];

    TEST_ASSERT_EQUAL_UINT32(RECORDER_LINE_CHARACTERS, strlen(line));
    TEST_ASSERT_EQUAL_CHAR('~', line[0]);
    for (uint32_t k = 0U; k < (sizeof(bytes) / 3U); k++) {
        uint32_t group = 0U;

        for (uint32_t d = 0U; d < 4U; d++) {
            group = (group << 6U) | digit_of(line[1U + (4U * k) + d]);
        }
        bytes[3U * k] = (uint8_t)(group >> 16U);
        bytes[(3U * k) + 1U] = (uint8_t)((group >> 8U) & 0xFFU);
        bytes[(3U * k) + 2U] = (uint8_t)(group & 0xFFU);
    }
    (void)memcpy(out, bytes, sizeof(bytes)); /* the PC is little-endian */
}

static uint32_t crc_of(const uint32_t *from, uint32_t count)
{
    uint32_t crc = CRC32_START;

    for (uint32_t k = 0U; k < count; k++) {
        crc = crc32_step(crc, (const uint8_t *)&from[k]);
    }
    return ~crc;
}

/* All lines, checked; the number of words. */
static uint32_t read_all(void)
{
    const uint32_t lines = recorder_dump_lines(&dump);
    char line[RECORDER_LINE_CHARACTERS + 1U];
    uint32_t decoded[LINE_WORDS];

    for (uint32_t k = 0U; k < lines; k++) {
        (void)memset(line, '?', sizeof(line)); /* the line ends itself */
        TEST_ASSERT_TRUE(recorder_dump_line(&dump, line));
        TEST_ASSERT_EQUAL_CHAR('\0', line[RECORDER_LINE_CHARACTERS]);
        decode(line, decoded);
        TEST_ASSERT_EQUAL_UINT32(k, decoded[0]);
        TEST_ASSERT_EQUAL_HEX32(crc_of(decoded, LINE_WORDS - 1U), decoded[LINE_WORDS - 1U]);
        (void)memcpy(&words[k * RECORDER_LINE_WORDS], &decoded[1],
                     RECORDER_LINE_WORDS * WORD_BYTES);
    }
    TEST_ASSERT_FALSE(recorder_dump_line(&dump, line));
    return lines * RECORDER_LINE_WORDS;
}

/* The check value of this CRC: that of "123456789"; here of eight digits, as it goes by four. */
TEST(test_crc_is_that_of_ieee_802_3)
{
    const uint8_t bytes[] = "12345678";
    const uint32_t crc = crc32_step(crc32_step(CRC32_START, bytes), &bytes[4]);

    TEST_ASSERT_EQUAL_HEX32(0x9AE0DAAFU, ~crc);
}

TEST(test_parts_lie_behind_each_other_and_the_end_is_their_crc)
{
    const uint32_t read = read_all();
    const recorder_history_t history = recorder_history(&run.recorder);
    const drive_t *const begin = recorder_begin_state(&run.recorder, &history);
    const uint32_t state = RECORDER_HEADER_WORDS + CONFIG_WORDS;
    const uint32_t entries = state + drive_words_count();
    const uint32_t end = entries + (4U * history.entries);
    const recorder_entry_t *const last =
        recorder_entry(&run.recorder, &history, history.entries - 1U);

    TEST_ASSERT_EQUAL_MEMORY(&dump.header, words, sizeof(dump.header));
    TEST_ASSERT_EQUAL_MEMORY(&run.cfg, &words[RECORDER_HEADER_WORDS], sizeof(run.cfg));
    for (uint32_t k = 0U; k < drive_words_count(); k++) {
        TEST_ASSERT_EQUAL_HEX32(drive_words_get(begin, k), words[state + k]);
    }
    TEST_ASSERT_EQUAL_MEMORY(last, &words[end - 4U], sizeof(*last));
    TEST_ASSERT_EQUAL_UINT32(end + 1U, dump.header.words);
    TEST_ASSERT_EQUAL_HEX32(crc_of(words, end), words[end]);
    for (uint32_t k = end + 1U; k < read; k++) {
        TEST_ASSERT_EQUAL_HEX32(0U, words[k]);
    }
}

static drive_cfg_t further;

/* A recording that begins with run.cfg and changes to `further`. */
static void record_a_change(void)
{
    recorded_run_start(&run);
    recorded_run_ticks(&run, 100U);
    further = run.cfg;
    further.current_loop.pi_d.kp++;
    further.crc = config_guard_crc(&further);
    drive_change(&run.drive, &further);
    recorder_change(&run.recorder, &run.cfg);
    recorded_run_ticks(&run, 10U);
    recorder_hold(&run.recorder, &run.drive);
    recorded_run_ticks(&run, 2U);
}

TEST(test_a_configuration_that_it_changes_to_lies_behind_the_entries)
{
    uint32_t end = 0U;

    record_a_change();
    recorder_dump_start(&dump, &run.recorder, &about);
    (void)read_all();
    end = RECORDER_HEADER_WORDS + CONFIG_WORDS + drive_words_count() + (4U * dump.header.entries);
    TEST_ASSERT_EQUAL_UINT32(1U, dump.header.further);
    TEST_ASSERT_EQUAL_MEMORY(&run.cfg, &words[RECORDER_HEADER_WORDS], sizeof(run.cfg));
    TEST_ASSERT_EQUAL_MEMORY(&further, &words[end], sizeof(further));
    TEST_ASSERT_EQUAL_UINT32(end + CONFIG_WORDS + 1U, dump.header.words);
    TEST_ASSERT_EQUAL_HEX32(crc_of(words, end + CONFIG_WORDS), words[end + CONFIG_WORDS]);
}

TEST(test_header_says_how_it_ended)
{
    const recorder_header_t *const header = &dump.header;
    const drive_t *const end = recorder_end_state(&run.recorder);

    TEST_ASSERT_EQUAL_MEMORY("NFRD", &header->magic, WORD_BYTES);
    TEST_ASSERT_EQUAL_UINT32(RECORDER_VERSION, header->version);
    TEST_ASSERT_EQUAL_UINT32(0U, header->further);
    TEST_ASSERT_EQUAL_UINT32(run.drive.fault.tick, header->fault_tick);
    TEST_ASSERT_EQUAL_UINT32(FAULT_BREAK, header->fault_id);
    TEST_ASSERT_EQUAL_UINT32(end->tick, header->end_tick);
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(end), header->end_hash);
    TEST_ASSERT_EQUAL_MEMORY(&about, &header->about, sizeof(about));
}

TEST(test_without_a_fault_the_header_has_none)
{
    recorded_run_start(&run);
    /* Of one that was cleared. */
    run.drive.fault = (fault_t){.id = FAULT_BREAK, .value = 1, .limit = 2, .tick = 3U};
    recorded_run_ticks(&run, 100U);
    recorder_hold(&run.recorder, &run.drive);
    recorded_run_ticks(&run, 2U);
    recorder_dump_start(&dump, &run.recorder, &about);
    TEST_ASSERT_EQUAL_UINT32(FAULT_NONE, dump.header.fault_id);
    TEST_ASSERT_EQUAL_UINT32(0U, dump.header.fault_value);
    TEST_ASSERT_EQUAL_UINT32(0U, dump.header.fault_limit);
    TEST_ASSERT_EQUAL_UINT32(0U, dump.header.fault_tick);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, dump.header.entries);
}

/* ---- packed ---- */

static recorder_pack_t packed;

/* Packs the recording into at most `room` words; the file is in `words`, and its end is its CRC. */
static void pack(uint32_t room)
{
    const recorder_header_t *const header = &packed.dump.header;

    recorder_pack_start(&packed, &run.recorder, &about, room);
    while (recorder_pack_measure(&packed)) {
        /* the next piece */
    }
    TEST_ASSERT_LESS_THAN_UINT32(WORDS_MAX, header->words);
    for (uint32_t k = 0U; k < header->words; k++) {
        words[k] = recorder_pack_next(&packed);
    }
    TEST_ASSERT_EQUAL_MEMORY(header, words, sizeof(*header));
    TEST_ASSERT_EQUAL_HEX32(crc_of(words, header->words - 1U), words[header->words - 1U]);
}

TEST(test_a_configuration_that_it_changes_to_lies_behind_the_packed_entries)
{
    const recorder_header_t *const header = &packed.dump.header;
    uint32_t end;

    record_a_change();
    pack(WORDS_MAX);
    end = RECORDER_HEADER_WORDS + CONFIG_WORDS + drive_words_count() + header->packed;
    TEST_ASSERT_GREATER_THAN_UINT32(0U, header->packed);
    TEST_ASSERT_EQUAL_UINT32(recorder_history(&run.recorder).entries, header->entries);
    TEST_ASSERT_EQUAL_UINT32(1U, header->further);
    TEST_ASSERT_EQUAL_MEMORY(&run.cfg, &words[RECORDER_HEADER_WORDS], sizeof(run.cfg));
    TEST_ASSERT_EQUAL_MEMORY(&further, &words[end], sizeof(further));
    TEST_ASSERT_EQUAL_UINT32(end + CONFIG_WORDS + 1U, header->words);
}

/* The state behind its only segment was never written, and is not read. */
TEST(test_a_room_in_which_no_segment_fits_gets_the_head_of_the_whole_recording_without_entries)
{
    const recorder_header_t *const header = &packed.dump.header;
    const uint32_t configs = 2U * CONFIG_WORDS;
    const uint32_t head = RECORDER_HEADER_WORDS + configs + drive_words_count() + 1U;
    const uint32_t rooms[] = {0U, head - 1U, head, head + 1U};

    record_a_change();
    for (uint32_t k = 0U; k < (sizeof(rooms) / sizeof(rooms[0])); k++) {
        pack(rooms[k]);
        TEST_ASSERT_EQUAL_UINT32(0U, header->entries);
        TEST_ASSERT_EQUAL_UINT32(0U, header->packed);
        TEST_ASSERT_EQUAL_UINT32(head, header->words);
        TEST_ASSERT_EQUAL_MEMORY(&run.cfg, &words[RECORDER_HEADER_WORDS], sizeof(run.cfg));
    }
}

/* ---- the name ---- */

#define NAME_CHARACTERS (RECORDER_NAME_WORDS * WORD_BYTES)

/* A name with something behind it that is not its own. */
typedef struct {
    recorder_about_t about;
    uint32_t behind;
} named_t;

TEST(test_a_name_is_readable_as_text_with_zeros_behind_it)
{
    static const char text[NAME_CHARACTERS] = "motor_a, bench_310v";
    named_t named = {.behind = 0x55555555U};

    recorder_about_name(&named.about, text);
    TEST_ASSERT_EQUAL_MEMORY(text, named.about.name, NAME_CHARACTERS); /* the PC is little-endian */
    TEST_ASSERT_EQUAL_HEX32(0x55555555U, named.behind);
}

TEST(test_a_name_that_does_not_fit_is_cut_off_and_overwrites_nothing)
{
    char text[NAME_CHARACTERS + 2U];
    named_t named = {.behind = 0x55555555U};

    (void)memset(text, 'x', sizeof(text) - 1U);
    text[sizeof(text) - 1U] = '\0';
    recorder_about_name(&named.about, text);
    TEST_ASSERT_EQUAL_MEMORY(text, named.about.name, NAME_CHARACTERS);
    TEST_ASSERT_EQUAL_HEX32(0x55555555U, named.behind);
}
