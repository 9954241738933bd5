// SPDX-License-Identifier: MIT
// Any frames, from a state that a run with a shipped motor, board and tuning has been in.
//
// The first byte chooses the state. Then changes of the frame, each with a byte that says what
// changes: see next_frame().
#include "bytes.h"
#include "drive_holds.h"
#include "fuzzed.h"
#include "scripted_run.h"

extern "C" {
#include "transitions.h"
}

#include <memory>
#include <vector>

namespace
{

constexpr int TICKS_MAX = 4096;  // of an input
constexpr std::size_t PARTS = 8; // of a state, at most

struct Start {
    drive_cfg_t cfg;
    drive_t drive;
    drive_in_t in;
};

struct Source {
    const char *scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
};

// Where the drive is: a state, or a part of one.
std::size_t place(const drive_t &drive)
{
    std::size_t part = drive.voltage_drive.active ? 1 : 0;
    if (drive.state == DRIVE_STATE_ALIGN) {
        part = drive.start.align.phase;
    } else if (drive.state == DRIVE_STATE_FLYING_START) {
        part = drive.start.flying_start.phase;
    }
    return static_cast<std::size_t>(transitions_number(drive.state)) * PARTS + part;
}

// The first tick of each place that a run comes through, and its last tick.
void add_starts(const Source &source, std::vector<Start> &starts)
{
    const nf::Config config = nf::load_scenario(source.scenario, source.with, source.set);
    nf::ScriptedRun run(config);
    const drive_cfg_t cfg = run.sim().cfg();
    fuzz::configuration_holds(cfg);
    std::vector<bool> seen(DRIVE_STATES * PARTS);
    while (run.tick() < run.end()) {
        const nf::Tick tick = run.control();
        const drive_t &drive = tick.sim->drive();
        const bool last = run.tick() + 1 == run.end();
        if (last || !seen[place(drive)]) {
            seen[place(drive)] = true;
            starts.push_back({cfg, drive, tick.sim->in()});
        }
        run.advance();
    }
}

const std::vector<Start> &starts()
{
    static const std::vector<Start> all = [] {
        // As long as a start takes.
        const std::vector<std::string> brief = {"scenario.duration_s=0.25",
                                                "scenario.evaluate_from_s=0"};
        std::vector<Start> found;
        for (const Source &source : std::vector<Source>{
                 {"s1", {}, brief},
                 {"s1_robust", {"all"}, brief},
                 {"s3_robust", {}, brief},
                 {"s4", {}, {"scenario.prelude_s=0.5", "scenario.duration_s=0.25"}},
                 {"s5", {}, {"scenario.duration_s=0.1"}},
                 {"s1_odrive_d5065", {}, brief},
                 {"s1_teknic_m2310p", {}, brief},
                 {"s1_robust", {}, {"scenario.initial_speed_rpm=-900", brief[0], brief[1]}},
             }) {
            add_starts(source, found);
        }
        return found;
    }();
    return all;
}

struct Changes {
    static constexpr unsigned small_currents = 0x01;
    static constexpr unsigned currents = 0x02;
    static constexpr unsigned bus = 0x04;
    static constexpr unsigned flags = 0x08;
    static constexpr unsigned command = 0x10;
    static constexpr unsigned request = 0x20;
    static constexpr unsigned slow = 0x40;
    static constexpr unsigned often = 0x80;
};

// Within a quarter of the converter's range.
uint16_t small_current(uint8_t byte, uint32_t shift)
{
    const int middle = 16384 >> shift;
    return static_cast<uint16_t>(middle + static_cast<int8_t>(byte) * (middle / 512));
}

void change_command(fuzz::Bytes &bytes, unsigned what, drive_command_t &command)
{
    if ((what & Changes::command) != 0) {
        command.target = static_cast<int32_t>(bytes.word());
        command.mode = bytes.byte();
    }
    if ((what & Changes::request) != 0) {
        command.request = bytes.byte();
    }
}

void change_measured(fuzz::Bytes &bytes, unsigned what, uint32_t shift, drive_in_t &in)
{
    if ((what & Changes::small_currents) != 0) {
        in.adc_ia = small_current(bytes.byte(), shift);
        in.adc_ib = small_current(bytes.byte(), shift);
    }
    if ((what & Changes::currents) != 0) {
        in.adc_ia = bytes.half();
        in.adc_ib = bytes.half();
    }
    if ((what & Changes::bus) != 0) {
        in.adc_bus = bytes.half();
    }
    if ((what & Changes::flags) != 0) {
        in.flags = bytes.half();
    }
}

// How the shaft turns while a frame stays; how often it does.
struct Stay {
    uint16_t turn = 0;
    int ticks = 1;
};

Stay next_frame(fuzz::Bytes &bytes, uint32_t shift, drive_in_t &in)
{
    Stay stay;
    const unsigned what = bytes.byte();
    change_measured(bytes, what, shift, in);
    change_command(bytes, what, in.command);
    if ((what & Changes::slow) != 0) {
        in.adc_temperature = bytes.half();
        in.angle = bytes.half();
        stay.turn = bytes.half();
    }
    if ((what & Changes::often) != 0) {
        stay.ticks = 1 + bytes.byte();
    }
    return stay;
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz::Bytes bytes(data, size);
    const Start &start = starts()[bytes.byte() % starts().size()];
    drive_t drive = start.drive;
    drive_in_t in = start.in;
    drive_out_t out{};
    drive.cfg = &start.cfg;
    for (int ticks = 0; ticks < TICKS_MAX && !bytes.empty();) {
        const Stay stay = next_frame(bytes, start.cfg.sampling.current_shift, in);
        for (int k = 0; k < stay.ticks; k++) {
            fuzz::step_holds(drive, in, out);
            in.angle = static_cast<uint16_t>(in.angle + stay.turn);
        }
        ticks += stay.ticks;
    }
    return 0;
}
