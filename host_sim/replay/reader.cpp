// SPDX-License-Identifier: MIT
#include "reader.h"

#include "line_code.h"

#include <cerrno>
#include <cstring>
#include <fstream>
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
            put(decode_line(text), place);
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

    std::vector<uint32_t> words_; // of the lines so far
    std::string problem_;         // the first of this recording
    std::optional<Recording> whole_;
    std::size_t number_ = 0;       // of this one in the file, from 1
    std::size_t whole_number_ = 0; // of the last whole one
    std::size_t place_ = 0;        // the last line of a recording, in the file
};

// The recording's line in a line of the log, with its mark; empty when there is none. A logger may put anything in front and
// blanks behind. No digit of base64 is a mark, so it begins at the last one; whether it is one its CRC says.
std::string_view recorded_part(std::string_view line)
{
    constexpr std::string_view BLANKS = " \t";
    const std::string_view text = line.substr(0, line.find_last_not_of(BLANKS) + 1);
    const std::size_t mark = text.rfind(RECORDER_LINE_MARK);
    if (mark == std::string_view::npos) {
        return {};
    }
    const std::string_view part = text.substr(mark);
    if (part.size() == RECORDER_LINE_CHARACTERS) {
        return part;
    }
    return text[0] == RECORDER_LINE_MARK ? text : std::string_view{};
}

} // namespace

Recording read(std::string_view bytes)
{
    Assembly assembly;
    std::size_t place = 0;
    while (!bytes.empty()) {
        const std::size_t end = bytes.find_first_of("\r\n");
        const std::string_view line = bytes.substr(0, end);
        const bool crlf = end != std::string_view::npos && bytes.substr(end, 2) == "\r\n";
        place++;
        if (const std::string_view part = recorded_part(line); !part.empty()) {
            assembly.add(part, place);
        }
        bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + (crlf ? 2 : 1));
    }
    return assembly.finish();
}

namespace
{

// What is longer than a log of days may be without an end, as a device or a pipe.
std::string bytes_of(const std::filesystem::path &path)
{
    std::ifstream file(path, std::ios::binary);
    if (!file || std::filesystem::is_directory(path)) {
        throw RecordingError(fmt::format("{}: cannot read: {}", path.string(),
                                         std::strerror(errno == 0 ? EISDIR : errno)));
    }
    constexpr std::size_t AT_ONCE = 1U << 20U;
    std::string bytes;
    while (file && bytes.size() <= FILE_BYTES_MAX) {
        const std::size_t had = bytes.size();
        bytes.resize(had + AT_ONCE);
        file.read(bytes.data() + had, AT_ONCE);
        bytes.resize(had + static_cast<std::size_t>(file.gcount()));
    }
    if (bytes.size() > FILE_BYTES_MAX) {
        throw RecordingError(
            fmt::format("{}: it is longer than {} MiB; keep the lines with a '{}', they are the "
                        "recordings",
                        path.string(), FILE_BYTES_MAX >> 20U, RECORDER_LINE_MARK));
    }
    return bytes;
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
