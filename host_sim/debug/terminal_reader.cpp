// SPDX-License-Identifier: MIT
#include "interrupt.h"
#include "line_reader.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include <editline/readline.h>
#include <sys/select.h>
#include <unistd.h>

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

// The library's own reading goes on after a signal. An interrupt is let in only while it waits, so
// that none is missed.
int next_key(std::FILE *from)
{
    const int file = fileno(from);
    sigset_t interrupt;
    sigset_t before;
    sigemptyset(&interrupt);
    for (const int signal : ending_signals()) {
        sigaddset(&interrupt, signal);
    }
    sigprocmask(SIG_BLOCK, &interrupt, &before);
    bool ready = false;
    bool broken = false;
    while (!ready && !broken && !was_interrupted()) {
        fd_set keys;
        FD_ZERO(&keys);
        FD_SET(file, &keys);
        ready = pselect(file + 1, &keys, nullptr, nullptr, nullptr, &before) > 0;
        broken = !ready && errno != EINTR;
    }
    sigprocmask(SIG_SETMASK, &before, nullptr);
    unsigned char key = 0;
    return ready && read(file, &key, 1) == 1 ? key : EOF;
}

class Terminal : public LineReader
{
public:
    explicit Terminal(const Complete &complete)
    {
        complete_line = complete;
        rl_attempted_completion_function = attempt;
        rl_getc_function = next_key;
        using_history();
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        char *text = nullptr;
        do { // Ctrl-C: another line in place of this one
            forget_interrupt();
            text = readline(prompt.c_str());
            if (text == nullptr) {
                std::fputc('\n', stdout);
            }
        } while (text == nullptr && was_interrupted() && !was_ended());
        if (text == nullptr) {
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

private:
    InterruptWatch watch_;
};

} // namespace

std::unique_ptr<LineReader> terminal_reader(const Complete &complete)
{
    return std::make_unique<Terminal>(complete);
}

} // namespace nf::debug
