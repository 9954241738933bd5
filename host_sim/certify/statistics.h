/* SPDX-License-Identifier: MIT */
// What a sample of runs says of all of them.
#pragma once

#include <vector>

namespace nf::certify
{

// The lower end of Wilson's interval of a share, one-sided, 95 %: of `count` runs `good` were good.
// 0 without runs.
double least_share(int good, int count);

// The value below which a share of the values lies, between two of them in a straight line; 0
// without values.
double quantile(std::vector<double> values, double share);

// The fourth of a range low…high in which x lies, 0 to 3.
int quarter_of(double x, double low, double high);

// The share of the variance of `values` that their group explains, corrected for what chance alone
// explains (epsilon squared), at least 0. A group is a number from 0 on. 0 where the values are all
// the same, or with fewer than two groups.
double explained_share(const std::vector<int> &groups, const std::vector<double> &values);

} // namespace nf::certify
