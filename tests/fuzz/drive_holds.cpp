// SPDX-License-Identifier: MIT
#include "drive_holds.h"

#include "fuzzed.h"
#include "state_check.h"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace fuzz
{
namespace
{

void within(const char *name, int64_t value, int64_t lowest, int64_t highest)
{
    if (value < lowest || value > highest) {
        (void)std::fprintf(stderr, "%s = %" PRId64 " is outside %" PRId64 " to %" PRId64 "\n", name,
                           value, lowest, highest);
        std::abort();
    }
}

void state_holds(const drive_t &drive)
{
    const std::string problem = nf::state_problem(drive, *drive.cfg);
    if (!problem.empty()) {
        (void)std::fprintf(stderr, "outside of what is proven: drive.%s\n", problem.c_str());
        std::abort();
    }
}

// All low sides on, as the configuration says: the short circuit of a motor that is too fast for
// open gates.
bool is_shorted(const drive_t &drive, const drive_out_t &out)
{
    const auto &phase = out.compare.phase;
    return drive.cfg->safe_state.open_speed > 0 && out.gate_enable && phase[0] == 0 &&
           phase[1] == 0 && phase[2] == 0;
}

bool may_drive(drive_state_t state)
{
    return state > DRIVE_STATE_READY && state < DRIVE_STATE_FAULT;
}

} // namespace

void configuration_holds(const drive_cfg_t &cfg)
{
    const bool starts_up = cfg.startup.current_hold != 0;
    const bool drives_voltage = cfg.voltage_drive.enabled != 0;
    if (starts_up) {
        within("cfg.sampling.sensor_pole_pairs", cfg.sampling.sensor_pole_pairs, 0, 0);
    }
#define ROW(used, path, lowest, highest) \
    if (used) { \
        within("cfg." #path, static_cast<int64_t>(cfg.path), lowest, highest); \
    }
#define CFG(path, when, lo, hi, quantity, meaning) ROW(true, path, lo, hi)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) ROW(starts_up, path, lo, hi)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    ROW(true, path, starts_up ? (lo_startup) : (lo), hi)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) ROW(drives_voltage, path, lo, hi)
#include "cfg.def"
#undef CFG
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
#undef ROW
}

void tick_holds(drive_state_t before, const drive_t &drive, const drive_in_t &in,
                const drive_out_t &out)
{
    const bool run = (in.command.request & DRIVE_REQUEST_RUN) != 0;
    const bool probe = (in.command.request & DRIVE_REQUEST_PROBE) != 0;
    const bool clear = (in.command.request & DRIVE_REQUEST_CLEAR) != 0;
    state_holds(drive);
    for (const uint16_t compare : out.compare.phase) {
        within("a compare value", compare, 0, drive.cfg->modulator.timer_counts);
    }
    const bool drives = out.gate_enable && !(is_shorted(drive, out) && !may_drive(drive.state));
    HOLDS(!drives || may_drive(drive.state),
          "gates on only from FLYING_START to RUN, or all low sides where that is configured");
    HOLDS(!drives || (drive.state == DRIVE_STATE_PROBE ? probe : run),
          "gates on only while it shall run, or shall measure the motor");
    HOLDS((in.flags & DRIVE_FLAG_BREAK) == 0 || !out.gate_enable,
          "a break opens the gates in its tick");
    HOLDS((in.flags & DRIVE_FLAG_BREAK) == 0 || drive.state == DRIVE_STATE_FAULT,
          "a break is a fault in its tick");
    HOLDS(drive.state != DRIVE_STATE_FAULT || drive.fault.id != FAULT_NONE, "FAULT has a fault");
    HOLDS(before != DRIVE_STATE_FAULT || drive.state == DRIVE_STATE_FAULT || (clear && !run),
          "FAULT is latched");
}

void step_holds(drive_t &drive, const drive_in_t &in, drive_out_t &out)
{
    const drive_state_t before = drive.state;
    drive_step(&drive, &in, &out);
    tick_holds(before, drive, in, out);
}

} // namespace fuzz
