// SPDX-License-Identifier: MIT
#include "program.h"

#include "completion.h"
#include "output_file.h"
#include "readable.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <stdexcept>

#include <fmt/format.h>

namespace nf
{

namespace
{

// What was printed in any way has to be there: a pipe or a disk may have refused it.
void flush_output()
{
    errno = 0;
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        throw std::runtime_error(fmt::format("standard output: cannot write{}{}",
                                             errno == 0 ? "" : ": ",
                                             errno == 0 ? "" : std::strerror(errno)));
    }
}

void replace_all(std::string &text, const std::string &what, const std::string &by)
{
    for (std::size_t at = text.find(what); at != std::string::npos;
         at = text.find(what, at + by.size())) {
        text.replace(at, what.size(), by);
    }
}

// What the library says repeats words of the command line, or their part behind a '=', whole.
std::string in_short(std::string text, const std::vector<std::string> &words)
{
    for (const std::string &word : words) {
        for (const std::string &part : {word, word.substr(word.find('=') + 1)}) {
            const std::string by = readable(part);
            if (by != part) {
                replace_all(text, part, by);
            }
        }
    }
    return readable(text, READABLE_LINE);
}

// Of the words that nobody expected, the first one's likeliest meaning.
std::string what_was_meant(const CLI::App &app)
{
    const std::vector<std::string> unexpected = app.remaining(true);
    const std::string word = unexpected.empty() ? "" : nearest_word(app, unexpected.front());
    return word.empty() ? "" : fmt::format(" did you mean {}?", word);
}

} // namespace

std::optional<int> parse(CLI::App &app, int argc, char **argv)
{
    app.set_version_flag("--version", fmt::format("{} {}", app.get_name(), NF_VERSION));
    std::string shell;
    app.add_option("--completion", shell,
                   "Print what a shell reads to complete words; bash: "
                   "source <(" +
                       app.get_name() + " --completion bash)")
        ->type_name("")
        ->check(CLI::IsMember({"bash", "zsh"}));
    if (argc > 1 && std::string(argv[1]) == ASK_COMPLETIONS) {
        for (const std::string &word : completions(app, {argv + 2, argv + argc})) {
            fmt::print("{}\n", word);
        }
        return 0;
    }
    for (int k = 1; k < argc; k++) {
        if (const std::string problem = utf8_problem(argv[k]); !problem.empty()) {
            fmt::print(stderr, "{}: argument {}: {}\n", app.get_name(), k, problem);
            return BAD_INPUT;
        }
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success &asked) { // --help, --version
        return app.exit(asked);
    } catch (const CLI::ParseError &error) {
        fmt::print(stderr, "{0}: {1};{2} `{0} --help` shows how\n", app.get_name(),
                   in_short(error.what(), {argv + 1, argv + argc}), what_was_meant(app));
        return BAD_INPUT;
    }
    if (!shell.empty()) {
        fmt::print("{}", completion_script(shell, app.get_name()));
        return 0;
    }
    if (app.get_subcommands().empty()) {
        fmt::print(stderr, "{0}: no command; `{0} --help` shows how\n", app.get_name());
        return BAD_INPUT;
    }
    return {};
}

int guarded(const char *program, int (*body)(int, char **), int argc, char **argv)
{
    try {
        const int status = body(argc, argv);
        flush_output();
        return status;
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", program, readable(error.what(), READABLE_LINE));
        return BAD_INPUT;
    }
}

void write_text(const std::string &path, const std::string &text)
{
    if (path == "-") {
        (void)std::fwrite(text.data(), 1, text.size(), stdout);
        flush_output();
    } else {
        OutputFile file(path);
        file.write(text);
        file.close();
    }
}

} // namespace nf
