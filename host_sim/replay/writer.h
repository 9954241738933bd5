/* SPDX-License-Identifier: MIT */
// The flight recorder at a run of the simulator: the firmware's own, fed as its control interrupt
// feeds it.
#pragma once

#include "config.h"
#include "tick.h"

extern "C" {
#include "recorder_dump.h"
}

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace nf::replay
{

// That a recorder goes on for after a fault, as on a board.
constexpr uint32_t POST_TICKS = 64;

// What a recording of this motor and board says of them, in the units of a board's firmware.
recorder_about_t about(const Config &config);

class Writer : public TickSink
{
public:
    // With the ring of the board's file.
    explicit Writer(const Config &config);
    // Where the recording ends: behind the first fault, as on a board that nobody follows, or with
    // the last tick.
    enum class Until {
        fault,
        end
    };
    Writer(const recorder_about_t &about, uint32_t segment_entries, Until until);
    // The recorder keeps places in its own memory.
    Writer(const Writer &) = delete;
    Writer &operator=(const Writer &) = delete;

    void add(const Tick &tick) override;

    // The recording as the firmware sends it.
    std::string text();

private:
    void freeze();

    recorder_about_t about_{};
    std::vector<recorder_entry_t> entries_;
    recorder_t recorder_{};
    // With the last tick, which the simulation does not outlive; a change puts the next one into
    // the other.
    std::array<drive_cfg_t, 2> cfgs_{};
    std::size_t in_force_ = 0;
    const drive_cfg_t *source_ =
        nullptr; // where the simulation has it; another place: it has changed
    drive_t drive_{};
    drive_in_t in_{};
};

} // namespace nf::replay
