/* SPDX-License-Identifier: MIT */
// The worst margin over two axes of the box: in each cell of a grid that of the worst run in it.
#pragma once

#include "judge.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace nf::certify
{

struct Cell {
    int runs = 0;
    int failed = 0;
    double worst = 1; // 1 without runs
};

struct WorstMap {
    std::size_t across; // axes of the box
    std::size_t up;
    std::size_t side;        // cells a side
    std::vector<Cell> cells; // side · side, the lowest row first

    const Cell &at(std::size_t column, std::size_t row) const
    {
        return cells[row * side + column];
    }
};

// Of the two axes that the worst margin of the recommended tuning depends on most.
WorstMap map_of(const Campaign &campaign, const Judgement &judgement);

} // namespace nf::certify
