// SPDX-License-Identifier: MIT
#include "udp_sink.h"

#include "channel.h"
#include "readable.h"
#include "signals.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf::live
{
namespace
{

// A signal of signals.h and its place.
struct Sent {
    const char *place;
    const char *signal;
};

constexpr std::array<Sent, 17> SENT = {{
    {"/state", "state"},
    {"/fault", "fault"},
    {"/speed/command_rpm", "speed_command_rpm"},
    {"/speed/reference_rpm", "speed_reference_rpm"},
    {"/speed/estimated_rpm", "speed_estimated_rpm"},
    {"/position/command_rad", "position_command_rad"},
    {"/position/estimated_rad", "position_estimated_rad"},
    {"/angle/estimated_el_deg", "angle_estimated_el_deg"},
    {"/current/q_a", "i_q_measured_a"},
    {"/current/q_reference_a", "i_q_reference_a"},
    {"/current/d_a", "i_d_measured_a"},
    {"/current/alpha_a", "i_alpha_a"},
    {"/current/beta_a", "i_beta_a"},
    {"/voltage/q_v", "v_q_v"},
    {"/voltage/d_v", "v_d_v"},
    {"/voltage/limit_v", "v_limit_v"},
    {"/voltage/bus_v", "drive.bus"},
}};

double value_of(const SignalInfo &signal, const Tick &tick)
{
    const bool word = signal.quantity == Quantity::state || signal.quantity == Quantity::fault;
    return word ? static_cast<double>(raw_value(signal, tick).value_or(0)) : si_value(signal, tick);
}

// A name of a service is looked up; of a number the system takes any, and cuts it off.
void refuse_port(const std::string &address, const std::string &port)
{
    const bool number = port.find_first_not_of("0123456789") == std::string::npos;
    constexpr std::size_t DIGITS_MAX = 5;
    constexpr unsigned long PORT_MAX = 65535;
    const bool is_long = port.size() > DIGITS_MAX;
    if (number && (is_long || std::stoul(port) == 0 || std::stoul(port) > PORT_MAX)) {
        throw ChannelError(fmt::format("{}: the port is 1 to {}", readable(address), PORT_MAX));
    }
}

} // namespace

std::string udp_text(const Tick &tick)
{
    nlohmann::json object;
    object["timestamp"] = tick.time_s;
    for (const Sent &sent : SENT) {
        const double value = value_of(*find_signal(sent.signal), tick);
        if (std::isfinite(value)) {
            object[nlohmann::json::json_pointer(sent.place)] = value;
        }
    }
    return object.dump();
}

UdpSink::UdpSink(const std::string &address, unsigned every) : every_(every)
{
    const std::size_t colon = address.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
        throw ChannelError(fmt::format("{}: --udp takes HOST:PORT", readable(address)));
    }
    refuse_port(address, address.substr(colon + 1));
    addrinfo wanted{};
    wanted.ai_socktype = SOCK_DGRAM;
    addrinfo *found = nullptr;
    const int problem = getaddrinfo(address.substr(0, colon).c_str(),
                                    address.substr(colon + 1).c_str(), &wanted, &found);
    if (problem != 0) {
        throw ChannelError(fmt::format("{}: {}", readable(address), gai_strerror(problem)));
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo *)> owner(found, freeaddrinfo);
    socket_ = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || connect(socket_, found->ai_addr, found->ai_addrlen) != 0) {
        const int error = errno;
        close(socket_);
        throw ChannelError(
            fmt::format("{}: cannot send: {}", readable(address), std::strerror(error)));
    }
}

UdpSink::~UdpSink()
{
    close(socket_);
}

void UdpSink::add(const Tick &tick)
{
    if (since_ == 0) {
        const std::string text = udp_text(tick);
        // Nobody there is no reason to stop.
        (void)send(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    }
    since_ = since_ + 1 >= every_ ? 0 : since_ + 1;
}

} // namespace nf::live
