// SPDX-License-Identifier: MIT
#include "measure.h"

#include <cmath>

#include <fmt/format.h>

extern "C" {
#include "fault_text.h"
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

// From power-up on: starts the identification as soon as the drive is READY.
class Starter
{
public:
    // Whether the run goes on.
    bool step(identify_t &identify, const drive_t &drive, std::string &refusal)
    {
        if (!started_ && drive.state == DRIVE_STATE_FAULT) {
            refusal = fmt::format("the drive has a fault before it is READY: {}",
                                  fault_text(drive.fault.id)->name);
        } else if (!started_ && drive.state == DRIVE_STATE_READY) {
            const char *const why = identify_start(&identify);
            refusal = why == nullptr ? "" : why;
            started_ = true;
        }
        return refusal.empty();
    }

    bool has_started() const
    {
        return started_;
    }

private:
    bool started_ = false;
};

std::string overtime(bool started)
{
    return fmt::format(started ? "it has not ended within {:.0f} s"
                               : "the drive is not READY after {:.0f} s",
                       LONGEST_S);
}

// Its line, if there is one.
void take_line(identify_t &identify, Measurement &found, const Listener &listener)
{
    text_t text{};
    identify_step(&identify, &text);
    if (text.length > LINE_END) {
        found.lines.emplace_back(text.characters, text.length - LINE_END);
        if (listener) {
            listener(found.lines.back());
        }
    }
}

} // namespace

Measurement measure(Simulation &sim, const Listener &listener, const Event &event)
{
    const about_t about = about_of(sim);
    const double tick_s = sim.bases().control_period_s;
    Measurement found;
    identify_t identify;
    Starter starter;
    identify_init(&identify, &sim.app(), &about);
    while (found.refusal.empty() && (!starter.has_started() || identify_is_busy(&identify))) {
        if (event) {
            event(sim);
        }
        sim.control();
        sim.advance();
        if (starter.step(identify, sim.drive(), found.refusal)) {
            take_line(identify, found, listener);
        }
        found.duration_s += tick_s;
        if (found.duration_s > LONGEST_S) {
            found.refusal = overtime(starter.has_started());
        }
    }
    if (!found.lines.empty() && found.lines.back().rfind(REFUSED, 0) == 0) {
        found.refusal = found.lines.back().substr(REFUSED.length());
    }
    return found;
}

} // namespace nf::identify
