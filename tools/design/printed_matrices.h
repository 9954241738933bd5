/* SPDX-License-Identifier: MIT */
// Matrices of a publication: as printed, and with what is wrong in the print put right.
#pragma once

#include "matrices.h"

#include <string>
#include <vector>

namespace nf::design
{

// One entry; row and column count from 1, as in the paper.
struct Correction {
    std::string matrix; // "phi" or "theta"
    int row;
    int column;
    double printed;
    double used;
    std::string reason;
};

struct PrintedMatrices {
    Discrete model; // with the corrections
    std::vector<Correction> corrections;
};

// Throws ConfigError for what is wrong.
PrintedMatrices read_matrices(const std::string &path);

} // namespace nf::design
