/* SPDX-License-Identifier: MIT */
// A run that can be at any of its ticks, forwards and backwards.
//
// At a tick its control interrupt has run: the drive's words are those of t_k, and so is the
// truth. Backwards is a snapshot and the ticks from there: a run is its inputs, so it comes to the
// same bits. Snapshots are thinned out as the run gets longer: there are never more than
// SNAPSHOTS_MAX, evenly spaced, and a way back runs at most one spacing. Of a run without an end
// the recent past alone is kept: its snapshots are not thinned out, and what is older is gone.
#pragma once

#include "scripted_run.h"

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace nf::debug
{

class Timeline
{
public:
    static constexpr int64_t SPACING_MIN = 1024;
    static constexpr std::size_t SNAPSHOTS_MAX = 256;

    static constexpr int64_t FOR_EVER = std::numeric_limits<int64_t>::max();

    // At the first tick. Throws ConfigError. The configuration must outlive it. `keep`: at least so
    // many ticks of the past can be reached.
    explicit Timeline(const Config &config, int64_t keep = FOR_EVER);
    explicit Timeline(const RecordedRun &recorded);

    int64_t now() const
    {
        return run_.tick();
    }
    // That can still be reached.
    int64_t first() const
    {
        return snapshots_.begin()->first;
    }
    int64_t last() const
    {
        return run_.end() - 1;
    }
    const ScriptedRun &run() const
    {
        return run_;
    }
    const Tick &tick() const
    {
        return tick_;
    }
    // The drive as this tick found it.
    const drive_t &before() const
    {
        return before_;
    }

    // One tick on; false at the last one.
    bool step();
    // To a tick, first() … last(). Ends at an earlier one, with false, when `stop` says so after
    // some tick.
    bool go_to(int64_t tick, bool (*stop)() = nullptr);

    // What is done to the run, after the control interrupt of each tick from the present one to
    // `until`; on the way again it happens again. `subject` names it for release().
    using Act = std::function<void(ScriptedRun &)>;
    void edit(const std::string &subject, const std::string &text, int64_t until, const Act &act,
              const Act &end = {});
    // Ends it here. False when nothing of this subject acts at the present tick or later.
    bool release(const std::string &subject);
    // A line for each.
    std::vector<std::string> edits() const;

    std::size_t snapshots() const
    {
        return snapshots_.size();
    }

private:
    struct Edit {
        std::string subject;
        std::string text;
        int64_t from;
        int64_t until;
        Act act;
        Act end; // in the tick after the last
    };
    void control();
    void keep_snapshot();
    void thin_out();
    void forget_past();
    void forget_future();

    ScriptedRun run_;
    int64_t keep_ = FOR_EVER;
    Tick tick_{};
    drive_t before_{};
    std::map<int64_t, ScriptedRun::Snapshot> snapshots_; // each before the control interrupt
    int64_t spacing_ = SPACING_MIN;
    std::vector<Edit> edits_;
};

} // namespace nf::debug
