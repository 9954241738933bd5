// SPDX-License-Identifier: MIT
#include "found_fault.h"

extern "C" {
#include "diagnosis.h"
}

namespace nf
{

FoundFault found_fault(const drive_t &drive, const Bases &bases)
{
    const bool is_swing = drive.fault.id == FAULT_OSCILLATION;
    return {drive.fault, is_swing ? last_swing_hz(drive, bases) : std::nullopt,
            diagnosis_advice(&drive, static_cast<uint32_t>(bases.pole_pairs))};
}

std::optional<double> last_swing_hz(const drive_t &drive, const Bases &bases)
{
    if (drive.watch.oscillation.span == 0) {
        return std::nullopt;
    }
    const double span_s =
        drive.watch.oscillation.span * drive.cfg->slow_ticks * bases.control_period_s;
    return drive.cfg->oscillation.halves_max / (2 * span_s);
}

} // namespace nf
