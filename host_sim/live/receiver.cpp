// SPDX-License-Identifier: MIT
#include "receiver.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr std::size_t AT_ONCE = 4096;

} // namespace

Receiver::Receiver(int file) : file_(file), stop_(eventfd(0, EFD_CLOEXEC))
{
    if (stop_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    thread_ = std::thread([this] { receive(); });
}

Receiver::~Receiver()
{
    (void)eventfd_write(stop_, 1);
    thread_.join();
    close(stop_);
}

Receiver::Received Receiver::take(double wait_s)
{
    std::unique_lock<std::mutex> lock(guard_);
    if (wait_s > 0) {
        came_.wait_for(lock, std::chrono::duration<double>(wait_s),
                       [this] { return !bytes_.empty() || !end_.empty(); });
    }
    // What came before the end counts: the end is said when nothing is left.
    const bool is_over = bytes_.empty();
    return {std::exchange(bytes_, {}), is_over ? end_ : ""};
}

// Why it ends; empty when there is something to read.
std::string Receiver::wait_for_bytes() const
{
    std::array<pollfd, 2> entries = {{{file_, POLLIN, 0}, {stop_, POLLIN, 0}}};
    if (poll(entries.data(), entries.size(), -1) < 0 && errno != EINTR) {
        return fmt::format("cannot wait: {}", std::strerror(errno));
    }
    return entries[1].revents != 0 ? "it is closed" : "";
}

// A file that hangs up is readable, and has nothing.
std::string Receiver::read_on()
{
    std::array<uint8_t, AT_ONCE> bytes{};
    const ssize_t count = read(file_, bytes.data(), bytes.size());
    if (count == 0) {
        return "the other end is gone";
    }
    if (count < 0) {
        return errno == EAGAIN || errno == EINTR
                   ? ""
                   : fmt::format("cannot read: {}", std::strerror(errno));
    }
    const std::lock_guard<std::mutex> lock(guard_);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.begin() + count);
    came_.notify_one();
    return "";
}

void Receiver::receive()
{
    std::string end;
    while (end.empty()) {
        end = wait_for_bytes();
        if (end.empty()) {
            end = read_on();
        }
    }
    const std::lock_guard<std::mutex> lock(guard_);
    end_ = end;
    came_.notify_one();
}

} // namespace nf::live
