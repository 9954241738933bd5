/* SPDX-License-Identifier: MIT */
// The board's drive, computed again on the PC from its inputs, in lock-step.
//
// It begins with a state of the board and then takes stretches of its ring. A stretch is computed
// first without anybody looking. Only when the state behind it has the hash that the board has
// announced, it is computed once more for those who look: what they see is what the board has
// computed.
#pragma once

#include "recorded_run.h"
#include "sim.h"
#include "stream.h"
#include "tick.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace nf::live
{

struct DriveSettings {
    drive_cfg_t cfg;
    Bases bases;
};

class Shadow
{
public:
    // The settings of a crc, NULL where they are not known. What it returns outlives the shadow.
    using Find = std::function<const DriveSettings *(uint32_t crc)>;

    // Keeps the last `keep_s` for run().
    Shadow(Find find, double keep_s);
    ~Shadow();

    bool is_in_step() const
    {
        return sim_ != nullptr;
    }

    // From the state before a segment on. Empty, or why that cannot be the state: then it is not in
    // step.
    std::string begin(const SegmentInfo &info, const std::vector<uint32_t> &state);

    // The first crc in a stretch whose settings are not known.
    std::optional<uint32_t> unknown_config(const Stretch &stretch) const;

    enum class Verdict {
        right,  // the state behind the stretch is the board's, and all its ticks went to `sink`
        gap,    // the stretch is not all that the board did up to its end
        departs // the board has another state
    };
    struct Advance {
        Verdict verdict;
        std::string why; // in a line; empty when it is right
    };
    // When it is not right no tick went to `sink`. All settings of the stretch are known.
    Advance advance(const Stretch &stretch, TickSink &sink);

    void lose_step();

    // The next tick. The drive's count wraps, this does not.
    int64_t next() const
    {
        return next_;
    }
    const Simulation &sim() const
    {
        return *sim_;
    }
    // What the last tick was told; nothing before the first one since it is in step.
    std::optional<drive_command_t> command() const;
    uint64_t hashes_compared() const
    {
        return compared_;
    }

    // The last `seconds` that were shown, without a gap, as far as they are kept; also when it is
    // not in step any more. Nothing: none are.
    std::optional<RecordedRun> run(double seconds) const;

private:
    struct Step {
        drive_in_t in;
        const DriveSettings *settings;
    };
    struct Kept {
        drive_t state; // before it
        const DriveSettings *settings;
        std::vector<Step> steps;
        std::vector<drive_out_t> outputs;
    };
    Advance judge(const Stretch &stretch, const std::vector<Step> &steps);
    std::vector<Step> steps_of(const Stretch &stretch) const;
    void compute(const std::vector<Step> &steps, TickSink &sink);
    void change(const DriveSettings &settings);
    void keep(Kept kept);

    Find find_;
    double keep_s_;
    std::unique_ptr<Simulation> sim_;
    const DriveSettings *settings_ = nullptr;
    int64_t next_ = 0;
    uint64_t compared_ = 0;
    std::deque<Kept> kept_;
    double kept_s_ = 0;
};

} // namespace nf::live
