/* SPDX-License-Identifier: MIT */
// The line to a board that the page has opened: the worker's `line`
// (tools/web/src/core/live_session.ts).
#pragma once

#include "channel.h"

namespace nf::web
{

class WorkerLine : public live::Channel
{
public:
    std::vector<uint8_t> read(double wait_s) override;
    void write(const std::vector<uint8_t> &bytes) override;
    double now_s() const override;

    // Whether a person has asked for a stop since this was called last.
    static bool take_stop();
};

} // namespace nf::web
