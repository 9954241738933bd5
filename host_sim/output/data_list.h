/* SPDX-License-Identifier: MIT */
// What the data folder holds, for people.
#pragma once

#include <string>

namespace nf
{

// Scenarios (name, motor, title, figure of the papers) and imperfection sets (name, what they are).
std::string data_list_text();

} // namespace nf
