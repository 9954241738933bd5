/* SPDX-License-Identifier: MIT */
// A serial port or a pseudo-terminal as a channel: 8 bits, no parity, one stop bit, no flow control, nothing translated.
#pragma once

#include "channel.h"

#include <memory>
#include <string>

namespace nf::live
{

// Any rate that the hardware can make. Throws ChannelError: "/dev/ttyACM0: cannot open: the system's reason".
std::unique_ptr<Channel> open_serial_port(const std::string &path, unsigned baud);

} // namespace nf::live
