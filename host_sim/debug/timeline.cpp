// SPDX-License-Identifier: MIT
#include "timeline.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace nf::debug
{

Timeline::Timeline(const Config &config, int64_t keep) : run_(config), keep_(keep)
{
    control();
}

Timeline::Timeline(const RecordedRun &recorded) : run_(recorded)
{
    control();
}

void Timeline::control()
{
    keep_snapshot();
    before_ = run_.sim().drive();
    tick_ = run_.control();
    for (const Edit &edit : edits_) { // first, as what ends may have stood over what goes on
        if (edit.end && now() > edit.from && now() - 1 == edit.until) {
            edit.end(run_);
        }
    }
    for (const Edit &edit : edits_) {
        if (now() >= edit.from && now() <= edit.until) {
            edit.act(run_);
        }
    }
}

void Timeline::keep_snapshot()
{
    const bool due = (now() - run_.first()) % spacing_ == 0 && snapshots_.count(now()) == 0;
    if (due) {
        snapshots_.emplace(now(), run_.save());
    }
    if (due && keep_ == FOR_EVER) {
        thin_out();
    } else if (due) {
        forget_past();
    }
}

// The ticks to be kept begin at or behind the oldest snapshot. What was done before it lies in it.
void Timeline::forget_past()
{
    const int64_t needed = std::max(now() - keep_, first());
    snapshots_.erase(snapshots_.begin(), std::prev(snapshots_.upper_bound(needed)));
    edits_.erase(std::remove_if(edits_.begin(), edits_.end(),
                                [this](const Edit &edit) { return edit.until < first() - 1; }),
                 edits_.end());
}

// Every other one goes, but never the first.
void Timeline::thin_out()
{
    if (snapshots_.size() <= SNAPSHOTS_MAX) {
        return;
    }
    spacing_ *= 2;
    for (auto at = snapshots_.begin(); at != snapshots_.end();) {
        at = (at->first - run_.first()) % spacing_ == 0 ? std::next(at) : snapshots_.erase(at);
    }
}

// What was kept of later ticks is no longer what will be.
void Timeline::forget_future()
{
    snapshots_.erase(snapshots_.upper_bound(now()), snapshots_.end());
}

bool Timeline::step()
{
    if (now() >= last()) {
        return false;
    }
    run_.advance();
    control();
    return true;
}

bool Timeline::go_to(int64_t tick, bool (*stop)())
{
    const auto nearest = std::prev(snapshots_.upper_bound(tick));
    if (tick < now() || nearest->first > now()) {
        run_.restore(nearest->second);
        control();
    }
    while (now() < tick && (stop == nullptr || !stop()) && step()) {
    }
    return now() == tick;
}

void Timeline::edit(const std::string &subject, const std::string &text, int64_t until,
                    const Act &act, const Act &end)
{
    edits_.push_back({subject, text, now(), std::max(until, now()), act, end});
    forget_future();
    act(run_);
}

bool Timeline::release(const std::string &subject)
{
    const int64_t here = now();
    bool found = false;
    for (Edit &edit : edits_) {
        if (edit.subject == subject && edit.until >= here) {
            edit.until = here - 1;
            found = true;
        }
    }
    edits_.erase(std::remove_if(edits_.begin(), edits_.end(),
                                [](const Edit &edit) { return edit.until < edit.from; }),
                 edits_.end());
    forget_future();
    if (found) {
        run_.restore(std::prev(snapshots_.upper_bound(here))->second);
        control();
        go_to(here);
    }
    return found;
}

std::vector<std::string> Timeline::edits() const
{
    std::vector<std::string> lines;
    lines.reserve(edits_.size());
    for (const Edit &edit : edits_) {
        std::string span = fmt::format("at tick {}", edit.from);
        if (edit.until == FOR_EVER) {
            span = fmt::format("from tick {} on", edit.from);
        } else if (edit.until > edit.from) {
            span = fmt::format("from tick {} to {}", edit.from, edit.until);
        }
        lines.push_back(fmt::format("{} {}", edit.text, span));
    }
    return lines;
}

} // namespace nf::debug
