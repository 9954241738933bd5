// SPDX-License-Identifier: MIT
#include "worker_line.h"

#include <array>

#include <emscripten.h>

// clang-format off: the bodies are JavaScript
EM_JS(int, nf_line_take, (uint8_t *to, int most, double wait_s), {
    return Module["line"]["take"](HEAPU8.subarray(to, to + most), wait_s);
})
EM_JS(void, nf_line_write, (const uint8_t *from, int count), {
    Module["line"]["write"](HEAPU8.subarray(from, from + count));
})
EM_JS(double, nf_line_now_s, (void), {
    return Module["line"]["nowS"]();
})
EM_JS(int, nf_line_take_stop, (void), {
    return Module["line"]["takeStop"]() ? 1 : 0;
})
// clang-format on

namespace nf::web
{

std::vector<uint8_t> WorkerLine::read(double wait_s)
{
    std::array<uint8_t, 16384> bytes{};
    const int count = nf_line_take(bytes.data(), static_cast<int>(bytes.size()), wait_s);
    if (count < 0) {
        throw live::ChannelError("the port is closed");
    }
    return {bytes.begin(), bytes.begin() + count};
}

void WorkerLine::write(const std::vector<uint8_t> &bytes)
{
    nf_line_write(bytes.data(), static_cast<int>(bytes.size()));
}

double WorkerLine::now_s() const
{
    return nf_line_now_s();
}

bool WorkerLine::take_stop()
{
    return nf_line_take_stop() != 0;
}

} // namespace nf::web
