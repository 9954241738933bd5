// SPDX-License-Identifier: MIT
#include "console.h"

#include "commands.h"

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

// A person steps on by the return key.
bool may_repeat(const std::string &line)
{
    return line.compare(0, 4, "step") == 0 || line.compare(0, 4, "back") == 0;
}

} // namespace

bool converse(Session &session, LineReader &reader, std::FILE *out)
{
    bool all_done = true;
    std::string last;
    fmt::print(out, "{}: ticks {} to {} of {:g} us; `help` lists the commands\n{}",
               session.scenario, session.timeline.first(), session.timeline.last(),
               session.timeline.run().sim().bases().control_period_s * 1e6,
               session.position_text());
    while (std::optional<std::string> line =
               reader.next(fmt::format("({} {}) ", session.scenario, session.timeline.now()))) {
        if (line->empty() && !reader.is_unattended() && may_repeat(last)) {
            line = last;
        }
        const Answer answer = execute(session, *line);
        fmt::print(out, "{}", answer.text);
        std::fflush(out);
        all_done = all_done && answer.outcome != Outcome::refused;
        last = *line;
        if (answer.outcome == Outcome::quit) {
            break;
        }
    }
    return all_done || !reader.is_unattended();
}

} // namespace nf::debug
