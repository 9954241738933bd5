#include "line_reader.h"

#include <cstdlib>
#include <cstring>

#include <editline/readline.h>
#include <fmt/format.h>

namespace nf::debug
{
namespace
{

Complete complete_line;
std::vector<std::string> candidates;

// One candidate a call, on the heap of C; state is 0 in the first call.
char *next_candidate(const char *word, int state)
{
    static std::size_t next = 0;
    (void)word;
    next = state == 0 ? 0 : next;
    return next < candidates.size() ? strdup(candidates[next++].c_str()) : nullptr;
}

char **attempt(const char *word, int start, int end)
{
    (void)end;
    candidates = complete_line(std::string(rl_line_buffer, static_cast<std::size_t>(start)), word);
    rl_attempted_completion_over = 1; // no file names instead
    return rl_completion_matches(word, next_candidate);
}

class Terminal : public LineReader
{
public:
    explicit Terminal(const Complete &complete)
    {
        complete_line = complete;
        rl_attempted_completion_function = attempt;
        using_history();
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        char *const text = readline(prompt.c_str());
        if (text == nullptr) {
            std::fputc('\n', stdout);
            return std::nullopt;
        }
        std::string line(text);
        std::free(text);
        if (!line.empty()) {
            add_history(line.c_str());
        }
        return line;
    }

    bool is_unattended() const override
    {
        return false;
    }
};

class Stream : public LineReader
{
public:
    Stream(std::FILE *from, std::FILE *echo) : from_(from), echo_(echo)
    {
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        std::string line;
        int c = std::fgetc(from_);
        if (c == EOF) {
            return std::nullopt;
        }
        for (; c != EOF && c != '\n'; c = std::fgetc(from_)) {
            line.push_back(static_cast<char>(c));
        }
        if (!line.empty() && line.back() == '\r') {
            line.pop_back();
        }
        fmt::print(echo_, "{}{}\n", prompt, line);
        return line;
    }

    bool is_unattended() const override
    {
        return true;
    }

private:
    std::FILE *from_;
    std::FILE *echo_;
};

} // namespace

std::unique_ptr<LineReader> terminal_reader(const Complete &complete)
{
    return std::make_unique<Terminal>(complete);
}

std::unique_ptr<LineReader> stream_reader(std::FILE *from, std::FILE *echo)
{
    return std::make_unique<Stream>(from, echo);
}

} // namespace nf::debug
