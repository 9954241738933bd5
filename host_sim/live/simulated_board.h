/* SPDX-License-Identifier: MIT */
// A whole board in this program: the firmware with flight recorder, store, console and link, on the
// motor of a scenario, at a serial line of the board's baud rate.
//
// A tick is the control interrupt, one pass of the background, and a PWM period of the plant and of
// the line. So all that happens depends on the configuration and on the bytes that come in, and on
// the ticks in which they do.
//
// The scenario's script commands the drive until the console or the link does; its load and its
// faults go on.
#pragma once

#include "channel.h"
#include "scripted_run.h"

extern "C" {
#include "box.h"
#include "commander.h"
#include "link.h"
}

#include <string>
#include <vector>

namespace nf::live
{

class SimulatedBoard
{
public:
    // The ring of the recorder has at least the entries of board.recorder_entries where no file
    // says it. With an erased flash, or with a copy of one: as another start of the board that left
    // it so. The configuration outlives the board. Throws ConfigError.
    explicit SimulatedBoard(const Config &config, const hal_host_flash_t *flash = nullptr);
    // Drive, line and background keep places of each other.
    SimulatedBoard(const SimulatedBoard &) = delete;
    SimulatedBoard &operator=(const SimulatedBoard &) = delete;

    // What the control interrupt of this tick has computed.
    Tick tick();

    // The PC's side of the line. put() does what has no room at once in later ticks.
    void put(const std::vector<uint8_t> &bytes);
    std::vector<uint8_t> take();

    // Since power-up.
    double now_s() const
    {
        return static_cast<double>(run_.tick()) * run_.sim().bases().control_period_s;
    }
    // Whether the scenario's script still commands the drive.
    bool follows_script() const
    {
        return run_.is_commanded();
    }
    // When the script ends.
    double script_s() const
    {
        return static_cast<double>(run_.end()) * run_.sim().bases().control_period_s;
    }
    const ScriptedRun &run() const
    {
        return run_;
    }
    const link_t &link() const
    {
        return link_;
    }
    const hal_host_line_t &line() const
    {
        return line_;
    }
    hal_host_flash_t &flash()
    {
        return flash_;
    }
    // Throttle, button and pulses, for whoever simulates them.
    hal_host_inputs_t &inputs()
    {
        return inputs_;
    }

private:
    void start(const Config &config);
    void greet();
    void background();

    std::string name_;
    about_t about_;
    drive_cfg_t cfg_; // of the image
    ScriptedRun run_;
    hal_host_line_t line_{};
    hal_host_flash_t flash_{};
    hal_host_inputs_t inputs_{};
    std::vector<recorder_entry_t> ring_;
    recorder_t recorder_{};
    live_config_t live_{};
    fault_log_t faults_{};
    box_t box_{};
    link_t link_{};
    std::vector<uint8_t> waiting_; // for room on the line
};

// Its line, for a client in the same program. Its clock is the board's, and reading lets the board
// run.
class BoardChannel : public Channel
{
public:
    // The board outlives it. `sink`, which may be NULL, looks at each tick.
    explicit BoardChannel(SimulatedBoard &board, TickSink *sink = nullptr)
        : board_(board), sink_(sink)
    {
    }

    std::vector<uint8_t> read(double wait_s) override;
    void write(const std::vector<uint8_t> &bytes) override;
    double now_s() const override
    {
        return board_.now_s();
    }

private:
    SimulatedBoard &board_;
    TickSink *sink_;
};

} // namespace nf::live
