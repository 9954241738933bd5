// SPDX-License-Identifier: MIT
// Where nobody has a terminal.
#include "live_view.h"

namespace nf::live
{

std::unique_ptr<LiveView> terminal_view()
{
    return plain_view();
}

} // namespace nf::live
