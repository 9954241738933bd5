// SPDX-License-Identifier: MIT
#include "measure.h"

#include <cmath>

extern "C" {
#include "identify.h"
}

namespace nf::identify
{

Measurement measure(Simulation &sim, const std::function<void(const Simulation &)> &each)
{
    constexpr double LONGEST_S = 60;
    Measurement found;
    about_t about{};
    about.rotation.pole_pairs = static_cast<uint32_t>(sim.bases().pole_pairs);
    about.current_full_scale_ua =
        static_cast<uint32_t>(std::lround(sim.bases().current_a / 2 * 1e6));
    about.bus_full_scale_uv = static_cast<uint32_t>(std::lround(sim.bases().voltage_v * 1e6));
    about.rotation.tick_ps =
        static_cast<uint32_t>(std::lround(sim.bases().control_period_s * 1e12));
    identify_t identify;
    identify_init(&identify, &sim.app(), &about);
    const auto longest = static_cast<int64_t>(LONGEST_S / sim.bases().control_period_s);
    bool started = false;
    for (int64_t tick = 0; tick < longest; tick++) {
        sim.control();
        if (each) {
            each(sim);
        }
        sim.advance();
        text_t text{};
        if (!started && sim.drive().state == DRIVE_STATE_READY) {
            const char *const why = identify_start(&identify);
            started = true;
            if (why != nullptr) {
                found.refusal = why;
                break;
            }
        }
        identify_step(&identify, &text);
        if (text.length > 0) {
            found.lines.emplace_back(text.characters, text.length - 2);
        }
        found.duration_s = static_cast<double>(tick) * sim.bases().control_period_s;
        if (identify.why != nullptr) {
            found.refusal = identify.why;
        }
        if (started && !identify_is_busy(&identify)) {
            break;
        }
    }
    return found;
}

} // namespace nf::identify
