// The C header that gives a target its configuration.
#pragma once

#include "config.h"

#include <string>

namespace nf
{

// The whole header: `static const drive_cfg_t DRIVE_CONFIG`, its provenance and the SI meaning of
// each field. The same files give the same text on every machine.
std::string make_header(const Config &config);

} // namespace nf
