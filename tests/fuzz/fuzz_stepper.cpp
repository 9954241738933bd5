// SPDX-License-Identifier: MIT
// Any lines as commands of the stepper, in a brief run: each is done, or refused with one line.
#include "commands.h"
#include "fuzzed.h"

#include <algorithm>
#include <sstream>
#include <string>

namespace
{

constexpr int LINES_MAX = 32;

const nf::Config &brief()
{
    static const nf::Config config = nf::load_scenario(
        "s1", {},
        {"scenario.prelude_s=0.06", "scenario.duration_s=0.002", "scenario.evaluate_from_s=0"});
    return config;
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    nf::debug::Session session(brief());
    std::istringstream lines(std::string(reinterpret_cast<const char *>(data), size));
    int left = LINES_MAX;
    for (std::string line; left > 0 && std::getline(lines, line); left--) {
        (void)nf::debug::completions("", line);
        const nf::debug::Answer answer = nf::debug::execute(session, line);
        if (answer.outcome == nf::debug::Outcome::quit) {
            break;
        }
        const auto ends = std::count(answer.text.begin(), answer.text.end(), '\n');
        HOLDS(answer.outcome != nf::debug::Outcome::refused || (ends <= 1 && !answer.text.empty()),
              "a refusal is one line");
    }
    return 0;
}
