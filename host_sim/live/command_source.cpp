// SPDX-License-Identifier: MIT
#include "command_source.h"

#include "interrupt.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
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
            fmt::print(echo_, "{}{}\n", prompt, *line);
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
    : file_(path.empty() || path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC))
{
    if (file_ < 0) {
        throw std::runtime_error(fmt::format("{}: cannot read: {}", path, std::strerror(errno)));
    }
    struct stat kind = {};
    if (fstat(file_, &kind) == 0 && S_ISDIR(kind.st_mode)) {
        close(file_);
        throw std::runtime_error(path + ": is a directory, no file of commands");
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
    while (!ended_ && poll(&entry, 1, 0) > 0) {
        const ssize_t count = read(file_, bytes.data(), bytes.size());
        ended_ = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
        for (ssize_t k = 0; k < count; k++) {
            const char c = bytes.at(static_cast<std::size_t>(k));
            if (c == '\n') {
                lines_.push_back(std::exchange(begun_, ""));
            } else if (c != '\r') {
                begun_ += c;
            }
        }
    }
    if (ended_ && !begun_.empty()) {
        lines_.push_back(std::exchange(begun_, ""));
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
