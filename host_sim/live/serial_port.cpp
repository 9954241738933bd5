// SPDX-License-Identifier: MIT
// The kernel's own termios2: <termios.h> has a fixed list of rates.
#include "serial_port.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

#include <asm/termbits.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr std::size_t AT_ONCE = 4096;
constexpr int WRITE_WAIT_MS = 1000; // a port that takes nothing for so long is stuck

} // namespace

SerialPort::SerialPort(const std::string &path, unsigned baud)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC))
{
    if (file_ < 0) {
        fail("cannot open");
    }
    try {
        set_up(baud);
    } catch (const ChannelError &) {
        close(file_);
        throw;
    }
}

SerialPort::~SerialPort()
{
    close(file_);
}

void SerialPort::fail(const char *what) const
{
    throw ChannelError(fmt::format("{}: {}: {}", path_, what, std::strerror(errno)));
}

void SerialPort::set_up(unsigned baud)
{
    struct termios2 settings{};
    if (ioctl(file_, TCGETS2, &settings) != 0) {
        fail("is no serial port");
    }
    settings.c_iflag = IGNBRK | IGNPAR;
    settings.c_oflag = 0;
    settings.c_lflag = 0;
    settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | BOTHER << IBSHIFT;
    settings.c_ispeed = baud;
    settings.c_ospeed = baud;
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    if (ioctl(file_, TCSETS2, &settings) != 0) {
        fail("cannot be set up");
    }
    if (ioctl(file_, TIOCEXCL) != 0) {
        fail("cannot be had alone");
    }
    // What came in before is of nobody's question.
    if (ioctl(file_, TCFLSH, TCIOFLUSH) != 0) {
        fail("cannot be emptied");
    }
}

std::vector<uint8_t> SerialPort::read(double wait_s)
{
    pollfd entry = {file_, POLLIN, 0};
    const int wait_ms = wait_s > 0 ? static_cast<int>(std::ceil(wait_s * 1000)) : 0;
    if (poll(&entry, 1, wait_ms) < 0 && errno != EINTR) {
        fail("cannot wait");
    }
    std::vector<uint8_t> bytes(AT_ONCE);
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
        fail("cannot read");
    }
    if (count == 0 && (entry.revents & POLLHUP) != 0) {
        throw ChannelError(path_ + ": the other end is gone");
    }
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
}

void SerialPort::write(const std::vector<uint8_t> &bytes)
{
    std::size_t done = 0;
    while (done < bytes.size()) {
        pollfd entry = {file_, POLLOUT, 0};
        if (poll(&entry, 1, WRITE_WAIT_MS) == 0) {
            throw ChannelError(path_ + ": cannot write: it takes nothing any more");
        }
        const ssize_t count = ::write(file_, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EAGAIN && errno != EINTR) {
            fail("cannot write");
        }
        done += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
}

double SerialPort::now_s() const
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace nf::live
