// SPDX-License-Identifier: MIT
#include "evaluate.h"
#include "measure.h"
#include "numbers.h"
#include "plate.h"
#include "truth.h"
#include <cstdio>
#include <fmt/format.h>
using namespace nf;
using namespace nf::identify;
int main(int argc, char **argv)
{
    std::vector<std::string> set(argv + 2, argv + argc);
    const Config c = load_scenario(argv[1], {}, set);
    Config plate = c;
    plate.motor = plate_of(c.motor);
    plate.model.resistance = plate.model.inductance = plate.model.flux = plate.model.inertia = 1;
    const Config believed = with_typical(plate);
    Simulation sim(c, believed);
    const Measurement m = measure(sim);
    if (!m.refusal.empty()) {
        fmt::print("{} REFUSED {} {:.2f} fault {}\n", argv[1], m.refusal, m.duration_s,
                   (int)sim.drive().fault.id);
        return 1;
    }
    const Truth t = truth_of(c);
    const Result r = evaluate(read_records(m.lines, argv[1]), plate, 25);
    const MeasuredSettings &b = r.measured;
    auto one = [&](const char *n, double v, double tr, double s, double bo) {
        fmt::print(" {} {:.3f} {:.3f} {:.3f}", n, 100 * (v / tr - 1), s, bo);
    };
    fmt::print("{} {:.2f}", argv[1], m.duration_s);
    one("R", r.motor.resistance_ohm, t.resistance_ohm, b.resistance_std_pct,
        b.resistance_bound_pct);
    one("Ld", r.motor.inductance_d_h, t.inductance_d_h, b.inductance_d_std_pct,
        b.inductance_d_bound_pct);
    one("Lq", r.motor.inductance_q_h, t.inductance_q_h, b.inductance_q_std_pct,
        b.inductance_q_bound_pct);
    one("phi", r.motor.flux_linkage_wb, t.flux_linkage_wb, b.flux_linkage_std_pct,
        b.flux_linkage_bound_pct);
    one("J", r.motor.inertia_kg_m2, t.inertia_kg_m2, b.inertia_std_pct, b.inertia_bound_pct);
    const double ic = continuous_current(c.motor);
    fmt::print(" td {:.1f} {:.1f} 0 ",
               (r.lost_time_s - lost_time_s(t.dead_time_s, t.knee_a, ic)) * 1e9,
               r.lost_time_bar_s * 1e9);
    for (auto &x : r.remarks) {
        fmt::print(" | {}", x);
    }
    fmt::print("\n");
}
