/* SPDX-License-Identifier: MIT */
// `motorsim live`: follows a board, writes what it does, and passes on what it is told.
#pragma once

#include "board_files.h"
#include "channel.h"
#include "client.h"

#include <optional>
#include <string>

namespace nf::live
{

struct LiveOptions {
    std::string trace; // files; empty: none
    std::string vcd;
    std::string udp; // HOST:PORT; empty: nobody
    unsigned udp_every = 10;
    std::optional<double> for_s; // of board time
    std::string script;          // empty: a person, or what is piped in; "-": what is piped in
    FileChoice files;
    double keep_s = 10;
    Timing timing;
    unsigned baud = 0; // of the port; 0: it has no rate
};

// Until it is told to end. False: a command was refused and nobody was there to see it, or a hash
// of the board differed. Throws LinkError, ChannelError, OutputError.
bool follow(Channel &channel, const LiveOptions &options);

} // namespace nf::live
