// SPDX-License-Identifier: MIT
#include "diff.h"

#include "signals.h"

extern "C" {
#include "drive_words.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

using Rows = std::vector<Comparison>;

constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q30 = 1073741824.0;
constexpr double LARGEST_MANTISSA = 32767.0;
constexpr double LARGEST_WORD = 134217728.0; // Q27

constexpr const char *NO_TWIN =
    "state and output: as the same code computes them again from the state before; what lies between the functions above\n"
    "has no twin\n";

double raw_in(const Word &word, const void *home)
{
    uint64_t bits = 0;
    std::memcpy(&bits, static_cast<const unsigned char *>(home) + word.offset, word.bytes);
    const unsigned unused = 64U - 8U * static_cast<unsigned>(word.bytes);
    return word.has_sign ? static_cast<double>(static_cast<int64_t>(bits << unused) >> unused)
                         : static_cast<double>(bits);
}

// The words of the table in which `own` departs, in SI units or as they are. A name without a dot
// is a second one.
void add_words(Rows &rows, const char *module, Word::Home home, const void *own,
               const void *reference, const Simulation *si)
{
    for (const SignalInfo &signal : all_signals()) {
        const bool has_home = signal.value == nullptr && signal.word.home == home;
        if (!has_home || std::strchr(signal.name, '.') == nullptr) {
            continue;
        }
        const double drive = raw_in(signal.word, own);
        const double good = raw_in(signal.word, reference);
        if (drive < good || drive > good) {
            const Scale scale = si == nullptr ? Scale{"", "", 1, 0} : word_scale(signal, *si);
            rows.push_back({module, signal.name, scale.unit, (drive - scale.zero) * scale.one,
                            (good - scale.zero) * scale.one, 0});
        }
    }
}

void compare_configuration(Rows &rows, const drive_cfg_t &own, const drive_cfg_t &built)
{
    const auto *const bytes = reinterpret_cast<const unsigned char *>(&own);
    const auto *const good = reinterpret_cast<const unsigned char *>(&built);
    const auto same = std::mismatch(bytes, bytes + sizeof own, good).first - bytes;
    if (same != sizeof built) {
        add_words(rows, "configuration", Word::Home::cfg, &own, &built, nullptr);
    }
    rows.push_back(
        {"configuration", "bytes as built", "", static_cast<double>(same), sizeof built, 0});
}

// D: the winding's share times R/L, 3 as below, and the feedback's, whose mantissa is rounded to
// nearest, that of the corner down to an even number. f/D is rounded to nearest in the
// configuration, and again of the new D.
template <typename Word>
void compare_decay(const Word &word, const nn_observer_cfg_t &own, const nn_observer_cfg_t &from,
                   double ratio)
{
    const double share = from.feedback_q15 / Q15;
    const double scale = 1 - share + share / ratio;
    const double change = std::abs(ratio - 1);
    const bool is_fed = from.feedback_q15 != 0;
    const double of_decay = 3 + (is_fed ? change / 2 : 0);
    const double decay = from.decay * ratio * scale;
    word("observer.decay", own.decay, decay, of_decay);
    word("observer.corner", own.corner, from.corner * ratio * scale, 3 + (is_fed ? 2 * change : 0),
         LARGEST_WORD);
    word("observer.feedback_q15", own.feedback_q15,
         from.decay * share / std::max(own.decay, 1) * Q15,
         is_fed ? 0.5 + 0.5 * from.decay / std::max(own.decay, 1) : 0);
}

// Configured values times what the drive has found out of R, L and φ, and times the shares of the
// speed; each ratio that is applied rounds down, and the ratio after it, below 2, doubles that: 1
// for one, 3 for two. A share is at most 1: 1 more.
void compare_model(Rows &rows, const model_t &m, const drive_cfg_t &built)
{
    const nn_observer_cfg_t &from = built.observer;
    const double r = m.resistance_q14 / Q14;
    const double l = m.inductance_q14 / Q14;
    const double inverse = m.inductance_inverse_q14 / Q14;
    const double saliency = m.saliency_q14 / Q14;
    const double flux = std::floor(m.flux_q30 / Q30 * Q14) / Q14;
    const double l_q = l * saliency; // rounded down to 2^-14 before it is applied
    constexpr double of_q = 3;
    const auto word = [&rows](const std::string &name, int32_t drive, double reference,
                              double tolerance, double largest = LARGEST_MANTISSA) {
        rows.push_back({"model", name, "", static_cast<double>(drive), std::min(reference, largest),
                        tolerance});
    };
    compare_decay(word, m.observer, from, r * inverse);
    word("observer.volt_gain", m.observer.volt_gain, from.volt_gain * inverse, 1);
    word("observer.flux_q27", m.observer.flux_q27, from.flux_q27 * flux * inverse, 3,
         LARGEST_WORD - 1);
    const double pace = m.pace_q14 / Q14;
    const double kappa = m.kappa_q14 / Q14;
    word("observer.eta", m.observer.eta, from.eta * l * l * pace * pace * kappa, 3 + 3);
    word("observer.kappa_p", m.observer.kappa_p, from.kappa_p * l * l * pace, 3 + 1);
    word("observer.rho_max_q13", m.observer.rho_max_q13, from.rho_max_q13 * pace, 1);
    word("observer.saliency_q13", m.observer.saliency_q13, from.saliency_q13 * saliency, 1);
    // 1/saliency is rounded down to 2^-14 first.
    word("observer.iq_gain_q14", m.observer.iq_gain_q14, from.iq_gain_q14 / saliency,
         1 + from.iq_gain_q14 / Q14);
    const auto loop = [&](const std::string &name, const current_loop_cfg_t &own,
                          const current_loop_cfg_t &nominal, double gain_d, double gain_q) {
        word(name + ".resistance_q13", own.resistance_q13, nominal.resistance_q13 * r, 1);
        word(name + ".emf_q13", own.emf_q13, nominal.emf_q13 * flux, 1);
        word(name + ".reactance_d_q13", own.reactance_d_q13, nominal.reactance_d_q13 * l, 1);
        word(name + ".reactance_q_q13", own.reactance_q_q13, nominal.reactance_q_q13 * l_q, of_q);
        word(name + ".pi_d.kp", own.pi_d.kp, nominal.pi_d.kp * gain_d, 1 + 1);
        word(name + ".pi_d.ki", own.pi_d.ki, nominal.pi_d.ki * gain_d, 1 + 1);
        word(name + ".pi_q.kp", own.pi_q.kp, nominal.pi_q.kp * gain_q, of_q + 1);
        word(name + ".pi_q.ki", own.pi_q.ki, nominal.pi_q.ki * gain_q, of_q + 1);
    };
    loop("run_loop", m.run_loop, built.current_loop, l * pace, l_q * pace);
    loop("hold_loop", m.hold_loop, built.hold_loop, 1, 1);
}

void compare_words(Rows &rows, const Simulation &sim, const drive_t &again, const drive_out_t &out)
{
    const uint32_t count = drive_words_count();
    uint32_t same = 0;
    for (uint32_t k = 0; k < count; k++) {
        same += drive_words_get(&sim.drive(), k) == drive_words_get(&again, k) ? 1U : 0U;
    }
    if (same != count) {
        add_words(rows, "state", Word::Home::drive, &sim.drive(), &again, &sim);
    }
    add_words(rows, "output", Word::Home::out, &sim.out(), &out, &sim);
    rows.push_back({"state", "words as computed again", "", static_cast<double>(same),
                    static_cast<double>(count), 0});
}

} // namespace

bool Comparison::departs() const
{
    return !(std::abs(drive - reference) <= tolerance);
}

Rows diff_tick(const drive_t &before, const Tick &tick, const drive_cfg_t &built)
{
    drive_t again = before;
    drive_out_t out{};
    Rows rows;
    compare_configuration(rows, *before.cfg, built);
    compare_model(rows, tick.sim->drive().motor.model, built);
    const Rows modules = step_beside_twins(again, tick.sim->in(), out, tick.sim->bases());
    rows.insert(rows.end(), modules.begin(), modules.end());
    compare_words(rows, *tick.sim, again, out);
    return rows;
}

const Comparison *first_departure(const Rows &rows)
{
    const auto found =
        std::find_if(rows.begin(), rows.end(), [](const Comparison &row) { return row.departs(); });
    return found == rows.end() ? nullptr : &*found;
}

std::string diff_text(const Rows &rows)
{
    std::string text = fmt::format("  {:<24}{:<24}{:>13}{:>13}{:>12}{:>12}\n", "function",
                                   "quantity", "drive", "reference", "apart", "tolerance");
    for (const Comparison &row : rows) {
        text += fmt::format("{} {:<24}{:<24}{:>13.6g}{:>13.6g}{:>12.3g}{:>12.3g} {}\n",
                            row.departs() ? '*' : ' ', row.module, row.quantity, row.drive,
                            row.reference, std::abs(row.drive - row.reference), row.tolerance,
                            row.unit);
    }
    text += NO_TWIN;
    const Comparison *const first = first_departure(rows);
    if (first == nullptr) {
        return text + fmt::format("no departure: {} values within their roundings\n", rows.size());
    }
    return text + fmt::format("first departure: {}, {}: drive {:.6g}, reference {:.6g} {}, "
                              "tolerance {:.3g}\n",
                              first->module, first->quantity, first->drive, first->reference,
                              first->unit, first->tolerance);
}

} // namespace nf::debug
