// The firmware's enumerators as words, for files and messages.
#pragma once

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
    case DRIVE_STATE_CATCH_SPIN:
        return "CATCH_SPIN";
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

inline const char *fault_name(fault_id_t fault)
{
    switch (fault) {
    case FAULT_NONE:
        return "NONE";
    case FAULT_BREAK:
        return "BREAK";
    case FAULT_OVERCURRENT:
        return "OVERCURRENT";
    case FAULT_OVERVOLTAGE:
        return "OVERVOLTAGE";
    case FAULT_UNDERVOLTAGE:
        return "UNDERVOLTAGE";
    case FAULT_STARTUP:
        return "STARTUP";
    case FAULT_CURRENT_OFFSET:
        return "CURRENT_OFFSET";
    }
    return "UNKNOWN";
}

} // namespace nf
