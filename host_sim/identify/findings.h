/* SPDX-License-Identifier: MIT */
// What an identification has found, for a person and for programs.
#pragma once

#include "evaluate.h"
#include "truth.h"

#include <optional>
#include <string>
#include <vector>

namespace nf::identify
{

// A value that was measured and its error bar, as the table has them.
struct Finding {
    std::string title;
    std::string value;
    std::string bar;
    std::string unit;
};
std::vector<Finding> findings_of(const Result &result);

// A table: each value with its error bar, and beside it the true one where the motor is simulated.
// The bars are those of bar_of().
std::string table_text(const Result &result, const std::optional<Truth> &truth);

// The same as JSON: of each value `value`, `bar` and `truth`, in SI units. duration_s: of the
// identification.
std::string json_text(const Result &result, const std::optional<Truth> &truth, double duration_s);

} // namespace nf::identify
