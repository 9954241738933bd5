// SPDX-License-Identifier: MIT
#include "recording.h"

#include "schema.h"
#include "state_check.h"

extern "C" {
#include "config_check.h"
#include "config_guard.h"
#include "crc32.h"
#include "drive_words.h"
#include "frame_code.h"
#include "words.h"
}

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>

#include <fmt/format.h>

namespace nf::replay
{
namespace
{

constexpr std::size_t WORD_BYTES = sizeof(uint32_t);
constexpr std::size_t CONFIG_WORDS = sizeof(drive_cfg_t) / WORD_BYTES;
constexpr std::size_t ENTRY_WORDS = sizeof(recorder_entry_t) / WORD_BYTES;
constexpr std::size_t CRC_WORD = 3; // of a change

using Configurations = std::vector<drive_cfg_t>;

// Of a scale, in its own unit. A board rounds its tick to its timer's counts: wider than the key's
// range.
struct Scale {
    const char *name;
    uint32_t value;
    uint32_t min;
    uint32_t max;
};

template <typename... Arguments>
[[noreturn]] void refuse(fmt::format_string<Arguments...> format, Arguments &&...arguments)
{
    throw RecordingError(fmt::format(format, std::forward<Arguments>(arguments)...));
}

uint64_t entry_words(const recorder_header_t &h)
{
    return h.packed == 0 ? uint64_t{h.entries} * ENTRY_WORDS : h.packed;
}

void check_sizes(const recorder_header_t &h, std::size_t words)
{
    if (h.version != RECORDER_VERSION) {
        refuse("of another firmware: its format is version {}, this program reads version {}",
               h.version, RECORDER_VERSION);
    }
    if (h.config_words != CONFIG_WORDS) {
        refuse("of another firmware: its configuration has {} words, this one's {}", h.config_words,
               CONFIG_WORDS);
    }
    if (h.state_words != drive_words_count()) {
        refuse("of another firmware: its state has {} words, this one's {}", h.state_words,
               drive_words_count());
    }
    if (h.further > 1) {
        refuse("its header says {} further configurations, allowed are 0 and 1", h.further);
    }
    const uint64_t expected = uint64_t{RECORDER_HEADER_WORDS} +
                              uint64_t{1 + h.further} * CONFIG_WORDS + h.state_words +
                              entry_words(h) + 1;
    if (h.words != expected) {
        refuse("its header says {} words, its parts make {}", h.words, expected);
    }
    if (words != h.words) {
        refuse("{} of {} words: it is cut off", words, h.words);
    }
}

recorder_header_t header_of(const std::vector<uint32_t> &words)
{
    recorder_header_t header{};
    if (words.empty() || words[0] != RECORDER_MAGIC) {
        refuse("no recording of a flight recorder: it begins with 0x{:08x}, not 0x{:08x}",
               words.empty() ? 0 : words[0], RECORDER_MAGIC);
    }
    if (words.size() < RECORDER_HEADER_WORDS) {
        refuse("{} of {} words of its header: it is cut off", words.size(), RECORDER_HEADER_WORDS);
    }
    std::memcpy(&header, words.data(), sizeof header);
    check_sizes(header, words.size());
    check_scales(header.about);
    return header;
}

drive_cfg_t configuration_of(const uint32_t *words, const char *which)
{
    drive_cfg_t cfg{};
    std::memcpy(&cfg, words, sizeof cfg);
    const uint32_t crc = config_guard_crc(&cfg);
    if (crc != cfg.crc) {
        refuse("the drive's {} was damaged: its CRC is 0x{:08x}, its bytes make 0x{:08x}", which,
               cfg.crc, crc);
    }
    if (const char *const bad = config_check(&cfg)) {
        refuse("this firmware refuses the {}: {}", which, bad);
    }
    return cfg;
}

drive_t state_of(const uint32_t *words, const recorder_header_t &header, const drive_cfg_t &cfg)
{
    drive_t state{};
    for (uint32_t k = 0; k < header.state_words; k++) {
        drive_words_set(&state, k, words[k]);
    }
    if (const std::string bad = state_problem(state, cfg); !bad.empty()) {
        refuse("the state's {}", bad);
    }
    if (state.tick != header.first_tick) {
        refuse("its first tick is {}, the state is of tick {}", header.first_tick, state.tick);
    }
    return state;
}

// Takes note of the configuration that the next frame has, when it is not the one in force.
void take_change(RecordedRun &run, uint32_t entry, uint32_t crc, const Configurations &all)
{
    const drive_cfg_t &in_force = run.changes.empty() ? run.image.cfg : run.changes.back().cfg;
    if (crc == in_force.crc) {
        return;
    }
    const auto found = std::find_if(all.begin(), all.end(),
                                    [crc](const drive_cfg_t &cfg) { return cfg.crc == crc; });
    if (found == all.end()) {
        refuse("its entry {} changes to the configuration 0x{:08x}, which it does not have", entry,
               crc);
    }
    run.changes.push_back({run.frames.size(), *found});
}

using Entries = std::vector<recorder_entry_t>;

// Of a piece of packed entries: see recorder_pack.h.
struct Piece {
    std::size_t end; // the frame after its last one
    uint32_t crc;    // of the outputs
};

// The word with the number of a piece's entries, and the length of its code; the CRC.
constexpr std::size_t PIECE_WORDS = 2;

// Takes the piece at `words`, of which `left` are there, and returns how many are its own.
std::size_t take_piece(const uint32_t *words, std::size_t left, Entries &entries,
                       std::vector<Piece> &pieces)
{
    const uint32_t count = words[0] & 0xFFU;
    const uint32_t length = words[0] >> 8U;
    const std::size_t used = PIECE_WORDS + (length + WORD_BYTES - 1) / WORD_BYTES;
    if (left < PIECE_WORDS || left < used || count == 0 || count > FRAME_CODE_ENTRIES_MAX) {
        refuse("its packed entries are damaged after entry {}", entries.size());
    }
    std::vector<uint8_t> code(length);
    for (std::size_t k = 0; k < code.size(); k++) {
        const std::size_t shift = 8 * (k % WORD_BYTES);
        code[k] = static_cast<uint8_t>(words[PIECE_WORDS + k / WORD_BYTES] >> shift);
    }
    const std::size_t first = entries.size();
    entries.resize(first + count);
    if (!frame_code_decode(code.data(), length, &entries[first], count)) {
        refuse("its packed entries {} to {} are no code", first, first + count - 1);
    }
    std::size_t frames = pieces.empty() ? 0 : pieces.back().end;
    recorder_frame_t frame{};
    for (std::size_t k = first; k < entries.size(); k++) {
        frames += recorder_unpack(&entries[k], &frame) ? 1U : 0U;
    }
    pieces.push_back({frames, words[1]});
    return used;
}

Entries entries_of(const recorder_header_t &header, const uint32_t *words,
                   std::vector<Piece> &pieces)
{
    Entries entries;
    if (header.packed == 0) {
        entries.resize(header.entries);
        std::memcpy(entries.data(), words, entries.size() * sizeof entries.front());
        return entries;
    }
    for (std::size_t at = 0; at < header.packed;) {
        at += take_piece(words + at, header.packed - at, entries, pieces);
    }
    if (entries.size() != header.entries) {
        refuse("its header says {} entries, its packed ones are {}", header.entries,
               entries.size());
    }
    return entries;
}

uint32_t crc_over(uint32_t before, uint32_t word)
{
    std::array<uint8_t, WORD_BYTES> bytes{};
    words_put(bytes.data(), word);
    return crc32_step(before, bytes.data());
}

uint32_t crc_over(uint32_t before, const drive_out_t &out)
{
    const uint32_t gate = out.gate_enable ? 0x8000U : 0U;
    const uint32_t both = out.compare.phase[0] | static_cast<uint32_t>(out.compare.phase[1]) << 16U;
    return crc_over(crc_over(before, both), out.compare.phase[2] | gate);
}

// The outputs that the drive computes from the inputs, and whether they are those that it had.
void compute_outputs(Recording &recording, const std::vector<Piece> &pieces)
{
    RecordedRun &run = recording.run;
    drive_t drive = run.image.state;
    drive.cfg = &run.image.cfg;
    auto change = run.changes.begin();
    std::size_t at = 0;
    for (const Piece &piece : pieces) {
        const std::size_t first = at;
        uint32_t crc = CRC32_START;
        for (; at < piece.end; at++) {
            for (; change != run.changes.end() && change->frame == at; ++change) {
                drive_change(&drive, &change->cfg);
            }
            drive_step(&drive, &run.frames[at], &run.outputs[at]);
            crc = crc_over(crc, run.outputs[at]);
        }
        if (~crc != piece.crc && !recording.departure) {
            recording.departure = {run.first() + static_cast<int64_t>(first),
                                   run.first() + static_cast<int64_t>(at) - 1, piece.crc, ~crc};
        }
    }
}

void take_frames(Recording &recording, const Entries &entries, const Configurations &all)
{
    recorder_frame_t frame{};
    for (uint32_t k = 0; k < entries.size(); k++) {
        const recorder_entry_t &entry = entries[k];
        const bool complete = recorder_unpack(&entry, &frame);
        if (k == 0 && complete) {
            refuse("its first entry is no change: what the first frame was told is missing");
        }
        if (complete) {
            recording.run.frames.push_back(frame.in);
            recording.run.outputs.push_back(frame.out);
        } else {
            take_change(recording.run, k, entry.word[CRC_WORD], all);
        }
    }
    const uint32_t ticks = recording.header.end_tick - recording.header.first_tick;
    if (recording.run.outputs.size() != ticks || ticks == 0) {
        refuse("{} frames for the ticks {} to {}", recording.run.outputs.size(),
               recording.header.first_tick, recording.header.end_tick);
    }
}

} // namespace

void check_scales(const recorder_about_t &about)
{
    constexpr uint32_t ANY = std::numeric_limits<uint32_t>::max();
    const auto pairs = static_cast<uint32_t>(find_field("motor.pole_pairs")->max);
    for (const Scale &scale : {Scale{"tick in ps", about.tick_ps, 1000000, 1000000000},
                               Scale{"current scale in uA", about.current_full_scale_ua, 1, ANY},
                               Scale{"bus scale in uV", about.bus_full_scale_uv, 1, ANY},
                               Scale{"number of pole pairs", about.pole_pairs, 1, pairs}}) {
        if (scale.value < scale.min || scale.value > scale.max) {
            refuse("its {} is {}, allowed are {} to {}", scale.name, scale.value, scale.min,
                   scale.max);
        }
    }
}

Bases bases_of(const recorder_about_t &about, const drive_cfg_t &cfg)
{
    constexpr double PICO = 1e-12;
    constexpr double MICRO = 1e-6;
    Bases b{};
    b.control_period_s = about.tick_ps * PICO;
    b.current_a = 2.0 * about.current_full_scale_ua * MICRO;
    b.voltage_v = about.bus_full_scale_uv * MICRO;
    b.pole_pairs = static_cast<int>(about.pole_pairs);
    return rescaled(b, cfg);
}

std::string Recording::name() const
{
    std::array<char, sizeof header.about.name + 1> text{};
    std::memcpy(text.data(), header.about.name, sizeof header.about.name);
    std::string name = text.data();
    std::replace_if(name.begin(), name.end(), [](char c) { return c < ' ' || c > '~'; }, '_');
    return name;
}

std::string Recording::build() const
{
    std::array<unsigned char, sizeof header.about.build> bytes{};
    std::memcpy(bytes.data(), header.about.build, bytes.size());
    std::string text;
    for (const unsigned char byte : bytes) {
        text += fmt::format("{:02x}", byte);
    }
    return text.find_first_not_of('0') == std::string::npos ? "" : text;
}

std::string reset_text(hal_reset_t reset)
{
    text_t text = {};
    fault_log_tell_reset(&text, reset);
    return {text.characters, text.length};
}

std::string Recording::reset() const
{
    const uint32_t reason = header.about.reset & 0xFFU;
    if (reason == HAL_RESET_UNKNOWN || reason >= HAL_RESETS) {
        return "";
    }
    return fmt::format(
        "{}: {}", header.about.cut != 0 ? "ends with a reset" : "last reset",
        reset_text({static_cast<hal_reset_reason_t>(reason), header.about.reset >> 8U}));
}

fault_t Recording::fault() const
{
    fault_t fault{};
    fault.id = static_cast<fault_id_t>(header.fault_id);
    fault.value = static_cast<int32_t>(header.fault_value);
    fault.limit = static_cast<int32_t>(header.fault_limit);
    fault.tick = header.fault_tick;
    return fault;
}

Recording parse(const std::vector<uint32_t> &words)
{
    Recording recording{};
    recording.header = header_of(words);
    if (recording.header.entries == 0) {
        refuse("it has no frames: the configuration changed twice in its last segment");
    }
    if (recording.header.fault_id >= FAULT_COUNT) {
        refuse("its fault is number {}, allowed are 0 to {}", recording.header.fault_id,
               FAULT_COUNT - 1);
    }
    const uint32_t *const config = words.data() + RECORDER_HEADER_WORDS;
    const uint32_t *const state = config + CONFIG_WORDS;
    const uint32_t *const entries = state + recording.header.state_words;
    DriveImage &image = recording.run.image;
    image.cfg = configuration_of(config, "configuration");
    Configurations all = {image.cfg};
    if (recording.header.further != 0) {
        const auto behind = static_cast<std::size_t>(entry_words(recording.header));
        all.push_back(configuration_of(entries + behind, "further configuration"));
    }
    image.state = state_of(state, recording.header, image.cfg);
    image.bases = bases_of(recording.header.about, image.cfg);
    std::vector<Piece> pieces;
    take_frames(recording, entries_of(recording.header, entries, pieces), all);
    compute_outputs(recording, pieces);
    return recording;
}

} // namespace nf::replay
