// SPDX-License-Identifier: MIT
#include "port_search.h"

#include "client.h"
#include "config.h"

#include <algorithm>
#include <functional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::live
{
namespace
{

namespace fs = std::filesystem;

constexpr unsigned TRIES_OF_SEVERAL = 10;

bool answers(Channel &channel, unsigned rate, bool is_alone)
{
    Timing timing;
    timing.tries = is_alone ? timing.tries : TRIES_OF_SEVERAL;
    Client client(channel, timing, {});
    client.has_rate(rate);
    try {
        (void)client.hello();
        return true;
    } catch (const LinkError &) {
        return false;
    }
}

bool is_usb_port(const fs::path &device)
{
    const std::string name = device.filename().string();
    return name.rfind("ttyACM", 0) == 0 || name.rfind("ttyUSB", 0) == 0;
}

std::vector<fs::path> content_of(const fs::path &folder)
{
    std::error_code none; // a folder that is not there has no content
    std::vector<fs::path> content;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder, none)) {
        content.push_back(entry.path());
    }
    return content;
}

} // namespace

std::vector<unsigned> known_rates()
{
    std::set<unsigned, std::greater<>> rates = {static_cast<unsigned>(BoardSettings{}.baud)};
    for (const std::string &board : list_boards()) {
        rates.insert(static_cast<unsigned>(load_board(board).baud));
    }
    return {rates.begin(), rates.end()};
}

unsigned find_rate(const std::function<std::unique_ptr<Channel>(unsigned)> &open,
                   const std::vector<unsigned> &rates)
{
    for (const unsigned rate : rates) {
        const std::unique_ptr<Channel> channel = open(rate);
        if (answers(*channel, rate, rates.size() == 1)) {
            return rate;
        }
    }
    throw LinkError(fmt::format("no board answers at {} baud; --baud names another rate",
                                fmt::join(rates, ", ")));
}

std::vector<std::string> list_ports(const fs::path &devices)
{
    std::set<std::string> ports;
    for (const fs::path &device : content_of(devices)) {
        if (is_usb_port(device)) {
            ports.insert(device.string());
        }
    }
    for (const fs::path &link : content_of(devices / "serial" / "by-id")) {
        std::error_code none;
        const fs::path device = fs::canonical(link, none);
        if (ports.erase((devices / device.filename()).string()) != 0) {
            ports.insert(link.string());
        }
    }
    return {ports.begin(), ports.end()};
}

} // namespace nf::live
