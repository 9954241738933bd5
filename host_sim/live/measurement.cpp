// SPDX-License-Identifier: MIT
#include "measurement.h"

namespace nf::live
{
namespace
{

// What follows `start`, or nothing.
bool begins(const std::string &line, const std::string &start, std::string &rest)
{
    if (line.rfind(start, 0) != 0) {
        return false;
    }
    rest = line.substr(start.size());
    return true;
}

// It begins with the name of a state, and comes whenever that changes.
bool tells_state(const std::string &line)
{
    return !line.empty() && line.front() >= 'A' && line.front() <= 'Z';
}

} // namespace

bool Measurement::take(const std::string &line)
{
    std::string rest;
    if (begins(line, "= ", rest)) {
        lines_.push_back(line);
        return true;
    }
    if (begins(line, "error: ", rest) || begins(line, "identify refused: ", rest)) {
        refusal_ = rest;
        ended_ = true;
        return true;
    }
    if (begins(line, "identify ", rest)) {
        lines_.push_back(line);
        ended_ = rest.rfind("done", 0) == 0;
        return true;
    }
    if (line == "ok") { // to the command itself
        return true;
    }
    if (!tells_state(line)) {
        phases_.push_back(line);
    }
    return false;
}

void Measurement::stop()
{
    if (!ended_) {
        refusal_ = "a stop has ended it";
        ended_ = true;
    }
}

} // namespace nf::live
