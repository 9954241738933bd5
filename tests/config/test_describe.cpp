// SPDX-License-Identifier: MIT
// What a row of cfg.def says one of its setting is, against what the files say in SI units.
#include "cfg_rows.h"
#include "config.h"
#include "describe.h"

#include "testing.h"

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace
{

constexpr double ROUNDED =
    1e-3; // relative: the smallest of these words is 655, half a step of it 0.8e-3

struct Expected {
    const char *path;
    double value;
    const char *unit;
};

const nf::CfgRow &row_of(std::string_view path)
{
    for (const nf::CfgRow &row : nf::cfg_rows()) {
        if (row.path == path) {
            return row;
        }
    }
    throw std::invalid_argument(std::string(path));
}

void expect(const nf::Config &config, const std::vector<Expected> &all)
{
    const drive_cfg_t cfg = nf::build(config);
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    for (const Expected &expected : all) {
        const nf::CfgRow &row = row_of(expected.path);
        const nf::Format format = nf::format_of(row, bases, cfg);
        const double value =
            (static_cast<double>(nf::raw_value(row, cfg)) - format.zero) * format.one;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(expected.value * ROUNDED, expected.value, value,
                                          expected.path);
        TEST_ASSERT_EQUAL_STRING_MESSAGE(expected.unit, format.unit, expected.path);
    }
}

// R 2.125 Ω, L 11.6 mH, φ 0.387 Wb; 10 kHz, slow period 1 ms, supervision every 4 ms; current loops
// 500 Hz and 50 Hz.
TEST(settings_are_what_the_files_say_in_si_units)
{
    const nf::Config config =
        nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {},
                       {"speed_loop.ramp_rpm_s=5000", "model.dead_time_s=2e-6",
                        "model.device_drop_v=1.2", "observer.kappa=0.025"});
    expect(config, {
                       {"protection.current_max", 18, "A"},
                       {"protection.bus_max", 400, "V"},
                       {"derating.heat_rate", 1 / 20.0, "1/s"},
                       {"observer.decay", 1e-4 * 2.125 / 0.0116, ""},
                       {"observer.volt_gain", 1e-4 / 0.0116, "A/V"},
                       {"observer.flux_q27", 0.387 / 0.0116, "A"},
                       {"observer.corner", 2.125 / 0.0116, "rad/s"},
                       {"current_loop.reactance_d_q13", 0.0116, "H"},
                       {"current_loop.emf_q13", 0.387, "Wb"},
                       {"current_loop.resistance_q13", 2.125, "Ohm"},
                       {"current_loop.pi_d.kp", 3.23933, ""},
                       {"current_loop.pi_d.ki", 0.101767, ""},
                       {"speed_loop.ramp", 5000, "rpm/s"},
                       {"speed_loop.speed_max", 2000, "rpm"},
                       {"modulator.dead_time_q15", 2e-6, "s"},
                       {"supervision.speed_error_periods", 0.5, "s"},
                       {"startup.lost_periods", 0.1, "s"},
                       {"slow_ticks", 1e-3, "s"},
                   });
}

TEST(settings_of_the_voltage_drive_are_what_its_file_says_in_si_units)
{
    const nf::Config config =
        nf::load_parts("motor_b", "bench_310v", "voltage_phase", {},
                       {"voltage_loop.kp_v_s_per_rad=0.4", "voltage_loop.ki_v_per_rad=3",
                        "phase_compensator.lead_max_deg=40", "phase_compensator.brake_max_deg=5"});
    expect(config, {
                       {"voltage_drive.enabled", 1, ""},
                       {"voltage_drive.pi.kp", 0.4, "V s/rad"},
                       {"voltage_drive.pi.ki", 3, "V/rad"},
                       {"voltage_drive.compensator.lead_max", 40, "deg"},
                       {"voltage_drive.compensator.brake_max", 5, "deg"},
                   });
}

std::string meaning(const char *path)
{
    const nf::Config config = nf::load_parts("motor_a", "bench_310v", "robust_motor_a", {},
                                             {"speed_loop.bandwidth_hz=14"});
    for (const nf::ConfigRow &row : nf::describe(config, nf::build(config))) {
        if (row.path == path) {
            return row.meaning;
        }
    }
    return "";
}

TEST(a_row_shows_its_meaning_with_value_unit_and_what_it_was_made_of)
{
    TEST_ASSERT_EQUAL_STRING("18 A", meaning("protection.current_max").c_str());
    TEST_ASSERT_EQUAL_STRING("low sides on for 0 s at a standing rotor",
                             meaning("startup.flying_start.charge_ticks").c_str());
    TEST_ASSERT_EQUAL_STRING("starts before it is a fault", meaning("startup.attempts").c_str());
    TEST_ASSERT_EQUAL_STRING(", bandwidth 14 Hz", meaning("speed_loop.pi.kp").substr(12).c_str());
}

} // namespace
