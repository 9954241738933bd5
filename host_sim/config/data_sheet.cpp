// SPDX-License-Identifier: MIT
#include "data_sheet.h"

#include "si.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double SQRT_2 = 1.41421356237309504880;
constexpr double SQRT_3 = 1.73205080756887729353;
constexpr double STAR = 1 / 2.0;  // two phases in series between two terminals
constexpr double DELTA = 1 / 3.0; // the star that does the same as a triangle
// Of the peak voltage between two terminals at an electrical speed.
constexpr double FLUX_PER_LINE = 1 / SQRT_3;
constexpr double PER_THOUSAND = 1e-3;
constexpr double FLUX_PER_TORQUE = 1 / 1.5; // T = 1.5·P·φ·i
// Six-step commutation: the mean of the voltage between two terminals over the 60° for which the
// two conduct, by its peak.
constexpr double SIX_STEP = 3 / PI;
constexpr double KG_M2_PER_G_CM2 = 1e-7;

// clang-format off
const std::vector<Conversion> CONVERSIONS = {
    {"number of poles", "pole_pairs", 1 / 2.0, 1, "", 0},
    {"resistance between two terminals, Ω, star or delta", "resistance_ohm", STAR, 1, "", 0},
    {"inductance between two terminals, H, star or delta", "inductance_d_h, inductance_q_h", STAR, 1, "", 0},
    {"resistance of one winding in delta, Ω", "resistance_ohm", DELTA, 1, "", 0},
    {"inductance of one winding in delta, H", "inductance_d_h, inductance_q_h", DELTA, 1, "", 0},
    {"K_v, rpm per V peak between two terminals", "flux_linkage_wb", FLUX_PER_LINE / RAD_S_PER_RPM, -1, "P", 1},
    {"K_v, rpm per V rms between two terminals", "flux_linkage_wb", SQRT_2 * FLUX_PER_LINE / RAD_S_PER_RPM, -1, "P", 1},
    {"K_v, rpm per V dc, six-step (block) commutation", "flux_linkage_wb", FLUX_PER_LINE / SIX_STEP / RAD_S_PER_RPM, -1, "P", 1},
    {"K_e, V peak between two terminals at 1000 rpm", "flux_linkage_wb", PER_THOUSAND * FLUX_PER_LINE / RAD_S_PER_RPM, 1, "P", 1},
    {"K_e, V rms between two terminals at 1000 rpm", "flux_linkage_wb", PER_THOUSAND * SQRT_2 * FLUX_PER_LINE / RAD_S_PER_RPM, 1, "P", 1},
    {"K_e, V·s/rad of the shaft, peak between two terminals", "flux_linkage_wb", FLUX_PER_LINE, 1, "P", 1},
    {"K_t, N·m per A peak of a phase", "flux_linkage_wb", FLUX_PER_TORQUE, 1, "P", 1},
    {"K_t, N·m per A rms of a phase", "flux_linkage_wb", FLUX_PER_TORQUE / SQRT_2, 1, "P", 1},
    {"K_t, N·m per A dc, six-step (block) commutation", "flux_linkage_wb", FLUX_PER_LINE / SIX_STEP, 1, "P", 1},
    {"current, A rms of a phase", "max_current_a, continuous_current_a", SQRT_2, 1, "", 0},
    {"rated power, W, at n rpm", "rated_torque_nm", 1 / RAD_S_PER_RPM, 1, "n", 1},
    {"inertia of the rotor, g·cm², to which the load's is added", "inertia_kg_m2", KG_M2_PER_G_CM2, 1, "", 0},
    {"inertia of a load behind a gear of i : 1, kg·m², to be added", "inertia_kg_m2", 1, 1, "i", 2},
};
// clang-format on

} // namespace

double Conversion::value(double x, double second) const
{
    return factor * std::pow(x, power) / std::pow(second, by_power);
}

std::string Conversion::formula() const
{
    const std::string times = power > 0 ? "·x" : "";
    const std::string under = power > 0 ? by : fmt::format("(x·{})", by);
    const std::string squared = by_power > 1 ? "²" : "";
    return fmt::format("{:.4g}{}{}{}{}", factor, times, *by == '\0' ? "" : "/",
                       *by == '\0' ? "" : under, squared);
}

const std::vector<Conversion> &conversions()
{
    return CONVERSIONS;
}

const Conversion &conversion(const std::string &sheet)
{
    for (const Conversion &row : CONVERSIONS) {
        if (row.sheet == sheet) {
            return row;
        }
    }
    throw std::out_of_range("no conversion of " + sheet);
}

} // namespace nf
