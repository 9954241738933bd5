// SPDX-License-Identifier: MIT
// What is typed from a data sheet: each unit against its definition, each convention against a
// motor that is turned and measured by hand, and what is refused.
#include "config.h"
#include "data_sheet.h"
#include "made.h"
#include "sheet.h"
#include "si.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using nf::sheet::Given;
using nf::sheet::Sheet;

// The definitions below have six digits.
constexpr double DEFINED = 3e-6;
constexpr double LB_IN_NM = 0.112985;
constexpr double OZ_IN_NM = 0.00706155;
constexpr double KGF_CM_NM = 0.0980665;
constexpr double LB_KG = 0.453592;
constexpr double INCH_M = 0.0254;
constexpr double KRPM_RAD_S = 104.719755;

struct Typed {
    const char *option;
    std::string typed;
    const char *key;
    double expected;
};

// With one pole pair.
double made_of(const std::string &option, const std::string &typed, const std::string &key)
{
    Given given;
    given["--pole-pairs"] = nf::sheet::read_option(nf::sheet::sheet_option("--pole-pairs"), "1");
    given["--rated-speed"] =
        nf::sheet::read_option(nf::sheet::sheet_option("--rated-speed"), "1000 rpm");
    given["--inertia"] = nf::sheet::read_option(nf::sheet::sheet_option("--inertia"), "0 kg.m2");
    given[option] = nf::sheet::read_option(nf::sheet::sheet_option(option), typed);
    for (const nf::sheet::Made &made : nf::sheet::make_all(given)) {
        if (made.key == key && (made.option == option || key == "inertia_kg_m2")) {
            return made.value();
        }
    }
    return std::nan("");
}

void check(const Typed &one)
{
    const std::string shown = std::string(one.option) + ' ' + one.typed;
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(DEFINED * one.expected, one.expected,
                                      made_of(one.option, one.typed, one.key), shown.c_str());
}

// φ of 1 pole pair is K_t/1.5 per A peak of a phase, K_e of the peak of a phase over rad/s, and
// 1/K_v of it.
const std::vector<Typed> UNITS = {
    {"--poles", "2", "pole_pairs", 1},
    {"--pole-pairs", "3", "pole_pairs", 3},
    {"--resistance", "0.3 ohm phase", "resistance_ohm", 0.3},
    {"--resistance", "300 mohm phase", "resistance_ohm", 0.3},
    {"--inductance", "0.0004 H phase", "inductance_d_h", 4e-4},
    {"--inductance", "0.4 mH phase", "inductance_q_h", 4e-4},
    {"--inductance-d", "400 uH phase", "inductance_d_h", 4e-4},
    {"--inductance-q", "400 uH phase", "inductance_q_h", 4e-4},
    {"--torque-constant", "0.3 N.m/A peak", "flux_linkage_wb", 0.2},
    {"--torque-constant", "300 mN.m/A peak", "flux_linkage_wb", 0.2},
    {"--torque-constant", "30 N.cm/A peak", "flux_linkage_wb", 0.2},
    {"--torque-constant", "3 oz.in/A peak", "flux_linkage_wb", 2 * OZ_IN_NM},
    {"--torque-constant", "3 lb.in/A peak", "flux_linkage_wb", 2 * LB_IN_NM},
    {"--torque-constant", "3 kg.cm/A peak", "flux_linkage_wb", 2 * KGF_CM_NM},
    {"--emf-constant", "20 V/krpm peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
    {"--emf-constant", "20 mV/rpm peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
    {"--emf-constant", "0.02 V/rpm peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
    {"--emf-constant", "0.2 V.s/rad peak phase", "flux_linkage_wb", 0.2},
    {"--emf-constant", "200 mV.s/rad peak phase", "flux_linkage_wb", 0.2},
    {"--kv", "50 rpm/V peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
    {"--kv", "5 rad/s/V peak phase", "flux_linkage_wb", 0.2},
    {"--rated-speed", "2000 rpm", "rated_speed_rpm", 2000},
    {"--rated-speed", "209.43951 rad/s", "rated_speed_rpm", 2000},
    {"--max-speed", "2000 rpm", "max_speed_rpm", 2000},
    {"--max-speed", "209.43951 rad/s", "max_speed_rpm", 2000},
    {"--rated-torque", "2 N.m", "rated_torque_nm", 2},
    {"--rated-torque", "2 mN.m", "rated_torque_nm", 0.002},
    {"--rated-torque", "2 N.cm", "rated_torque_nm", 0.02},
    {"--rated-torque", "2 kgf.cm", "rated_torque_nm", 2 * KGF_CM_NM},
    {"--rated-torque", "2 oz.in", "rated_torque_nm", 2 * OZ_IN_NM},
    {"--rated-torque", "2 lb.in", "rated_torque_nm", 2 * LB_IN_NM},
    {"--rated-torque", "2 lb.ft", "rated_torque_nm", 24 * LB_IN_NM},
    {"--rated-power", "100 W", "rated_torque_nm", 100 / KRPM_RAD_S},
    {"--rated-power", "0.1 kW", "rated_torque_nm", 100 / KRPM_RAD_S},
    {"--rated-power", "1 hp", "rated_torque_nm", 745.69987 / KRPM_RAD_S},
    {"--max-current", "6 A peak", "max_current_a", 6},
    {"--max-current", "600 mA peak", "max_current_a", 0.6},
    {"--continuous-current", "6 A peak", "continuous_current_a", 6},
    {"--continuous-current", "600 mA peak", "continuous_current_a", 0.6},
    {"--demagnetising-current", "6 A peak", "demagnetising_current_a", 6},
    {"--demagnetising-current", "600 mA peak", "demagnetising_current_a", 0.6},
    {"--thermal-time-constant", "30 s", "thermal_time_constant_s", 30},
    {"--thermal-time-constant", "0.5 min", "thermal_time_constant_s", 30},
    {"--inertia", "2 kg.m2", "inertia_kg_m2", 2},
    {"--inertia", "2 kg.cm2", "inertia_kg_m2", 2e-4},
    {"--inertia", "2 g.cm2", "inertia_kg_m2", 2e-7},
    {"--inertia", "2 kg.mm2", "inertia_kg_m2", 2e-6},
    {"--inertia", "2 oz.in2", "inertia_kg_m2", 2 * LB_KG / 16 * INCH_M *INCH_M},
    {"--inertia", "2 oz.in.s2", "inertia_kg_m2", 2 * OZ_IN_NM},
    {"--inertia", "2 lb.in2", "inertia_kg_m2", 2 * LB_KG *INCH_M *INCH_M},
    {"--inertia", "2 lb.in.s2", "inertia_kg_m2", 2 * LB_IN_NM},
    {"--friction", "2 N.m.s", "viscous_friction_nm_s", 2},
    {"--friction", "2 mN.m.s", "viscous_friction_nm_s", 0.002},
    {"--friction", "2 N.m/krpm", "viscous_friction_nm_s", 2 / KRPM_RAD_S},
    {"--friction", "2 mN.m/krpm", "viscous_friction_nm_s", 0.002 / KRPM_RAD_S},
    {"--friction", "2 oz.in/krpm", "viscous_friction_nm_s", 2 * OZ_IN_NM / KRPM_RAD_S},
};

TEST(each_unit_is_what_its_definition_says)
{
    for (const Typed &one : UNITS) {
        check(one);
    }
}

bool is_shown(const nf::sheet::Quantity &quantity, const std::string &symbol)
{
    return std::any_of(UNITS.begin(), UNITS.end(), [&](const Typed &one) {
        const std::string noun = nf::sheet::sheet_option(one.option).quantities[0].noun;
        const std::string typed = one.typed + ' ';
        return noun == quantity.noun &&
               (symbol.empty() || typed.find(' ' + symbol + ' ') != std::string::npos);
    });
}

TEST(no_unit_is_left_without_a_definition)
{
    for (const nf::sheet::SheetOption &option : nf::sheet::sheet_options()) {
        for (const nf::sheet::Quantity &quantity : option.quantities) {
            for (const nf::sheet::Unit &unit : quantity.units) {
                const std::string name = fmt::format("{} {}", option.name, unit.symbol);
                TEST_ASSERT_TRUE_MESSAGE(is_shown(quantity, unit.symbol), name.c_str());
            }
        }
    }
}

TEST(a_unit_may_be_spelt_as_sheets_spell_it)
{
    const std::vector<Typed> spellings = {
        {"--resistance", "0.3Ω phase", "resistance_ohm", 0.3},
        {"--resistance", "300 mΩ per phase", "resistance_ohm", 0.3},
        {"--resistance", "+0.3 Ohms  (star)", "resistance_ohm", 0.3},
        {"--resistance", "3e-1 OHM, phase", "resistance_ohm", 0.3},
        {"--inductance", "400 µH phase", "inductance_d_h", 4e-4},
        {"--inductance", "400 \u03BCH phase", "inductance_d_h", 4e-4},
        {"--rated-torque", "2 N·m", "rated_torque_nm", 2},
        {"--rated-torque", "2 N*m", "rated_torque_nm", 2},
        {"--rated-torque", "2 N-m", "rated_torque_nm", 2},
        {"--rated-torque", "2 N m", "rated_torque_nm", 2},
        {"--rated-torque", "2Nm", "rated_torque_nm", 2},
        {"--rated-torque", "2 mNm", "rated_torque_nm", 0.002},
        {"--rated-torque", "2 Ncm", "rated_torque_nm", 0.02},
        {"--rated-torque", "2 kg·cm", "rated_torque_nm", 2 * KGF_CM_NM},
        {"--rated-torque", "2 kgcm", "rated_torque_nm", 2 * KGF_CM_NM},
        {"--rated-torque", "2 ozin", "rated_torque_nm", 2 * OZ_IN_NM},
        {"--rated-torque", "2 oz-in", "rated_torque_nm", 2 * OZ_IN_NM},
        {"--rated-torque", "2 OZ-IN", "rated_torque_nm", 2 * OZ_IN_NM},
        {"--rated-torque", "2 in-lb", "rated_torque_nm", 2 * LB_IN_NM},
        {"--rated-torque", "2 lbf·ft", "rated_torque_nm", 24 * LB_IN_NM},
        {"--torque-constant", "300 mNm/A peak", "flux_linkage_wb", 0.2},
        {"--torque-constant", "0.3 Nm / A (peak)", "flux_linkage_wb", 0.2},
        {"--torque-constant", "0.3 N·m/Apk", "flux_linkage_wb", 0.2},
        {"--torque-constant", "0.3 N·m per A peak", "flux_linkage_wb", 0.2},
        {"--torque-constant", "3 oz-in/A peak", "flux_linkage_wb", 2 * OZ_IN_NM},
        {"--emf-constant", "20 V/1000rpm peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--emf-constant", "20 V/1000 min⁻¹ peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--emf-constant", "20 Vpeak/krpm phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--emf-constant", "20 V_pk/kRPM, line to neutral", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--emf-constant", "20 V peak/krpm L-N", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--emf-constant", "0.2 V/(rad/s) peak phase", "flux_linkage_wb", 0.2},
        {"--emf-constant", "0.2 Vs/rad peak phase", "flux_linkage_wb", 0.2},
        {"--kv", "50 RPM/V peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--kv", "50 1/min/V peak phase", "flux_linkage_wb", 20 / KRPM_RAD_S},
        {"--kv", "5 (rad/s)/V peak phase", "flux_linkage_wb", 0.2},
        {"--inertia", "2 kg·cm²", "inertia_kg_m2", 2e-4},
        {"--inertia", "2 kgcm2", "inertia_kg_m2", 2e-4},
        {"--inertia", "2 kg*m^2", "inertia_kg_m2", 2},
        {"--inertia", "2 oz-in²", "inertia_kg_m2", 2 * LB_KG / 16 * INCH_M * INCH_M},
        {"--inertia", "2 oz-in-sec²", "inertia_kg_m2", 2 * OZ_IN_NM},
        {"--inertia", "2 oz in s^2", "inertia_kg_m2", 2 * OZ_IN_NM},
        {"--rated-speed", "2000", "rated_speed_rpm", 2000},
        {"--rated-speed", "2000 1/min", "rated_speed_rpm", 2000},
        {"--rated-speed", "2000 min-1", "rated_speed_rpm", 2000},
        {"--rated-speed", "2000 r/min", "rated_speed_rpm", 2000},
        {"--max-current", "6Apk", "max_current_a", 6},
        {"--poles", "2 poles", "pole_pairs", 1},
    };
    for (const Typed &one : spellings) {
        check(one);
    }
}

// A motor with φ = 0.2 Wb and one pole pair, turned at 1 rad/s and looked at, or driven with 1 A
// and held. What its sheet prints is derived here from its sine waves, and gives 0.2 Wb again.
constexpr double FLUX_WB = 0.2;
constexpr int STEPS = 100000;

// The mean of a sine over the 60° about its peak: for so long a pair of phases conducts with
// six-step commutation.
double mean_about_the_peak()
{
    double sum = 0;
    for (int k = 0; k < STEPS; k++) {
        sum += std::cos((-30 + 60 * (k + 0.5) / STEPS) * nf::PI / 180);
    }
    return sum / STEPS;
}

double rms_of_a_sine()
{
    double sum = 0;
    for (int k = 0; k < STEPS; k++) {
        const double value = std::sin(nf::TWO_PI * k / STEPS);
        sum += value * value;
    }
    return std::sqrt(sum / STEPS);
}

// The difference of two sines that are 120° apart.
double peak_between_terminals()
{
    double peak = 0;
    for (int k = 0; k < STEPS; k++) {
        const double angle = nf::TWO_PI * k / STEPS;
        peak = std::max(peak, std::sin(angle) - std::sin(angle - nf::TWO_PI / 3));
    }
    return peak;
}

TEST(each_convention_of_a_voltage_gives_the_motor_that_was_measured)
{
    const double terminals = FLUX_WB * peak_between_terminals();
    const std::pair<const char *, double> volts[] = {
        {"peak phase", FLUX_WB},
        {"rms phase", FLUX_WB * rms_of_a_sine()},
        {"peak phase to phase", terminals},
        {"rms line-to-line", terminals * rms_of_a_sine()},
        {"six-step", terminals * mean_about_the_peak()},
        {"block commutation, terminal to terminal", terminals * mean_about_the_peak()},
    };
    for (const auto &[said, volt] : volts) {
        check({"--emf-constant", fmt::format("{} V.s/rad {}", volt, said), "flux_linkage_wb",
               FLUX_WB});
        check({"--kv", fmt::format("{} rad/s/V {}", 1 / volt, said), "flux_linkage_wb", FLUX_WB});
    }
}

// Power in is power out: three phases with a current in phase with the EMF, or two terminals with a
// constant one.
TEST(each_convention_of_a_torque_constant_gives_the_motor_that_was_measured)
{
    const double per_peak = 3 * FLUX_WB * rms_of_a_sine() * rms_of_a_sine();
    const std::pair<const char *, double> torques[] = {
        {"peak", per_peak},
        {"sine rms phase current", per_peak / rms_of_a_sine()},
        {"six step", FLUX_WB * peak_between_terminals() * mean_about_the_peak()},
        {"dc", FLUX_WB * peak_between_terminals() * mean_about_the_peak()},
    };
    for (const auto &[said, torque] : torques) {
        check({"--torque-constant", fmt::format("{} N.m/A {}", torque, said), "flux_linkage_wb",
               FLUX_WB});
    }
}

// A star of 0.3 Ω shows twice as much between two terminals. A triangle of 0.9 Ω shows 0.9 Ω beside
// 1.8 Ω, the same 0.6 Ω.
TEST(each_convention_of_a_winding_gives_the_star_that_does_the_same)
{
    for (const char *const said :
         {"0.6 ohm phase to phase", "0.6 ohm line-to-line", "0.6 ohm L-L",
          "0.6 ohm terminal to terminal", "0.6 ohm phase to phase, delta", "0.3 ohm phase",
          "0.3 ohm line to neutral", "0.3 ohm wye", "0.9 ohm delta winding"}) {
        check({"--resistance", said, "resistance_ohm", 0.3});
    }
    check({"--inductance", "0.6 mH phase to phase", "inductance_d_h", 0.3e-3});
    check({"--inductance", "0.9 mH delta winding", "inductance_q_h", 0.3e-3});
    check({"--max-current", fmt::format("{} A rms", 6 * rms_of_a_sine()), "max_current_a", 6});
}

TEST(the_formulas_of_the_guide_give_the_same)
{
    const auto by_formula = [](const char *sheet, double x) {
        return nf::conversion(sheet).value(x, 1);
    };
    check({"--kv", "270 rpm/V peak phase to phase", "flux_linkage_wb",
           by_formula("K_v, rpm per V peak between two terminals", 270)});
    check({"--kv", "270 rpm/V rms phase to phase", "flux_linkage_wb",
           by_formula("K_v, rpm per V rms between two terminals", 270)});
    check({"--kv", "270 rpm/V six-step", "flux_linkage_wb",
           by_formula("K_v, rpm per V dc, six-step (block) commutation", 270)});
    check({"--emf-constant", "4.64 V/krpm peak phase to phase", "flux_linkage_wb",
           by_formula("K_e, V peak between two terminals at 1000 rpm", 4.64)});
    check({"--emf-constant", "4.64 V/krpm rms phase to phase", "flux_linkage_wb",
           by_formula("K_e, V rms between two terminals at 1000 rpm", 4.64)});
}

// 1 A of dc makes K_t; the friction at 1000 rpm takes that.
TEST(the_friction_follows_from_what_flows_without_load)
{
    const std::string sheets[][2] = {{"0.3 N.m/A six-step", "1 A 1000 rpm"},
                                     {"0.3 N.m/A peak", "1 A @ 1000 rpm"},
                                     {"0.3 N.m/A peak", "1000 rpm, 1000 mA"},
                                     {"0.3 N.m/A rms", "104.719755 rad/s at 1 A"},
                                     {"0.3 N.m/A peak", "0.70710678 A rms 1000 rpm"}};
    for (const auto &[constant, no_load] : sheets) {
        Given given;
        given["--torque-constant"] =
            nf::sheet::read_option(nf::sheet::sheet_option("--torque-constant"), constant);
        given["--no-load"] = nf::sheet::read_option(nf::sheet::sheet_option("--no-load"), no_load);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(DEFINED * 0.3 / KRPM_RAD_S, 0.3 / KRPM_RAD_S,
                                          nf::sheet::make_all(given).back().value(),
                                          no_load.c_str());
    }
}

// What give() refuses of a sheet that has these.
std::string refusal(const std::vector<std::pair<std::string, std::string>> &typed)
{
    Sheet sheet;
    try {
        for (const auto &[option, value] : typed) {
            sheet.give(option, value);
        }
    } catch (const std::runtime_error &error) {
        return error.what();
    }
    return "taken";
}

void check_refused(const std::string &option, const std::string &typed, const std::string &problem)
{
    const std::string said = refusal({{option, typed}});
    TEST_ASSERT_EQUAL_STRING(fmt::format("{} \"{}\": {}", option, typed, problem).c_str(),
                             said.c_str());
}

TEST(a_convention_that_is_missing_is_asked_for_with_the_words_and_the_factor)
{
    check_refused(
        "--resistance", "0.6 ohm",
        R"(say "phase to phase", twice the value of a phase, "phase", or "delta winding", three times it)");
    check_refused("--max-current", "6 A", R"(say "peak" or "rms"; peak is 1.414 times rms)");
    const std::string kinds[][2] = {{"--torque-constant", "0.1 N.m/A"},
                                    {"--torque-constant", "0.1 N.m/A sine"},
                                    {"--emf-constant", "4 V/krpm"},
                                    {"--emf-constant", "4 V/krpm peak"},
                                    {"--emf-constant", "4 V/krpm phase to phase"},
                                    {"--kv", "270 rpm/V"}};
    for (const auto &[option, typed] : kinds) {
        const std::string said = refusal({{option, typed}});
        for (const char *const needed : {"say \"peak\"", "\"rms\"", "\"six-step\"", " times "}) {
            TEST_ASSERT_TRUE_MESSAGE(said.find(needed) != std::string::npos, said.c_str());
        }
    }
}

TEST(words_that_contradict_each_other_or_mean_nothing_are_refused)
{
    for (const auto &[option, typed] : {std::pair("--max-current", "6 A peak rms"),
                                        std::pair("--resistance", "1 ohm phase line to line"),
                                        std::pair("--resistance", "1 ohm per phase, delta"),
                                        std::pair("--kv", "270 rpm/V six-step per phase"),
                                        std::pair("--kv", "270 rpm/V six-step rms")}) {
        const std::string said = refusal({{option, typed}});
        TEST_ASSERT_TRUE_MESSAGE(
            said.find("contradict each other; allowed: \"p") != std::string::npos, said.c_str());
    }
    for (const auto &[option, typed] :
         {std::pair("--max-current", "6 A peak to peak"),
          std::pair("--resistance", "1 ohm phase rms"), std::pair("--rated-torque", "1 N.m peak"),
          std::pair("--resistance", "1 ohm phase ±10 %")}) {
        const std::string said = refusal({{option, typed}});
        TEST_ASSERT_TRUE_MESSAGE(said.find("is no word for it; allowed: ") != std::string::npos,
                                 said.c_str());
    }
}

TEST(a_unit_that_is_wrong_or_missing_is_answered_with_the_right_ones)
{
    check_refused("--resistance", "0.6", "has no unit for a resistance; allowed: ohm, mohm");
    check_refused("--resistance", "0.6 V phase",
                  R"("V" is no unit of a resistance; allowed: ohm, mohm)");
    check_refused("--resistance", "0.6 MOhm phase",
                  R"("MOhm" is no unit of a resistance; allowed: ohm, mohm)");
    check_refused("--resistance", "0.6 mohm/km phase",
                  R"("mohm/km" is no unit of a resistance; allowed: ohm, mohm)");
    check_refused("--max-current", "6 mN.m", R"("mN.m" is no unit of a current; allowed: A, mA)");
    check_refused(
        "--rated-torque", "1 N.m/A",
        R"("N.m/A" is no unit of a torque; allowed: N.m, mN.m, N.cm, kgf.cm, oz.in, lb.in, lb.ft)");
    for (const char *const typed :
         {"", " ", "-", "ohm", "nan", "inf ohm phase", "1e999 ohm phase", "\xff\xfe"}) {
        const std::string said = refusal({{"--resistance", typed}});
        TEST_ASSERT_TRUE_MESSAGE(said.find("does not begin with a number") != std::string::npos,
                                 said.c_str());
    }
    for (const char *const typed : {"0,6 ohm phase", "1,000 ohm phase"}) {
        const std::string said = refusal({{"--resistance", typed}});
        TEST_ASSERT_TRUE_MESSAGE(said.find("comma") != std::string::npos, said.c_str());
    }
}

TEST(a_text_that_is_too_long_for_a_value_is_refused)
{
    for (const std::size_t count : {std::size_t{201}, std::size_t{1000000}}) {
        const std::string said = refusal({{"--resistance", "1" + std::string(count, 'V')}});
        TEST_ASSERT_TRUE_MESSAGE(said.find("is longer than 200 characters") != std::string::npos,
                                 said.substr(0, 100).c_str());
    }
}

TEST(a_value_out_of_range_is_answered_with_the_range_in_its_own_unit)
{
    check_refused("--resistance", "0.01 mohm phase to phase",
                  "is too small; allowed: 2 to 100000 mohm phase to phase");
    check_refused("--rated-torque", "0 mN.m", "is too small; allowed: 0.01 to 1e+07 mN.m");
    check_refused("--max-current", "5000 A rms", "is too large; allowed: 0.007072 to 707.1 A rms");
    check_refused("--poles", "7", "is not a whole number of pole pairs; allowed: 2 to 100");
    check_refused("--poles", "0", "is too small; allowed: 2 to 100");
    check_refused("--poles", "1e300", "is too large; allowed: 2 to 100");
    check_refused("--rated-speed", "-1000", "is too small; allowed: 1 to 200000 rpm");
    // φ of 7 pole pairs from 1e-5 to 10 Wb
    TEST_ASSERT_EQUAL_STRING(
        "--kv \"0 rpm/V peak phase\": is too small; allowed: 0.1365 to 136400 rpm/V peak phase",
        refusal({{"--poles", "14"}, {"--kv", "0 rpm/V peak phase"}}).c_str());
    const std::string named = refusal({{"--name", ""}});
    TEST_ASSERT_TRUE_MESSAGE(named.rfind("--name: ", 0) == 0, named.c_str());
}

TEST(a_load_has_no_negative_inertia)
{
    TEST_ASSERT_EQUAL_STRING(
        "--load-inertia \"-1 g.cm2\": is below 0",
        refusal({{"--inertia", "181 g.cm2"}, {"--load-inertia", "-1 g.cm2"}}).c_str());
}

TEST(the_ends_of_a_range_that_is_named_are_taken)
{
    for (const char *const end : {"0.1365 rpm/V peak phase", "136400 rpm/V peak phase"}) {
        TEST_ASSERT_EQUAL_STRING("taken", refusal({{"--poles", "14"}, {"--kv", end}}).c_str());
    }
    for (const char *const end : {"0.007072 A rms", "707.1 A rms"}) {
        TEST_ASSERT_EQUAL_STRING("taken", refusal({{"--max-current", end}}).c_str());
    }
}

TEST(what_gives_the_same_twice_is_refused)
{
    for (const auto &[one, first, other, second] :
         {std::array{"--poles", "8", "--pole-pairs", "4"},
          std::array{"--inductance", "1 mH phase", "--inductance-d", "1 mH phase"},
          std::array{"--inductance", "1 mH phase", "--inductance-q", "1 mH phase"},
          std::array{"--friction", "0", "--no-load", "1 A six-step 1000 rpm"}}) {
        TEST_ASSERT_EQUAL_STRING(
            fmt::format("{} \"{}\": {} \"{}\" gives the same; leave one of them out", other, second,
                        one, first)
                .c_str(),
            refusal({{one, first}, {other, second}}).c_str());
    }
}

const std::vector<std::pair<std::string, std::string>> FLAT_MOTOR = {
    {"--name", "flat \"70\" W \\"},
    {"--poles", "16"},
    {"--resistance", "0.608 ohm phase to phase"},
    {"--inductance", "0.463 mH phase to phase"},
    {"--torque-constant", "36.9 mN.m/A six-step"},
    {"--rated-speed", "4000"},
    {"--rated-torque", "128 mN.m"},
    {"--max-current", "6 A peak"},
    {"--inertia", "181 g.cm2"},
    {"--no-load", "234 mA 6110 rpm"},
};

Sheet sheet_of(const std::vector<std::pair<std::string, std::string>> &more = {},
               const std::string &without = "")
{
    Sheet sheet;
    for (const auto *all : {&FLAT_MOTOR, &more}) {
        for (const auto &[option, typed] : *all) {
            if (option != without) {
                sheet.give(option, typed);
            }
        }
    }
    return sheet;
}

nf::MotorSettings loaded(const Sheet &sheet)
{
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        fmt::format("nf_sheet_{}.toml", static_cast<const void *>(&sheet));
    std::ofstream(path) << sheet.motor_file();
    const nf::MotorSettings motor = nf::load_motor(path.string()).motor;
    std::filesystem::remove(path);
    return motor;
}

// K_t: 0.0369/8·(1/√3)/(3/π) by hand; friction 0.0369 N·m/A · 0.234 A at 639.84 rad/s.
TEST(the_file_is_loaded_as_it_was_meant)
{
    const nf::MotorSettings motor =
        loaded(sheet_of({{"--load-inertia", "19 g.cm2"}, {"--max-speed", "4400"}}));
    TEST_ASSERT_EQUAL_STRING("flat \"70\" W \\", motor.name.c_str());
    TEST_ASSERT_EQUAL_INT(8, motor.pole_pairs);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.304, motor.resistance_ohm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2315e-3, motor.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2315e-3, motor.inductance_q_h);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.00278872, motor.flux_linkage_wb);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.128, motor.rated_torque_nm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4000, motor.rated_speed_rpm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4400, motor.max_speed_rpm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 6, motor.max_current_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2e-5, motor.inertia_kg_m2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 1.3495e-5, motor.viscous_friction_nm_s);
}

TEST(behind_each_value_stands_what_was_typed)
{
    const std::string text = sheet_of().motor_file();
    for (const auto &[option, typed] : FLAT_MOTOR) {
        const bool is_there =
            option == "--name" ||
            text.find(fmt::format(" # {} {}", option, typed)) != std::string::npos;
        TEST_ASSERT_TRUE_MESSAGE(is_there, option.c_str());
    }
}

TEST(a_sheet_that_lacks_one_value_names_it)
{
    TEST_ASSERT_TRUE(sheet_of().missing().empty());
    for (const auto &entry : FLAT_MOTOR) {
        const std::vector<std::vector<std::string>> missing = sheet_of({}, entry.first).missing();
        TEST_ASSERT_FALSE_MESSAGE(missing.empty(), entry.first.c_str());
        TEST_ASSERT_EQUAL_STRING(entry.first.c_str(), missing.front().front().c_str());
    }
}

void check_remark(const std::vector<std::pair<std::string, std::string>> &more,
                  const std::string &expected)
{
    std::string all;
    for (const std::string &remark : sheet_of(more).remarks()) {
        all += remark + '\n';
    }
    TEST_ASSERT_TRUE_MESSAGE(all.find(expected) != std::string::npos,
                             (expected + " not in:\n" + all).c_str());
}

TEST(what_contradicts_is_remarked_with_its_size_and_with_what_is_taken)
{
    const std::string constant = "--torque-constant \"36.9 mN.m/A six-step\", which is taken";
    check_remark({{"--kv", "251 rpm/V six-step"}},
                 "--kv \"251 rpm/V six-step\" gives 3.1 % more flux linkage than " + constant +
                     "\n");
    // 259 rpm per V of six steps are 259·3/π per V peak between two terminals
    check_remark({{"--kv", "247.13 rpm/V peak phase to phase"}},
                 "gives the same flux linkage as " + constant);
    check_remark({{"--kv", "259 rpm/V rms phase to phase"}},
                 "gives 35 % more flux linkage than " + constant +
                     "; --kv would fit as \"six-step\"");
    check_remark({{"--emf-constant", "2 V/krpm peak phase to phase"}},
                 "gives 51 % less flux linkage than " + constant);
    check_remark(
        {{"--rated-power", "70 W"}},
        "--rated-power \"70 W\" is 31 % more power than the 53.62 W of --rated-torque \"128 mN.m\"");
    check_remark({{"--max-speed", "3000"}}, "--max-speed \"3000\" is below --rated-speed \"4000\"");
    check_remark({{"--rated-speed", "7000"}},
                 "--rated-speed \"7000\" is above the 6110 rpm without load");
    check_remark({{"--max-current", "2 A peak"}},
                 "rated torque takes 3.82 A peak, more than --max-current \"2 A peak\"");
    check_remark({{"--continuous-current", "10 A peak"}},
                 "--continuous-current \"10 A peak\" is above --max-current");
    check_remark({}, "no --max-speed: the drive asks for the rated speed at most");
}

TEST(what_is_refused_leaves_the_sheet_as_it_was)
{
    Sheet sheet = sheet_of();
    const std::string before = sheet.motor_file();
    for (const char *const typed : {"0.6", "0.6 ohm", "1e9 ohm phase"}) {
        try {
            sheet.give("--resistance", typed);
            TEST_FAIL_MESSAGE(typed);
        } catch (const std::runtime_error &) {
            TEST_ASSERT_EQUAL_STRING(before.c_str(), sheet.motor_file().c_str());
        }
    }
}

} // namespace
