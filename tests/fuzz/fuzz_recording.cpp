// SPDX-License-Identifier: MIT
// Any bytes as a recording: it is refused with one line, or runs again.
//
// The first byte chooses what the rest is:
//     0    the file
//     1    the words of a file, of which each line gets its CRC
//     2    changes of a genuine recording: which (1 byte), then 2 bytes for the place and 4 for the
//          word; the CRC of each configuration in it is made good
#include "bytes.h"
#include "fuzzed.h"
#include "line_code.h"
#include "reader.h"
#include "replay.h"
#include "scenario.h"
#include "scripted_run.h"
#include "writer.h"

extern "C" {
#include "config_guard.h"
}

#include <algorithm>
#include <cstring>

namespace
{

using nf::replay::Recording;
using nf::replay::RecordingError;

constexpr int TICKS = 64; // of the stepper with it
constexpr int CHANGE = TICKS / 2;

void run(const Recording &recording)
{
    const nf::replay::Result result = nf::replay::replay(recording);
    HOLDS(!nf::replay::summary(recording, result).empty(), "a recording has a summary");
    nf::ScriptedRun stepped(recording.run);
    while (stepped.tick() < stepped.end() && stepped.tick() < stepped.first() + TICKS) {
        (void)stepped.control();
        stepped.advance();
    }
}

void one_line(const RecordingError &error)
{
    const std::string line = error.what();
    HOLDS(!line.empty() && line.find_first_of("\r\n") == std::string::npos,
          "a refusal is one line");
}

// A line of a recording, the firmware's own way.
std::string encoded(uint32_t number, const uint32_t *words)
{
    constexpr const char *DIGITS =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<uint32_t> all = {number};
    all.insert(all.end(), words, words + RECORDER_LINE_WORDS);
    all.push_back(nf::replay::crc_of(all.data(), all.size()));
    std::vector<uint8_t> bytes(all.size() * sizeof(uint32_t));
    std::memcpy(bytes.data(), all.data(), bytes.size());
    std::string text(1, RECORDER_LINE_MARK);
    for (std::size_t k = 0; k + 2 < bytes.size(); k += 3) {
        const uint32_t three = static_cast<uint32_t>(bytes[k]) << 16U |
                               static_cast<uint32_t>(bytes[k + 1]) << 8U | bytes[k + 2];
        for (const unsigned shift : {18U, 12U, 6U, 0U}) {
            text += DIGITS[(three >> shift) & 63U];
        }
    }
    return text + '\n';
}

// Of words, with the CRC of all where there are as many as the header says.
std::string file_of(std::vector<uint32_t> words)
{
    constexpr std::size_t WORDS = offsetof(recorder_header_t, words) / sizeof(uint32_t);
    if (words.size() > WORDS && words[WORDS] > WORDS + 1 && words[WORDS] <= words.size()) {
        words[words[WORDS] - 1] = nf::replay::crc_of(words.data(), words[WORDS] - 1);
    }
    words.resize((words.size() + RECORDER_LINE_WORDS - 1) / RECORDER_LINE_WORDS *
                 RECORDER_LINE_WORDS);
    std::string text;
    for (std::size_t at = 0; at < words.size(); at += RECORDER_LINE_WORDS) {
        text += encoded(static_cast<uint32_t>(at / RECORDER_LINE_WORDS), words.data() + at);
    }
    return text;
}

std::vector<uint32_t> words_of(const std::string &text)
{
    std::vector<uint32_t> words;
    for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
        const std::string_view rest(text.data() + at, text.find('\n', at) - at);
        const nf::replay::Line line = nf::replay::decode_line(rest);
        words.insert(words.end(), line.words.begin(), line.words.end());
    }
    words.resize(words.at(2));
    return words;
}

// Brief runs, each ending in another state.
std::vector<uint32_t> recorded(const char *scenario, const char *duration, const char *prelude)
{
    const nf::Config config =
        nf::load_scenario(scenario, {"adc"}, {duration, prelude, "scenario.evaluate_from_s=0"});
    nf::replay::Writer writer(config);
    nf::RunOptions options;
    options.sink = &writer;
    (void)nf::run_scenario(config, options);
    return words_of(writer.text());
}

// One from the first tick on that changes its configuration, early enough for the stepper.
std::vector<uint32_t> recorded_with_a_change()
{
    const nf::Config config =
        nf::load_scenario("s1", {"adc"},
                          {"scenario.duration_s=0.01", "scenario.prelude_s=0",
                           "scenario.evaluate_from_s=0", "board.recorder_entries=1024"});
    drive_cfg_t other = nf::build(config);
    other.speed_loop.pi.kp /= 2;
    other.crc = config_guard_crc(&other);
    nf::ScriptedRun run(config);
    nf::replay::Writer writer(config);
    while (run.tick() < run.end()) {
        if (run.tick() == CHANGE) {
            run.sim().change(other);
        }
        writer.add(run.control());
        run.advance();
    }
    return words_of(writer.text());
}

const std::vector<std::vector<uint32_t>> &genuine()
{
    static const std::vector<std::vector<uint32_t>> all = {
        recorded("s1", "scenario.duration_s=0.01", "scenario.prelude_s=0.05"),
        recorded("s1_robust", "scenario.duration_s=0.01", "scenario.prelude_s=0.06"),
        recorded("s4", "scenario.duration_s=0.01", "scenario.prelude_s=0.06"),
        recorded_with_a_change(),
    };
    return all;
}

// Makes the CRC of a configuration good, and so each entry that names it.
void seal(std::vector<uint32_t> &words, std::size_t at)
{
    drive_cfg_t cfg{};
    std::memcpy(&cfg, words.data() + at, sizeof cfg);
    const uint32_t before = cfg.crc;
    cfg.crc = config_guard_crc(&cfg);
    std::replace(words.begin(), words.end(), before, cfg.crc);
    std::memcpy(words.data() + at, &cfg, sizeof cfg);
}

std::vector<uint32_t> changed(fuzz::Bytes &bytes)
{
    const std::vector<uint32_t> &good = genuine()[bytes.byte() % genuine().size()];
    std::vector<uint32_t> words = good;
    while (!bytes.empty()) {
        const std::size_t at = bytes.half() % words.size();
        words[at] = bytes.word();
    }
    constexpr std::size_t FURTHER = offsetof(recorder_header_t, further) / sizeof(uint32_t);
    seal(words, RECORDER_HEADER_WORDS);
    if (good[FURTHER] != 0) {
        seal(words, words.size() - 1 - sizeof(drive_cfg_t) / sizeof(uint32_t));
    }
    return words;
}

std::vector<uint32_t> words_in(fuzz::Bytes &bytes)
{
    std::vector<uint32_t> words;
    while (!bytes.empty()) {
        words.push_back(bytes.word());
    }
    return words;
}

Recording recording_of(fuzz::Bytes &bytes)
{
    switch (bytes.byte() % 3) {
    case 0:
        return nf::replay::read(bytes.rest());
    case 1:
        return nf::replay::read(file_of(words_in(bytes)));
    default:
        return nf::replay::parse(changed(bytes));
    }
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz::Bytes bytes(data, size);
    try {
        run(recording_of(bytes));
    } catch (const RecordingError &error) {
        one_line(error);
    }
    return 0;
}
