// SPDX-License-Identifier: MIT
#include "measure.h"

#include <cmath>

extern "C" {
#include "identify.h"
}

namespace nf::identify
{
namespace
{

constexpr double LONGEST_S = 130;                 // the firmware ends it after 120
constexpr std::size_t LINE_END = 2;               // CR, LF
const std::string REFUSED = "identify refused: "; // last line, with the cause behind it

about_t about_of(const Simulation &sim)
{
    const Bases &bases = sim.bases();
    constexpr double pico = 1e12;
    constexpr double micro = 1e6;
    const auto whole = [](double value) { return static_cast<uint32_t>(std::lround(value)); };
    about_t about{};
    about.rotation.tick_ps = whole(bases.control_period_s * pico);
    about.rotation.pole_pairs = static_cast<uint32_t>(bases.pole_pairs);
    about.current_zero_count =
        static_cast<uint16_t>(1U << (14U - sim.cfg().sampling.current_shift));
    about.current_full_scale_ua = whole(bases.current_a / 2 * micro);
    about.bus_full_scale_uv = whole(bases.voltage_v * micro);
    return about;
}

} // namespace

Measurement measure(Simulation &sim, const Listener &listener, const Event &event)
{
    const about_t about = about_of(sim);
    const double tick_s = sim.bases().control_period_s;
    Measurement found;
    identify_t identify;
    identify_init(&identify, &sim.app(), &about);
    bool started = false;
    for (; found.duration_s < LONGEST_S && (!started || identify_is_busy(&identify));
         found.duration_s += tick_s) {
        if (event) {
            event(sim);
        }
        sim.control();
        sim.advance();
        if (!started && sim.drive().state == DRIVE_STATE_READY) {
            const char *const why = identify_start(&identify);
            found.refusal = why == nullptr ? "" : why;
            started = true;
        }
        text_t text{};
        identify_step(&identify, &text);
        if (text.length > LINE_END) {
            found.lines.emplace_back(text.characters, text.length - LINE_END);
            if (listener) {
                listener(found.lines.back());
            }
        }
    }
    if (identify.why != nullptr && !found.lines.empty()) {
        found.refusal = found.lines.back().substr(REFUSED.length());
    }
    return found;
}

} // namespace nf::identify
