// SPDX-License-Identifier: MIT
#include "reader.h"

#include "line_code.h"
#include "log_file.h"
#include "whole_input.h"

#include <optional>
#include <string>

#include <fmt/format.h>

namespace nf::replay
{
namespace
{

// A recording while its lines come in.
class Assembly
{
public:
    void add(std::string_view text, std::size_t place)
    {
        place_ = place;
        try {
            const Line line = decode_line(text);
            if (line != last_) { // else a log that has each line twice
                last_ = line;
                put(line, place);
            }
        } catch (const RecordingError &error) {
            begin_after_a_whole_one();
            spoil(fmt::format("line {}: {}", place, error.what()));
        }
    }

    Recording finish() const
    {
        if (whole_) {
            Recording last = *whole_;
            last.remark = remark();
            return last;
        }
        if (problem_.empty() && words_.empty()) {
            throw RecordingError(fmt::format("there is no recording in it: no line has {} "
                                             "characters from a '{}' on",
                                             RECORDER_LINE_CHARACTERS, RECORDER_LINE_MARK));
        }
        throw RecordingError(problem_.empty() ? cut_off() : problem_);
    }

private:
    // Of what comes after the last whole one.
    std::string remark() const
    {
        if (number_ == whole_number_) {
            return "";
        }
        return fmt::format("recording {} of {}; a later one, {}", whole_number_, number_,
                           problem_.empty() ? fmt::format("line {}: {}", place_, cut_off())
                                            : problem_);
    }

    void begin()
    {
        words_.clear();
        problem_.clear();
        number_++;
    }

    // Whatever is damaged behind the end of one belongs to the next.
    void begin_after_a_whole_one()
    {
        if (whole_ && number_ == whole_number_) {
            begin();
        }
    }

    void spoil(const std::string &problem)
    {
        problem_ = problem_.empty() ? problem : problem_;
    }

    std::size_t lines() const
    {
        return words_.size() / RECORDER_LINE_WORDS;
    }

    // 0 before the word that says it.
    uint64_t expected_words() const
    {
        constexpr std::size_t WORDS = offsetof(recorder_header_t, words) / sizeof(uint32_t);
        return words_.empty() ? 0 : words_[WORDS];
    }

    std::string cut_off() const
    {
        const uint64_t all = (expected_words() + RECORDER_LINE_WORDS - 1) / RECORDER_LINE_WORDS;
        return fmt::format("it ends after {} of {} lines: it is cut off", lines(), all);
    }

    void put(const Line &line, std::size_t place)
    {
        if (line.number == 0) {
            begin();
        }
        begin_after_a_whole_one();
        if (line.number != lines()) {
            spoil(fmt::format("line {}: it is number {} of the recording, {} is missing", place,
                              line.number, lines()));
        }
        if (problem_.empty()) {
            words_.insert(words_.end(), line.words.begin(), line.words.end());
            complete();
        }
    }

    void complete()
    {
        if (words_[0] != RECORDER_MAGIC) {
            (void)parse(words_); // says so
        }
        const uint64_t words = expected_words();
        if (words < 1 || words > words_.size()) {
            return;
        }
        words_.resize(static_cast<std::size_t>(words));
        const uint32_t crc = crc_of(words_.data(), words_.size() - 1);
        if (crc != words_.back()) {
            throw RecordingError(fmt::format("the recording's CRC is 0x{:08x}, its words make "
                                             "0x{:08x}: it is damaged",
                                             words_.back(), crc));
        }
        whole_ = parse(words_);
        whole_number_ = number_;
    }

    std::optional<Line> last_;
    std::vector<uint32_t> words_; // of the lines so far
    std::string problem_;         // the first of this recording
    std::optional<Recording> whole_;
    std::size_t number_ = 0;       // of this one in the file, from 1
    std::size_t whole_number_ = 0; // of the last whole one
    std::size_t place_ = 0;        // the last line of a recording, in the file
};

// The recording's line in a line of the log, with its mark; empty when there is none. A logger may
// put anything in front. No digit of base64 is a mark, so it begins at the last one; whether it is
// one its CRC says.
std::string_view recorded_part(std::string_view line)
{
    const std::size_t mark = line.rfind(RECORDER_LINE_MARK);
    if (mark == std::string_view::npos) {
        return {};
    }
    const std::string_view part = line.substr(mark);
    if (part.size() == RECORDER_LINE_CHARACTERS) {
        return part;
    }
    return line[0] == RECORDER_LINE_MARK ? line : std::string_view{};
}

} // namespace

Recording read(std::string_view bytes)
{
    Assembly assembly;
    const std::vector<std::string> lines = log_lines(bytes);
    for (std::size_t k = 0; k < lines.size(); k++) {
        if (const std::string_view part = recorded_part(lines[k]); !part.empty()) {
            assembly.add(part, k + 1);
        }
    }
    return assembly.finish();
}

namespace
{

std::string bytes_of(const std::filesystem::path &path)
{
    try {
        return read_log(path, fmt::format("keep the lines with a '{}', they are the recordings",
                                          RECORDER_LINE_MARK));
    } catch (const InputError &error) {
        throw RecordingError(error.what());
    }
}

} // namespace

Recording read_file(const std::filesystem::path &path)
{
    const std::string bytes = bytes_of(path);
    try {
        return read(bytes);
    } catch (const RecordingError &error) {
        throw RecordingError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

} // namespace nf::replay
