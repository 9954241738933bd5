// SPDX-License-Identifier: MIT
// Sends the ticks of a short run to HOST:PORT, each EVERY-th, for test_udp.py.
#include "scenario.h"
#include "udp_sink.h"

#include <cstdio>
#include <exception>
#include <string>

int main(int argc, char **argv)
{
    if (argc != 3) {
        return 2;
    }
    try {
        const nf::Config config =
            nf::load_scenario("s1", {}, {"scenario.duration_s=0.02", "scenario.evaluate_from_s=0"});
        nf::live::UdpSink sink(argv[1], static_cast<unsigned>(std::stoul(argv[2])));
        nf::RunOptions options;
        options.sink = &sink;
        (void)nf::run_scenario(config, options);
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "send_udp: %s\n", error.what());
        return 2;
    }
}
