/* SPDX-License-Identifier: MIT */
// The flash of a simulated board as a file: the bytes of its slots, one after the other. So another
// start of the board finds what was stored.
#pragma once

#include "output_file.h"

extern "C" {
#include "hal_host_flash.h"
}

#include <string>

namespace nf::live
{

// Erased where there is no such file; `seed` as of hal_host_flash_init(). Throws ConfigError where
// the file is none of a flash.
hal_host_flash_t read_flash(const std::string &path, unsigned seed);

// Closes the file. Throws OutputError.
void write_flash(OutputFile &file, hal_host_flash_t flash);

} // namespace nf::live
