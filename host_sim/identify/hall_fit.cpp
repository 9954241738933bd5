// SPDX-License-Identifier: MIT
#include "hall_fit.h"

#include "bars.h"
#include "si.h"

extern "C" {
#include "hall.h"
}

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace nf::identify
{
namespace
{

constexpr std::size_t SIGNALS = 3;
constexpr std::size_t EDGES = 6;
constexpr double DEG = 180 / PI;
constexpr double FLUX_OFF = 0.25;       // of φ: with more the rotor has not followed the vector
constexpr double HIGH_LEAST = 0.02;     // of a turn: a signal that is high or low for less is stuck
constexpr double SCATTER_MOST_DEG = 15; // of an edge: half of what two sensors may be off
constexpr double ALIKE_DEG = 12;        // two signals whose edges are nearer are one
constexpr double SECTOR_MOST_DEG = 180; // which the decoder takes
constexpr double COGGING = 0.05;        // of the rated torque
constexpr double COGGING_PERIODS = 6;   // in an electrical turn, at least
constexpr double EMF_UNSURE = 0.5;      // of what the rotor's angles have in common
constexpr int PHASES = 64;              // of an edge on a tick, that are tried

// Within ±180°.
double wrapped(double deg)
{
    return std::remainder(deg, 360.0);
}

// High from `rise` to `fall`, forwards, whatever the direction of the turn.
struct Signal {
    double middle_deg = 0;
    double width_deg = 0;
    double scatter_deg = 0; // of an edge

    double rise_deg() const
    {
        return middle_deg - width_deg / 2;
    }
    double fall_deg() const
    {
        return middle_deg + width_deg / 2;
    }
};

// A signal that is high once in each turn, from the same edge to the same edge, has a vector of
// sin(w/2)/π. Edges that scatter by σ make it shorter by e^(−σ²/2).
Signal signal_of(const HallLevels &levels, double rotor_rad)
{
    const double most = std::sin(PI * levels.high) / PI;
    const double left = std::clamp(std::abs(levels.middle) / std::max(most, 1e-9), 1e-9, 1.0);
    Signal signal;
    signal.middle_deg = (std::arg(levels.middle) + rotor_rad) * DEG;
    signal.width_deg = 360 * levels.high;
    signal.scatter_deg = std::sqrt(-2 * std::log(left)) * DEG;
    return signal;
}

bool is_high(const Signal &signal, double deg)
{
    return std::abs(wrapped(deg - signal.middle_deg)) < signal.width_deg / 2;
}

// A window has a little more or less than whole turns. The levels in this rest are those of the
// same angles in the other turns, so they are taken out or put in.
HallLevels of_whole_turns(const HallLevels &levels, const Record &r)
{
    constexpr int parts = 64;
    const double direction = r.turns_el < 0 ? -1 : 1;
    const double turns = std::abs(r.turns_el);
    const double rest = turns - std::max(std::round(turns), 1.0);
    const Signal about = signal_of(levels, 0);
    HallLevels of_rest;
    for (int k = 0; k < parts; k++) {
        const double at_turns = r.start_turns + direction * rest * (k + 0.5) / parts;
        if (is_high(about, 360 * at_turns)) {
            of_rest.middle += std::polar(1.0 / parts, 2 * PI * at_turns);
            of_rest.high += 1.0 / parts;
        }
    }
    return {(levels.middle * turns - of_rest.middle * rest) / (turns - rest),
            (levels.high * turns - of_rest.high * rest) / (turns - rest)};
}

// How far the mean of the edges of a window may be off, in ticks: a turn takes `ticks`, so each
// edge falls on another part of a tick than the one before. The worst of all places of the first.
double worst_of_ticks(double ticks, int turns)
{
    double worst = 0;
    for (int phase = 0; phase < PHASES; phase++) {
        double sum = 0;
        for (int k = 0; k < turns; k++) {
            const double place = static_cast<double>(phase) / PHASES + k * ticks;
            sum += place - std::floor(place) - 0.5;
        }
        worst = std::max(worst, std::abs(sum) / turns);
    }
    return worst + 0.5 / PHASES;
}

struct Window {
    std::array<Signal, SIGNALS> signals;
    double rotor_rad = 0; // in the frame of the current
    double turns = 0;
    double tick_deg = 0; // that the vector turns in one
    double bound_deg = 0;
};

Window window_of(const Record &r, const Legs &legs, const Inductances &l)
{
    Window window;
    window.rotor_rad = std::arg(rotor_wb(r, legs, l));
    window.turns = std::abs(r.turns_el);
    window.tick_deg = 360 * window.turns / r.ticks;
    for (std::size_t k = 0; k < SIGNALS; k++) {
        window.signals[k] = signal_of(of_whole_turns(r.halls[k], r), window.rotor_rad);
    }
    const int whole = std::max(static_cast<int>(std::round(window.turns)), 1);
    window.bound_deg = worst_of_ticks(r.ticks / window.turns, whole) * window.tick_deg;
    return window;
}

struct Windows {
    std::vector<Window> backwards;
    std::vector<Window> forwards;
};

bool follows(const Record &r, const Legs &legs, const Inductances &l, const Flux &flux)
{
    return std::abs(r.turns_el) >= 1 &&
           std::abs(std::abs(rotor_wb(r, legs, l)) / flux.wb.value - 1) < FLUX_OFF;
}

// The mean of an angle over windows, near that of the first one, and its standard deviation.
template <typename Angle> Value mean_of(const std::vector<Window> &windows, Angle angle)
{
    const double first = angle(windows.front());
    double sum = 0;
    double squares = 0;
    for (const Window &window : windows) {
        const double apart = wrapped(angle(window) - first);
        sum += apart;
        squares += apart * apart;
    }
    const auto count = static_cast<double>(windows.size());
    const double mean = sum / count;
    const double variance = count > 1 ? (squares / count - mean * mean) / (count - 1) : 0;
    return {first + mean, std::sqrt(std::max(variance, 0.0)), 0};
}

// Of one direction: the mean over its windows.
struct Side {
    Value deg;
    double bound_deg;
};

template <typename Angle>
Side side_of(const std::vector<Window> &windows, std::size_t signal, Angle angle)
{
    Side side = {mean_of(windows, [&](const Window &w) { return angle(w.signals[signal]); }), 0};
    double turns = 0;
    double scatter = 0;
    for (const Window &window : windows) {
        const double sigma =
            std::hypot(window.signals[signal].scatter_deg, window.tick_deg / std::sqrt(12));
        scatter = std::max(scatter, sigma);
        turns += window.turns;
        side.bound_deg = std::max(side.bound_deg, window.bound_deg);
    }
    side.deg.std = std::hypot(side.deg.std, scatter / std::sqrt(turns));
    return side;
}

struct BothWays {
    Value deg;
    double late_deg = 0;
};

template <typename Angle> BothWays edge_of(const Windows &windows, std::size_t signal, Angle angle)
{
    const Side back = side_of(windows.backwards, signal, angle);
    const Side ahead = side_of(windows.forwards, signal, angle);
    const double late = wrapped(ahead.deg.value - back.deg.value) / 2;
    return {{back.deg.value + late, std::hypot(back.deg.std, ahead.deg.std) / 2,
             (back.bound_deg + ahead.bound_deg) / 2},
            late};
}

// ---- what is wrong ----

std::string stuck(const std::vector<Record> &records)
{
    for (std::size_t k = 0; k < SIGNALS; k++) {
        double least = 1;
        double most = 0;
        for (const Record &r : records) {
            least = std::min(least, r.halls[k].high);
            most = std::max(most, r.halls[k].high);
        }
        if (most < HIGH_LEAST) {
            return fmt::format("Hall signal {} stays low: is it shorted to ground, or has its "
                               "sensor no supply?",
                               k + 1);
        }
        if (least > 1 - HIGH_LEAST) {
            return fmt::format("Hall signal {} stays high: is its wire open?", k + 1);
        }
    }
    return "";
}

std::string scattered(const Windows &windows)
{
    for (std::size_t k = 0; k < SIGNALS; k++) {
        double scatter = 0;
        for (const auto *side : {&windows.backwards, &windows.forwards}) {
            for (const Window &window : *side) {
                scatter = std::max(scatter, window.signals[k].scatter_deg);
            }
        }
        if (scatter > SCATTER_MOST_DEG) {
            return fmt::format("Hall signal {} does not repeat in each electrical turn, its edges "
                               "scatter by {:.0f}°: is motor.pole_pairs right, is it disturbed?",
                               k + 1, scatter);
        }
    }
    return "";
}

std::string alike(const Window &window)
{
    for (std::size_t a = 0; a < SIGNALS; a++) {
        for (std::size_t b = a + 1; b < SIGNALS; b++) {
            const Signal &one = window.signals[a];
            const Signal &other = window.signals[b];
            if (std::abs(wrapped(one.rise_deg() - other.rise_deg())) < ALIKE_DEG &&
                std::abs(wrapped(one.fall_deg() - other.fall_deg())) < ALIKE_DEG) {
                return fmt::format("Hall signals {} and {} are the same: are their wires shorted "
                                   "to each other?",
                                   a + 1, b + 1);
            }
        }
    }
    return "";
}

uint32_t order_of(const std::array<HallEdge, EDGES> &edges, int inverted)
{
    uint32_t patterns = 0;
    for (std::size_t k = 0; k < EDGES; k++) {
        patterns |= static_cast<uint32_t>(edges[k].pattern ^ inverted) << (3 * k);
    }
    return patterns;
}

std::string out_of_order(const std::array<HallEdge, EDGES> &edges)
{
    if (hall_order_holds(order_of(edges, 0))) {
        return "";
    }
    for (int k = 0; k < static_cast<int>(SIGNALS); k++) {
        if (hall_order_holds(order_of(edges, 1 << k))) {
            return fmt::format("Hall signal {} is inverted against the other two (sensors 60° "
                               "apart): the drive takes sensors 120° apart",
                               k + 1);
        }
    }
    std::string found;
    for (const HallEdge &edge : edges) {
        found += fmt::format("{}{}", found.empty() ? "" : ", ", edge.pattern);
    }
    return fmt::format("the Hall signals have the patterns {} in a turn, expected 1 to 6 once each",
                       found);
}

std::string too_wide(const std::array<HallEdge, EDGES> &edges)
{
    double bar = 0;
    double widest = 0;
    for (std::size_t k = 0; k < EDGES; k++) {
        const HallEdge &next = edges[(k + 1) % EDGES];
        bar = std::max(bar, error_bar(edges[k].deg.std, edges[k].deg.bound));
        widest = std::max(widest, std::fmod(next.deg.value - edges[k].deg.value + 360, 360.0));
    }
    if (bar > HALL_BAR_MOST_DEG) {
        return fmt::format("the edges of the Hall signals are known to ± {:.1f}° only, ± {:.0f}° "
                           "are of use",
                           bar, HALL_BAR_MOST_DEG);
    }
    return widest >= SECTOR_MOST_DEG
               ? fmt::format("a pattern of the Hall signals is {:.0f}° wide, less than {:.0f}° are "
                             "of use",
                             widest, SECTOR_MOST_DEG)
               : "";
}

// ---- the edges ----

// In their order, the patterns after them last.
std::array<HallEdge, EDGES> edges_of(const Windows &windows, double bound_deg, Halls &halls)
{
    struct Change {
        Value deg;
        int bit;
        bool rises;
    };
    std::vector<Change> changes;
    halls.late_deg = 0;
    for (std::size_t k = 0; k < SIGNALS; k++) {
        const int bit = 1 << k;
        const BothWays rise = edge_of(windows, k, [](const Signal &s) { return s.rise_deg(); });
        const BothWays fall = edge_of(windows, k, [](const Signal &s) { return s.fall_deg(); });
        changes.push_back({rise.deg, bit, true});
        changes.push_back({fall.deg, bit, false});
        halls.late_deg += (rise.late_deg + fall.late_deg) / static_cast<double>(EDGES);
    }
    for (Change &change : changes) {
        change.deg.value -= 360 * std::floor(change.deg.value / 360);
        change.deg.bound += bound_deg;
    }
    std::sort(changes.begin(), changes.end(),
              [](const Change &a, const Change &b) { return a.deg.value < b.deg.value; });
    int pattern = 0; // before the first: a signal that falls before it rises is high
    for (int bit = 1; bit < 1 << SIGNALS; bit *= 2) {
        const auto first = std::find_if(changes.begin(), changes.end(),
                                        [&](const Change &c) { return c.bit == bit; });
        pattern |= first->rises ? 0 : bit;
    }
    std::array<HallEdge, EDGES> edges;
    for (std::size_t k = 0; k < EDGES; k++) {
        pattern ^= changes[k].bit;
        edges[k] = {pattern, changes[k].deg};
    }
    return edges;
}

// What the rotor's angle in the frame has in common backwards and forwards: a load that pulls one
// way. The friction's part has a sign in each.
double common_deg(const Windows &windows)
{
    const auto rotor = [](const Window &w) { return w.rotor_rad * DEG; };
    return wrapped(mean_of(windows.backwards, rotor).value +
                   mean_of(windows.forwards, rotor).value) /
           2;
}

// A rotor whose inertia holds it against the cogging.
double cogging_deg(const Records &records, const Flux &flux, const Shaft &shaft, double current_a,
                   double speed_el_rad_s)
{
    const int pairs = records.scales.pole_pairs;
    const double torque = COGGING * 1.5 * pairs * flux.wb.value * current_a;
    const double frequency = COGGING_PERIODS * speed_el_rad_s;
    return pairs * torque / (shaft.inertia_kg_m2.value * frequency * frequency) * DEG;
}

std::string first_of(const std::vector<std::string> &troubles)
{
    const auto found = std::find_if(troubles.begin(), troubles.end(),
                                    [](const std::string &text) { return !text.empty(); });
    return found == troubles.end() ? "" : *found;
}

} // namespace

Halls fit_halls(const Records &records, const Legs &legs, const Inductances &inductances,
                const Flux &flux, const Shaft &shaft)
{
    Halls halls;
    Windows windows;
    std::vector<Record> followed;
    double current_a = 0;
    for (const Record &r : records.of("hall")) {
        if (follows(r, legs, inductances, flux)) {
            auto &side = r.turns_el < 0 ? windows.backwards : windows.forwards;
            side.push_back(window_of(r, legs, inductances));
            followed.push_back(r);
            halls.speed_el_rad_s = std::abs(r.speed_el_rad_s);
            current_a = std::max(current_a, r.current_a);
        }
    }
    if (windows.backwards.empty() || windows.forwards.empty()) {
        halls.trouble = "the rotor has not turned backwards and forwards for the Hall sensors";
        return halls;
    }
    halls.trouble =
        first_of({stuck(followed), scattered(windows), alike(windows.forwards.front())});
    if (!halls.trouble.empty()) {
        return halls;
    }
    const double bound = EMF_UNSURE * std::abs(common_deg(windows)) +
                         cogging_deg(records, flux, shaft, current_a, halls.speed_el_rad_s);
    halls.edges = edges_of(windows, bound, halls);
    halls.trouble = first_of({out_of_order(halls.edges), too_wide(halls.edges)});
    halls.measured = halls.trouble.empty();
    return halls;
}

} // namespace nf::identify
