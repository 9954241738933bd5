/* SPDX-License-Identifier: MIT */
// Reads one file or override: what is wrong with it is found here, whether or not another layer
// overrides it.
#pragma once

#include "layer.h"

namespace nf
{

// A file of a kind from its text, without looking at the files that it refers to. Any bytes are
// allowed; throws ConfigError for what is wrong.
Layer read_layer(FileKind kind, const std::string &file, const std::string &text);

// An override "section.key=value", or "motor=NAME" and the like.
Layer read_override(const std::string &text);

} // namespace nf
