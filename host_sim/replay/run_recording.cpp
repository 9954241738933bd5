// SPDX-License-Identifier: MIT
#include "run_recording.h"

#include "reader.h"
#include "scripted_run.h"
#include "writer.h"

#include <algorithm>
#include <cstddef>

namespace nf::replay
{
namespace
{

constexpr uint32_t ENTRIES_OF_A_FRAME = 2; // it, and a change of what it is told, at most

constexpr std::size_t TICKS_AT_ONCE = 256;

// Frames of a run.
struct Span {
    std::size_t first;
    std::size_t end;
};

// Behind the last tick that brought FAULT and those that a board records after it.
std::size_t end_of(const RecordedRun &run, const std::function<void()> &meanwhile)
{
    ScriptedRun ticks(run);
    std::size_t end = run.frames.size();
    bool failed = run.image.state.state == DRIVE_STATE_FAULT;
    for (std::size_t k = 0; k < run.frames.size(); k++) {
        const bool fails = ticks.control().sim->drive().state == DRIVE_STATE_FAULT;
        if (fails && !failed) {
            end = std::min(run.frames.size(), k + 1 + POST_TICKS);
        }
        failed = fails;
        ticks.advance();
        if (k % TICKS_AT_ONCE == 0) {
            meanwhile();
        }
    }
    return end;
}

std::size_t frames_max()
{
    constexpr std::size_t BYTES_OF_LINE = RECORDER_LINE_CHARACTERS + 1; // with its end
    constexpr std::size_t WORDS_OF_ENTRY = sizeof(recorder_entry_t) / sizeof(uint32_t);
    constexpr std::size_t OTHER_WORDS = 4096; // header, configurations, state
    constexpr std::size_t OF_FILE =
        (LOG_BYTES_MAX / BYTES_OF_LINE * RECORDER_LINE_WORDS - OTHER_WORDS) / WORDS_OF_ENTRY;
    constexpr std::size_t OF_SEGMENT = RECORDER_ENTRIES_MAX - RECORDER_ENTRIES_MIN;
    return std::min(OF_FILE, OF_SEGMENT) / ENTRIES_OF_A_FRAME;
}

// The recorder's snapshot is the state behind its first tick.
Span span_of(const RecordedRun &run, const std::function<void()> &meanwhile)
{
    constexpr std::size_t CONFIGURATIONS = 2;
    Span span{0, end_of(run, meanwhile)};
    const auto behind =
        std::find_if(run.changes.begin(), run.changes.end(),
                     [&](const ConfigChange &change) { return change.frame >= span.end; });
    if (std::distance(run.changes.begin(), behind) >= static_cast<std::ptrdiff_t>(CONFIGURATIONS)) {
        span.first = std::prev(behind, CONFIGURATIONS)->frame;
    }
    span.first = std::max(span.first, span.end - std::min(span.end, frames_max()));
    return span;
}

} // namespace

RunRecording recording_of(const RecordedRun &run, const recorder_about_t &about,
                          const std::function<void()> &meanwhile)
{
    const Span span = span_of(run, meanwhile);
    // One segment holds all of it.
    const auto frames = static_cast<uint32_t>(span.end - span.first);
    Writer writer(about, ENTRIES_OF_A_FRAME * frames + RECORDER_ENTRIES_MIN, Writer::Until::end);
    ScriptedRun ticks(run);
    for (std::size_t k = 0; k < span.end; k++) {
        const Tick tick = ticks.control();
        if (k >= span.first) {
            writer.add(tick);
        }
        ticks.advance();
        if (k % TICKS_AT_ONCE == 0) {
            meanwhile();
        }
    }
    const bool failed = ticks.sim().drive().state == DRIVE_STATE_FAULT;
    return {writer.text(), run.first() + static_cast<int64_t>(span.first) + 1,
            static_cast<int64_t>(span.end - span.first) - 1, failed};
}

} // namespace nf::replay
