// SPDX-License-Identifier: MIT
#include "remarks.h"

#include "si.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

// Beyond it two values of one thing are rather in another convention than printed with few digits.
constexpr double LIKELY = 0.05;
// Within it a value in another convention is the same.
constexpr double ALIKE = 0.03;
constexpr double SHOWN_PCT = 0.05; // rounded to a tenth it is something

std::string quoted(const Given &given, const std::string &option)
{
    return fmt::format("{} \"{}\"", option, given.at(option).front().typed);
}

// "3.1 % less flux linkage than", of a share above or below 1.
std::string compared(double share, const char *what)
{
    const double pct = std::abs(share - 1) * IN_PER_CENT;
    if (pct < SHOWN_PCT) {
        return fmt::format("the same {} as", what);
    }
    return fmt::format("{:.{}f} % {} {} than", pct, pct < 10 ? 1 : 0, share < 1 ? "less" : "more",
                       what);
}

double value_of(const std::vector<Made> &made, const std::string &key)
{
    const auto found =
        std::find_if(made.begin(), made.end(), [&](const Made &one) { return one.key == key; });
    return found == made.end() ? 0 : found->value();
}

class Remarks
{
public:
    explicit Remarks(const Given &given) : given_(given), made_(make_all(given))
    {
    }

    std::vector<std::string> all();

private:
    void add(const std::string &line)
    {
        lines_.push_back(line);
    }
    void compare_flux(const std::string &taken, const std::string &other);
    std::string agreeing(const std::string &option, double flux) const;
    void flux();
    void power();
    void speeds();
    void currents();
    void inertia();

    const Given &given_;
    std::vector<Made> made_;
    std::vector<std::string> lines_;
};

// The convention in which an option would give a flux linkage, as words to try; "" for none.
std::string Remarks::agreeing(const std::string &option, double flux) const
{
    for (const Convention &trial : conventions_of(sheet_option(option).quantities[0].needs)) {
        if (std::abs(flux_of(given_, option, trial) / flux - 1) < ALIKE) {
            return fmt::format("; {} would fit as \"{}\"", option, words(trial));
        }
    }
    return "";
}

void Remarks::compare_flux(const std::string &taken, const std::string &other)
{
    const auto flux = [&](const std::string &option) {
        return flux_of(given_, option, given_.at(option).front().convention);
    };
    const double share = flux(other) / flux(taken);
    const bool is_wrong = std::abs(share - 1) > LIKELY;
    add(fmt::format("{} gives {} {}, which is taken{}{}", quoted(given_, other),
                    compared(share, "flux linkage"), quoted(given_, taken),
                    is_wrong ? agreeing(other, flux(taken)) : "",
                    is_wrong ? agreeing(taken, flux(other)) : ""));
}

void Remarks::flux()
{
    const std::string taken = flux_option(given_);
    for (const char *const other : {"--emf-constant", "--kv"}) {
        if (has(given_, other) && taken != other) {
            compare_flux(taken, other);
        }
    }
}

void Remarks::power()
{
    if (has(given_, "--rated-power") && has(given_, "--rated-torque")) {
        const double from_torque =
            given_.at("--rated-torque").front().si() * given_.at("--rated-speed").front().si();
        const double share = given_.at("--rated-power").front().si() / from_torque;
        add(fmt::format("{} is {} the {:.4g} W of {} at rated speed; the torque is taken",
                        quoted(given_, "--rated-power"), compared(share, "power"), from_torque,
                        quoted(given_, "--rated-torque")));
    }
}

void Remarks::speeds()
{
    if (!has(given_, "--max-speed")) {
        add("no --max-speed: the drive asks for the rated speed at most");
    } else if (value_of(made_, "max_speed_rpm") < value_of(made_, "rated_speed_rpm")) {
        add(fmt::format("{} is below {}: the drive does not reach rated speed",
                        quoted(given_, "--max-speed"), quoted(given_, "--rated-speed")));
    }
    const double without_load_rpm =
        has(given_, "--no-load") ? given_.at("--no-load")[1].si() / RAD_S_PER_RPM : 0;
    if (has(given_, "--no-load") && value_of(made_, "rated_speed_rpm") > without_load_rpm) {
        add(fmt::format("{} is above the {:.5g} rpm without load of {}",
                        quoted(given_, "--rated-speed"), without_load_rpm,
                        quoted(given_, "--no-load")));
    }
}

void Remarks::currents()
{
    const double needed =
        value_of(made_, "rated_torque_nm") /
        (1.5 * value_of(made_, "pole_pairs") * value_of(made_, "flux_linkage_wb"));
    for (const auto &[option, key] : {std::pair("--max-current", "max_current_a"),
                                      std::pair("--continuous-current", "continuous_current_a")}) {
        const double there = value_of(made_, key);
        if (there > 0 && needed > there * (1 + ALIKE)) {
            add(fmt::format("rated torque takes {:.3g} A peak, more than {}", needed,
                            quoted(given_, option)));
        }
    }
    if (value_of(made_, "continuous_current_a") > value_of(made_, "max_current_a")) {
        add(fmt::format("{} is above {}, which is what the drive asks for at most",
                        quoted(given_, "--continuous-current"), quoted(given_, "--max-current")));
    }
}

void Remarks::inertia()
{
    if (!has(given_, "--load-inertia")) {
        add("no --load-inertia: the inertia is the rotor's alone; start and speed loop are computed "
            "from that of all that turns");
    }
}

std::vector<std::string> Remarks::all()
{
    flux();
    power();
    speeds();
    currents();
    inertia();
    return lines_;
}

} // namespace

std::vector<std::string> remarks_on(const Given &given)
{
    return Remarks(given).all();
}

} // namespace nf::sheet
