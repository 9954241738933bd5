// SPDX-License-Identifier: MIT
#include "session.h"

#include "names.h"

extern "C" {
#include "fault_text.h"
}

#include <cmath>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

constexpr const char *INTERRUPTED = "interrupted";

// RUN has a second form.
std::string state_text(const drive_t &drive)
{
    const bool driven = drive.state == DRIVE_STATE_RUN && drive.voltage_drive.active;
    return fmt::format("{}{}", state_and_gates(drive), driven ? ", voltage-driven" : "");
}

} // namespace

// What holds already where a run begins does not stop it.
void Session::arm()
{
    for (Break &one : breaks) {
        one.last = one.value(timeline.tick());
    }
}

const Break *Session::struck()
{
    const Break *found = nullptr;
    for (Break &one : breaks) {
        const double value = one.value(timeline.tick());
        const bool changed = is_true(value - one.last);
        if (changed && (one.on_change || (is_true(value) && !is_true(one.last)))) {
            found = found == nullptr ? &one : found;
        }
        one.last = value;
    }
    return found;
}

std::string Session::run_until(const Value &condition, const std::string &text)
{
    arm();
    wanted.reset();
    while (timeline.step()) {
        if (const Break *const one = struck()) {
            return fmt::format("break on {}", one->text);
        }
        if (condition && is_true(condition(timeline.tick()))) {
            return text;
        }
        if (stop()) {
            return INTERRUPTED;
        }
    }
    return "end of the scenario";
}

std::string Session::go_to(int64_t tick)
{
    wanted.reset();
    if (timeline.go_to(tick, stop)) {
        return "";
    }
    wanted = tick;
    return fmt::format("stopped: {}\n", INTERRUPTED);
}

std::string Session::position_text() const
{
    const Tick &tick = timeline.tick();
    const drive_t &drive = tick.sim->drive();
    const double rpm = si_value(*find_signal("speed_estimated_rpm"), tick);
    const std::string estimated =
        std::isnan(rpm) ? "speed unknown to the drive" : fmt::format("estimated {:.1f} rpm", rpm);
    const std::string speed =
        timeline.run().is_recorded()
            ? estimated
            : fmt::format("{:.1f} rpm, {}", si_value(*find_signal("speed_rpm"), tick), estimated);
    std::string text = fmt::format("tick {}  t = {:.4f} s  {}  {}", timeline.now(), tick.time_s,
                                   state_text(drive), speed);
    if (drive.state == DRIVE_STATE_FAULT) {
        text += fmt::format("  {}", fault_text(drive.fault.id)->name);
    }
    for (const Named &named : watched) {
        text += "\n  " + signal_line(named, tick);
    }
    return text + '\n';
}

} // namespace nf::debug
