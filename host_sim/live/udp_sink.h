/* SPDX-License-Identifier: MIT */
// Ticks as JSON datagrams, one object each, as PlotJuggler's UDP streaming reads them with its JSON
// protocol:
//
//     {"timestamp":1.2345,"state":9,"fault":0,"speed":{"command_rpm":…},"current":{"q_a":…},…}
//
// Numbers only, nested by quantity; what is not known is left out. `timestamp` is in seconds.
#pragma once

#include "tick.h"

#include <cstdint>
#include <string>
#include <vector>

namespace nf::live
{

// The text of one datagram.
std::string udp_text(const Tick &tick);

class UdpSink : public TickSink
{
public:
    // HOST:PORT. Each `every`-th tick is sent. Throws ChannelError.
    UdpSink(const std::string &address, unsigned every);
    ~UdpSink() override;
    UdpSink(const UdpSink &) = delete;
    UdpSink &operator=(const UdpSink &) = delete;

    // What nobody receives is lost.
    void add(const Tick &tick) override;

private:
    int socket_ = -1;
    unsigned every_;
    unsigned since_ = 0;
};

} // namespace nf::live
