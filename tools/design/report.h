/* SPDX-License-Identifier: MIT */
// What a design worked out, as JSON for programs and as text for people.
#pragma once

#include "compare.h"

#include <string>
#include <vector>

namespace nf::design
{

// One object; each number's unit is the end of its key, rows and columns of the matrices are named
// by `states` and `inputs`. `chosen` is the model whose optimum becomes the drive's gains.
// `comparison` has of compare_all() `quantity`, `paper`, `printed`, `computed` (null: has none) and
// `remark`.
std::string design_json(const DesignSettings &settings, const std::vector<ModelStudy> &studies,
                        const std::string &chosen);

// A summary, and the drive's gains as TOML.
std::string design_text(const DesignSettings &settings, const std::vector<ModelStudy> &studies,
                        const std::string &chosen);

std::string comparison_text(const std::vector<Comparison> &rows);

// The poles of a pair with a set of matrices, and what they mean.
std::string poles_text(const Model &model, const Gains &gains);

} // namespace nf::design
