// SPDX-License-Identifier: MIT
#include "made.h"

#include "data_sheet.h"
#include "schema.h"
#include "si.h"
#include "spelling.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

namespace nf::sheet
{

bool has(const Given &given, const std::string &option)
{
    return given.count(option) != 0;
}

namespace
{

constexpr int DIGITS = 6;           // that are written: rounding is far below what any sheet knows
constexpr int RANGE_DIGITS = 4;     // of a range in a message
constexpr double PLAIN_BELOW = 1e7; // 100000 rather than 1e+05
constexpr double SQRT_3 = 1.73205080756887729353;

double factor_of(const char *sheet)
{
    return conversion(sheet).factor;
}

const Printed &printed(const Given &given, std::string_view option)
{
    return given.at(std::string(option)).front();
}

double across_factor(Across across, bool is_resistance)
{
    switch (across) {
    case Across::terminals:
        return factor_of(is_resistance ? "resistance between two terminals, Ω, star or delta"
                                       : "inductance between two terminals, H, star or delta");
    case Across::winding:
        return factor_of(is_resistance ? "resistance of one winding in delta, Ω"
                                       : "inductance of one winding in delta, H");
    case Across::phase:
    case Across::unsaid:
        break;
    }
    return 1;
}

double peak_factor(Sort sort)
{
    return sort == Sort::rms ? factor_of("current, A rms of a phase") : 1;
}

// φ·P of a torque per ampere.
double torque_factor(Sort sort)
{
    switch (sort) {
    case Sort::rms:
        return factor_of("K_t, N·m per A rms of a phase");
    case Sort::six_step:
        return factor_of("K_t, N·m per A dc, six-step (block) commutation");
    case Sort::peak:
    case Sort::unsaid:
        break;
    }
    return factor_of("K_t, N·m per A peak of a phase");
}

// φ·P of a voltage per rad/s of the shaft. With six-step commutation that is the torque per ampere:
// power in is power out.
double voltage_factor(const Convention &convention)
{
    if (convention.sort == Sort::six_step) {
        return torque_factor(Sort::six_step);
    }
    return factor_of("K_e, V·s/rad of the shaft, peak between two terminals") *
           peak_factor(convention.sort) * (convention.across == Across::phase ? SQRT_3 : 1);
}

double flux_factor(const std::string &option, const Convention &convention)
{
    return option == "--torque-constant" ? torque_factor(convention.sort)
                                         : voltage_factor(convention);
}

int flux_power(const std::string &option)
{
    return option == "--kv" ? -1 : 1;
}

// The values of a motor file one after the other, as far as they follow from what is given.
class Maker
{
public:
    explicit Maker(const Given &given) : given_(given)
    {
    }

    std::vector<Made> all();

private:
    // `option` gives `key`: factor times what it prints in SI.
    void take(const char *key, const char *option, double factor, const std::string &comment = "",
              int power = 1);
    void poles();
    void across(const char *key, const char *option, bool is_resistance,
                const std::string &comment = "");
    void current(const char *key, const char *option);
    void speed(const char *key, const char *option, const std::string &comment = "");
    void windings();
    void flux();
    void rated();
    void limits();
    void inertia();
    void friction();
    void no_load();

    const Given &given_;
    std::vector<Made> made_;
};

void Maker::take(const char *key, const char *option, double factor, const std::string &comment,
                 int power)
{
    if (!has(given_, option)) {
        return;
    }
    const Printed &from = printed(given_, option);
    made_.push_back({key, option, from, factor * std::pow(from.unit.si, power), power, 0, comment});
}

void Maker::poles()
{
    take("pole_pairs", "--poles", factor_of("number of poles"));
    take("pole_pairs", "--pole-pairs", 1);
}

void Maker::across(const char *key, const char *option, bool is_resistance,
                   const std::string &comment)
{
    if (has(given_, option)) {
        take(key, option, across_factor(printed(given_, option).convention.across, is_resistance),
             comment);
    }
}

void Maker::current(const char *key, const char *option)
{
    if (has(given_, option)) {
        take(key, option, peak_factor(printed(given_, option).convention.sort));
    }
}

void Maker::speed(const char *key, const char *option, const std::string &comment)
{
    take(key, option, 1 / RAD_S_PER_RPM, comment);
}

void Maker::windings()
{
    across("resistance_ohm", "--resistance", true);
    across("inductance_d_h", "--inductance", false);
    across("inductance_d_h", "--inductance-d", false);
    across("inductance_q_h", "--inductance", false, "q axis as d axis");
    across("inductance_q_h", "--inductance-q", false);
}

void Maker::flux()
{
    const std::string option = flux_option(given_);
    if (option.empty() || pole_pairs(given_) == 0) {
        return;
    }
    take("flux_linkage_wb", option.c_str(),
         flux_factor(option, printed(given_, option).convention) / pole_pairs(given_), "",
         flux_power(option));
}

// The speeds first: one that is out of range is to blame rather than the power over it.
void Maker::rated()
{
    speed("rated_speed_rpm", "--rated-speed");
    if (has(given_, "--max-speed")) {
        speed("max_speed_rpm", "--max-speed");
    } else {
        speed("max_speed_rpm", "--rated-speed", "no --max-speed: as rated speed");
    }
    take("rated_torque_nm", "--rated-torque", 1);
    if (!has(given_, "--rated-torque") && has(given_, "--rated-speed")) {
        const Printed &speed = printed(given_, "--rated-speed");
        take("rated_torque_nm", "--rated-power", 1 / speed.si(), "at rated speed");
    }
}

void Maker::limits()
{
    current("max_current_a", "--max-current");
    current("continuous_current_a", "--continuous-current");
    take("thermal_time_constant_s", "--thermal-time-constant", 1);
    current("demagnetising_current_a", "--demagnetising-current");
}

void Maker::inertia()
{
    take("inertia_kg_m2", "--inertia", 1);
    if (has(given_, "--inertia") && has(given_, "--load-inertia")) {
        const Printed &load = printed(given_, "--load-inertia");
        if (load.number < 0) {
            refuse("--load-inertia", load.typed, "is below 0");
        }
        made_.back().more = load.si();
        made_.back().comment = fmt::format("and --load-inertia {}", load.typed);
    }
}

void Maker::friction()
{
    take("viscous_friction_nm_s", "--friction", 1);
    if (has(given_, "--no-load") && !flux_option(given_).empty()) {
        no_load();
    }
}

// The torque of the current without load, over its speed. φ·P, of any torque per ampere, needs no
// pole pairs.
void Maker::no_load()
{
    const std::string option = flux_option(given_);
    const Printed &flux = printed(given_, option);
    const Printed &current = given_.at("--no-load")[0];
    const Printed &speed = given_.at("--no-load")[1];
    const bool is_of_sheet =
        option == "--torque-constant" || flux.convention.sort == Sort::six_step;
    Sort sort = current.convention.sort;
    if (sort == Sort::unsaid && is_of_sheet) {
        sort = flux.convention.sort;
    }
    if (sort == Sort::unsaid) {
        refuse(
            "--no-load", current.typed,
            R"(say which current, behind its unit: "peak" or "rms" of a phase, or "six-step" of the dc side)");
    }
    if (speed.si() <= 0) {
        refuse("--no-load", speed.typed, "its speed has to be above 0");
    }
    const double flux_poles =
        flux_factor(option, flux.convention) * std::pow(flux.si(), flux_power(option));
    made_.push_back({"viscous_friction_nm_s", "--no-load", current,
                     flux_poles / torque_factor(sort) / speed.si() * current.unit.si, 1, 0,
                     current.convention.sort == Sort::unsaid
                         ? fmt::format("a {} current, as that of {}", words({{}, sort}), option)
                         : ""});
}

std::vector<Made> Maker::all()
{
    poles();
    windings();
    flux();
    rated();
    limits();
    inertia();
    friction();
    return made_;
}

// `digits` significant ones, to the inner side of a range.
double inwards(double bound, bool is_lower)
{
    const double place = std::pow(10.0, std::floor(std::log10(bound)) - (RANGE_DIGITS - 1));
    // A bound that has no more digits is not moved by what division has left of it.
    const double steps = bound / place;
    const double nearest = std::round(steps);
    const double whole = std::abs(steps - nearest) < 1e-6 ? nearest
                         : is_lower                       ? std::ceil(steps)
                                                          : std::floor(steps);
    return whole * place;
}

// The number that gives a value of the key.
double number_for(const Made &made, double value)
{
    return made.power > 0 ? (value - made.more) / made.factor : made.factor / value;
}

std::string bound_text(double bound, bool is_lower)
{
    if (!(bound > 0)) {
        return "0";
    }
    const double shown = inwards(bound, is_lower);
    const bool is_plain = shown >= std::pow(10, RANGE_DIGITS) && shown < PLAIN_BELOW;
    return is_plain ? fmt::format("{:.0f}", shown) : fmt::format("{:.{}g}", shown, RANGE_DIGITS);
}

std::string allowed_text(const Made &made, const Field &field)
{
    const bool rises = made.power > 0;
    const double least = number_for(made, rises ? field.min : field.max);
    // Kv of no flux linkage at all would be endless; no key that is divided by begins at 0.
    const double most = number_for(made, rises ? field.max : field.min);
    return fmt::format("{} to {}", bound_text(least, true),
                       made.from.as_typed(bound_text(most, false)));
}

} // namespace

double Made::value() const
{
    const double exact = factor * std::pow(from.number, power) + more;
    return std::strtod(fmt::format("{:.{}g}", exact, DIGITS).c_str(), nullptr);
}

std::vector<Made> make_all(const Given &given)
{
    return Maker(given).all();
}

double flux_of(const Given &given, const std::string &option, const Convention &convention)
{
    return flux_factor(option, convention) *
           std::pow(printed(given, option).si(), flux_power(option)) / pole_pairs(given);
}

std::string flux_option(const Given &given)
{
    for (const char *const option : {"--torque-constant", "--emf-constant", "--kv"}) {
        if (has(given, option)) {
            return option;
        }
    }
    return "";
}

void check_range(const Made &made)
{
    const Field &field = *find_field(std::string("motor.") + made.key);
    const double value = made.value();
    const bool is_whole =
        std::string(made.key) != "pole_pairs" || std::abs(value - std::round(value)) <= 0;
    // A number of 0 of what is divided by gives no value.
    if (std::isfinite(value) && value >= field.min && value <= field.max && is_whole) {
        return;
    }
    const bool is_low = made.power > 0 ? value < field.min : !(value <= field.max);
    const char *const problem = !is_whole ? "is not a whole number of pole pairs"
                                : is_low  ? "is too small"
                                          : "is too large";
    refuse(made.option, made.from.typed,
           fmt::format("{}; allowed: {}", problem, allowed_text(made, field)));
}

int pole_pairs(const Given &given)
{
    const bool has_pairs = has(given, "--pole-pairs");
    if (!has_pairs && !has(given, "--poles")) {
        return 0;
    }
    const double pairs = has_pairs
                             ? printed(given, "--pole-pairs").number
                             : printed(given, "--poles").number * factor_of("number of poles");
    const Field &field = *find_field("motor.pole_pairs");
    return pairs >= field.min && pairs <= field.max ? static_cast<int>(pairs) : 0;
}

} // namespace nf::sheet
