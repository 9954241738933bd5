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

constexpr uint32_t POST_TICKS = 64;

uint32_t rounded(double value)
{
    return static_cast<uint32_t>(std::llround(value));
}

// In the units of a board's firmware (hal_header.cpp).
recorder_about_t about(const Config &config)
{
    constexpr double NANO = 1e-9;
    constexpr double MILLI = 1e-3;
    constexpr double Q16 = 65536.0;
    const Bases bases = make_bases(config.motor, config.board);
    recorder_about_t about{};
    about.tick_ns = rounded(bases.control_period_s / NANO);
    about.current_full_scale_ma = rounded(config.board.current_full_scale_a / MILLI);
    about.bus_full_scale_mv = rounded(config.board.bus_full_scale_v / MILLI);
    about.step_per_rpm_q16 = rounded(bases.step_from_rpm(1.0) * Q16);
    recorder_about_name(&about, fmt::format("neurofoc: {}, {}, {}", config.motor.name,
                                            config.board.name, config.tuning.name)
                                    .c_str());
    return about;
}

} // namespace

Writer::Writer(const Config &config)
    : about_(about(config)),
      entries_(std::size_t{RECORDER_SEGMENTS} * recorder_segment_entries(config.board))
{
    if (recorder_init(&recorder_, entries_.data(), recorder_segment_entries(config.board),
                      POST_TICKS) != nullptr) {
        throw std::logic_error("the recorder refuses its size");
    }
}

void Writer::add(const Tick &tick)
{
    const Simulation &sim = *tick.sim;
    recorder_step(&recorder_, &sim.drive(), &sim.in(), &sim.out());
    recorder_service(&recorder_, &sim.drive());
    cfg_ = sim.cfg();
    drive_ = sim.drive();
    drive_.cfg = &cfg_;
    in_ = sim.in();
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
    recorder_dump_start(&dump, &recorder_, &cfg_, &about_);
    std::string text;
    std::array<char, RECORDER_LINE_CHARACTERS + 1> line{};
    while (recorder_dump_line(&dump, line.data())) {
        text += line.data();
        text += '\n';
    }
    return text;
}

} // namespace nf::replay
