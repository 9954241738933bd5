// SPDX-License-Identifier: MIT
// Where nobody has a terminal.
#include "line_reader.h"

namespace nf::debug
{

std::unique_ptr<LineReader> terminal_reader(const Complete &complete)
{
    (void)complete;
    return stream_reader(stdin, stdout);
}

} // namespace nf::debug
