/* SPDX-License-Identifier: MIT */
// The firmware's states as words, for files and messages. Faults: firmware/protect/fault_text.h.
#pragma once

#include <string>

extern "C" {
#include "drive.h"
}

namespace nf
{

inline const char *state_name(drive_state_t state)
{
    switch (state) {
    case DRIVE_STATE_INIT:
        return "INIT";
    case DRIVE_STATE_OFFSET_CAL:
        return "OFFSET_CAL";
    case DRIVE_STATE_READY:
        return "READY";
    case DRIVE_STATE_FLYING_START:
        return "FLYING_START";
    case DRIVE_STATE_PROBE:
        return "PROBE";
    case DRIVE_STATE_ALIGN:
        return "ALIGN";
    case DRIVE_STATE_HOLD:
        return "HOLD";
    case DRIVE_STATE_IF_RAMP:
        return "IF_RAMP";
    case DRIVE_STATE_HANDOVER:
        return "HANDOVER";
    case DRIVE_STATE_RUN:
        return "RUN";
    case DRIVE_STATE_FAULT:
        return "FAULT";
    }
    return "UNKNOWN";
}

// With what the gates do beside the state.
inline std::string state_and_gates(const drive_t &drive)
{
    const char *const gates = safe_state_is_short(&drive.safe_state) ? ", shorting the motor" : "";
    return std::string(state_name(drive.state)) + gates;
}

} // namespace nf
