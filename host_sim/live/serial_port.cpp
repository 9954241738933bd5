// SPDX-License-Identifier: MIT
// The kernel's own termios2: <termios.h> has a fixed list of rates.
#include "serial_port.h"

#include "readable.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

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
        receiver_ = std::make_unique<Receiver>(file_);
    } catch (const ChannelError &) {
        close(file_);
        throw;
    }
}

SerialPort::~SerialPort()
{
    receiver_.reset();
    close(file_);
}

void SerialPort::fail(const char *what) const
{
    throw ChannelError(
        fmt::format("{}: {}: {}", readable(path_, READABLE_PATH), what, std::strerror(errno)));
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
    settings.c_cc[VMIN] = 1; // nothing there is EAGAIN, a port that hangs up is 0 bytes
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
    Receiver::Received received = receiver_->take(wait_s);
    if (!received.end.empty()) {
        throw ChannelError(fmt::format("{}: {}", path_, received.end));
    }
    return std::move(received.bytes);
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
