// SPDX-License-Identifier: MIT
#include "progress.h"

#include <cstdio>

#include <unistd.h>

#include <fmt/format.h>

namespace nf::commands
{

std::function<void(double)> progress_line()
{
    if (isatty(STDERR_FILENO) == 0) {
        return {};
    }
    return [shown = 0](double done) mutable {
        const int percent = static_cast<int>(done * 100.0);
        if (percent != shown) {
            fmt::print(stderr, "\r{:<6}\r", done < 1 ? fmt::format("{} %", percent) : "");
            shown = percent;
        }
    };
}

std::function<void(double)> progress_of_runs(int runs)
{
    constexpr int WHILE = 100;
    if (isatty(STDERR_FILENO) != 0 || runs < WHILE) {
        return progress_line();
    }
    return [runs, shown = 0](double done) mutable {
        constexpr int PARTS = 4;
        const int parts = static_cast<int>(done * PARTS);
        if (parts != shown && parts < PARTS) {
            fmt::print(stderr, "motorsim: {} of {} runs\n", runs * parts / PARTS, runs);
        }
        shown = parts;
    };
}

} // namespace nf::commands
