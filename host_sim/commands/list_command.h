/* SPDX-License-Identifier: MIT */
// `motorsim list` and `motorsim estimators`: what there is to choose from.
#pragma once

namespace nf::commands
{

int list();

int estimators();

} // namespace nf::commands
