#include "state_check.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr std::size_t WORD_BYTES = sizeof(uint32_t);
constexpr uint32_t CATCH_PHASES = 4;

// What is no number of its type must not be looked at as one.
uint32_t bits_of(const void *member, std::size_t bytes)
{
    uint32_t bits = 0;
    std::memcpy(&bits, member, bytes);
    return bits;
}

struct Bounded {
    const char *name;
    const void *member;
    std::size_t bytes;
    uint32_t least;
    uint32_t most;
};

std::string choice_problem(const drive_t &s, const drive_cfg_t &cfg)
{
    const auto flag = [](const char *name, const bool &member) {
        return Bounded{name, &member, sizeof(bool), 0, 1};
    };
    const auto word = [](const char *name, const auto &member, uint32_t least, uint32_t most) {
        return Bounded{name, &member, WORD_BYTES, least, most};
    };
    const std::array<Bounded, 12> all = {{
        word("state", s.state, 0, DRIVE_STATE_FAULT),
        word("slow_count", s.slow_count, 1, cfg.slow_ticks),
        flag("voltage_driven", s.voltage_driven),
        flag("identified", s.identified),
        word("catch_spin.phase", s.catch_spin.phase, 0, CATCH_PHASES - 1),
        flag("catch_spin.gates", s.catch_spin.gates),
        word("align.phase", s.align.phase, 0, ALIGN_DONE),
        flag("align.backwards", s.align.backwards),
        word("fault.id", s.fault.id, 0, FAULT_COUNT - 1),
        word("supervision.suspect.id", s.supervision.suspect.id, 0, FAULT_COUNT - 1),
        word("supervision.step", s.supervision.step, 0, SUPERVISION_STEPS - 1),
        word("guard.at", s.guard.at, 0, sizeof(drive_cfg_t) - 2 * WORD_BYTES),
    }};
    for (const Bounded &one : all) {
        const uint32_t value = bits_of(one.member, one.bytes);
        if (value < one.least || value > one.most) {
            return fmt::format("{} is {}, allowed are {} to {}", one.name, value, one.least,
                               one.most);
        }
    }
    return s.guard.at % WORD_BYTES != 0 ? fmt::format("guard.at is {}, no whole word", s.guard.at)
                                        : "";
}

// What drive_step leaves a state in, whatever it is told; with another number it may compute what no word holds.
std::string range_problem(const drive_t &s)
{
    struct Range {
        const char *name;
        int64_t value;
        int64_t least;
        int64_t most;
    };
    const Range all[] = {
#define FIELD(path, lowest, highest) {#path, static_cast<int64_t>(s.path), lowest, highest},
#include "state.def"
#undef FIELD
    };
    for (const Range &one : all) {
        if (one.value < one.least || one.value > one.most) {
            return fmt::format("{} is {}, allowed are {} to {}", one.name, one.value, one.least,
                               one.most);
        }
    }
    return "";
}

// A state of a way that this configuration does not go.
std::string way_problem(const drive_t &s, const drive_cfg_t &cfg)
{
    const bool starts_up = cfg.startup.current_hold != 0 && cfg.sampling.sensor_pole_pairs == 0;
    if (!starts_up && s.state > DRIVE_STATE_READY && s.state < DRIVE_STATE_RUN) {
        return fmt::format("state is {}, and the configuration has no start-up",
                           static_cast<int>(s.state));
    }
    return s.voltage_driven && cfg.voltage_drive.enabled == 0
               ? "voltage_driven is 1, and the configuration has no voltage drive"
               : "";
}

bool same_shifts(const current_loop_cfg_t &a, const current_loop_cfg_t &b)
{
    return a.pi_d.kp_shift == b.pi_d.kp_shift && a.pi_d.ki_shift == b.pi_d.ki_shift &&
           a.pi_q.kp_shift == b.pi_q.kp_shift && a.pi_q.ki_shift == b.pi_q.ki_shift;
}

// The drive corrects the model's factors, never its shifts.
bool has_own_shifts(const model_t &model, const drive_cfg_t &cfg)
{
    const nn_observer_cfg_t &a = model.observer;
    const nn_observer_cfg_t &b = cfg.observer;
    const bool observer = a.weight_shift == b.weight_shift && a.current_shift == b.current_shift &&
                          a.rate_shift == b.rate_shift &&
                          a.proportional_shift == b.proportional_shift;
    return !observer || !same_shifts(model.run_loop, cfg.current_loop) ||
           !same_shifts(model.hold_loop, cfg.hold_loop);
}

} // namespace

std::string state_problem(const drive_t &state, const drive_cfg_t &cfg)
{
    std::string problem = choice_problem(state, cfg);
    if (problem.empty()) { // each is what its type may hold
        problem = range_problem(state);
    }
    if (problem.empty()) {
        problem = way_problem(state, cfg);
    }
    return problem.empty() && has_own_shifts(state.model, cfg)
               ? "model has other shifts than the configuration"
               : problem;
}

} // namespace nf
