// SPDX-License-Identifier: MIT
#include "ripple.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double TURN = 2 * 3.14159265358979323846;
constexpr double LEAST_TURNS = 2;
constexpr double BAND =
    1.1; // of the mean speeds of a steady stretch, the largest over the smallest

} // namespace

void Ripple::add(double angle_el_rad, const Values &values, double supply_rad)
{
    samples_.push_back({angle_el_rad, values, supply_rad});
}

void Ripple::clear()
{
    samples_.clear();
}

double Ripple::turned_rad(const Stretch &stretch) const
{
    double turned = 0;
    for (std::size_t k = stretch.from + 1; k < stretch.to; k++) {
        turned += std::remainder(samples_[k].angle_el_rad - samples_[k - 1].angle_el_rad, TURN);
    }
    return turned;
}

// The sample by which the rotor has made an electrical turn, either way; the last one where it
// makes none.
std::size_t Ripple::turn_end(std::size_t from) const
{
    double turned = 0;
    std::size_t k = from;
    while (k + 1 < samples_.size() && std::abs(turned) < TURN) {
        k++;
        turned += std::remainder(samples_[k].angle_el_rad - samples_[k - 1].angle_el_rad, TURN);
    }
    return k;
}

// Likewise the sample from which it makes one up to `to`.
std::size_t Ripple::turn_begin(std::size_t to) const
{
    double turned = 0;
    std::size_t k = to - 1;
    while (k > 0 && std::abs(turned) < TURN) {
        turned += std::remainder(samples_[k].angle_el_rad - samples_[k - 1].angle_el_rad, TURN);
        k--;
    }
    return k;
}

std::vector<Ripple::Stretch> Ripple::steady_stretches() const
{
    std::vector<Stretch> stretches;
    double least = 0;
    double most = 0;
    for (std::size_t from = 0; from + 1 < samples_.size();) {
        const std::size_t end = turn_end(from);
        const double speed = turned_rad({from, end + 1}) / static_cast<double>(end - from);
        least = std::min(speed, least);
        most = std::max(speed, most);
        const bool same_way = least * most > 0;
        const double ratio = same_way ? std::max(most / least, least / most) : 2 * BAND;
        if (!stretches.empty() && ratio <= BAND) {
            stretches.back().to = end + 1;
        } else {
            stretches.push_back({from, end + 1});
            least = most = speed;
        }
        from = end;
    }
    return stretches;
}

// Without the turn in which the speed begins to change, or ends to.
Ripple::Stretch Ripple::inside(const Stretch &stretch, std::size_t settled) const
{
    Stretch part = {std::max(stretch.from, settled), stretch.to};
    if (stretch.from > 0) {
        part.from = std::max(part.from, turn_end(stretch.from));
    }
    if (stretch.to < samples_.size()) {
        part.to = std::max(part.from, turn_begin(stretch.to));
    }
    return part;
}

// Where that is long enough.
std::optional<Ripple::Fitted> Ripple::fitted(const Stretch &part) const
{
    const double turned = std::abs(turned_rad(part));
    if (turned < LEAST_TURNS * TURN) {
        return std::nullopt;
    }
    return Fitted{part, RippleFit(samples_, part.from, part.to, turned)};
}

std::vector<Ripple::Fitted> Ripple::fits(std::size_t settled) const
{
    std::vector<Fitted> fits;
    for (const Stretch &stretch : steady_stretches()) {
        if (const std::optional<Fitted> fit = fitted(inside(stretch, settled))) {
            fits.push_back(*fit);
        }
    }
    if (fits.empty()) {
        if (const std::optional<Fitted> all = fitted({settled, samples_.size()})) {
            fits.push_back(*all);
        }
    }
    return fits;
}

void Ripple::take_off(const RippleFit &fit, const Stretch &stretch,
                      std::array<Split, SIGNALS> &splits) const
{
    for (std::size_t k = stretch.from; k < stretch.to; k++) {
        const Values forced = fit.forced(samples_[k]);
        for (std::size_t n = 0; n < SIGNALS; n++) {
            splits[n].rest[k] -= forced[n];
        }
    }
    for (std::size_t n = 0; n < SIGNALS; n++) {
        splits[n].amplitude = std::max(splits[n].amplitude.value_or(0), fit.amplitude()[n]);
    }
}

std::array<Ripple::Split, Ripple::SIGNALS> Ripple::split(std::size_t settled) const
{
    std::array<Split, SIGNALS> splits;
    for (std::size_t n = 0; n < SIGNALS; n++) {
        for (const RippleFit::Sample &sample : samples_) {
            splits[n].signal.push_back(sample.values[n]);
        }
        splits[n].rest = splits[n].signal;
    }
    const std::vector<Fitted> found = fits(settled);
    // Half way between two fitted stretches the later one's fit begins.
    std::size_t from = 0;
    for (std::size_t f = 0; f < found.size(); f++) {
        const bool last = f + 1 == found.size();
        const std::size_t to =
            last ? samples_.size() : (found[f].of.to + found[f + 1].of.from + 1) / 2;
        take_off(found[f].fit, {from, to}, splits);
        from = to;
    }
    return splits;
}

} // namespace nf
