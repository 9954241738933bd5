// SPDX-License-Identifier: MIT
#include "completion.h"

#include "files.h"
#include "schema.h"
#include "suggest.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace nf
{

namespace
{

using Words = std::vector<std::string>;

Words names_of_settings()
{
    Words names;
    for (const Field &field : schema()) {
        names.push_back(field.name() + "=");
    }
    return names;
}

// Of a type that a list of words, "{one,two}", stands behind, these.
Words listed_in(const std::string &type)
{
    const std::size_t begin = type.find('{');
    const std::size_t end = type.rfind('}');
    if (begin == std::string::npos || end == std::string::npos) {
        return {};
    }
    return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

Words values_of(const CLI::Option &option)
{
    static const std::map<std::string, Words (*)()> NAMES = {
        {A_MOTOR, [] { return list_names(FileKind::motor); }},
        {A_BOARD, [] { return list_names(FileKind::board); }},
        {A_TUNING, [] { return list_names(FileKind::tuning); }},
        {AN_IMPERFECTION, [] { return list_names(FileKind::imperfection); }},
        {A_SCENARIO, [] { return list_names(FileKind::scenario); }},
        {A_SETTING, names_of_settings},
    };
    const std::string type = option.get_type_name();
    const auto names = NAMES.find(type.substr(0, type.find(':')));
    return names == NAMES.end() ? listed_in(type) : names->second();
}

// "--name" and "-n" of each option.
Words options_of(const CLI::App &app)
{
    Words found;
    for (const CLI::Option *option : app.get_options()) {
        for (const std::string &name : option->get_lnames()) {
            found.push_back("--" + name);
        }
        for (const std::string &name : option->get_snames()) {
            found.push_back("-" + name);
        }
    }
    return found;
}

std::vector<const CLI::App *> commands_of(const CLI::App &app)
{
    return app.get_subcommands(nullptr);
}

Words names_of_commands(const CLI::App &app)
{
    Words found;
    for (const CLI::App *command : commands_of(app)) {
        found.push_back(command->get_name());
    }
    return found;
}

// Where on a command line its next word stands.
struct Place {
    const CLI::App *app;
    std::size_t arguments = 0;           // that came before, without options
    const CLI::Option *option = nullptr; // whose value is next
};

bool is_option(const std::string &word)
{
    return word.size() > 1 && word.front() == '-';
}

void step_over(Place &place, const std::string &word)
{
    if (place.option != nullptr) {
        place.option = nullptr;
        return;
    }
    if (is_option(word)) {
        const CLI::Option *const option = place.app->get_option_no_throw(word);
        place.option = option != nullptr && option->get_items_expected_max() > 0 ? option : nullptr;
        return;
    }
    for (const CLI::App *command : commands_of(*place.app)) {
        if (command->check_name(word)) {
            place = {command};
            return;
        }
    }
    place.arguments++;
}

Words next_argument(const Place &place)
{
    std::vector<const CLI::Option *> arguments;
    for (const CLI::Option *option : place.app->get_options()) {
        if (option->get_positional()) {
            arguments.push_back(option);
        }
    }
    return place.arguments < arguments.size() ? values_of(*arguments[place.arguments]) : Words{};
}

Words allowed_at(const Place &place, const std::string &begun)
{
    if (place.option != nullptr) {
        return values_of(*place.option);
    }
    if (!begun.empty() && begun.front() == '-') {
        return options_of(*place.app);
    }
    Words found = names_of_commands(*place.app);
    const Words names = next_argument(place);
    found.insert(found.end(), names.begin(), names.end());
    return found;
}

} // namespace

std::vector<std::string> completions(const CLI::App &app, const std::vector<std::string> &words)
{
    Place place{&app};
    for (std::size_t k = 0; k + 1 < words.size(); k++) {
        step_over(place, words[k]);
    }
    const std::string begun = words.empty() ? "" : words.back();
    Words found = allowed_at(place, begun);
    found.erase(std::remove_if(found.begin(), found.end(),
                               [&](const std::string &word) { return word.rfind(begun, 0) != 0; }),
                found.end());
    return found;
}

std::string nearest_word(const CLI::App &app, const std::string &wrong)
{
    const std::vector<CLI::App *> parsed = app.get_subcommands();
    const CLI::App &at = parsed.empty() ? app : *parsed.back();
    return nearest(wrong.substr(0, wrong.find('=')),
                   is_option(wrong) ? options_of(at) : names_of_commands(at));
}

std::string completion_script(const std::string &shell, const std::string &name)
{
    // What ends with '=' is only begun. Where the program offers nothing, the shell offers files.
    static constexpr const char *BASH = R"(_{0}() {{
    local IFS=$'\n'
    COMPREPLY=($("${{COMP_WORDS[0]}}" {1} "${{COMP_WORDS[@]:1:COMP_CWORD}}" 2>/dev/null))
    [[ ${{#COMPREPLY[@]}} -eq 1 && ${{COMPREPLY[0]}} == *= ]] && compopt -o nospace
    return 0
}}
complete -o default -F _{0} {0}
)";
    static constexpr const char *ZSH = R"(#compdef {0}
_{0}() {{
    local -a found begun
    found=("${{(@f)$("${{words[1]}}" {1} "${{(@)words[2,CURRENT]}}" 2>/dev/null)}}")
    begun=("${{(@M)found:#*=}}")
    found=("${{(@)found:#*=}}")
    [[ -n "${{begun[*]}}" ]] && compadd -S '' -- "${{begun[@]}}"
    [[ -n "${{found[*]}}" ]] && compadd -- "${{found[@]}}"
    [[ -n "${{begun[*]}}${{found[*]}}" ]] || _files
}}
compdef _{0} {0}
)";
    return fmt::format(fmt::runtime(shell == "zsh" ? ZSH : BASH), name, ASK_COMPLETIONS);
}

} // namespace nf
