// SPDX-License-Identifier: MIT
#include "turn_fit.h"

#include "bars.h"
#include "config.h"
#include "least_squares.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace nf::identify
{
namespace
{

// Of the median of the coasting windows: a window that is off by more is of a rotor that was lost
// or stands. Of φ with current: a coasting that disagrees by so much more than the bars does not
// count.
constexpr double COAST_OFF = 0.1;
constexpr std::size_t COAST_WINDOWS = 6; // the first of them: later ones are slower
constexpr double TORQUE_FACTOR = 1.5;
constexpr double SAME_SPEED = 0.1;
constexpr double UNLIKE_CURRENTS = 1.2; // one over the other, at least
constexpr double RAMP_OFF =
    0.05; // of the change of speed: a ramp whose mean is so far from its middle has waited
constexpr double WAIT_MOST =
    0.05; // of a ramp down: it is left out where others have not waited so long
constexpr double INERTIA_SCALE = 6e-3;
constexpr double TORQUE_UNSURE = 9e-4; // of what the current can pull: angle of the voltage, delays
constexpr double HELD_UNSURE = 2e-3;   // likewise, at constant speed
constexpr double COAST_SETTLED_TICKS =
    1500;                            // the frame has found the rotor, and its current is over
constexpr double TURN_UNSURE = 0.03; // rad, of the frame's angle at the ends of a window
constexpr double TURNING_LOSS_UNSURE = 0.06; // ripple: a leg whose current is smaller loses nothing
constexpr double ALIKE_UNSURE = 5;         // of friction: windows that follow each other err alike
constexpr double BOTH_LOSS_UNSURE = 0.024; // of both ways together, found on simulated motors
// Of one window against another at another speed: of the loss, and of R·i where the rotor swings
// over its cogging.
constexpr double TREND_LOSS_UNSURE = 0.1;
constexpr double TREND_SWING_UNSURE = 0.02;
// Of a load that swings: the impulse that is left after a ramp, over the bound of J, and what of it
// errors explain; of the rest in J; what ramps of unlike steepness are apart,
// over both bars; a time of the swing over that of a window, its angle.
constexpr double LEFT_SEEN = 6;
constexpr double SCATTER_SEEN = 3; // of pairs of one steepness, over that bound
constexpr double LEFT_EXPLAINED = 1.5;
constexpr double LEFT_UNSURE = 2;
constexpr double INERTIA_UNSURE_MOST = 3; // of a J that is of any use
constexpr double APART_SEEN = 1.5;
constexpr double SWING_UNSURE = 8;
// Windows of one speed and current: their torques are apart by so much of that of the steepest
// ramps. Of 500 rigid machines one reaches it.
constexpr double UNLIKE_SEEN = 0.2;
constexpr double FRICTION_UNLIKE = 0.15; // of friction, from window to window
constexpr double HIGHEST = 0.99;
constexpr double FLUX_SCALE = 1e-3; // the voltage is known to, with harmonics of the EMF
constexpr double EVENLY = 0.95;     // of a range in which all is alike likely: 95 % are within

double sinc(double x)
{
    return std::abs(x) < 1e-9 ? 1 : std::sin(x) / x;
}

double mean_of(const std::vector<double> &values)
{
    double sum = 0;
    for (const double value : values) {
        sum += value;
    }
    return sum / static_cast<double>(values.size());
}

// At least one value.
double median_of(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

// Standard deviation of the mean.
double scatter_of(const std::vector<double> &values)
{
    const double mean = mean_of(values);
    double squares = 0;
    for (const double value : values) {
        squares += (value - mean) * (value - mean);
    }
    const auto count = static_cast<double>(values.size());
    return count > 1 ? std::sqrt(squares / (count - 1) / count) : 0;
}

// What the rotor, ωL and the legs make of a window: the voltage less R·i. A demand stays in space
// for a period while the frame turns: the mean of what turns is smaller by a sinc, and so is the
// demand that holds against it.
std::complex<double> without_resistance_v(const Record &r, const Legs &legs)
{
    const double held = sinc(r.speed_el_rad_s * legs.period_s / 2);
    return r.voltage_v / held - legs.warm_ohm() * r.i_a;
}

// Less the legs too.
std::complex<double> induced_v(const Record &r, const Legs &legs)
{
    const double size = std::abs(r.i_a);
    const double lost = size > 0 ? legs.at_bus(r.bus_v).lost_turning_v(size) / size : 0;
    return without_resistance_v(r, legs) - lost * r.i_a;
}

// L_q·i belongs to the voltage whatever the load angle.
std::complex<double> active_flux_wb(const Record &r, const Legs &legs, const Inductances &l)
{
    const std::complex<double> jw(0, r.speed_el_rad_s);
    return induced_v(r, legs) / jw - l.q_h.value * r.i_a;
}

// φ of a window that turns: (L_d − L_q)·i_d belongs to the flux.
double flux_of(const Record &r, const Legs &legs, const Inductances &l)
{
    const std::complex<double> rotor = active_flux_wb(r, legs, l);
    const double along = (r.i_a * std::conj(rotor)).real() / std::abs(rotor);
    return std::abs(rotor) - (l.d_h.value - l.q_h.value) * along;
}

// φ of the windows about the speed of another, at another current.
std::vector<double> fluxes_beside(const Records &records, const Legs &legs, const Inductances &l,
                                  const Record &other)
{
    std::vector<double> found;
    for (const Record &r : records.all) {
        const bool steady = r.kind == "spin" || r.kind == "hold";
        const bool same = std::abs(r.speed_el_rad_s / other.speed_el_rad_s - 1) < SAME_SPEED;
        const double share = r.current_a / other.current_a;
        if (steady && same && std::max(share, 1 / share) > UNLIKE_CURRENTS) {
            found.push_back(flux_of(r, legs, l));
        }
    }
    return found;
}

// With another current behind the first one, at the same speed: a line through both says what is
// there without. The other one is half of the first, or more than that where friction lets the
// rotor lag.
Value turning_flux(const Records &records, const Legs &legs, const Inductances &l)
{
    const std::vector<Record> turning = records.of("spin");
    if (turning.size() < 2) {
        throw ConfigError("the records end before the rotor has turned");
    }
    const Record &last = turning.back();
    const std::vector<double> others = fluxes_beside(records, legs, l, last);
    if (others.empty()) {
        throw ConfigError("the records have no window at another current and the same speed");
    }
    const double at_last = flux_of(last, legs, l);
    const double ratio = std::abs(last.i_a) / std::abs(turning[turning.size() - 2].i_a);
    const double change = (median_of(others) - at_last) * ratio / (1 - ratio);
    const double lost = legs.lost_turning_v(std::abs(last.i_a)) / last.speed_el_rad_s;
    return {at_last - change, std::abs(change) / 3 + scatter_of(others),
            FLUX_SCALE * at_last + TURNING_LOSS_UNSURE * lost};
}

// The EMF falls, and a small current flows as the control lets it. The legs lose something by it:
// nothing where the ripple is larger than current and knee, all that fit_legs() says where it is
// smaller. The mean of both counts, and the bar has both ends.
Value coasting_flux(const Record &r, const Legs &legs)
{
    const double w = std::abs(r.speed_el_rad_s);
    const double nothing_lost = std::abs(without_resistance_v(r, legs)) / w;
    const double all_lost = std::abs(induced_v(r, legs)) / w;
    return {(nothing_lost + all_lost) / 2, 0,
            EVENLY * std::abs(nothing_lost - all_lost) / 2 + FLUX_SCALE * all_lost};
}

double coasting_wb(const Record &r)
{
    return std::abs(r.voltage_v) / std::abs(r.speed_el_rad_s);
}

// The windows in which the frame has found the rotor and no current is left, and that agree with
// each other.
std::vector<Record> settled_coasting(const Records &records)
{
    std::vector<Record> settled;
    std::vector<double> fluxes;
    double ticks = 0;
    for (const Record &r : records.of("coast")) {
        if (ticks >= COAST_SETTLED_TICKS && std::abs(r.speed_el_rad_s) > 0) {
            settled.push_back(r);
            fluxes.push_back(coasting_wb(r));
        }
        ticks += r.ticks;
    }
    if (!settled.empty()) {
        const double middle = median_of(fluxes);
        const auto is_off = [&](const Record &r) {
            return std::abs(coasting_wb(r) - middle) > COAST_OFF * middle;
        };
        settled.erase(std::remove_if(settled.begin(), settled.end(), is_off), settled.end());
    }
    return settled;
}

// Of the first windows: later ones are slower.
std::vector<Value> coasting_fluxes(const Records &records, const Legs &legs)
{
    std::vector<Value> found;
    for (const Record &r : settled_coasting(records)) {
        if (found.size() < COAST_WINDOWS) {
            found.push_back(coasting_flux(r, legs));
        }
    }
    return found;
}

Value mean_flux(const std::vector<Value> &fluxes)
{
    std::vector<double> values;
    double bound = 0;
    for (const Value &flux : fluxes) {
        values.push_back(flux.value);
        bound = std::max(bound, flux.bound);
    }
    return {median_of(values), scatter_of(values), bound};
}

double bar(const Value &value)
{
    return error_bar(value.std, value.bound);
}

// Both by the squares of their bars. The bounds are averaged, as both may err the same way. What
// the two lie apart beyond their bars no bar knows of: half of it is added.
Value combined(const Value &a, const Value &b, double disagreement)
{
    const double square_a = a.std * a.std + a.bound * a.bound;
    const double square_b = b.std * b.std + b.bound * b.bound;
    const double share = square_b / (square_a + square_b);
    Value both;
    both.value = share * a.value + (1 - share) * b.value;
    both.std = std::hypot(share * a.std, (1 - share) * b.std);
    both.bound = share * a.bound + (1 - share) * b.bound + disagreement / 2;
    return both;
}

// The windows at the whole current, from a quarter of the speed to the whole. R and the legs make
// an error that falls with the speed; L makes the same one at each.
std::vector<FluxAtSpeed> fluxes_over_speed(const Records &records, const Legs &legs,
                                           const Inductances &l)
{
    constexpr std::size_t windows = 4; // the last one is at another current
    const std::vector<Record> turning = records.of("spin");
    std::vector<FluxAtSpeed> found;
    for (std::size_t k = turning.size() - std::min(windows, turning.size()); k + 1 < turning.size();
         k++) {
        const Record &r = turning[k];
        const double size = std::abs(r.i_a);
        const Value &ohm = legs.resistance_ohm;
        const double lost = legs.lost_turning_v(size);
        const double unsure_v =
            (bar(ohm) + TREND_SWING_UNSURE * ohm.value) * size + TREND_LOSS_UNSURE * lost;
        const double wb = flux_of(r, legs, l);
        found.push_back({r.speed_el_rad_s, {wb, 0, FLUX_SCALE * wb + unsure_v / r.speed_el_rad_s}});
    }
    return found;
}

// A pair: down, hold, up, hold.
struct Pair {
    const Record *down;
    const Record *low;
    const Record *up;
    const Record *high;
};

bool is_pair(const std::vector<Record> &all, std::size_t at)
{
    return all[at].kind == "ramp" && all[at + 1].kind == "hold" && all[at + 2].kind == "ramp" &&
           all[at + 3].kind == "hold";
}

// A ramp down that waits for the bus is late in its window, whose mean speed is above the middle
// then: by more than that of the ramp up, a share of the change of speed. The end of the ramp may
// be missing.
double wait_share(const Pair &pair)
{
    const double middle = (pair.low->speed_el_rad_s + pair.high->speed_el_rad_s) / 2;
    const double down = std::abs(pair.down->speed_el_rad_s - middle);
    const double up = std::abs(pair.up->speed_el_rad_s - middle);
    return std::max(down - up, 0.0) / (pair.high->speed_el_rad_s - pair.low->speed_el_rad_s);
}

// Without those that have waited long, if others have not.
std::vector<Pair> without_waits(const std::vector<Pair> &pairs)
{
    std::vector<Pair> whole;
    std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(whole),
                 [](const Pair &pair) { return wait_share(pair) < WAIT_MOST; });
    return whole.empty() ? pairs : whole;
}

std::vector<Pair> pairs_of(const std::vector<Record> &all)
{
    std::vector<Pair> pairs;
    for (std::size_t k = 0; k + 3 < all.size(); k++) {
        if (is_pair(all, k)) {
            pairs.push_back({&all[k], &all[k + 1], &all[k + 2], &all[k + 3]});
            k += 3;
        }
    }
    return without_waits(pairs);
}

// Those of the same steepness, in their order.
std::vector<std::vector<Pair>> by_steepness(const std::vector<Pair> &pairs)
{
    std::vector<std::vector<Pair>> groups;
    for (const Pair &pair : pairs) {
        if (groups.empty() || groups.back().back().down->ticks != pair.down->ticks) {
            groups.emplace_back();
        }
        groups.back().push_back(pair);
    }
    return groups;
}

// Of a ramp's window what the torque of the constant speeds, between them by the mean speed, does
// not explain; N·m·s.
double impulse(const Record &ramp, const Pair &pair, const Scales &scales)
{
    const double low = pair.low->torque / pair.low->ticks;
    const double high = pair.high->torque / pair.high->ticks;
    const double share = (ramp.speed_el_rad_s - pair.low->speed_el_rad_s) /
                         (pair.high->speed_el_rad_s - pair.low->speed_el_rad_s);
    const double steady = (low + (high - low) * share) * ramp.ticks;
    return TORQUE_FACTOR * scales.pole_pairs * scales.period_s * (ramp.torque - steady);
}

Value inertia_of(const std::vector<Pair> &pairs, const Scales &scales)
{
    std::vector<double> found;
    for (const Pair &pair : pairs) {
        const double change =
            (pair.high->speed_el_rad_s - pair.low->speed_el_rad_s) / scales.pole_pairs;
        found.push_back((impulse(*pair.up, pair, scales) - impulse(*pair.down, pair, scales)) / 2 /
                        change);
    }
    const double inertia = mean_of(found);
    return {inertia, scatter_of(found), INERTIA_SCALE * inertia};
}

// The torque of the motor over that which the current can pull: small where the rotor is light, and
// then errors of the angle count.
double pulled_share(const std::vector<Pair> &pairs, const Flux &flux)
{
    const Record &up = *pairs.back().up;
    const Record &down = *pairs.back().down;
    const double torque = std::abs(up.torque - down.torque) / 2 / up.ticks;
    return torque / (flux.wb.value * std::abs(up.i_a));
}

// Of pairs of one steepness.
Value bounded_inertia(const std::vector<Pair> &pairs, const Scales &scales, const Flux &flux)
{
    Value inertia = inertia_of(pairs, scales);
    const double share = std::max(pulled_share(pairs, flux), 1e-3);
    double waited = 0;
    for (const Pair &pair : pairs) {
        waited = std::max(waited, wait_share(pair));
    }
    inertia.bound += (TORQUE_UNSURE / share + waited) * std::abs(inertia.value);
    return inertia;
}

// The first ramp, much slower than those of the pairs, between two windows of constant speed.
// Without it: nothing.
std::optional<Pair> slow_ramp(const std::vector<Record> &all)
{
    for (std::size_t k = 0; k + 2 < all.size(); k++) {
        if (all[k].kind == "spin" && all[k + 1].kind == "ramp" && all[k + 2].kind == "spin") {
            return Pair{nullptr, &all[k], &all[k + 1], &all[k + 2]};
        }
    }
    return std::nullopt;
}

double torque_a_tick(const Record &r)
{
    return r.torque / r.ticks;
}

// What a constant speed takes, by a line through the windows on both sides of the slow ramp.
double friction_a_tick(const Pair &slow, double speed_el_rad_s)
{
    const double low = torque_a_tick(*slow.low);
    const double share = (speed_el_rad_s - slow.low->speed_el_rad_s) /
                         (slow.high->speed_el_rad_s - slow.low->speed_el_rad_s);
    return low + (torque_a_tick(*slow.high) - low) * share;
}

// The impulse that the windows after a pair's ramps have more or less than friction takes, over
// that of a ramp: a rotor with all that it turns has its speed by then, a load on an elastic shaft
// swings about it.
double left_share(const std::vector<Pair> &pairs, const Pair &slow)
{
    double squares = 0;
    double ramps = 0;
    for (const Pair &pair : pairs) {
        for (const Record *hold : {pair.low, pair.high}) {
            const double more = torque_a_tick(*hold) - friction_a_tick(slow, hold->speed_el_rad_s);
            squares += std::pow(more * hold->ticks, 2) / 2;
        }
        ramps += std::abs(pair.up->torque - pair.down->torque) / 2;
    }
    const auto count = static_cast<double>(pairs.size());
    return std::sqrt(squares / count) / (ramps / count);
}

// By how much the torques at the highest speed and one current are apart, over the torque of the
// ramps: friction is the same in all of these windows, that of a swing is not. Ramps that end in
// the same phase of a swing each time do not show it.
double unlike_share(const std::vector<Record> &all, const std::vector<Pair> &steepest)
{
    const Pair &pair = steepest.back();
    const Record &high = *pair.high;
    double least = torque_a_tick(high);
    double most = least;
    for (const Record &r : all) {
        const bool is_steady = r.kind == "spin" || r.kind == "hold";
        const bool is_there = r.speed_el_rad_s > HIGHEST * high.speed_el_rad_s &&
                              std::abs(r.i_a) * UNLIKE_CURRENTS > std::abs(high.i_a);
        if (is_steady && is_there) {
            least = std::min(least, torque_a_tick(r));
            most = std::max(most, torque_a_tick(r));
        }
    }
    const double friction = std::abs(most + least) / 2;
    const double ramps = std::abs(torque_a_tick(*pair.up) - torque_a_tick(*pair.down)) / 2;
    return std::max(most - least - FRICTION_UNLIKE * friction, 0.0) / ramps;
}

// Of one steepness, with what a load that swings may add or take.
struct Steepness {
    Value inertia;
    double left = 0; // left_share()
    bool swings = false;
};

// What is left beyond what the errors of the torque explain is of a rotor that still swings itself,
// or of a load that does. It is a bound of J in any case.
Steepness steepness_of(const std::vector<Pair> &pairs, const std::optional<Pair> &slow,
                       const Scales &scales, const Flux &flux)
{
    Steepness found;
    found.inertia = bounded_inertia(pairs, scales, flux);
    found.left = slow ? left_share(pairs, *slow) : 0;
    const double left = found.left * std::abs(found.inertia.value);
    const double explained = LEFT_EXPLAINED * found.inertia.bound;
    found.swings = left > LEFT_SEEN * found.inertia.bound ||
                   2 * found.inertia.std > SCATTER_SEEN * found.inertia.bound;
    found.inertia.bound += LEFT_UNSURE * std::max(left - explained, 0.0);
    return found;
}

// Ramps of all steepness have the same J, and the torque after them is that of friction. Where they
// have not, or it is not, the load swings on an elastic shaft. The impulse that is left then, by
// the time of a swing in place of that of the window, is missing in J or too much of it; J is that
// of the ramps which leave the smallest share of theirs.
void take_swing(const std::vector<Record> &all, const std::vector<std::vector<Pair>> &groups,
                const Scales &scales, const Flux &flux, Shaft &shaft)
{
    const std::optional<Pair> slow = slow_ramp(all);
    std::vector<Steepness> found;
    found.reserve(groups.size());
    for (const std::vector<Pair> &pairs : groups) {
        found.push_back(steepness_of(pairs, slow, scales, flux));
    }
    const Steepness &steep = found.back();
    const Steepness *calm = &steep;
    double apart = 0;
    bool swings = false;
    for (const Steepness &other : found) {
        const double difference = std::abs(other.inertia.value - steep.inertia.value);
        if (difference > APART_SEEN * (bar(other.inertia) + bar(steep.inertia))) {
            apart = std::max(apart, difference);
        }
        swings = swings || other.swings;
        if (other.inertia.value > 0 && other.left < calm->left) {
            calm = &other;
        }
    }
    const double unlike = unlike_share(all, groups.back());
    shaft.inertia_kg_m2 = steep.inertia;
    shaft.swings = apart > 0 || swings || unlike > UNLIKE_SEEN;
    shaft.swing_kg_m2 = std::max(SWING_UNSURE * calm->left, unlike) * calm->inertia.value;
    if (shaft.swings) {
        shaft.inertia_kg_m2 = calm->inertia;
        shaft.inertia_kg_m2.bound += apart + shaft.swing_kg_m2;
    }
}

// One statement on the friction: B·speed + C = torque, to about `unsure`.
struct Drag {
    double speed;
    double torque;
    double unsure;
};

// At constant speed the motor's torque is that of the friction.
void add_held_drags(const std::vector<Pair> &pairs, const Scales &scales, const Flux &flux,
                    std::vector<Drag> &drags)
{
    const double factor = TORQUE_FACTOR * scales.pole_pairs;
    for (const Pair &pair : pairs) {
        for (const Record *r : {pair.low, pair.high}) {
            drags.push_back({r->speed_el_rad_s / scales.pole_pairs, factor * r->torque / r->ticks,
                             factor * HELD_UNSURE * flux.wb.value * std::abs(r->i_a)});
        }
    }
}

// Without current the friction brakes the rotor. The torque of the current that is left is taken
// off.
void add_coasting_drags(const Records &records, double inertia, const Flux &flux,
                        std::vector<Drag> &drags)
{
    const double period_s = records.scales.period_s;
    const double factor = TORQUE_FACTOR * records.scales.pole_pairs;
    const std::vector<Record> windows =
        flux.coasting_counts() ? settled_coasting(records) : std::vector<Record>();
    for (std::size_t k = 0; k + 1 < windows.size(); k++) {
        const Record &a = windows[k];
        const Record &b = windows[k + 1];
        const double between_s = (a.ticks + b.ticks) / 2 * period_s;
        const double fall = (a.speed_el_rad_s - b.speed_el_rad_s) / records.scales.pole_pairs;
        const double left = factor * (a.torque + b.torque) / (a.ticks + b.ticks);
        const double turn_unsure = TURN_UNSURE / std::min(a.ticks, b.ticks) / period_s;
        drags.push_back({(a.speed_el_rad_s + b.speed_el_rad_s) / 2 / records.scales.pole_pairs,
                         inertia * fall / between_s + left,
                         inertia * turn_unsure / records.scales.pole_pairs / between_s});
    }
}

// The drive takes what the legs lose at one bus voltage from the power of the EMF. Braking lifts
// the bus, and with it the loss.
Records at_one_bus(Records records, const Legs &legs)
{
    for (Record &r : records.all) {
        const double size = std::abs(r.i_a);
        if (r.torque != 0 && size > 0 && r.speed_el_rad_s > 0) {
            const double more_v = legs.lost_turning_v(size) * (r.bus_v / legs.bus_v - 1);
            r.torque -= r.ticks * size * more_v / r.speed_el_rad_s;
        }
    }
    return records;
}

void fit_friction(const std::vector<Drag> &drags, Shaft &shaft)
{
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(drags.size()), 2);
    Eigen::VectorXd torque(rows.rows());
    for (Eigen::Index k = 0; k < rows.rows(); k++) {
        const Drag &drag = drags[static_cast<std::size_t>(k)];
        rows.row(k) << drag.speed / drag.unsure, 1 / drag.unsure;
        torque[k] = drag.torque / drag.unsure;
    }
    const Fit fit = fit_linear(rows, torque);
    const double scale = ALIKE_UNSURE / std::clamp(fit.rms, 1e-9, 1.0);
    // coasting shows friction over J
    const double unsure = bar(shaft.inertia_kg_m2) / shaft.inertia_kg_m2.value;
    const double viscous = std::max(fit.value[0], 0.0);
    const double coulomb = std::max(fit.value[1], 0.0);
    shaft.viscous_nm_s = {viscous, fit.std[0] * scale, unsure * viscous};
    shaft.coulomb_nm = {coulomb, fit.std[1] * scale, unsure * coulomb};
}

} // namespace

std::complex<double> rotor_wb(const Record &turning, const Legs &legs,
                              const Inductances &inductances)
{
    return active_flux_wb(turning, legs, inductances);
}

double Flux::disagreement_wb() const
{
    const double apart = std::abs(turning_wb.value - coasting_wb.value);
    return has_coasted ? std::max(apart - bar(turning_wb) - bar(coasting_wb), 0.0) : 0;
}

bool Flux::coasting_counts() const
{
    return has_coasted && disagreement_wb() < COAST_OFF * turning_wb.value;
}

Flux fit_flux(const Records &records, const Legs &legs, const Inductances &inductances)
{
    Flux flux;
    flux.turning_wb = turning_flux(records, legs, inductances);
    flux.over_speed = fluxes_over_speed(records, legs, inductances);
    const std::vector<Value> coasting = coasting_fluxes(records, legs);
    flux.has_coasted = coasting.size() > 1;
    flux.wb = flux.turning_wb;
    if (flux.has_coasted) {
        flux.coasting_wb = mean_flux(coasting);
    }
    if (flux.coasting_counts()) {
        flux.wb = combined(flux.turning_wb, flux.coasting_wb, flux.disagreement_wb());
    }
    const Record last = records.of("spin").back();
    flux.wb.bound =
        std::hypot(flux.wb.bound, BOTH_LOSS_UNSURE * legs.lost_turning_v(std::abs(last.i_a)) /
                                      last.speed_el_rad_s);
    for (const Record &r : records.all) {
        flux.speed_el_rad_s = std::max(flux.speed_el_rad_s, r.speed_el_rad_s);
    }
    return flux;
}

Shaft fit_shaft(const Records &sent, const Legs &legs, const Flux &flux)
{
    const Records records = at_one_bus(sent, legs);
    const std::vector<std::vector<Pair>> groups = by_steepness(pairs_of(records.all));
    if (groups.empty()) {
        throw ConfigError("the records end before the ramps of speed");
    }
    Shaft shaft;
    take_swing(records.all, groups, records.scales, flux, shaft);
    if (!(bar(shaft.inertia_kg_m2) < INERTIA_UNSURE_MOST * shaft.inertia_kg_m2.value)) {
        throw ConfigError(
            "the load swings so much on an elastic shaft, or changes so much, that the ramps do not show the "
            "inertia; identify the motor without the load, or on a stiff coupling");
    }
    std::vector<Drag> drags;
    add_held_drags(groups.back(), records.scales, flux, drags);
    add_coasting_drags(records, shaft.inertia_kg_m2.value, flux, drags);
    fit_friction(drags, shaft);
    return shaft;
}

} // namespace nf::identify
