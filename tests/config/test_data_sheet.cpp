// SPDX-License-Identifier: MIT
// What data sheets print is turned into what a motor file holds, and the page for users says how.
#include "config.h"
#include "data_sheet.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "testing.h"
#include <fmt/format.h>

namespace
{

// Printed values have three digits and more.
constexpr double PRINTED = 1e-3;

struct Example {
    const char *sheet;
    double printed;
    double second; // pole pairs, rpm or gear
    double in_file;
};

// Sources: the headers of host_sim/motors/teknic_m2310p.toml and odrive_d5065.toml. K_t = 8.27/270
// is 1.5·P·φ of the latter. Values in rms are the same motors', divided by √2 by hand. In a
// triangle of 3 Ω each two terminals show 3 Ω beside 6 Ω, that is 2 Ω: both lines give the star of
// 1 Ω. Six steps: K_t·K_v = 60/(2π), as power in is power out; two phases carry the current I over
// ±30° about the peak of √3·φ·P·ω, so T = √3·φ·P·I·(sin 30° + sin 30°)/(π/3).
constexpr Example EXAMPLES[] = {
    {"number of poles", 14, 1, 7},
    {"resistance between two terminals, Ω, star or delta", 0.72, 1, 0.36},
    {"resistance between two terminals, Ω, star or delta", 2, 1, 1},
    {"inductance between two terminals, H, star or delta", 0.40e-3, 1, 0.20e-3},
    {"resistance of one winding in delta, Ω", 3, 1, 1},
    {"inductance of one winding in delta, H", 3e-3, 1, 1e-3},
    {"K_v, rpm per V peak between two terminals", 270, 7, 0.002917},
    {"K_v, rpm per V rms between two terminals", 381.84, 7, 0.002917},
    {"K_v, rpm per V dc, six-step (block) commutation", 187, 8, 0.003859},
    {"K_e, V peak between two terminals at 1000 rpm", 4.64, 4, 0.006396},
    {"K_e, V rms between two terminals at 1000 rpm", 3.2810, 4, 0.006396},
    {"K_e, V·s/rad of the shaft, peak between two terminals", 0.044309, 4, 0.006396},
    {"K_t, N·m per A peak of a phase", 0.0384, 4, 0.0064},
    {"K_t, N·m per A peak of a phase", 0.03063, 7, 0.002917},
    {"K_t, N·m per A rms of a phase", 0.054271, 4, 0.006396},
    {"K_t, N·m per A dc, six-step (block) commutation", 0.05106, 8, 0.003859},
    {"current, A rms of a phase", 5.0205, 1, 7.1},
    {"rated power, W, at n rpm", 100, 4000, 0.23873},
    {"inertia of the rotor, g·cm², to which the load's is added", 70.6, 1, 7.06e-6},
    {"inertia of a load behind a gear of i : 1, kg·m², to be added", 0.01, 10, 1e-4},
};

TEST(every_formula_gives_the_value_of_its_example)
{
    for (const nf::Conversion &conversion : nf::conversions()) {
        bool shown = false;
        for (const Example &example : EXAMPLES) {
            if (std::string(example.sheet) == conversion.sheet) {
                shown = true;
                TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(PRINTED * example.in_file, example.in_file,
                                                  conversion.value(example.printed, example.second),
                                                  conversion.sheet);
            }
        }
        TEST_ASSERT_TRUE_MESSAGE(shown, conversion.sheet);
    }
}

// The motor files that state where their values are from hold what the formulas make of them.
TEST(the_shipped_motors_hold_what_their_data_sheets_give)
{
    const nf::MotorSettings teknic = nf::load_motor("teknic_m2310p").motor;
    const nf::MotorSettings odrive = nf::load_motor("odrive_d5065").motor;
    TEST_ASSERT_DOUBLE_WITHIN(PRINTED * 0.0064, 0.006396, teknic.flux_linkage_wb);
    TEST_ASSERT_DOUBLE_WITHIN(PRINTED * 0.36, 0.36, teknic.resistance_ohm);
    TEST_ASSERT_DOUBLE_WITHIN(PRINTED * 0.0002, 0.0002, teknic.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(PRINTED * 0.0029, 0.002917, odrive.flux_linkage_wb);
}

TEST(formulas_are_shown_as_they_are_computed)
{
    const std::string expected[] = {
        "0.5·x",       "0.5·x",       "0.5·x",        "0.3333·x",     "0.3333·x",   "5.513/(x·P)",
        "7.797/(x·P)", "5.774/(x·P)", "0.005513·x/P", "0.007797·x/P", "0.5774·x/P", "0.6667·x/P",
        "0.4714·x/P",  "0.6046·x/P",  "1.414·x",      "9.549·x/n",    "1e-07·x",    "1·x/i²"};
    TEST_ASSERT_EQUAL_size_t(std::size(expected), nf::conversions().size());
    for (std::size_t k = 0; k < std::size(expected); k++) {
        TEST_ASSERT_EQUAL_STRING(expected[k].c_str(), nf::conversions()[k].formula().c_str());
    }
}

TEST(the_page_for_users_has_every_line)
{
    std::ifstream file(NF_FILES_PAGE);
    const std::string page((std::istreambuf_iterator<char>(file)), {});
    for (const nf::Conversion &conversion : nf::conversions()) {
        const std::string line = fmt::format("| {} | `{}` | {} |\n", conversion.sheet,
                                             conversion.key, conversion.formula());
        TEST_ASSERT_TRUE_MESSAGE(page.find(line) != std::string::npos, line.c_str());
    }
}

} // namespace
