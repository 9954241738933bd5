// SPDX-License-Identifier: MIT
// motorsim as a call: {"args": ["run", "s1"]} makes {"stdout", "stderr", "status"}. Files lie in the page's file system.
#include "calls.h"
#include "motorsim.h"

#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>

#include <fcntl.h>
#include <unistd.h>

namespace nf::web
{
namespace
{

// As long as it lives, a stream's bytes go to a file.
class Redirection
{
public:
    Redirection(std::FILE *stream, const char *path)
        : stream_(stream), path_(path), before_(dup(fileno(stream)))
    {
        const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(file, fileno(stream));
        close(file);
    }
    ~Redirection()
    {
        flush();
        dup2(before_, fileno(stream_));
        close(before_);
        unlink(path_);
    }
    Redirection(const Redirection &) = delete;
    Redirection &operator=(const Redirection &) = delete;

    // Since it began.
    std::string text()
    {
        flush();
        std::ifstream file(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    }

private:
    void flush()
    {
        std::cout.flush();
        (void)std::fflush(stream_);
    }

    std::FILE *stream_;
    const char *path_;
    int before_;
};

Json program(const Json &given)
{
    std::vector<std::string> words = {"motorsim"};
    for (const std::string &word : texts_of(given, "args")) {
        words.push_back(word);
    }
    std::vector<char *> argv;
    argv.reserve(words.size() + 1);
    for (std::string &word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    Redirection out(stdout, "/tmp/stdout");
    Redirection err(stderr, "/tmp/stderr");
    const int status = motorsim(static_cast<int>(words.size()), argv.data());
    return {{"stdout", out.text()}, {"stderr", err.text()}, {"status", status}};
}

} // namespace

const Calls &program_calls()
{
    static const Calls calls = {{"program", program}};
    return calls;
}

} // namespace nf::web
