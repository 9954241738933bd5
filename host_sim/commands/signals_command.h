/* SPDX-License-Identifier: MIT */
// `motorsim signals`, with the options of a choice.
#pragma once

#include "choice.h"

namespace nf::commands
{

int signals(const Choice &choice);

} // namespace nf::commands
