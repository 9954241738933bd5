/* SPDX-License-Identifier: MIT */
// The outcome of a run as JSON for programs and as a table for people.
#pragma once

#include "scenario.h"

#include <string>
#include <vector>

namespace nf
{

// A figure of a run beside its limit.
struct ResultRow {
    std::string name; // with its unit at the end
    std::string value;
    std::string limit; // "" without one
    bool holds;        // its limit; false without one
};

// Those of the table: figures that do not apply are left out, but for those that have a limit.
std::vector<ResultRow> result_rows(const Config &config, const RunResult &result);

// What the files and the run have to say beside the figures.
std::vector<std::string> notes_of(const Config &config, const RunResult &result);

// One flat object, each number in the unit at the end of its key; a figure that does not apply is
// null. `state_final` and `gates_enabled_final` say how the run ended: FAULT with the gates open is
// a drive that gave up safely. `saturations` holds the ticks at the end of their range of each
// signal (saturation.h). Where the scenario has limits for this run, `accepted` says whether all
// hold and `failed_limits` names those that do not.
std::string json_text(const Config &config, const RunResult &result);

// One line a figure: value, limit, whether it holds. Figures that do not apply are left out.
std::string table_text(const Config &config, const RunResult &result);

} // namespace nf
