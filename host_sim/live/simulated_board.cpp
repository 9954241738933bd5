// SPDX-License-Identifier: MIT
#include "simulated_board.h"

#include "about_text.h"
#include "header.h"
#include "identity.h"
#include "temperature_sensor.h"
#include "writer.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr double MILLI = 1e-3;
constexpr double MICRO = 1e-6;

template <typename Integer> Integer rounded(double value)
{
    return static_cast<Integer>(std::llround(value));
}

temperature_line_t temperature_of(const BoardSettings &board)
{
    temperature_line_t line{};
    for (const double celsius : board.temperature_points_c) {
        auto &point = line.at[line.points++];
        point.count = rounded<int32_t>(temperature_count(board, celsius));
        point.mc = rounded<int32_t>(celsius / MILLI);
    }
    return line;
}

// As DRIVE_ABOUT of an image.
about_t about_of(const Config &config, const std::string &name)
{
    about_t about{};
    about.name = name.c_str();
    about.identity = identity_of(config);
    about.rotation.pole_pairs = static_cast<uint32_t>(config.motor.pole_pairs);
    about.rotation.tick_ps = tick_ps(config.board);
    about.speed_max_rpm = speed_max_rpm(config.motor);
    about.is_example = config.sources.motor_is_example ? 1 : 0;
    about.baud = static_cast<uint32_t>(config.board.baud);
    about.current_zero_count = static_cast<uint16_t>(1U << (config.board.adc_bits - 1));
    about.current_full_scale_ua = rounded<uint32_t>(config.board.current_full_scale_a / MICRO);
    about.bus_full_scale_uv = rounded<uint32_t>(config.board.bus_full_scale_v / MICRO);
    about.temperature = temperature_of(config.board);
    return about;
}

// Of a segment. A board whose RAM is small has a ring that is overwritten before a PC has read a
// state over a slow line; here there is room.
uint32_t segment_entries(const BoardSettings &board)
{
    return std::max(recorder_segment_entries(board), recorder_segment_entries({}));
}

} // namespace

SimulatedBoard::SimulatedBoard(const Config &config, const hal_host_flash_t *flash)
    : name_(about_name(config)), about_(about_of(config, name_)), cfg_(build(config)), run_(config),
      ring_(std::size_t{RECORDER_SEGMENTS} * segment_entries(config.board))
{
    if (flash == nullptr) {
        hal_host_flash_init(&flash_, config.scenario.seed);
    } else {
        flash_ = *flash;
    }
    hal_host_line_init(&line_, about_.baud, about_.rotation.tick_ps);
    start(config);
    greet();
}

void SimulatedBoard::start(const Config &config)
{
    Simulation &sim = run_.sim();
    sim.hal().line = &line_;
    sim.hal().flash = &flash_;
    hal_host_inputs_init(&inputs_, about_.rotation.tick_ps);
    sim.hal().inputs = &inputs_;
    sim.hal().reset.reason = HAL_RESET_SUPPLY;
    live_config_init(&live_, &sim.app(), &sim.hal(), &about_, &cfg_);
    link_init(&link_, &live_);
    run_.start(live_.in_force->cfg);
    if (recorder_init(&recorder_, ring_.data(), segment_entries(config.board),
                      replay::POST_TICKS) != nullptr) {
        throw std::logic_error("the recorder refuses its size");
    }
    app_record(&sim.app(), &recorder_);
    box_init(&box_, &sim.app(), &sim.hal(), &live_.about, &faults_, true);
}

// As an image does.
void SimulatedBoard::greet()
{
    link_say(&link_, live_.about.name);
    stored_config_tell(&link_.console.out, &live_.stored);
    link_say(&link_, "");
    box_tell_start(&link_.console.out, &box_);
    link_say(&link_, "");
}

// What is taken back of the script's requests is so before the line is heard: whatever is posted
// then is a user's. A post puts the other slot in force; two of them have the same one, and another
// command.
void SimulatedBoard::background()
{
    app_t &app = run_.sim().app();
    commander_step(&app);
    const uint32_t in_force = app.mailbox.in_force;
    const drive_command_t before = command_mailbox_take(&app.mailbox);
    recorder_service(&recorder_, &app.drive);
    link_step(&link_);
    const drive_command_t after = command_mailbox_take(&app.mailbox);
    if (app.mailbox.in_force != in_force || after.request != before.request ||
        after.mode != before.mode || after.target != before.target) {
        run_.leave_to_user();
    }
}

Tick SimulatedBoard::tick()
{
    std::size_t sent = 0;
    while (sent < waiting_.size() && hal_host_line_write(&line_, waiting_[sent])) {
        sent++;
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(sent));
    const Tick tick = run_.control();
    background();
    run_.advance();
    return tick;
}

void SimulatedBoard::put(const std::vector<uint8_t> &bytes)
{
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

std::vector<uint8_t> SimulatedBoard::take()
{
    std::vector<uint8_t> bytes;
    for (uint8_t byte = 0; hal_host_line_read(&line_, &byte);) {
        bytes.push_back(byte);
    }
    return bytes;
}

std::vector<uint8_t> BoardChannel::read(double wait_s)
{
    const double until_s = board_.now_s() + wait_s;
    std::vector<uint8_t> bytes = board_.take();
    while (bytes.empty() && board_.now_s() < until_s) {
        const Tick tick = board_.tick();
        if (sink_ != nullptr) {
            sink_->add(tick);
        }
        bytes = board_.take();
    }
    return bytes;
}

void BoardChannel::write(const std::vector<uint8_t> &bytes)
{
    board_.put(bytes);
}

} // namespace nf::live
