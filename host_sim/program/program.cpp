#include "program.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>

namespace nf
{

namespace
{

bool put(const std::string &text)
{
    return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
           std::fflush(stdout) == 0;
}

bool put(const std::string &path, const std::string &text)
{
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    return !file.fail();
}

} // namespace

std::optional<int> parse(CLI::App &app, int argc, char **argv)
{
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success &asked) { // --help
        return app.exit(asked);
    } catch (const CLI::ParseError &error) {
        fmt::print(stderr, "{0}: {1}; `{0} --help` shows how\n", app.get_name(), error.what());
        return BAD_INPUT;
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
        return body(argc, argv);
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", program, error.what());
        return BAD_INPUT;
    }
}

void write_text(const std::string &path, const std::string &text)
{
    const bool to_output = path == "-";
    errno = 0;
    if (!(to_output ? put(text) : put(path, text))) {
        throw std::runtime_error(fmt::format(
            "{}: cannot write: {}", to_output ? "standard output" : path, std::strerror(errno)));
    }
}

} // namespace nf
