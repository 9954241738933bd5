// SPDX-License-Identifier: MIT
#include "replay.h"

#include "fault_line.h"
#include "names.h"

extern "C" {
#include "drive_words.h"
}

#include <fmt/format.h>

namespace nf::replay
{
namespace
{

std::optional<Difference> compare(int64_t tick, const drive_out_t &recorded,
                                  const drive_out_t &computed)
{
    for (std::size_t leg = 0; leg < 3; leg++) {
        const uint16_t then = recorded.compare.phase[leg];
        const uint16_t now = computed.compare.phase[leg];
        if (then != now) {
            return Difference{tick, fmt::format("out.compare.phase[{}]", leg), then, now};
        }
    }
    if (recorded.gate_enable != computed.gate_enable) {
        return Difference{tick, "out.gate_enable", recorded.gate_enable ? 1 : 0,
                          computed.gate_enable ? 1 : 0};
    }
    return std::nullopt;
}

// A reset leaves no state at the end to compare with.
std::optional<Difference> compare_end(const Recording &recording, const drive_t &drive)
{
    const recorder_header_t &h = recording.header;
    if (h.about.cut != 0) {
        return std::nullopt;
    }
    const int64_t last = recording.last();
    const fault_id_t id = drive.state == DRIVE_STATE_FAULT ? drive.fault.id : FAULT_NONE;
    if (static_cast<uint32_t>(id) != h.fault_id) {
        return Difference{last, "drive.fault.id", h.fault_id, id};
    }
    if (id != FAULT_NONE && drive.fault.tick != h.fault_tick) {
        return Difference{last, "drive.fault.tick", h.fault_tick, drive.fault.tick};
    }
    const uint32_t hash = drive_words_hash(&drive);
    if (hash != h.end_hash) {
        return Difference{last, "the state's hash", h.end_hash, hash};
    }
    return std::nullopt;
}

// The fault in which the recording ends. If a reset has cut it, only the replay knows.
fault_t fault_at_end(const Recording &recording, const Result &result)
{
    if (recording.header.about.cut == 0) {
        return recording.fault();
    }
    const fault_t &latched = result.fault;
    return result.state == DRIVE_STATE_FAULT ? latched : fault_t{};
}

std::string end_text(const Recording &recording, const Result &result)
{
    const Bases &bases = recording.run.image.bases;
    const FoundFault fault = {fault_at_end(recording, result), result.fault.swing_hz,
                              result.fault.advice};
    if (fault.id == FAULT_NONE) {
        return fmt::format("  ends in {}, speed {:.0f} rpm\n", state_name(result.state),
                           result.speed_rpm);
    }
    const int64_t at = recording.run.tick_of(fault.tick);
    return fmt::format("  fault at tick {}, {:.4f} s before the end, at {:.0f} rpm: {}\n", at,
                       static_cast<double>(recording.last() - at) * bases.control_period_s,
                       result.speed_rpm, fault_measure(fault, bases));
}

std::string verdict(const Recording &recording, const Result &result)
{
    if (!result.difference) {
        const bool cut = recording.header.about.cut != 0;
        return fmt::format("  replayed: the outputs of all {} ticks{} are those recorded\n",
                           recording.run.outputs.size(),
                           cut ? "" : fmt::format(" and the state's hash {:08x}", result.end_hash));
    }
    const Difference &d = *result.difference;
    const bool hash = d.signal.rfind("the ", 0) == 0; // of a state or of outputs
    return fmt::format("  departs at tick {}: {}, recorded {}, computed {}\n", d.tick, d.signal,
                       hash ? fmt::format("{:08x}", d.recorded) : std::to_string(d.recorded),
                       hash ? fmt::format("{:08x}", d.computed) : std::to_string(d.computed));
}

std::string changes_text(const Recording &recording)
{
    std::string text;
    for (const ConfigChange &change : recording.run.changes) {
        text += fmt::format("  configuration {:08x} from tick {} on\n", change.cfg.crc,
                            recording.run.first() + static_cast<int64_t>(change.frame));
    }
    return text;
}

} // namespace

Result replay(const Recording &recording)
{
    const DriveImage &image = recording.run.image;
    drive_t drive = image.state;
    drive.cfg = &image.cfg;
    Result result{};
    step_t speed = drive_speed(&drive);
    auto change = recording.run.changes.begin();
    for (std::size_t k = 0; k < recording.run.outputs.size(); k++) {
        const int64_t tick = recording.run.first() + static_cast<int64_t>(k);
        drive_out_t out{};
        for (; change != recording.run.changes.end() && change->frame == k; ++change) {
            drive_change(&drive, &change->cfg);
        }
        if (drive.state != DRIVE_STATE_FAULT) {
            speed = drive_speed(&drive);
        }
        drive_step(&drive, &recording.run.frames[k], &out);
        if (!result.difference) {
            result.difference = compare(tick, recording.run.outputs[k], out);
        }
    }
    if (!result.difference && recording.departure) {
        const Departure &found = *recording.departure;
        result.difference = {
            found.first,
            fmt::format("the CRC of the outputs of ticks {} to {}", found.first, found.last),
            found.recorded, found.computed};
    }
    if (!result.difference) {
        result.difference = compare_end(recording, drive);
    }
    result.end_hash = drive_words_hash(&drive);
    result.fault = found_fault(drive, image.bases);
    result.state = drive.state;
    result.speed_rpm = image.bases.rpm_from_step(speed);
    return result;
}

int64_t tick_of_interest(const Recording &recording, const Result &result)
{
    const fault_t fault = fault_at_end(recording, result);
    const int64_t at = recording.run.tick_of(fault.tick);
    const bool seen =
        fault.id != FAULT_NONE && at >= recording.run.first() && at <= recording.last();
    const int64_t end = seen ? at : recording.last();
    return result.difference ? result.difference->tick : end;
}

std::string summary(const Recording &recording, const Result &result)
{
    const double period_s = recording.run.image.bases.control_period_s;
    const std::string build = recording.build();
    return fmt::format("{}\n  build {}, configuration {:08x}\n"
                       "  ticks {} to {}: {} of {:g} us, {:.4f} s\n",
                       recording.name(), build.empty() ? "of the simulator" : build,
                       recording.run.image.cfg.crc, recording.run.first(), recording.last(),
                       recording.run.outputs.size(), period_s * 1e6,
                       static_cast<double>(recording.run.outputs.size()) * period_s) +
           (recording.remark.empty() ? "" : fmt::format("  {}\n", recording.remark)) +
           (recording.reset().empty() ? "" : fmt::format("  {}\n", recording.reset())) +
           changes_text(recording) + end_text(recording, result) + verdict(recording, result);
}

} // namespace nf::replay
