/* SPDX-License-Identifier: MIT */
// The signals of a run as a CSV file, one row a control tick, for PlotJuggler, pandas and the like.
//
// The unit of each column is the end of its name. Estimates stand beside the truth of the same
// instant. v_d_v, v_q_v and the duties are what the drive asks for at this instant; they act from
// the next one on. speed_command_rpm is the speed command, in position mode what the position loop
// makes of it; speed_reference_rpm is the same after the ramp and all limits. position_command_rad
// is 0 in speed mode. Mechanical angles are multi-turn, electrical ones within ±180°; state and
// fault are words. The same run gives the same bytes.
#pragma once

#include "output_file.h"
#include "tick.h"

#include <string>

#include <fmt/format.h>

namespace nf
{

class Trace : public TickSink
{
public:
    // Rows before t = 0 on request. All of it throws OutputError.
    Trace(const std::string &path, bool with_prelude);

    void add(const Tick &tick) override;
    // Call after the last row. Without, there is no file.
    void close();

private:
    void flush();

    bool with_prelude_;
    OutputFile file_;
    fmt::memory_buffer buffer_;
};

} // namespace nf
