// SPDX-License-Identifier: MIT
#include "command_source.h"

#include "interrupt.h"
#include "readable.h"

#include <array>
#include <cerrno>

#include <poll.h>
#include <unistd.h>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr int WAIT_MS = 20; // between two looks for a line that is waited for

class SourceReader : public debug::LineReader
{
public:
    SourceReader(CommandSource &source, std::FILE *echo) : source_(source), echo_(echo)
    {
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        std::optional<std::string> line = source_.next();
        while (!line && !source_.has_ended() && !debug::was_ended()) {
            poll(nullptr, 0, WAIT_MS);
            line = source_.next();
        }
        if (line) {
            fmt::print(echo_, "{}{}\n", prompt, readable(*line, debug::LINE_READABLE));
        }
        return line;
    }

    bool is_unattended() const override
    {
        return true;
    }

private:
    CommandSource &source_;
    std::FILE *echo_;
};

} // namespace

CommandSource::CommandSource(const std::string &path)
    : file_(path.empty() || path == "-" ? STDIN_FILENO : open_input(path)),
      collector_(file_ == STDIN_FILENO ? "standard input" : path, file_)
{
    if (file_ == STDIN_FILENO) {
        check_standard_input();
    }
}

CommandSource::~CommandSource()
{
    if (file_ != STDIN_FILENO) {
        close(file_);
    }
}

void CommandSource::take_what_has_come()
{
    std::array<char, 4096> bytes{};
    pollfd entry = {file_, POLLIN, 0};
    while (!ended_ && lines_.empty() && poll(&entry, 1, 0) > 0) {
        const ssize_t count = read(file_, bytes.data(), bytes.size());
        ended_ = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
        for (ssize_t k = 0; k < count; k++) {
            if (collector_.add(bytes.at(static_cast<std::size_t>(k)))) {
                lines_.push_back(collector_.take());
            }
        }
    }
    if (ended_ && collector_.has_begun()) {
        lines_.push_back(collector_.take());
    }
}

std::optional<std::string> CommandSource::next()
{
    take_what_has_come();
    if (lines_.empty()) {
        return std::nullopt;
    }
    std::string line = lines_.front();
    lines_.pop_front();
    return line;
}

std::unique_ptr<debug::LineReader> CommandSource::reader(std::FILE *echo)
{
    return std::make_unique<SourceReader>(*this, echo);
}

} // namespace nf::live
