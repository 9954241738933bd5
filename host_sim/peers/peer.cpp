// SPDX-License-Identifier: MIT
#include "peer.h"

#include "flux_observer.h"
#include "kalman.h"
#include "luenberger.h"
#include "neural.h"
#include "sliding_mode.h"

#include "files.h"
#include "schema.h"
#include "suggest.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::peers
{
namespace
{

constexpr const char *ESTIMATOR = "estimator";
constexpr const char *GAIN = "gain";

const Gain PLL_BANDWIDTH = {"pll_bandwidth", 0.002, 0.5,
                            "natural frequency of the PLL, rad a sample"};
const Gain PLL_DAMPING = {"pll_damping", 0.5, 4, "damping of the PLL"};

Pll pll_of(const Gains &gains)
{
    return {gains.at(PLL_BANDWIDTH.name), gains.at(PLL_DAMPING.name)};
}

std::unique_ptr<Estimator> make_luenberger(const Gains &gains)
{
    return std::make_unique<Luenberger>(gains.at("bandwidth"), pll_of(gains));
}

std::unique_ptr<Estimator> make_sliding_mode(const Gains &gains)
{
    const SlidingMode::Gains own = {gains.at("layer"), gains.at("amplitude"), gains.at("filter")};
    return std::make_unique<SlidingMode>(own, pll_of(gains));
}

std::unique_ptr<Estimator> make_flux(const Gains &gains)
{
    return std::make_unique<FluxObserver>(gains.at("correction"), pll_of(gains));
}

std::unique_ptr<Estimator> make_kalman(const Gains &gains)
{
    return std::make_unique<Kalman>(
        Kalman::Gains{gains.at("flux_noise"), gains.at("angle_noise"), gains.at("speed_noise")});
}

std::unique_ptr<Estimator> make_neural(const Gains &gains)
{
    return std::make_unique<Neural>(
        Neural::Gains{gains.at("kappa"), gains.at("kappa_p"), gains.at("rho_max")});
}

std::vector<std::string> names()
{
    std::vector<std::string> found;
    for (const Peer &peer : all()) {
        found.emplace_back(peer.name);
    }
    return found;
}

[[noreturn]] void refuse(const Node &value, const std::string &key, const char *what,
                         const std::vector<std::string> &known)
{
    const std::string near = nearest(key, known);
    fail(value.origin, key, shown(value),
         near.empty() ? what : fmt::format("{}, did you mean {}?", what, near),
         fmt::format("{}", fmt::join(known, ", ")));
}

const Node &member_of(const Node &table, std::string_view path, const char *name,
                      std::string_view allowed)
{
    for (const auto &[key, value] : table.members) {
        if (key == name) {
            return value;
        }
    }
    fail(table.origin, std::string(path), "", "is missing", std::string(allowed));
}

const Peer &peer_of(const Node &document)
{
    const std::string known = fmt::format("{}", fmt::join(names(), ", "));
    const Node &name = member_of(document, ESTIMATOR, ESTIMATOR, known);
    for (const Peer &peer : all()) {
        if (name.kind == Node::Kind::text && name.text == peer.name) {
            return peer;
        }
    }
    fail(name.origin, ESTIMATOR, shown(name), "is no estimator", known);
}

Gains gains_of(const Peer &peer, const Node &table)
{
    std::vector<std::string> known;
    Gains gains;
    for (const Gain &gain : peer.gains) {
        const std::string path = fmt::format("{}.{}", GAIN, gain.name);
        const std::string allowed = range_text(gain.min, gain.max, "");
        const Node &value = member_of(table, path, gain.name, allowed);
        check_number(path, value, gain.min, gain.max, allowed);
        gains[gain.name] = value.number();
        known.emplace_back(gain.name);
    }
    for (const auto &[key, value] : table.members) {
        if (gains.count(key) == 0) {
            refuse(value, key, "unknown gain", known);
        }
    }
    return gains;
}

} // namespace

const std::vector<Peer> &all()
{
    static const std::vector<Peer> peers = {
        {"luenberger",
         "Luenberger observer of the extended EMF, PLL",
         {{"bandwidth", 0.02, 2, "of current and EMF, rad a sample"}, PLL_BANDWIDTH, PLL_DAMPING},
         make_luenberger},
        {"sliding_mode",
         "sliding-mode observer of the extended EMF, PLL",
         {{"layer", 0.005, 1.5, "slope within the boundary layer; 1 ends an error in a sample"},
          {"amplitude", 1, 4,
           "of the switched voltage, over the EMF at the limit of the speed; above 1 it slides"},
          {"filter", 0.01, 1, "share that the low-pass of the EMF closes in a sample"},
          PLL_BANDWIDTH,
          PLL_DAMPING},
         make_sliding_mode},
        {"flux",
         "stator flux with its magnitude corrected, PLL",
         {{"correction", 1e-4, 0.5, "share of the magnitude's error that a sample takes away"},
          PLL_BANDWIDTH,
          PLL_DAMPING},
         make_flux},
        {"kalman",
         "extended Kalman filter with four states",
         {{"flux_noise", 1e-3, 100, "of the flux over L_d, over that of the current, a sample"},
          {"angle_noise", 1e-3, 100, "of the angle times φ/L_d, likewise"},
          {"speed_noise", 1e-4, 10, "of the turn in a sample times φ/L_d, likewise"}},
         make_kalman},
        {"neural",
         "paper A (22) with proportional path",
         {{"kappa", 1e-3, 0.3, "share of the speed error that a sample takes away"},
          {"kappa_p", 1e-3, 1, "proportional path"},
          {"rho_max", 0.01, 10, "limit of R/(ωL)"}},
         make_neural},
    };
    return peers;
}

Tuned load(const std::string &option, const std::string &reference)
{
    const std::filesystem::path path =
        resolve_in(data_folder() / "peers", reference, "", ESTIMATOR, {option});
    const Node document = parse_document(display_name(path), read_bytes(path));
    const Peer &peer = peer_of(document);
    for (const auto &[key, value] : document.members) {
        if (key != ESTIMATOR && key != GAIN) {
            refuse(value, key, "unknown key", {ESTIMATOR, GAIN});
        }
    }
    const Node &table = member_of(document, GAIN, GAIN, "a table");
    if (table.kind != Node::Kind::table) {
        fail(table.origin, GAIN, shown(table), fmt::format("is {}", kind_name(table)), "a table");
    }
    return {&peer, peer.make(gains_of(peer, table))};
}

} // namespace nf::peers
