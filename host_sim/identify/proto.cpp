// SPDX-License-Identifier: MIT
#include "evaluate.h"
#include "flux_fit.h"
#include "inertia_fit.h"
#include "measure.h"
#include "machine.h"
#include "found_fault.h"
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
using namespace nf;
static void print(const char *name, double value, double std, double bound)
{
    printf("%s %.9g %.9g %.9g\n", name, value, std, bound);
}
static void print(const char *name, const identify::Estimate &e)
{
    print(name, e.value, e.std, e.bound);
}
// The values of a text of records.
static int evaluate_file(const char *path)
{
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    try {
        const auto records = identify::parse_records(text.str(), path);
        const auto legs = identify::fit_legs(records);
        identify::Known known;
        const auto r = identify::evaluate(records, known, path);
        const auto &m = r.motor;
        const auto &e = r.measured;
        print("R", m.resistance_ohm, e.resistance_std_pct, e.resistance_bound_pct);
        print("Ld", m.inductance_d_h, e.inductance_d_std_pct, e.inductance_d_bound_pct);
        print("Lq", m.inductance_q_h, e.inductance_q_std_pct, e.inductance_q_bound_pct);
        print("phi", m.flux_linkage_wb, e.flux_linkage_std_pct, e.flux_linkage_bound_pct);
        print("J", m.inertia_kg_m2, e.inertia_std_pct, e.inertia_bound_pct);
        print("V0", legs.loss_v);
        print("knee", legs.knee_a);
        print("m", legs.mismatch);
        print("B", m.viscous_friction_nm_s, 0, e.viscous_friction_bar_nm_s);
        print("C", e.coulomb_friction_nm, 0, e.coulomb_friction_bar_nm);
        print("td", e.dead_time_s, 0, e.dead_time_bar_s);
        print("bus", e.bus_v, 0, 0);
        print("ic", e.current_a, 0, 0);
        print("noise", e.current_noise_lsb, 0, 0);
        print("rated", m.rated_speed_rpm, 0, 0);
        const auto inductances = identify::fit_inductances(identify::bursts_of(records, legs), legs, {});
        const auto flux = identify::fit_flux(records, legs, inductances);
        print("phit", flux.turning_wb);
        if (flux.coasting_wb) { print("phic", *flux.coasting_wb); }
        for (const auto &s : r.remarks) { printf("remark %s\n", s.c_str()); }
    } catch (const ConfigError &error) {
        printf("error %s\n", error.what());
        return 2;
    }
    return 0;
}
int main(int argc, char **argv)
{
    if (argc == 3 && !strcmp(argv[1], "records")) { return evaluate_file(argv[2]); }
    std::vector<std::string> set(argv + 2, argv + argc);
    const Config c = load_scenario(argv[1], {}, set);
    Simulation sim(c);
    const Bases &b = sim.bases();
    plant_cfg_t p = make_plant_cfg(c, sim.cfg());
    FILE *trace = nullptr;
    if (const char *t = getenv("TRACE")) trace = fopen(t, "w");
    long n = 0; int every = 10; double imax=0;
    auto m = identify::measure(sim, [&](const Simulation &s) {
        plant_view_t v; plant_view(&s.plant(), &v);
        for (double i : v.i_abc_a) imax = std::max(imax, std::abs(i));
        if (trace && n++ % every == 0) {
            const drive_t &d = s.drive();
            fprintf(trace, "%.5f,%.4f,%.4f,%.4f,%.4f,%d,%d,%d,%d,%d,%d,%d\n", v.time_s, v.theta_el_rad, v.omega_mech_rad_s, v.i_d_a, v.i_q_a,
                (int)d.signals.current_frame.d, (int)d.signals.current_frame.q, (int)d.signals.voltage.d, (int)d.signals.voltage.q, (int)d.vector.step, (int)(d.vector.position.turns_q32>>8), (int)d.probe.lag_q15);
        }
    });
    printf("truth P %d R %.9g Ld %.9g Lq %.9g phi %.9g J %.9g B %.9g C %.9g td %.9g drop %.9g knee %.9g bus %.9g T %.9g Icont %.9g Imax %.9g sat %g %g %g %g ga %g gb %g\n",
        (int)p.motor.pole_pairs, p.motor.resistance_ohm, p.motor.inductance_d_h, p.motor.inductance_q_h, p.motor.flux_linkage_wb,
        p.motor.inertia_kg_m2, p.motor.viscous_friction_nm_s, p.motor.coulomb_friction_nm, c.plant.dead_time_s, c.plant.device_drop_v, p.supply.commutation_knee_a, c.board.bus_nominal_v,
        b.control_period_s, c.motor.continuous_current_a, c.motor.max_current_a, p.motor.saturation_d, p.motor.saturation_q, p.motor.saturation_shared, p.motor.saturation_a, c.plant.adc_gain_error_pct[0], c.plant.adc_gain_error_pct[1]);
    printf("bases Ib %.9g Ub %.9g wmax %.9g shift %d\n", 2*c.board.current_full_scale_a, c.board.bus_full_scale_v, c.motor.max_speed_rpm, (int)sim.cfg().speed_shift);
    for (auto &l : m.lines) printf("%s\n", l.c_str());
    printf("end %s state %d fault %d duration %.3f imax %.3f oc %.3f\n", m.refusal.c_str(), sim.drive().state, sim.drive().fault.id, m.duration_s, imax, c.board.overcurrent_a);
}
