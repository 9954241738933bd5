// SPDX-License-Identifier: MIT
#include "state_check.h"

extern "C" {
#include "transitions.h"
}

#include <cstdint>
#include <cstring>
#include <type_traits>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr std::size_t WORD_BYTES = sizeof(uint32_t);
constexpr int64_t GUARD_AT_MAX = sizeof(drive_cfg_t) - 2 * WORD_BYTES;

// The number that a member's bits are: a flag or a choice of these bits need not be one.
template <class Member> int64_t number_of(const Member &member)
{
    using Wide = std::conditional_t<std::is_enum_v<Member>, uint32_t, Member>;
    using Number = std::conditional_t<std::is_same_v<Member, bool>, uint8_t, Wide>;
    static_assert(sizeof(Number) == sizeof(Member));
    Number number{};
    std::memcpy(&number, &member, sizeof number);
    return number;
}

// What drive_step leaves a state in, whatever it is told; with another number it may compute what
// no word holds.
std::string range_problem(const drive_t &s)
{
    struct Range {
        const char *name;
        int64_t value;
        int64_t least;
        int64_t most;
    };
    const Range all[] = {
        {"guard.at", number_of(s.guard.at), 0, GUARD_AT_MAX},
#define FIELD(path, lowest, highest, quantity) {#path, number_of(s.path), lowest, highest},
#define FREE(path, quantity)
#include "state.def"
#undef FIELD
#undef FREE
    };
    for (const Range &one : all) {
        if (one.value < one.least || one.value > one.most) {
            return fmt::format("{} is {}, allowed are {} to {}", one.name, one.value, one.least,
                               one.most);
        }
    }
    return s.guard.at % WORD_BYTES != 0 ? fmt::format("guard.at is {}, no whole word", s.guard.at)
                                        : "";
}

// Else drive_step makes a fault of it at once: it is a state that no run has left.
std::string code_problem(const drive_t &s)
{
    const int64_t code = number_of(s.state);
    for (uint32_t number = 0; number < DRIVE_STATES; number++) {
        if (number_of(transitions_state(number)) == code) {
            return "";
        }
    }
    return fmt::format("state is {}, which is none", code);
}

// A state of a way that this configuration does not go.
std::string way_problem(const drive_t &s, const drive_cfg_t &cfg)
{
    const bool starts_up = cfg.startup.current_hold != 0;
    if (!starts_up && s.state > DRIVE_STATE_READY && s.state < DRIVE_STATE_RUN &&
        s.state != DRIVE_STATE_PROBE) {
        return fmt::format("state is {}, and the configuration has no start-up",
                           static_cast<int>(s.state));
    }
    return s.voltage_drive.active && cfg.voltage_drive.enabled == 0
               ? "voltage_drive.active is 1, and the configuration has no voltage drive"
               : "";
}

} // namespace

std::string state_problem(const drive_t &state, const drive_cfg_t &cfg)
{
    std::string problem = code_problem(state);
    if (problem.empty()) {
        problem = range_problem(state);
    }
    return problem.empty() ? way_problem(state, cfg) : problem; // each is what its type may hold
}

} // namespace nf
