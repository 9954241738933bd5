// SPDX-License-Identifier: MIT
#include "writer.h"

#include "header.h"
#include "recording.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace nf::replay
{
namespace
{

uint32_t rounded(double value)
{
    return static_cast<uint32_t>(std::llround(value));
}

} // namespace

recorder_about_t about(const Config &config)
{
    constexpr double PICO = 1e-12;
    constexpr double MICRO = 1e-6;
    recorder_about_t about{};
    about.tick_ps = rounded(1 / config.board.pwm_frequency_hz / PICO);
    about.current_full_scale_ua = rounded(config.board.current_full_scale_a / MICRO);
    about.bus_full_scale_uv = rounded(config.board.bus_full_scale_v / MICRO);
    about.pole_pairs = static_cast<uint32_t>(config.motor.pole_pairs);
    recorder_about_name(&about, fmt::format("neurofoc: {}, {}, {}", config.motor.name,
                                            config.board.name, config.tuning.name)
                                    .c_str());
    return about;
}

Writer::Writer(const Config &config)
    : Writer(about(config), recorder_segment_entries(config.board), Until::fault)
{
}

Writer::Writer(const recorder_about_t &about, uint32_t segment_entries, Until until)
    : about_(about), entries_(std::size_t{RECORDER_SEGMENTS} * segment_entries)
{
    if (recorder_init(&recorder_, entries_.data(), segment_entries, POST_TICKS) != nullptr) {
        throw std::logic_error("the recorder refuses its size");
    }
    recorder_follow(&recorder_, until == Until::end);
}

void Writer::add(const Tick &tick)
{
    const Simulation &sim = *tick.sim;
    const bool changed = source_ != nullptr && sim.drive().cfg != source_;
    source_ = sim.drive().cfg;
    if (changed) {
        recorder_change(&recorder_, &cfgs_[in_force_]);
        in_force_ = 1 - in_force_;
    }
    cfgs_[in_force_] = sim.cfg();
    drive_ = sim.drive();
    drive_.cfg = &cfgs_[in_force_];
    in_ = sim.in();
    recorder_step(&recorder_, &drive_, &in_, &sim.out());
    recorder_service(&recorder_, &drive_);
}

// It closes in the tick behind the last.
void Writer::freeze()
{
    recorder_hold(&recorder_, &drive_);
    while (!recorder_.frozen) {
        drive_out_t out{};
        recorder_service(&recorder_, &drive_);
        drive_step(&drive_, &in_, &out);
        recorder_step(&recorder_, &drive_, &in_, &out);
    }
}

std::string Writer::text()
{
    freeze();
    recorder_dump_t dump{};
    recorder_dump_start(&dump, &recorder_, &about_);
    std::string text;
    std::array<char, RECORDER_LINE_CHARACTERS + 1> line{};
    while (recorder_dump_line(&dump, line.data())) {
        text += line.data();
        text += '\n';
    }
    return text;
}

} // namespace nf::replay
