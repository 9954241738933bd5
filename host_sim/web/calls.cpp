// SPDX-License-Identifier: MIT
#include "calls.h"

#include <stdexcept>

#include <fmt/format.h>

namespace nf::web
{
namespace
{

const Call &find_call(const std::string &name)
{
    for (const Calls *calls : all_calls()) {
        for (const Call &call : *calls) {
            if (name == call.name) {
                return call;
            }
        }
    }
    throw std::runtime_error(fmt::format("there is no call {}", name));
}

// What a file holds need not be UTF-8; the page is told all the same.
std::string text_of(const Json &json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace

std::vector<const Calls *> all_calls()
{
    return {&config_service::calls(), &run_session::calls(),    &play_session::calls(),
            &step_session::calls(),   &replay_session::calls(), &live_session::calls(),
            &board_setup::calls()};
}

std::string answer(const std::string &name, const std::string &given)
{
    try {
        const Json value = find_call(name).make(Json::parse(given));
        return text_of({{"value", value}});
    } catch (const std::exception &error) {
        return text_of({{"error", error.what()}});
    }
}

std::vector<std::string> texts_of(const Json &given, const char *key)
{
    return given.value(key, std::vector<std::string>{});
}

Choice choice_of(const Json &given)
{
    return {given.at("scenario"), texts_of(given, "with"), texts_of(given, "set")};
}

} // namespace nf::web
