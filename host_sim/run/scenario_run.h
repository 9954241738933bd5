/* SPDX-License-Identifier: MIT */
// run_scenario() in slices, for whoever shows how far it is or may stop it.
#pragma once

#include "run_result.h"
#include "scripted_run.h"

#include <optional>

namespace nf
{

class ScenarioRun
{
public:
    // Throws ConfigError. All three must outlive the run; options.progress is not called.
    ScenarioRun(const Config &real, const Config &believed, const RunOptions &options);

    // So many ticks, or those that are left. Throws what the sink throws.
    void advance(int64_t ticks);
    bool is_done() const
    {
        return run_.tick() >= run_.end();
    }
    // The script, and where the run is in it.
    const ScriptedRun &script() const
    {
        return run_;
    }

    // After the last tick, once.
    RunResult finish();

private:
    void one();
    void note_swing();
    void note_missed();
    void note_load(const Tick &tick);
    void note_late_start();
    void judge_steps(const Tick &tick);
    void evaluate(const Tick &tick);
    void watch_state();
    bool reference_moving();

    const Config &config_; // the drive's
    const RunOptions &options_;
    ScriptedRun run_;
    int64_t evaluate_from_;
    Metrics metrics_;
    double rpm_per_step_;
    double ampere_per_bit_;
    double supply_rad_s_; // of its ripple; 0: it has none
    int64_t reference_ = 0;
    drive_state_t state_ = DRIVE_STATE_INIT;
    std::optional<double> runs_from_s_; // of the ticks that are judged the first in RUN
    RunResult result_;
};

} // namespace nf
