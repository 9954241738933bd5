// SPDX-License-Identifier: MIT
// Recordings: one of a run comes out bit for bit, through changes of its configuration too; a
// changed one is refused in one line or departs where it was changed.
#include "line_code.h"
#include "reader.h"
#include "replay.h"
#include "scenario.h"
#include "schema.h"
#include "scripted_run.h"
#include "writer.h"

extern "C" {
#include "config_guard.h"
#include "crc32.h"
#include "drive_words.h"
#include "frame_code.h"
#include "hal.h"
#include "testing.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

using nf::replay::Recording;
using nf::replay::RecordingError;
using nf::replay::Result;

namespace
{

constexpr int MUTATIONS = 3000;
constexpr int FORGERIES = 3000;
constexpr std::size_t CONFIG = RECORDER_HEADER_WORDS;
constexpr std::size_t STATE = CONFIG + sizeof(drive_cfg_t) / sizeof(uint32_t);
constexpr std::size_t ENTRY_WORDS = 4;
constexpr std::size_t ENTRIES = 5; // words of the header
constexpr std::size_t FURTHER = 6;
constexpr std::size_t FIRST_TICK = 7;

// A short run that ends in a fault.
const std::string &recorded()
{
    static const std::string text = [] {
        const nf::Config config =
            nf::load_scenario("s1", {"adc"},
                              {"scenario.duration_s=0.05", "scenario.evaluate_from_s=0",
                               "board.recorder_entries=65536",
                               "scenario.fault=[{time_s = 0.03, what = \"adc_a_high\"}]"});
        nf::replay::Writer writer(config);
        nf::RunOptions options;
        options.sink = &writer;
        (void)nf::run_scenario(config, options);
        return writer.text();
    }();
    return text;
}

const char *const KAPPA = "observer.kappa=0.03";           // may change while current flows
const char *const SLOW_TICKS = "speed_loop.slow_ticks=12"; // makes the drive begin anew

nf::Config config_with(const std::vector<std::string> &set, int entries)
{
    std::vector<std::string> all = {"scenario.duration_s=0.5", "scenario.evaluate_from_s=0",
                                    "board.recorder_entries=" + std::to_string(entries)};
    all.insert(all.end(), set.begin(), set.end());
    return nf::load_scenario("s1_robust", {"adc"}, all);
}

constexpr int WHOLE = 65536; // entries that hold all of it
constexpr int RING = 1024;   // … that hold the last ticks: four segments of 256

constexpr int64_t SEGMENT = RING / RECORDER_SEGMENTS; // ticks at most

// The last tick of these runs: the drive is in RUN and speeds up.
int64_t last_tick()
{
    static const nf::Config config = config_with({}, RING);
    static const int64_t tick = nf::ScriptedRun(config).end() - 1;
    return tick;
}

struct Given {
    int64_t tick;
    std::vector<std::string> set;
};

// The run with a drive that is given these configurations before these ticks.
std::string recorded_with(const std::vector<Given> &changes, int entries = WHOLE)
{
    const nf::Config config = config_with({}, entries);
    nf::ScriptedRun run(config);
    nf::replay::Writer writer(config);
    while (run.tick() < run.end()) {
        for (const Given &change : changes) {
            if (change.tick == run.tick()) {
                run.sim().change(nf::build(config_with(change.set, entries)));
            }
        }
        writer.add(run.control());
        run.advance();
    }
    return writer.text();
}

uint32_t crc_with(const std::vector<std::string> &set)
{
    return nf::build(config_with(set, WHOLE)).crc;
}

std::vector<std::string> lines_of(const std::string &text)
{
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at);
        lines.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return lines;
}

std::string joined(const std::vector<std::string> &lines, const char *end = "\n")
{
    std::string text;
    for (const std::string &line : lines) {
        text += line + end;
    }
    return text;
}

using Words = std::vector<uint32_t>;

Words words_of(const std::string &text)
{
    Words words;
    for (const std::string &line : lines_of(text)) {
        const nf::replay::Line decoded = nf::replay::decode_line(line);
        words.insert(words.end(), decoded.words.begin(), decoded.words.end());
    }
    words.resize(words.at(2));
    return words;
}

Words with(Words words, std::size_t at, uint32_t value)
{
    words[at] = value;
    return words;
}

Words cut(const Words &words, std::size_t count)
{
    return {words.begin(), words.begin() + static_cast<std::ptrdiff_t>(count)};
}

uint32_t bits(std::mt19937 &random)
{
    return static_cast<uint32_t>(random());
}

std::string refusal(const std::function<void()> &act)
{
    try {
        act();
    } catch (const RecordingError &error) {
        const std::string line = error.what();
        TEST_ASSERT_TRUE_MESSAGE(!line.empty() && line.find('\n') == std::string::npos,
                                 line.c_str());
        return line;
    }
    return "";
}

std::string refusal_of(const std::string &bytes)
{
    return refusal([&] { (void)nf::replay::read(bytes); });
}

std::string refusal_of(const Words &words)
{
    return refusal([&] { (void)nf::replay::parse(words); });
}

void assert_contains(const char *part, const std::string &text)
{
    TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, text.c_str());
}

// A recording that is the one that was made.
void assert_genuine(const Recording &recording)
{
    const Result result = nf::replay::replay(recording);
    TEST_ASSERT_FALSE(result.difference.has_value());
    TEST_ASSERT_EQUAL_HEX32(recording.header.end_hash, result.end_hash);
}

TEST(a_run_comes_out_bit_for_bit)
{
    const Recording recording = nf::replay::read(recorded());
    assert_genuine(recording);
    TEST_ASSERT_EQUAL_INT(FAULT_ADC_SATURATED, recording.fault().id);
    TEST_ASSERT_EQUAL_UINT32(recording.header.end_tick - 1 - 64, recording.fault().tick);
    assert_contains("ADC_SATURATED", summary(recording, nf::replay::replay(recording)));
}

TEST(text_of_a_console_around_it_does_not_matter)
{
    std::vector<std::string> lines = lines_of(recorded());
    lines.insert(lines.begin(), {"neurofoc", "READY, speed unknown, asked 0 rpm", ""});
    lines.insert(lines.begin() + 10, {"ok", std::string("\0\x7F\xFF", 3)});
    lines.emplace_back("dump ends");
    for (const char *const end : {"\n", "\r\n", "\r"}) {
        assert_genuine(nf::replay::read(joined(lines, end)));
    }
}

// As terminals log: a time in front, blanks and the end of a line behind.
TEST(what_a_logger_adds_to_its_lines_does_not_matter)
{
    for (const char *const prefix :
         {"[2024-05-01 12:00:00.123] ", "12:00:00.123 -> ", "user@host:~$ ", "[~] ", "\t"}) {
        for (const char *const behind : {"", "  ", " \t", " \r"}) {
            std::vector<std::string> lines = lines_of(recorded());
            lines.insert(lines.begin() + 10, "READY, at ~0 rpm");
            for (std::string &line : lines) {
                line = prefix + line + behind;
            }
            assert_genuine(nf::replay::read(joined(lines, "\r\n")));
        }
    }
}

// A mark of the byte order, UTF-16 as of a shell's redirection, and each line twice.
TEST(what_a_program_makes_of_the_whole_file_does_not_matter)
{
    const std::vector<std::string> lines = lines_of(recorded());
    std::string wide = "\xFF\xFE";
    for (const char c : joined(lines, "\r\n")) {
        wide += {c, '\0'};
    }
    assert_genuine(nf::replay::read(wide));
    assert_genuine(nf::replay::read("\xEF\xBB\xBF" + recorded()));
    std::vector<std::string> twice;
    for (const std::string &line : lines) {
        twice.insert(twice.end(), {"[1] " + line, "[2] " + line});
    }
    const Recording recording = nf::replay::read(joined(twice));
    assert_genuine(recording);
    TEST_ASSERT_EQUAL_STRING("", recording.remark.c_str());
}

TEST(damage_behind_what_a_logger_adds_is_named)
{
    std::vector<std::string> lines = lines_of(recorded());
    for (std::string &line : lines) {
        line.insert(0, "12:00:00 ");
    }
    lines[7].back() = lines[7].back() == 'A' ? 'B' : 'A';
    assert_contains("line 8: its CRC is", refusal_of(joined(lines)));
    lines.erase(lines.begin() + 7);
    assert_contains("line 8: it is number 8 of the recording, 7 is missing",
                    refusal_of(joined(lines)));
    lines[3].pop_back();
    assert_contains("line 5: it is number 4 of the recording, 3 is missing",
                    refusal_of(joined(lines)));
}

TEST(of_several_the_last_whole_one_counts)
{
    const std::string &whole = recorded();
    const std::string half = whole.substr(0, whole.rfind('\n', whole.size() / 2)); // whole lines
    assert_genuine(nf::replay::read(half + '\n' + whole));
    assert_genuine(nf::replay::read(whole + half));
    assert_contains("cut off", refusal_of(half + '\n' + half));
}

TEST(a_later_damaged_one_is_told)
{
    const std::string &whole = recorded();
    const std::vector<std::string> all = lines_of(whole);
    const std::size_t lines = all.size();
    const auto remark = [](const std::string &text) { return nf::replay::read(text).remark; };
    TEST_ASSERT_EQUAL_STRING("", remark(whole).c_str());
    TEST_ASSERT_EQUAL_STRING("", remark(whole + whole).c_str());
    TEST_ASSERT_EQUAL_STRING("", remark(whole.substr(0, whole.size() / 2) + '\n' + whole).c_str());

    const std::vector<std::string> later(all.begin(), all.begin() + 3);
    const std::string cut = "recording 1 of 2; a later one, line " + std::to_string(lines + 3) +
                            ": it ends after 3 of " + std::to_string(lines) +
                            " lines: it is cut off";
    TEST_ASSERT_EQUAL_STRING(cut.c_str(), remark(whole + joined(later)).c_str());
    const std::string damaged = "recording 2 of 3; a later one, line " +
                                std::to_string(2 * lines + 1) + ": it has 3 characters";
    for (const std::string &rest : {std::string("~ab\n"), "~ab\n" + joined(later).substr(82)}) {
        const std::string found = remark(whole + whole + rest);
        TEST_ASSERT_EQUAL_STRING(damaged.c_str(), found.substr(0, damaged.size()).c_str());
    }
    const Recording recording = nf::replay::read(whole + "~ab\n");
    assert_contains("\n  recording 1 of 2; a later one, line",
                    summary(recording, nf::replay::replay(recording)));
}

TEST(what_is_no_recording_is_refused)
{
    assert_contains("no recording", refusal_of(std::string()));
    assert_contains("no recording", refusal_of("READY\r\nok\r\n"));
    assert_contains("no recording", refusal_of(std::string(100000, '\0')));
    assert_contains("line 1: it has 3 characters", refusal_of("~ab"));
    assert_contains("is no digit of base64",
                    refusal_of("~" + std::string(RECORDER_LINE_CHARACTERS - 1, '*')));
    assert_contains("its CRC is", refusal_of("~" + std::string(RECORDER_LINE_CHARACTERS - 1, 'A')));
}

TEST(ticks_go_on_where_the_drives_count_wraps)
{
    nf::RecordedRun run{};
    run.image.state.tick = 0xFFFFFFF0U;
    TEST_ASSERT_EQUAL_INT64(0xFFFFFFF0LL, run.first());
    TEST_ASSERT_EQUAL_INT64(0xFFFFFFF8LL, run.tick_of(0xFFFFFFF8U));
    TEST_ASSERT_EQUAL_INT64(0x100000005LL, run.tick_of(5U));
    TEST_ASSERT_EQUAL_INT64(0xFFFFFFE0LL, run.tick_of(0xFFFFFFE0U)); // before the first
}

// By kind: 0 a byte is another, 1 cut off, 2 a line is missing, 3 twice, 4 exchanged with the next,
// 5 bytes come in between.
std::string mutated(std::mt19937 &random, int kind)
{
    std::string text = recorded();
    const auto any = [&](std::size_t count) { return static_cast<std::size_t>(random()) % count; };
    if (kind == 0) {
        text[any(text.size())] = static_cast<char>(any(256));
    } else if (kind == 1) {
        text.resize(any(text.size()));
    } else if (kind == 5) {
        text.insert(any(text.size()), std::string(1 + any(5), static_cast<char>(any(256))));
    } else {
        std::vector<std::string> lines = lines_of(text);
        const auto at = lines.begin() + static_cast<std::ptrdiff_t>(any(lines.size() - 1));
        if (kind == 2) {
            lines.erase(at);
        } else if (kind == 3) {
            lines.insert(at, std::string(*at));
        } else {
            std::swap(*at, *(at + 1));
        }
        text = joined(lines);
    }
    return text;
}

// Whatever happens to a file, it is refused in one line or it is still the same, as one with a line
// twice.
TEST(damage_is_refused)
{
    std::mt19937 random(1);
    int refused = 0;
    for (int k = 0; k < MUTATIONS; k++) {
        const std::string text = mutated(random, k % 6);
        try {
            assert_genuine(nf::replay::read(text));
        } catch (const RecordingError &) {
            TEST_ASSERT_NOT_EQUAL(0, refusal_of(text).size());
            refused++;
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(MUTATIONS * 5 / 6 * 9 / 10, refused);
}

TEST(what_the_header_says_and_the_configuration_are_checked)
{
    const Words good = words_of(recorded());
    const uint32_t many = 0xFFFFFFFF;
    const struct {
        std::size_t word;
        uint32_t value;
        const char *text;
    } cases[] = {
        {0, 0x474E5089, "no recording of a flight recorder"},
        {1, 2, "of another firmware: its format is version 2, this program reads version 5"},
        {2, 77, "its header says 77 words"},
        {3, 3, "its configuration has 3 words"},
        {4, 3, "its state has 3 words"},
        {5, many, "its parts make"},
        {FURTHER, 1, "its parts make"},
        {FURTHER, 2, "its header says 2 further configurations, allowed are 0 and 1"},
        {FURTHER, many, "its header says 4294967295 further configurations"},
        {FIRST_TICK, 3, "its first tick is 3"},
        {8, 3, "frames for the ticks"},
        {10, FAULT_COUNT, "its fault is number"},
        {15, 999999, "its tick in ps is 999999, allowed are 1000000 to 1000000000"},
        {15, 1000000001, "its tick in ps is 1000000001"},
        {16, 0, "its current scale in uA is 0"},
        {17, 0, "its bus scale in uV is 0"},
        {18, 0, "its number of pole pairs is 0, allowed are 1 to 50"},
        {18, 51, "its number of pole pairs is 51"},
        {CONFIG, good[CONFIG] ^ 4U, "configuration was damaged"},
    };
    for (const auto &[word, value, text] : cases) {
        assert_contains(text, refusal_of(with(good, word, value)));
    }
    assert_contains("is cut off", refusal_of(cut(good, good.size() - 5)));
    assert_contains("is cut off", refusal_of(cut(good, 9)));
}

// ---- packed entries ----

constexpr std::size_t PACKED = 14; // words of the header
constexpr std::size_t RESET = 48;  // the last reset
constexpr std::size_t CUT = RESET + 1;
constexpr uint32_t PIECE = 40; // entries of a piece

// The recording with its entries as recorder_pack.h says, made here a second time.
Words packed(const Words &plain)
{
    const std::size_t first = STATE + drive_words_count();
    const std::size_t count = plain[ENTRIES];
    std::vector<recorder_entry_t> entries(count);
    std::memcpy(entries.data(), &plain[first], count * sizeof(recorder_entry_t));
    Words words(plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(first));
    for (std::size_t at = 0; at < count;) {
        std::array<uint8_t, 160> code{};
        uint32_t length = 0;
        const uint32_t put = frame_code_encode(
            &entries[at], static_cast<uint32_t>(std::min<std::size_t>(PIECE, count - at)),
            code.data(), code.size() - 8, &length);
        uint32_t crc = CRC32_START;
        for (std::size_t k = at; k < at + put; k++) {
            const uint32_t *const word = entries[k].word;
            if ((word[2] & 0x8000U) == 0) {
                crc = crc32_word(crc32_word(crc, word[2]), word[3] & 0xFFFFU);
            }
        }
        words.push_back(put | length << 8U);
        words.push_back(~crc);
        for (uint32_t k = 0; k < length; k += 4) {
            uint32_t word = 0;
            std::memcpy(&word, &code[k], sizeof word);
            words.push_back(word);
        }
        at += put;
    }
    words[PACKED] = static_cast<uint32_t>(words.size() - first);
    words.insert(words.end(),
                 plain.begin() + static_cast<std::ptrdiff_t>(first + count * ENTRY_WORDS),
                 plain.end());
    words[2] = static_cast<uint32_t>(words.size());
    return words;
}

TEST(a_packed_run_is_the_same_run)
{
    for (const std::string &text : {recorded(), recorded_with({{last_tick() - 400, {KAPPA}}})}) {
        const Words plain = words_of(text);
        const Words small = packed(plain);
        const Recording expected = nf::replay::parse(plain);
        const Recording found = nf::replay::parse(small);
        TEST_ASSERT_LESS_THAN_size_t(plain.size() / 2, small.size());
        TEST_ASSERT_FALSE(found.departure.has_value());
        TEST_ASSERT_EQUAL_size_t(expected.run.frames.size(), found.run.frames.size());
        for (std::size_t k = 0; k < expected.run.frames.size(); k++) {
            TEST_ASSERT_EQUAL_MEMORY(&expected.run.frames[k], &found.run.frames[k],
                                     sizeof(drive_in_t));
            TEST_ASSERT_EQUAL_MEMORY(&expected.run.outputs[k].compare,
                                     &found.run.outputs[k].compare, sizeof(compare_t));
        }
        assert_genuine(found);
    }
}

TEST(an_output_that_a_packed_run_does_not_repeat_is_named_by_its_ticks)
{
    Words words = packed(words_of(recorded()));
    const std::size_t crc = STATE + drive_words_count() + 1;
    words[crc] ^= 1U;
    const Recording recording = nf::replay::parse(words);
    const Result result = nf::replay::replay(recording);
    TEST_ASSERT_TRUE(result.difference.has_value());
    TEST_ASSERT_EQUAL_INT64(recording.run.first(), result.difference->tick);
    assert_contains("departs at tick 1: the CRC of the outputs of ticks 1 to ",
                    summary(recording, result));
}

TEST(what_is_wrong_with_packed_entries_is_said)
{
    const Words good = packed(words_of(recorded()));
    const std::size_t first = STATE + drive_words_count();
    assert_contains("its packed entries are damaged after entry 0",
                    refusal_of(with(good, first, good[first] & ~0xFFU)));
    assert_contains("its packed entries are damaged after entry 0",
                    refusal_of(with(good, first, 0xFFFFFF28U)));
    assert_contains("its packed entries 0 to 39 are no code",
                    refusal_of(with(good, first, good[first] - 0x100U)));
    assert_contains("its header says 3 entries", refusal_of(with(good, ENTRIES, 3)));
    assert_contains("its parts make", refusal_of(with(good, PACKED, good[PACKED] + 1)));
}

TEST(the_last_reset_is_told)
{
    const Words good = words_of(recorded());
    const auto told = [&](uint32_t reset, uint32_t cut) {
        const Recording recording = nf::replay::parse(with(with(good, RESET, reset), CUT, cut));
        return summary(recording, nf::replay::replay(recording));
    };
    assert_contains("\n  last reset: pin\n", told(HAL_RESET_PIN, 0));
    assert_contains("\n  ends with a reset: watchdog after exception 3\n",
                    told(HAL_RESET_WATCHDOG | 3U << 8U, 1));
    TEST_ASSERT_TRUE(told(0, 0).find("reset") == std::string::npos);
    TEST_ASSERT_TRUE(told(99, 0).find("reset") == std::string::npos);
}

// What changed it, and when.
void assert_changes(const Recording &recording, const std::vector<Given> &expected)
{
    TEST_ASSERT_EQUAL_size_t(expected.size(), recording.run.changes.size());
    for (std::size_t k = 0; k < expected.size(); k++) {
        const nf::ConfigChange &change = recording.run.changes[k];
        TEST_ASSERT_EQUAL_INT64(expected[k].tick,
                                recording.run.first() + static_cast<int64_t>(change.frame));
        TEST_ASSERT_EQUAL_HEX32(crc_with(expected[k].set), change.cfg.crc);
    }
}

TEST(a_run_comes_out_bit_for_bit_through_a_change_of_its_configuration)
{
    const int64_t tick = last_tick() - 400;
    for (const char *const set : {KAPPA, SLOW_TICKS}) {
        const std::vector<Given> given = {{tick, {set}}};
        Recording recording = nf::replay::read(recorded_with(given));
        TEST_ASSERT_EQUAL_HEX32(crc_with({}), recording.run.image.cfg.crc);
        assert_changes(recording, given);
        assert_genuine(recording);
        const std::string said =
            fmt::format("\n  configuration {:08x} from tick {} on\n", crc_with({set}), tick);
        assert_contains(said.c_str(), summary(recording, nf::replay::replay(recording)));

        recording.run.changes.clear();
        const Result without = nf::replay::replay(recording);
        TEST_ASSERT_TRUE(without.difference.has_value());
        TEST_ASSERT_GREATER_OR_EQUAL_INT64(tick, without.difference->tick);
    }
}

TEST(a_change_may_come_before_any_frame_of_a_segment)
{
    for (int64_t tick = last_tick() - 2 * SEGMENT; tick < last_tick() - SEGMENT; tick += 5) {
        const std::vector<Given> given = {{tick, {KAPPA}}};
        const Recording recording = nf::replay::read(recorded_with(given, RING));
        assert_changes(recording, given);
        assert_genuine(recording);
    }
}

TEST(of_one_configuration_and_back_both_changes_come_out)
{
    const std::vector<Given> given = {{last_tick() - 500, {KAPPA}}, {last_tick() - 300, {}}};
    const std::string text = recorded_with(given);
    const Recording recording = nf::replay::read(text);
    TEST_ASSERT_EQUAL_UINT32(1, recording.header.further);
    assert_changes(recording, given);
    assert_genuine(recording);
}

// The configuration of what was before is no longer there.
TEST(of_three_configurations_the_history_begins_with_the_second)
{
    const int64_t first = last_tick() - 2 * SEGMENT;
    const std::vector<Given> given = {{last_tick() - 10, {SLOW_TICKS}}};
    const Recording recording = nf::replay::read(recorded_with({{first, {KAPPA}}, given[0]}, RING));
    TEST_ASSERT_EQUAL_HEX32(crc_with({KAPPA}), recording.run.image.cfg.crc);
    TEST_ASSERT_GREATER_OR_EQUAL_INT64(first, recording.run.first());
    assert_changes(recording, given);
    assert_genuine(recording);
}

TEST(a_recording_of_which_no_configuration_is_left_is_refused_with_the_reason)
{
    const std::string text =
        recorded_with({{last_tick() - 500, {KAPPA}}, {last_tick() - 300, {SLOW_TICKS}}});
    assert_contains("it has no frames: the configuration changed twice in its last segment",
                    refusal_of(text));
}

// A recording with a change in it, and where that is.
struct Changed {
    Words words;
    std::size_t further; // word of the configuration
    std::size_t entry;   // number of the entry that changes to it
};

Changed changed_recording()
{
    static const Words words = words_of(recorded_with({{last_tick() - 400, {KAPPA}}}, RING));
    const std::size_t entries = STATE + words[4];
    const uint32_t crc = crc_with({KAPPA});
    std::size_t entry = 0;
    while (words[entries + entry * ENTRY_WORDS + 3] != crc ||
           words[entries + entry * ENTRY_WORDS + 2] != 0x8000U) {
        entry++;
    }
    return {words, entries + words[ENTRIES] * ENTRY_WORDS, entry};
}

TEST(a_further_configuration_that_is_damaged_or_cut_off_is_refused)
{
    const auto &[words, further, entry] = changed_recording();
    assert_contains("further configuration was damaged",
                    refusal_of(with(words, further, words[further] ^ 4U)));
    assert_contains("is cut off", refusal_of(cut(words, further + 9)));
}

// Another configuration with its own CRC in place of the further one.
void put_further(Changed &changed, drive_cfg_t cfg)
{
    cfg.crc = config_guard_crc(&cfg);
    std::memcpy(&changed.words[changed.further], &cfg, sizeof cfg);
}

drive_cfg_t further_of(const Changed &changed)
{
    drive_cfg_t cfg{};
    std::memcpy(&cfg, &changed.words[changed.further], sizeof cfg);
    return cfg;
}

TEST(a_further_configuration_that_no_firmware_takes_is_refused_by_its_setting)
{
    Changed changed = changed_recording();
    drive_cfg_t cfg = further_of(changed);
    cfg.sampling.offset_log2 = 13;
    put_further(changed, cfg);
    assert_contains("this firmware refuses the further configuration: sampling.offset_log2",
                    refusal_of(changed.words));
}

TEST(a_change_to_a_configuration_that_is_not_there_is_refused_by_its_entry)
{
    const auto &[words, further, entry] = changed_recording();
    const std::size_t crc = STATE + words[4] + entry * ENTRY_WORDS + 3;
    const std::string expected = "its entry " + std::to_string(entry) +
                                 " changes to the configuration 0x12345678, which it does not have";
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), refusal_of(with(words, crc, 0x12345678)).c_str());
}

TEST(a_state_that_is_none_is_refused)
{
    const Words good = words_of(recorded());
    int refused = 0;
    for (std::size_t at = STATE; at < STATE + good[4]; at++) {
        refused += refusal_of(with(good, at, 0xFFFFFFFF)).empty() ? 0 : 1;
    }
    // 8 flags, 10 choices, guard.at, tick, and 13 shifts of the model; 67, 24 of the probe, 2 of
    // the safe state, and flag and valley of the weakening, 3 of the calibration, 2 of the flux's
    // supervision, 3 of the guard and 2 of the scene, whose range in state.def has no −1. A flag's
    // word counts by its lowest byte.
    TEST_ASSERT_EQUAL_INT(8 + 10 + 1 + 1 + 13 + 67 + 24 + 2 + 2 + 3 + 2 + 3 + 2, refused);
}

// Any words at all: refused in one line, or run without harm.
TEST(forged_words_do_no_harm)
{
    for (const Words &good : {words_of(recorded()), changed_recording().words}) {
        std::mt19937 random(2);
        for (int k = 0; k < FORGERIES; k++) {
            Words words = good;
            for (uint32_t change = 0; change <= random() % 4; change++) {
                const std::size_t end = k % 2 == 0 ? words.size() : STATE;
                words[random() % end] = k % 3 == 0 ? bits(random) : bits(random) % 64;
            }
            (void)refusal_of(words);
        }
    }
}

// A forger's configuration with its CRC, in force from any frame on.
TEST(a_forged_change_runs_or_is_refused)
{
    const Changed good = changed_recording();
    const uint32_t genuine = crc_with({KAPPA});
    std::mt19937 random(4);
    int ran = 0;
    for (int k = 0; k < FORGERIES; k++) {
        Changed forged = good;
        Words &words = forged.words;
        const std::size_t word = random() % (sizeof(drive_cfg_t) / sizeof(uint32_t) - 1);
        words[good.further + word] = k % 2 == 0 ? bits(random) : bits(random) % 8;
        put_further(forged, further_of(forged));
        std::replace(words.begin() + static_cast<std::ptrdiff_t>(STATE + words[4]),
                     words.begin() + static_cast<std::ptrdiff_t>(good.further), genuine,
                     further_of(forged).crc);
        ran += refusal([&] { (void)nf::replay::replay(nf::replay::parse(words)); }).empty() ? 1 : 0;
    }
    TEST_ASSERT_GREATER_THAN_INT(FORGERIES / 10, ran);
}

// A frame may be any: the drive is total.
TEST(forged_frames_run_and_depart)
{
    const Words good = words_of(recorded());
    const std::size_t entries = STATE + good[4];
    std::mt19937 random(3);
    for (int k = 0; k < 50; k++) {
        Words words = good;
        for (std::size_t at = entries + ENTRY_WORDS; at + 1 < words.size(); at += ENTRY_WORDS) {
            words[at] = bits(random);
            words[at + 1] = bits(random) & 0xFFFCFFFFU; // neither break nor late
        }
        const Recording recording = nf::replay::parse(words);
        TEST_ASSERT_TRUE(nf::replay::replay(recording).difference.has_value());
    }
}

TEST(another_output_is_named_with_its_tick)
{
    const Words good = words_of(recorded());
    const std::size_t entry = STATE + good[4] + 400 * ENTRY_WORDS;
    const Recording before = nf::replay::parse(good);
    const Recording after =
        nf::replay::parse(with(good, entry + 2, good[entry + 2] ^ (1U << 17U))); // compare of b
    const Result result = nf::replay::replay(after);
    std::size_t frame = 0;
    while (after.run.outputs[frame].compare.phase[1] ==
           before.run.outputs[frame].compare.phase[1]) {
        frame++;
    }
    TEST_ASSERT_TRUE(result.difference.has_value());
    TEST_ASSERT_EQUAL_UINT32(good[FIRST_TICK] + frame, result.difference->tick);
    TEST_ASSERT_EQUAL_STRING("out.compare.phase[1]", result.difference->signal.c_str());
    TEST_ASSERT_EQUAL_INT64(before.run.outputs[frame].compare.phase[1],
                            result.difference->computed);
    TEST_ASSERT_EQUAL_INT64(after.run.outputs[frame].compare.phase[1], result.difference->recorded);
    assert_contains("departs at tick", summary(after, result));
}

TEST(another_end_is_named)
{
    const Words good = words_of(recorded());
    const struct {
        std::size_t word;
        const char *signal;
    } cases[] = {{9, "the state's hash"}, {10, "drive.fault.id"}, {13, "drive.fault.tick"}};
    for (const auto &[word, signal] : cases) {
        const Result result =
            nf::replay::replay(nf::replay::parse(with(good, word, good[word] ^ 1U)));
        TEST_ASSERT_TRUE(result.difference.has_value());
        TEST_ASSERT_EQUAL_STRING(signal, result.difference->signal.c_str());
    }
}

// From the smallest to the largest that a key allows, both included.
std::vector<double> range_of(const char *key)
{
    constexpr int STEPS = 60;
    const nf::Field &field = *nf::find_field(key);
    std::vector<double> values;
    for (int k = 0; k <= STEPS; k++) {
        values.push_back(field.min * std::pow(field.max / field.min, double{1} * k / STEPS));
    }
    return values;
}

// What a replay takes from the recording of such a motor and board.
nf::Bases replayed_bases(const nf::Config &config)
{
    static const Words good = words_of(recorded());
    const recorder_about_t about = nf::replay::about(config);
    Words words = good;
    std::memcpy(words.data() + offsetof(recorder_header_t, about) / sizeof(uint32_t), &about,
                sizeof about);
    return nf::replay::parse(words).run.image.bases;
}

// `found` is `expected` but for half of a unit of the scale that it was recorded in, and for the
// arithmetic of doubles.
void assert_rounded_once(double expected, double found, double scale_in_units)
{
    constexpr double DOUBLES = 1e-14;
    const double tolerance = expected * (0.5 / scale_in_units + DOUBLES);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected, found);
}

TEST(a_recorded_speed_is_that_of_the_run_for_all_pole_pairs_and_pwm_frequencies)
{
    nf::Config config = nf::load_scenario("s1");
    const nf::Field &pairs = *nf::find_field("motor.pole_pairs");
    for (int p = static_cast<int>(pairs.min); p <= static_cast<int>(pairs.max); p++) {
        for (const double frequency_hz : range_of("board.pwm_frequency_hz")) {
            config.motor.pole_pairs = p;
            config.board.pwm_frequency_hz = frequency_hz;
            const nf::Bases expected = nf::make_bases(config.motor, config.board);
            const nf::Bases found = replayed_bases(config);
            const double tick_ps = 1e12 / frequency_hz;
            TEST_ASSERT_EQUAL_INT(p, found.pole_pairs);
            assert_rounded_once(expected.control_period_s, found.control_period_s, tick_ps);
            assert_rounded_once(expected.rpm_from_step(1), found.rpm_from_step(1), tick_ps);
        }
    }
}

TEST(a_recorded_current_and_voltage_are_those_of_the_run_for_all_full_scales)
{
    nf::Config config = nf::load_scenario("s1");
    const auto check = [&](double &scale, const char *key, double nf::Bases::*base) {
        const double before = scale;
        for (const double value : range_of(key)) {
            scale = value;
            assert_rounded_once(nf::make_bases(config.motor, config.board).*base,
                                replayed_bases(config).*base, value * 1e6);
        }
        scale = before;
    };
    check(config.board.current_full_scale_a, "board.current_full_scale_a", &nf::Bases::current_a);
    check(config.board.bus_full_scale_v, "board.bus_full_scale_v", &nf::Bases::voltage_v);
}

TEST(scales_are_those_of_the_configuration)
{
    const nf::Config config = nf::load_scenario("s1");
    const nf::Bases expected = nf::make_bases(config.motor, config.board);
    const nf::Bases found = nf::replay::read(recorded()).run.image.bases;
    TEST_ASSERT_EQUAL_INT(expected.pole_pairs, found.pole_pairs);
    TEST_ASSERT_EQUAL_INT(expected.speed_shift, found.speed_shift);
    assert_rounded_once(expected.speed_el_rad_s, found.speed_el_rad_s,
                        1e12 * expected.control_period_s);
}

} // namespace
