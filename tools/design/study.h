/* SPDX-License-Identifier: MIT */
// Everything that a design works out, for each set of matrices.
#pragma once

#include "design_file.h"
#include "optimum.h"
#include "printed_matrices.h"
#include "response.h"

#include <string>
#include <vector>

namespace nf::design
{

// Matrices and where they are from: "computed" from the motor file, or "printed" in a publication.
struct Model {
    std::string name;
    Discrete discrete;
    std::vector<Correction> corrections;
};

// The computed model first; the printed one where the design names a file.
std::vector<Model> make_models(const DesignSettings &settings);

// A pair of gains with a name, and its two step responses.
struct Pair {
    std::string name; // "arbitrary", "published", "optimum"
    Gains gains;
};

struct PairResponse {
    std::string pair;
    int input;
    Response response;
    ResponseFigures figures;
    LoopState settled;
};

struct ModelStudy {
    Model model;
    Region region;
    std::optional<double> largest_ki_per_s; // at the published pair's K_p
    Optimum optimum;
    Optimum free; // without regard to stability
    std::vector<Pair> pairs;
    std::vector<PairResponse> responses;
};

// Throws UnstableError for a start or a pair that is unstable.
ModelStudy study(const DesignSettings &settings, const Model &model);

} // namespace nf::design
