// SPDX-License-Identifier: MIT
#include "board_commands.h"
#include "live_view.h"

#include <cstdio>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr double LINE_EVERY_S = 1;

class Plain : public LiveView
{
public:
    void say(const std::string &line) override
    {
        fmt::print("{}\n", line);
        std::fflush(stdout);
    }

    void show(const Follower &follower) override
    {
        if (!follower.shadow().is_in_step()) {
            return;
        }
        const double time_s =
            static_cast<double>(follower.shadow().next()) * follower.bases().control_period_s;
        if (time_s - shown_s_ >= LINE_EVERY_S || time_s < shown_s_) {
            shown_s_ = time_s;
            say(fmt::format("{:.3f} s: {}", time_s, status_text(follower)));
        }
    }

    std::optional<std::string> typed() override
    {
        return std::nullopt;
    }

    void leave() override
    {
    }

    void enter() override
    {
    }

private:
    double shown_s_ = -LINE_EVERY_S;
};

} // namespace

std::unique_ptr<LiveView> plain_view()
{
    return std::make_unique<Plain>();
}

} // namespace nf::live
