/* SPDX-License-Identifier: MIT */
// A serial port or a pseudo-terminal as a channel: 8 bits, no parity, one stop bit, no flow
// control, nothing translated.
#pragma once

#include "channel.h"
#include "receiver.h"

#include <memory>
#include <string>

namespace nf::live
{

class SerialPort : public Channel
{
public:
    // Any rate that the hardware can make. Throws ChannelError: "/dev/ttyACM0: cannot open: the
    // system's reason".
    SerialPort(const std::string &path, unsigned baud);
    ~SerialPort() override;
    SerialPort(const SerialPort &) = delete;
    SerialPort &operator=(const SerialPort &) = delete;

    std::vector<uint8_t> read(double wait_s) override;
    void write(const std::vector<uint8_t> &bytes) override;
    double now_s() const override;

private:
    [[noreturn]] void fail(const char *what) const;
    void set_up(unsigned baud);

    std::string path_;
    int file_;
    std::unique_ptr<Receiver> receiver_;
};

} // namespace nf::live
