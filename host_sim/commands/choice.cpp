// SPDX-License-Identifier: MIT
#include "choice.h"

#include "completion.h"

#include <utility>

#include <fmt/format.h>

namespace nf::commands
{

Config Choice::load() const
{
    std::vector<std::string> all = set;
    for (const auto &[key, value] : {std::pair("motor", motor), std::pair("board", board)}) {
        if (!value.empty()) {
            all.push_back(fmt::format("{}={}", key, value));
        }
    }
    return load_scenario(scenario, with, all);
}

void describe_with(CLI::App &command, std::vector<std::string> &with)
{
    command.add_option("--with", with, "imperfection set, name or path; may be repeated")
        ->allow_extra_args(false)
        ->type_name(AN_IMPERFECTION);
}

void describe_set(CLI::App &command, std::vector<std::string> &set)
{
    command.add_option("--set", set, "override a setting; may be repeated")
        ->allow_extra_args(false)
        ->type_name(A_SETTING);
}

void describe_board(CLI::App &command, std::string &board, const char *help)
{
    command.add_option("--board", board, help)->type_name(A_BOARD);
}

void describe(CLI::App &command, Choice &arguments)
{
    command
        .add_option("scenario", arguments.scenario, "name (see `motorsim list`) or path of a .toml")
        ->required()
        ->type_name(A_SCENARIO);
    describe_with(command, arguments.with);
    command
        .add_option("--motor", arguments.motor,
                    "another motor, by name or path; zoo:17 brings its board along")
        ->type_name(A_MOTOR);
    describe_board(command, arguments.board, "another board, by name or path");
    describe_set(command, arguments.set);
}

} // namespace nf::commands
