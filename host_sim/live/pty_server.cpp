// SPDX-License-Identifier: MIT
#include "pty_server.h"

#include "readable.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr double SLICE_S = 1e-3;  // of the board between two looks at the terminal
constexpr double LAG_MAX_S = 0.1; // what the board is behind by more than that is given up
constexpr double REPORT_S = 1;    // between two reports of that
constexpr std::size_t READ_AT_ONCE = 4096;

[[noreturn]] void fail(const std::string &what)
{
    throw ChannelError(fmt::format("{}: {}", what, std::strerror(errno)));
}

double now_s()
{
    using std::chrono::duration;
    return duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

} // namespace

Pty::Pty(const std::string &link) : link_(link)
{
    try {
        open_port();
        make_link();
    } catch (const ChannelError &) {
        close(port_file_);
        close(board_);
        throw;
    }
}

Pty::~Pty()
{
    if (!link_.empty()) {
        unlink(link_.c_str());
    }
    close(port_file_);
    close(board_);
}

void Pty::open_port()
{
    std::array<char, 128> name{};
    board_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (board_ < 0 || grantpt(board_) != 0 || unlockpt(board_) != 0 ||
        ptsname_r(board_, name.data(), name.size()) != 0 ||
        fcntl(board_, F_SETFL, O_NONBLOCK) != 0) {
        fail("cannot make a pseudo-terminal");
    }
    port_ = name.data();
    port_file_ = open(port_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios settings{};
    if (port_file_ < 0 || tcgetattr(port_file_, &settings) != 0) {
        fail(port_);
    }
    cfmakeraw(&settings);
    if (tcsetattr(port_file_, TCSANOW, &settings) != 0) {
        fail(port_);
    }
}

void Pty::make_link()
{
    if (link_.empty()) {
        return;
    }
    std::error_code error;
    if (std::filesystem::is_symlink(link_, error)) {
        std::filesystem::remove(link_, error);
    }
    if (symlink(port_.c_str(), link_.c_str()) != 0) {
        const std::string name = std::exchange(link_, "");
        fail(readable(name, READABLE_PATH) + ": cannot make a link");
    }
}

std::vector<uint8_t> Pty::read()
{
    std::vector<uint8_t> bytes(READ_AT_ONCE);
    const ssize_t count = ::read(board_, bytes.data(), bytes.size());
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
        fail(port_);
    }
    bytes.resize(count < 0 ? 0 : static_cast<std::size_t>(count));
    return bytes;
}

void Pty::write(const std::vector<uint8_t> &bytes)
{
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::write(board_, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EAGAIN) {
            return;
        }
        if (count < 0 && errno != EINTR) {
            fail(port_);
        }
        done += count < 0 ? 0 : static_cast<std::size_t>(count);
    }
}

namespace
{

// Tells how far the board's time may go.
class Pace
{
public:
    Pace(const Serving &serving, double board_s)
        : serving_(serving), started_s_(now_s()), board_s_(board_s)
    {
    }

    double until_s(double board_s)
    {
        if (serving_.pace <= 0) {
            return board_s + SLICE_S;
        }
        const double due_s = board_s_ + (now_s() - started_s_) * serving_.pace;
        const double lag_s = due_s - board_s;
        if (lag_s > LAG_MAX_S * std::max(1.0, serving_.pace)) {
            report(lag_s);
            started_s_ = now_s();
            board_s_ = board_s;
            return board_s + SLICE_S;
        }
        return std::min(due_s, board_s + SLICE_S * std::max(1.0, serving_.pace));
    }

private:
    void report(double lag_s)
    {
        if (now_s() - reported_s_ > REPORT_S) {
            serving_.lags(lag_s);
            reported_s_ = now_s();
        }
    }

    const Serving &serving_;
    double started_s_;
    double board_s_;
    double reported_s_ = 0;
};

} // namespace

void serve(SimulatedBoard &board, Pty &pty, const Serving &serving)
{
    Pace pace(serving, board.now_s());
    while (!serving.stops()) {
        const double until_s = pace.until_s(board.now_s());
        const bool waits = board.now_s() >= until_s;
        board.put(pty.read());
        while (board.now_s() < until_s) {
            board.tick();
        }
        pty.write(board.take());
        if (waits) {
            std::this_thread::sleep_for(std::chrono::duration<double>(SLICE_S / 2));
        }
    }
}

} // namespace nf::live
