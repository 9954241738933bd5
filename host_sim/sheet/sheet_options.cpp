// SPDX-License-Identifier: MIT
#include "sheet_options.h"

#include "pattern.h"
#include "si.h"
#include "spelling.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

// By definition: the pound, the inch, standard gravity.
constexpr double LB_KG = 0.45359237;
constexpr double OZ_KG = LB_KG / 16;
constexpr double IN_M = 0.0254;
constexpr double FT_M = 12 * IN_M;
constexpr double GRAVITY = 9.80665;
constexpr double KGF_CM = GRAVITY * 0.01;
constexpr double OZ_IN = OZ_KG * GRAVITY * IN_M;
constexpr double LB_IN = LB_KG * GRAVITY * IN_M;
constexpr double LB_FT = LB_KG * GRAVITY * FT_M;
constexpr double PER_KRPM = 1e-3 / RAD_S_PER_RPM; // of a rad/s

const Quantity POLES = {"a number of poles", {{"", 1, "poles|pole"}}, Needs::nothing, true};
const Quantity POLE_PAIRS = {
    "a number of pole pairs", {{"", 1, "pole pairs|pole pair|pairs"}}, Needs::nothing, true};
const Quantity RESISTANCE = {
    "a resistance", {{"ohm", 1, "ohms"}, {"mohm", 1e-3, "mohms|milliohm"}}, Needs::across};
const Quantity INDUCTANCE = {
    "an inductance", {{"H", 1}, {"mH", 1e-3}, {"uH", 1e-6}}, Needs::across};
const Quantity TORQUE_CONSTANT = {"a torque constant",
                                  {{"N.m/A", 1},
                                   {"mN.m/A", 1e-3},
                                   {"N.cm/A", 1e-2},
                                   {"oz.in/A", OZ_IN, "ozf.in/A|in.oz/A"},
                                   {"lb.in/A", LB_IN, "lbf.in/A|in.lb/A"},
                                   {"kg.cm/A", KGF_CM, "kgf.cm/A"}},
                                  Needs::any_sort};
const Quantity EMF_CONSTANT = {"an EMF constant",
                               {{"V/krpm", PER_KRPM},
                                {"mV/rpm", PER_KRPM},
                                {"V/rpm", 1 / RAD_S_PER_RPM},
                                {"V.s/rad", 1, "V/rad/s|V.s"},
                                {"mV.s/rad", 1e-3, "mV/rad/s"}},
                               Needs::voltage};
const Quantity KV = {
    "a Kv", {{"rpm/V", RAD_S_PER_RPM, "kv"}, {"rad/s/V", 1, "rad/V/s|rad/V.s"}}, Needs::voltage};
const Quantity TORQUE = {"a torque",
                         {{"N.m", 1},
                          {"mN.m", 1e-3},
                          {"N.cm", 1e-2},
                          {"kgf.cm", KGF_CM, "kg.cm|kp.cm"},
                          {"oz.in", OZ_IN, "ozf.in|in.oz"},
                          {"lb.in", LB_IN, "lbf.in|in.lb|lbs.in"},
                          {"lb.ft", LB_FT, "lbf.ft|ft.lb|lbs.ft"}}};
const Quantity POWER = {"a power", {{"W", 1}, {"kW", 1e3}, {"hp", 550 * LB_FT}}};
const Quantity SPEED = {"a speed", {{"rpm", RAD_S_PER_RPM}, {"rad/s", 1}}, Needs::nothing, true};
const Quantity CURRENT = {"a current", {{"A", 1}, {"mA", 1e-3}}, Needs::sort};
// Of the same current as the torque constant, where nothing else is said.
const Quantity NO_LOAD_CURRENT = {
    "a current", {{"A", 1}, {"mA", 1e-3}}, Needs::any_sort, false, true};
const Quantity NO_LOAD_SPEED = {"a speed", {{"rpm", RAD_S_PER_RPM}, {"rad/s", 1}}};
const Quantity INERTIA = {"a moment of inertia",
                          {{"kg.m2", 1},
                           {"kg.cm2", 1e-4},
                           {"g.cm2", 1e-7},
                           {"kg.mm2", 1e-6},
                           {"oz.in2", OZ_KG *IN_M *IN_M},
                           {"oz.in.s2", OZ_IN, "oz.in.sec2|ozf.in.s2"},
                           {"lb.in2", LB_KG *IN_M *IN_M},
                           {"lb.in.s2", LB_IN, "lb.in.sec2|lbf.in.s2"}}};
const Quantity FRICTION = {"a friction",
                           {{"N.m.s", 1, "N.m.s/rad|N.m/rad/s"},
                            {"mN.m.s", 1e-3, "mN.m.s/rad"},
                            {"N.m/krpm", PER_KRPM},
                            {"mN.m/krpm", PER_KRPM * 1e-3},
                            {"oz.in/krpm", OZ_IN *PER_KRPM}}};
const Quantity TIME = {"a time", {{"s", 1}, {"min", 60}}};

const std::vector<SheetOption> OPTIONS = {
    {"--name", "what it is called in reports", "EC 45 flat", {}},
    {"--poles", "number of poles, twice the pole pairs", "16", {POLES}},
    {"--pole-pairs", "in place of --poles", "8", {POLE_PAIRS}},
    {"--resistance", "winding resistance", "0.608 ohm phase to phase", {RESISTANCE}},
    {"--inductance", "winding inductance, for both axes", "0.463 mH phase to phase", {INDUCTANCE}},
    {"--inductance-d", "d axis, of a motor with buried magnets", "0.4 mH phase", {INDUCTANCE}},
    {"--inductance-q", "q axis", "0.7 mH phase", {INDUCTANCE}},
    {"--torque-constant", "Kt, torque per current", "36.9 mN.m/A six-step", {TORQUE_CONSTANT}},
    {"--emf-constant", "Ke, voltage per speed", "4.64 V/krpm peak phase to phase", {EMF_CONSTANT}},
    {"--kv", "Kv, speed per voltage", "270 rpm/V peak phase to phase", {KV}},
    {"--rated-speed",
     "speed at which it is to be used, with room below the bus voltage",
     "4000 rpm",
     {SPEED}},
    {"--rated-torque", "torque for ever", "128 mN.m", {TORQUE}},
    {"--rated-power", "power at rated speed, in place of the torque", "70 W", {POWER}},
    {"--max-speed", "the drive never asks for more; else the rated speed", "4400 rpm", {SPEED}},
    {"--max-current",
     "largest current of a phase that the drive may ask for",
     "6 A peak",
     {CURRENT}},
    {"--continuous-current",
     "of a phase, for ever; else that of rated torque",
     "2.7 A rms",
     {CURRENT}},
    {"--demagnetising-current", "what the magnets bear", "20 A peak", {CURRENT}},
    {"--thermal-time-constant", "of the winding", "29.6 s", {TIME}},
    {"--inertia", "moment of inertia of the rotor", "181 g.cm2", {INERTIA}},
    {"--load-inertia",
     "that of all else that turns, as the shaft feels it",
     "181 g.cm2",
     {INERTIA}},
    {"--no-load",
     "current and speed without load: the friction",
     "234 mA 6110 rpm",
     {NO_LOAD_CURRENT, NO_LOAD_SPEED}},
    {"--friction", "viscous friction, 0 where nobody knows it", "1.3e-5 N.m.s", {FRICTION}},
};

// Where a second number begins: "234 mA | 6110 rpm".
std::size_t second_number(const std::string &text)
{
    for (std::size_t at = 1; at < text.size(); at++) {
        const bool is_digit = std::isdigit(static_cast<unsigned char>(text[at])) != 0;
        if (is_digit && std::string(" ,/").find(text[at - 1]) != std::string::npos) {
            return at;
        }
    }
    return std::string::npos;
}

// "234 mA at 6110 rpm", "234 mA @ 6110 rpm", "234 mA, 6110 rpm".
std::string without_joint(const std::string &text)
{
    return replace_matches(text, R"( ?(, |@|\bat\b|\band\b) ?)", " ");
}

std::vector<Printed> read_two(const SheetOption &option, const std::string &typed)
{
    const std::string spelt = without_joint(one_spelling(typed));
    const std::size_t at = second_number(spelt);
    if (at == std::string::npos) {
        refuse(option.name, typed, fmt::format("two values are needed, as \"{}\"", option.example));
    }
    std::string parts[] = {spelt.substr(0, at), spelt.substr(at)};
    if (has_unit_of(option.quantities[1], parts[0])) {
        std::swap(parts[0], parts[1]);
    }
    std::vector<Printed> both = {read_printed(option.name, option.quantities[0], parts[0]),
                                 read_printed(option.name, option.quantities[1], parts[1])};
    both[0].typed = tidied(typed);
    both[1].typed = tidied(typed);
    return both;
}

} // namespace

const std::vector<SheetOption> &sheet_options()
{
    return OPTIONS;
}

const SheetOption &sheet_option(const std::string &name)
{
    return *std::find_if(OPTIONS.begin(), OPTIONS.end(),
                         [&](const SheetOption &option) { return option.name == name; });
}

const std::vector<std::vector<std::string>> &needed_options()
{
    static const std::vector<std::vector<std::string>> NEEDED = {
        {"--name"},
        {"--poles", "--pole-pairs"},
        {"--resistance"},
        {"--inductance", "--inductance-d"},
        {"--inductance", "--inductance-q"},
        {"--torque-constant", "--emf-constant", "--kv"},
        {"--rated-speed"},
        {"--rated-torque", "--rated-power"},
        {"--max-current"},
        {"--inertia"},
        {"--no-load", "--friction"},
    };
    return NEEDED;
}

const std::vector<std::vector<std::string>> &rival_options()
{
    static const std::vector<std::vector<std::string>> RIVALS = {
        {"--poles", "--pole-pairs"},
        {"--inductance", "--inductance-d"},
        {"--inductance", "--inductance-q"},
        {"--no-load", "--friction"},
    };
    return RIVALS;
}

std::vector<Printed> read_option(const SheetOption &option, const std::string &typed)
{
    if (option.quantities.empty()) {
        return {};
    }
    return option.quantities.size() > 1
               ? read_two(option, typed)
               : std::vector<Printed>{read_printed(option.name, option.quantities[0], typed)};
}

} // namespace nf::sheet
