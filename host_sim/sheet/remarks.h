/* SPDX-License-Identifier: MIT */
// What of a data sheet does not fit together.
#pragma once

#include "made.h"

#include <string>
#include <vector>

namespace nf::sheet
{

// A line each, of a whole sheet that is within all ranges.
std::vector<std::string> remarks_on(const Given &given);

} // namespace nf::sheet
