// SPDX-License-Identifier: MIT
// What an editor of motor, board, tuning, scenario and imperfection files asks: the keys there are,
// what is wrong with a text, what a scenario is made of.
#include "calls.h"

#include "files.h"
#include "read_layer.h"
#include "schema.h"
#include "timed_list.h"

#include <array>
#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::web::config_service
{
namespace
{

constexpr std::array<FileKind, 5> KINDS = {FileKind::scenario, FileKind::imperfection,
                                           FileKind::motor, FileKind::board, FileKind::tuning};

FileKind kind_of(const std::string &name)
{
    for (const FileKind kind : KINDS) {
        if (name == kind_name(kind)) {
            return kind;
        }
    }
    throw std::runtime_error(fmt::format("there is no kind of file {}", name));
}

// The program's line, and the number of the line of `file` that it names; 0 where it names none of
// it.
Json problem(const std::string &file, const std::string &text)
{
    const std::string start = file + ':';
    const bool is_here = text.rfind(start, 0) == 0;
    const long line = is_here ? std::strtol(text.c_str() + start.size(), nullptr, 10) : 0;
    return {{"line", line}, {"text", text}};
}

// A file on its own. A reader stops at the first mistake, as the program does.
Json check(const Json &given)
{
    const std::string file = given.at("file");
    Json problems = Json::array();
    try {
        (void)read_layer(kind_of(given.at("kind")), file, given.at("text"));
    } catch (const ConfigError &error) {
        problems.push_back(problem(file, error.what()));
    }
    return problems;
}

// All files of a scenario together; `file` is the one whose lines count.
Json check_all(const Json &given)
{
    Json problems = Json::array();
    try {
        const Choice choice = choice_of(given);
        (void)build(load_scenario(choice.scenario, choice.with, choice.set));
    } catch (const ConfigError &error) {
        problems.push_back(problem(given.value("file", ""), error.what()));
    }
    return problems;
}

std::vector<std::string> kinds_with(const std::string &section)
{
    std::vector<std::string> kinds;
    for (const FileKind kind : KINDS) {
        if (may_hold(kind, section)) {
            kinds.emplace_back(kind_name(kind));
        }
    }
    return kinds;
}

Json schema_keys(const Json &given)
{
    (void)given;
    Json keys = Json::array();
    for (const Field &field : schema()) {
        keys.push_back({{"section", field.section},
                        {"key", field.key},
                        {"allowed", field.allowed()},
                        {"default", field.default_text()},
                        {"meaning", field.meaning()},
                        {"kinds", kinds_with(field.section)}});
    }
    for (const EntryValue &value : entry_values()) {
        keys.push_back({{"section", fmt::format("scenario.{}", value.list)},
                        {"key", value.key},
                        {"allowed", value.allowed()},
                        {"default", "one of them"},
                        {"meaning", value.help},
                        {"kinds", {kind_name(FileKind::scenario)}}});
    }
    return keys;
}

// The names of the shipped files of each kind; of scenarios with their titles.
Json names(const Json &given)
{
    (void)given;
    Json all;
    for (const FileKind kind : KINDS) {
        all[kind_name(kind)] = list_names(kind);
    }
    all["titles"] = Json::object();
    for (const ScenarioInfo &info : list_scenarios()) {
        all["titles"][info.id] = info.title;
    }
    return all;
}

// The names of the scenarios that a scenario is based on, the nearest first.
std::vector<std::string> bases_of(const std::string &scenario,
                                  const std::vector<std::filesystem::path> &read)
{
    const std::string own = std::filesystem::path(scenario).stem().string();
    std::vector<std::string> bases;
    for (const std::filesystem::path &path : read) {
        const std::string name = path.stem().string();
        if (path.parent_path().filename() == "scenarios" && name != own) {
            bases.insert(bases.begin(), name);
        }
    }
    return bases;
}

// Which motor, board and tuning a scenario has, and what it is based on.
Json parts(const Json &given)
{
    const Choice choice = choice_of(given);
    const SourceFiles sources = load_scenario(choice.scenario, choice.with, choice.set).sources;
    return {{"motor", sources.motor},
            {"board", sources.board},
            {"tuning", sources.tuning},
            {"bases", bases_of(choice.scenario, sources.read)}};
}

} // namespace

const Calls &calls()
{
    static const Calls all = {{"config.check", check},
                              {"config.check_all", check_all},
                              {"config.schema", schema_keys},
                              {"config.names", names},
                              {"config.parts", parts}};
    return all;
}

} // namespace nf::web::config_service
