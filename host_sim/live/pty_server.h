/* SPDX-License-Identifier: MIT */
// A simulated board on a pseudo-terminal, as a real one is on a serial port.
#pragma once

#include "simulated_board.h"

#include <functional>
#include <string>

namespace nf::live
{

// The board's end of a pseudo-terminal. The other end is a port for any program: raw, without echo.
class Pty
{
public:
    // `link`, unless empty, becomes a symbolic link to the port; one that is there already is
    // replaced. Throws ChannelError.
    explicit Pty(const std::string &link = "");
    ~Pty();
    Pty(const Pty &) = delete;
    Pty &operator=(const Pty &) = delete;

    const std::string &port() const
    {
        return port_;
    }

    // What a client has written. Does not wait.
    std::vector<uint8_t> read();
    // What the port has no room for, as nobody reads it, is lost. Does not wait.
    void write(const std::vector<uint8_t> &bytes);

private:
    void open_port();
    void make_link();

    int board_ = -1;
    int port_file_ = -1; // open as long as the server: a client that goes does not end it
    std::string port_;
    std::string link_;
};

struct Serving {
    double pace = 1; // seconds of the board in a second; 0: as fast as it goes
    std::function<bool()> stops = [] { return false; }; // asked some 1000 times a second
    std::function<void(double lag_s)> lags = [](double) {
    }; // behind that pace, at most once a second
};

// Until serving.stops().
void serve(SimulatedBoard &board, Pty &pty, const Serving &serving);

} // namespace nf::live
