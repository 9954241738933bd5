// SPDX-License-Identifier: MIT
#include "shadow.h"

#include "state_check.h"

#include <algorithm>
#include <utility>

extern "C" {
#include "drive_words.h"
}

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr std::size_t CRC_WORD = 3; // of a change

// A change has the crc of the settings that follow.
bool is_change(const recorder_entry_t &entry)
{
    recorder_frame_t ignored{};
    return !recorder_unpack(&entry, &ignored);
}

} // namespace

Shadow::Shadow(Find find, double keep_s) : find_(std::move(find)), keep_s_(keep_s)
{
}

Shadow::~Shadow() = default;

void Shadow::lose_step()
{
    sim_.reset();
}

std::string Shadow::begin(const SegmentInfo &info, const std::vector<uint32_t> &state)
{
    lose_step();
    const DriveSettings *const settings = find_(info.config_crc);
    if (settings == nullptr) {
        return fmt::format("its configuration {:08x} is not known", info.config_crc);
    }
    drive_t drive{};
    for (uint32_t k = 0; k < state.size(); k++) {
        drive_words_set(&drive, k, state[k]);
    }
    const uint32_t hash = drive_words_hash(&drive);
    if (hash != info.hash || drive.tick != info.first_tick) {
        return fmt::format("the state of tick {} has the hash {:08x}, the board says {:08x} of "
                           "tick {}",
                           drive.tick, hash, info.hash, info.first_tick);
    }
    if (const std::string problem = state_problem(drive, settings->cfg); !problem.empty()) {
        return "the state's " + problem;
    }
    settings_ = settings;
    sim_ = std::make_unique<Simulation>(DriveImage{settings->cfg, drive, settings->bases});
    kept_.clear();
    kept_s_ = 0;
    // A board that has started anew counts from 0 again.
    const auto passed = static_cast<int32_t>(drive.tick - static_cast<uint32_t>(next_));
    next_ = passed >= 0 ? next_ + passed : drive.tick;
    compared_++;
    return "";
}

std::optional<drive_command_t> Shadow::command() const
{
    return !is_in_step() || kept_.empty() || kept_.back().steps.empty()
               ? std::nullopt
               : std::optional<drive_command_t>(kept_.back().steps.back().in.command);
}

std::optional<uint32_t> Shadow::unknown_config(const Stretch &stretch) const
{
    for (const recorder_entry_t &entry : stretch.entries) {
        if (is_change(entry) && find_(entry.word[CRC_WORD]) == nullptr) {
            return entry.word[CRC_WORD];
        }
    }
    return std::nullopt;
}

std::vector<Shadow::Step> Shadow::steps_of(const Stretch &stretch) const
{
    std::vector<Step> steps;
    recorder_frame_t frame{};
    const DriveSettings *settings = settings_;
    for (const recorder_entry_t &entry : stretch.entries) {
        if (recorder_unpack(&entry, &frame)) {
            steps.push_back({frame.in, settings});
        } else {
            settings = find_(entry.word[CRC_WORD]);
        }
    }
    return steps;
}

Shadow::Advance Shadow::judge(const Stretch &stretch, const std::vector<Step> &steps)
{
    drive_t drive = sim_->drive();
    for (const Step &step : steps) {
        drive_out_t out{};
        if (step.settings->cfg.crc != drive.cfg->crc) {
            drive_change(&drive, &step.settings->cfg);
        }
        drive_step(&drive, &step.in, &out);
    }
    if (drive.tick != stretch.end.first_tick) {
        return {Verdict::gap,
                fmt::format("the board's recorder went on at tick {}", stretch.end.first_tick)};
    }
    compared_++;
    const uint32_t hash = drive_words_hash(&drive);
    if (hash != stretch.end.hash) {
        return {Verdict::departs,
                fmt::format("THE BOARD DEPARTS between ticks {} and {}: the hash of its state is "
                            "{:08x}, of the same inputs here {:08x}",
                            sim_->drive().tick, drive.tick, stretch.end.hash, hash)};
    }
    return {Verdict::right, ""};
}

// A segment begins with a change: what its first frame is told.
Shadow::Advance Shadow::advance(const Stretch &stretch, TickSink &sink)
{
    const std::vector<Step> steps = steps_of(stretch);
    if (stretch.entries.empty()) {
        return {Verdict::gap, "the board's ring has overwritten a segment before it came"};
    }
    const Advance found =
        is_change(stretch.entries.front())
            ? judge(stretch, steps)
            : Advance{Verdict::departs, "the first entry of a segment is no change"};
    if (found.verdict == Verdict::right) {
        compute(steps, sink);
    }
    return found;
}

void Shadow::change(const DriveSettings &settings)
{
    drive_t drive = sim_->drive();
    drive_change(&drive, &settings.cfg);
    sim_ = std::make_unique<Simulation>(DriveImage{settings.cfg, drive, settings.bases});
    settings_ = &settings;
}

void Shadow::compute(const std::vector<Step> &steps, TickSink &sink)
{
    Kept kept{sim_->drive(), settings_, steps, {}};
    for (const Step &step : steps) {
        if (step.settings->cfg.crc != settings_->cfg.crc) {
            change(*step.settings);
        }
        sim_->feed(step.in);
        const Tick tick = tick_of_frame(
            *sim_, step.in, static_cast<double>(next_) * settings_->bases.control_period_s);
        sim_->control();
        sink.add(tick);
        kept.outputs.push_back(sim_->out());
        sim_->advance();
        next_++;
    }
    keep(std::move(kept));
}

void Shadow::keep(Kept kept)
{
    const auto length_s = [](const Kept &one) {
        return static_cast<double>(one.steps.size()) * one.settings->bases.control_period_s;
    };
    kept_s_ += length_s(kept);
    kept_.push_back(std::move(kept));
    while (kept_s_ - length_s(kept_.front()) > keep_s_) {
        kept_s_ -= length_s(kept_.front());
        kept_.pop_front();
    }
}

std::optional<RecordedRun> Shadow::run(double seconds) const
{
    if (kept_.empty()) {
        return std::nullopt;
    }
    auto from = kept_.end();
    double have_s = 0;
    while (from != kept_.begin() && have_s < seconds) {
        --from;
        have_s += static_cast<double>(from->steps.size()) * from->settings->bases.control_period_s;
    }
    RecordedRun run{{from->settings->cfg, from->state, from->settings->bases}, {}, {}, {}};
    const DriveSettings *settings = from->settings;
    for (; from != kept_.end(); ++from) {
        for (const Step &step : from->steps) {
            if (step.settings->cfg.crc != settings->cfg.crc) {
                run.changes.push_back({run.frames.size(), step.settings->cfg});
            }
            settings = step.settings;
            run.frames.push_back(step.in);
        }
        run.outputs.insert(run.outputs.end(), from->outputs.begin(), from->outputs.end());
    }
    return run;
}

} // namespace nf::live
