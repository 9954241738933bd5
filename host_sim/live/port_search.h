/* SPDX-License-Identifier: MIT */
// Which serial ports there are, and at which rate a board answers on one: what a person need not
// know to see his board.
#pragma once

#include "channel.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace nf::live
{

// Rates of the shipped boards and the one of a board file that names none, bit/s, the highest
// first.
std::vector<unsigned> known_rates();

// The first of the rates, bit/s, at which a board answers; `open` opens its port at a rate, and
// closes it with the channel. Takes half a second a rate, or two where there is one only. Throws
// LinkError that names the rates when there is no answer, and what `open` throws.
unsigned find_rate(const std::function<std::unique_ptr<Channel>(unsigned)> &open,
                   const std::vector<unsigned> &rates);

// Ports of USB in a folder of devices, sorted, each by the name under serial/by-id that says which
// adapter it is, or else by its own.
std::vector<std::string> list_ports(const std::filesystem::path &devices = "/dev");

} // namespace nf::live
