// Every intermediate of one tick in the order in which the drive computes it.
#pragma once

#include "tick.h"

#include <string>

namespace nf::debug
{

std::string stages_text(const Tick &tick);

} // namespace nf::debug
