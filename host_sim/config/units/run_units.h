/* SPDX-License-Identifier: MIT */
// The firmware's numbers of RUN, with or without a start-up.
#pragma once

#include "bases.h"

namespace nf
{

run_cfg_t make_run(const TuningSettings &tuning);

} // namespace nf
