// SPDX-License-Identifier: MIT
// Where a program may open no port by its name: a page is given one by its user.
#include "serial_port.h"

#include <fmt/format.h>

namespace nf::live
{

SerialPort::SerialPort(const std::string &path, unsigned baud) : path_(path), file_(-1)
{
    set_up(baud);
}

SerialPort::~SerialPort() = default;

void SerialPort::set_up(unsigned baud)
{
    (void)baud;
    fail("cannot open");
}

void SerialPort::fail(const char *what) const
{
    throw ChannelError(fmt::format("{}: {}: a page opens no port by its name", path_, what));
}

// Of an object that cannot be made.
std::vector<uint8_t> SerialPort::read(double wait_s)
{
    (void)wait_s;
    fail("cannot read");
}

void SerialPort::write(const std::vector<uint8_t> &bytes)
{
    (void)bytes;
    fail("cannot write");
}

double SerialPort::now_s() const
{
    fail("has no clock");
}

} // namespace nf::live
