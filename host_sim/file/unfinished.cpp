// SPDX-License-Identifier: MIT
#include "unfinished.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <string>

#include <unistd.h>

namespace nf
{
namespace
{

constexpr std::array<int, 5> ENDS = {SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM};

// What a handler reads: memory of fixed size that is there before any signal. The name is complete
// before `used` is true.
struct Slot {
    std::atomic<bool> used{false};
    std::array<char, PATH_MAX> path{};
};
std::array<Slot, 16> slots;
static_assert(std::atomic<bool>::is_always_lock_free, "a handler may read nothing else");

// The action is the default one again when this is called. So the program ends as it would have
// ended without it.
void remove_and_end(int signal)
{
    for (const Slot &slot : slots) {
        if (slot.used) {
            (void)unlink(slot.path.data());
        }
    }
    (void)raise(signal);
}

// A signal that is ignored stays so, as does one that somebody else takes.
void take_signals()
{
    for (const int signal : ENDS) {
        struct sigaction now = {};
        sigaction(signal, nullptr, &now);
        if (now.sa_handler != SIG_DFL || (now.sa_flags & SA_SIGINFO) != 0) {
            continue;
        }
        struct sigaction action = {};
        action.sa_handler = remove_and_end;
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
    }
}

// While it lives no signal comes between the file and its entry here.
class Held
{
public:
    Held()
    {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    ~Held()
    {
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    Held(const Held &) = delete;
    Held &operator=(const Held &) = delete;

private:
    sigset_t before_{};
};

// The number of slots where none is free, or none holds such a name.
std::size_t enter(const std::string &path)
{
    std::size_t place = 0;
    while (place < slots.size() && slots.at(place).used) {
        place++;
    }
    if (place == slots.size() || path.size() >= PATH_MAX) {
        return slots.size();
    }
    std::memcpy(slots.at(place).path.data(), path.c_str(), path.size() + 1);
    slots.at(place).used = true;
    return place;
}

} // namespace

UnfinishedFile::UnfinishedFile(const std::filesystem::path &path)
    : file_(nullptr), place_(slots.size())
{
    const Held held;
    take_signals();
    file_ = std::fopen(path.c_str(), "wbx");
    if (file_ != nullptr) {
        place_ = enter(std::filesystem::absolute(path).string());
    }
}

UnfinishedFile::~UnfinishedFile()
{
    if (place_ < slots.size()) {
        slots.at(place_).used = false;
    }
}

} // namespace nf
