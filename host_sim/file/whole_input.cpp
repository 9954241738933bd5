// SPDX-License-Identifier: MIT
#include "whole_input.h"

#include "readable.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

namespace nf
{
namespace
{

[[noreturn]] void refuse_input(const std::filesystem::path &path, const std::string &why)
{
    throw InputError(fmt::format("{}: {}", readable(path.string(), READABLE_PATH), why));
}

[[noreturn]] void refuse_reading(const std::filesystem::path &path, int error)
{
    refuse_input(path, fmt::format("cannot read: {}", std::strerror(error)));
}

bool is_of_kind(int file, mode_t kind)
{
    struct stat found = {};
    return fstat(file, &found) == 0 && (found.st_mode & S_IFMT) == kind;
}

// Closes a descriptor, also when an exception passes.
class Closing
{
public:
    explicit Closing(int file) : file_(file)
    {
    }
    ~Closing()
    {
        close(file_);
    }
    Closing(const Closing &) = delete;
    Closing &operator=(const Closing &) = delete;

private:
    int file_;
};

} // namespace

int open_input(const std::filesystem::path &path)
{
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        refuse_reading(path, errno);
    }
    if (is_of_kind(file, S_IFDIR)) {
        close(file);
        refuse_reading(path, EISDIR);
    }
    return file;
}

void check_standard_input()
{
    if (is_of_kind(STDIN_FILENO, S_IFDIR)) {
        refuse_reading("standard input", EISDIR);
    }
}

std::string read_whole(const std::filesystem::path &path, std::size_t most,
                       const std::string &instead)
{
    constexpr std::size_t AT_ONCE = std::size_t{1} << 20U;
    const int file = open_input(path);
    const Closing closing(file);
    std::string bytes;
    ssize_t count = 1;
    while (count != 0 && bytes.size() <= most) {
        const std::size_t had = bytes.size();
        bytes.resize(had + std::min(AT_ONCE, most + 1 - had));
        count = read(file, bytes.data() + had, bytes.size() - had);
        const int error = errno;
        bytes.resize(had + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count < 0 && error != EINTR) {
            refuse_reading(path, error);
        }
    }
    if (bytes.size() > most) {
        refuse_input(path, fmt::format("it is longer than {}; {}",
                                       most >> 20U == 0 ? fmt::format("{} bytes", most)
                                                        : fmt::format("{} MiB", most >> 20U),
                                       instead));
    }
    return bytes;
}

LineCollector::LineCollector(std::string name, int file)
    : name_(std::move(name)), is_device_(is_of_kind(file, S_IFCHR) && isatty(file) == 0)
{
}

bool LineCollector::add(char c)
{
    bytes_++;
    if (is_device_ && bytes_ > LINE_BYTES_MAX) {
        throw InputError(fmt::format("{}: a device with more than {} bytes is no script",
                                     readable(name_, READABLE_PATH), LINE_BYTES_MAX));
    }
    if (c == '\n') {
        number_++;
        return true;
    }
    if (line_.size() == LINE_BYTES_MAX) {
        throw InputError(
            fmt::format("{}: line {} is too long for a command; allowed: at most {} bytes",
                        readable(name_, READABLE_PATH), number_, LINE_BYTES_MAX));
    }
    line_ += c;
    return false;
}

std::string LineCollector::take()
{
    if (!line_.empty() && line_.back() == '\r') {
        line_.pop_back();
    }
    return std::exchange(line_, "");
}

} // namespace nf
