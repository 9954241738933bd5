/* SPDX-License-Identifier: MIT */
// What the paper prints beside what its matrices and its equations give.
#pragma once

#include "study.h"

#include <optional>
#include <string>
#include <vector>

namespace nf::design
{

struct Comparison {
    std::string quantity; // with its unit at the end, as a JSON key
    std::optional<double> paper;
    std::optional<double> printed; // from the matrices as printed
    std::optional<double> computed;
    std::string remark;
};

// The claims of paper B's section 4 and its matrices, entry by entry.
std::vector<Comparison> compare_all(const DesignSettings &settings,
                                    const std::vector<ModelStudy> &studies);

} // namespace nf::design
