/* SPDX-License-Identifier: MIT */
// What a page can call. Each part of the bench has a file of its own, whose calls are a table;
// calls.cpp lists the tables. All calls come from one thread.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace nf::web
{

using Json = nlohmann::ordered_json;

struct Call {
    const char *name;                // "run.start"
    Json (*make)(const Json &given); // throws what is to be said in one line
};
using Calls = std::vector<Call>;

namespace config_service
{
const Calls &calls();
}
namespace run_session
{
const Calls &calls();
}
namespace play_session
{
const Calls &calls();
}
namespace step_session
{
const Calls &calls();
}
namespace replay_session
{
const Calls &calls();
}
namespace live_session
{
const Calls &calls();
}
namespace board_setup
{
const Calls &calls();
}

// The tables of all parts.
std::vector<const Calls *> all_calls();

// {"value": …}, or {"error": "one line"}, for whatever the text may be.
std::string answer(const std::string &name, const std::string &given);

// A list of texts that may be left out.
std::vector<std::string> texts_of(const Json &given, const char *key);

// A block of numbers in memory, which the page copies before its next call.
template <typename Number> Json block_of(const std::vector<Number> &numbers)
{
    return {{"address", reinterpret_cast<std::uintptr_t>(numbers.data())},
            {"count", numbers.size()}};
}

// What a scenario is made of: of "scenario", "with" and "set".
struct Choice {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
};
Choice choice_of(const Json &given);

} // namespace nf::web
