// SPDX-License-Identifier: MIT
// The firmware's numbers from SI units by hand, none with the code's own constants: motor A every
// field, most of them in example_cfg.h of the firmware's own tests with their way of getting there;
// of motor B what another motor, another tuning and the ends of a range make otherwise.
#include "config.h"
#include "describe.h"
#include "numbers.h"
#include "per_unit.h"
#include "setting_error.h"
#include "startup_units.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "testing.h"

extern "C" drive_cfg_t example_cfg(void);

namespace
{

// What example_cfg.h takes in place of the tuning `published` and of what follows from the motor.
const std::vector<std::string> AS_BY_HAND = {
    "tuning.command_timeout_s=0",
    "tuning.console_timeout_s=0",
    "input.kind=voltage",
    "input.both_ways=true",
    "motor.continuous_current_a=6.719",
    "startup.current_pct=119.0653", // 8 A
    "supervision.oscillation=fault",
    "supervision.oscillation_half_waves=20",
    "observer.kappa=0.005",
    "observer.kappa_p=0.1",
    "observer.rho_max=2",
    "model.dead_time_s=2e-6",
    "model.device_drop_v=1.2",
};

// Where example_cfg.h has another number than follows from the bench and the rules.
const std::map<std::string, std::int64_t> FROM_THE_RULES = {
    {"derating.temperature.zero", 3072}, // 100 °C of -50 °C to 150 °C: 3/4 of 4096
    {"derating.temperature_lowest", 51}, // a quarter of 5 % of 4096
    {"derating.temperature_highest", 4045},
    {"derating.bus_high.zero", 28308}, // 355 V and 3/4 of the way to 400 V: 388.75 V of 450 V
    {"derating.bus_high.gain", 27307}, // 2^15 · 2^11 over 33.75 V of 450 V, 2457.6
    {"startup.residual_max", 1376},    // 1/4 of the continuous current, 5504
    {"startup.residual_lost", 4128},   // 3/4 of it
    {"startup.settle_periods", 10},    // 0.15·180 rpm at 2587 rpm/s: 10.4 ms
};

// Not of this tuning, or a sum over all others.
const std::vector<std::string> NOT_BY_HAND = {"voltage_drive.", "model.",
                                              "startup.flying_start.gap_factor", "sensor.", "crc"};

constexpr std::size_t BY_HAND_LEAST = 100;

bool is_by_hand(const std::string &path)
{
    return std::none_of(NOT_BY_HAND.begin(), NOT_BY_HAND.end(),
                        [&](const std::string &start) { return path.rfind(start, 0) == 0; });
}

// Each number by hand was rounded, of a value with four digits and more. A power of two is exact.
std::int64_t tolerance(const std::string &path)
{
    const bool is_power =
        path.find("shift") != std::string::npos || path.find("log2") != std::string::npos;
    return is_power ? 0 : 1;
}

TEST(every_field_is_what_was_worked_out_by_hand)
{
    const nf::Config config = nf::load_parts("motor_a", "bench_310v", "published", {}, AS_BY_HAND);
    const std::vector<nf::ConfigRow> built = nf::describe(config, nf::build(config));
    const std::vector<nf::ConfigRow> hand = nf::describe(config, example_cfg());
    std::size_t compared = 0;
    std::string wrong;
    for (std::size_t k = 0; k < built.size(); k++) {
        const std::string &path = built[k].path;
        const auto rule = FROM_THE_RULES.find(path);
        const std::int64_t expected = rule == FROM_THE_RULES.end() ? hand[k].value : rule->second;
        if (!is_by_hand(path)) {
            continue;
        }
        compared++;
        if (std::abs(built[k].value - expected) > tolerance(path)) {
            wrong += fmt::format("{} is {} and not {}; ", path, built[k].value, expected);
        }
    }
    TEST_ASSERT_EQUAL_STRING("", wrong.c_str());
    TEST_ASSERT_GREATER_THAN(BY_HAND_LEAST, compared);
}

constexpr double ROUNDING = 0.5 + 1e-6;
constexpr double MANTISSA =
    1e-4; // relative: half a step of a mantissa of 14 bits at least, and counters rounded up

// R 0.405 Ω, L_d 13.5 mH, L_q 23.5 mH, φ 0.375 Wb, P 2, 3.98 N·m, 1200 and 1800 rpm, 6.3 A, J
// 0.011; 10 kHz, ±20 A, 450 V, 310 V (200…400), over-current 18 A. I_b = 40 A, U_b = 450 V, T = 100
// µs, slow 1 ms, supervision every 4 ms. I_c = 3.98/(1.5·2·0.375) = 3.53778 A. A rpm is
// 2/60/10000·2^32 = 14316.5577 steps.
constexpr double CONTINUOUS_Q15 = 3.53778 / 40 * 32768; // 2898.15
constexpr double STEPS_PER_RPM = 14316.5577;

drive_cfg_t motor_b(const std::vector<std::string> &set = {}, const char *tuning = "robust_motor_a")
{
    return nf::build(nf::load_parts("motor_b", "bench_310v", tuning, {}, set));
}

void expect(double by_hand, double found)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, by_hand, found);
}

void expect_mantissa(double by_hand, double mantissa, unsigned shift)
{
    TEST_ASSERT_DOUBLE_WITHIN(MANTISSA * by_hand, by_hand,
                              std::ldexp(mantissa, -static_cast<int>(shift)));
}

void expect_gain(double by_hand, const pi_cfg_t &pi)
{
    expect_mantissa(by_hand, pi.kp, pi.kp_shift);
}

void expect_integral(double by_hand, const pi_cfg_t &pi)
{
    expect_mantissa(by_hand * 2048, pi.ki, pi.ki_shift);
}

// Motor A, I_b is 40 A. Three phases within the over-current limit make 2/sqrt(3)·18 A = 20.785 A.
// With phi/L of 19.095 A the sum is 39.88 A and fits I_b, with 19.31 A it is 40.095 A and takes
// twice of it. With phi/L_d of 33.4 A it fits 80 A; there the q state is 20.785 A·L_q/L_d: three
// times L_d/L_q is 62.4 A, and 81 A if the drive may correct it by 30 %.
TEST(the_observers_base_holds_the_longest_vector_and_the_largest_saliency)
{
    const struct {
        std::vector<std::string> set;
        std::uint32_t shift;
    } cases[] = {
        {{"motor.flux_linkage_wb=0.2215", "motor.rated_torque_nm=4"}, 0},
        {{"motor.flux_linkage_wb=0.2240", "motor.rated_torque_nm=4"}, 1},
        {{"motor.inductance_q_h=0.0348", "adaptation.saliency_pct=28"}, 1},
        {{"motor.inductance_q_h=0.0348", "adaptation.saliency_pct=30"}, 2},
    };
    for (const auto &[set, shift] : cases) {
        const nf::Config config = nf::load_parts("motor_a", "bench_310v", "published", {}, set);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(shift, nf::build(config).observer.current_shift,
                                         set[0].c_str());
    }
}

// 6 A and 1.5 A of 1.5·40 A; 100 A is beyond three times the full scale of 20 A, which never flows.
TEST(bus_currents)
{
    const derating_cfg_t c =
        motor_b({"board.bus_current_max_a=6", "board.bus_regeneration_max_a=1.5"}).derating;
    expect(6.0 / 60 * 32768, c.bus_current_max);
    expect(1.5 / 60 * 32768, c.bus_regeneration_max);
    const derating_cfg_t none =
        motor_b({"board.bus_current_max_a=100", "board.bus_regeneration_max_a=100"}).derating;
    expect(32767, none.bus_current_max);
    expect(32767, none.bus_regeneration_max);
    expect(0, motor_b().derating.bus_regeneration_max);
    expect(0, motor_b({"board.bus_regeneration_max_a=-1"}).derating.bus_regeneration_max);
    expect(1, motor_b({"board.bus_regeneration_max_a=0"}).derating.bus_regeneration_max);
}

// X = Ω_b·L·I_b/U_b below 4. Where the firmware holds less than the file says, it is told, with
// what it holds.
TEST(what_the_firmware_holds_less_of_than_the_file_says_is_told)
{
    const auto config = [](const char *henry) {
        return nf::load_parts("outrunner_24v", "b_g431b_esc1", "any", {},
                              {std::string("motor.inductance_d_h=") + henry,
                               std::string("motor.inductance_q_h=") + henry});
    };
    const auto told = [](const nf::Config &of) {
        std::vector<std::string> found;
        for (const std::string &note : of.scenario.notes) {
            if (note.find("the firmware holds") != std::string::npos) {
                found.push_back(note);
            }
        }
        return found;
    };
    const nf::Config fits = config("0.000144");
    TEST_ASSERT_TRUE(nf::build(fits).current_loop.reactance_q_q13 < 32767);
    TEST_ASSERT_EQUAL_size_t(0, told(fits).size());
    const nf::Config beyond = config("0.0001815");
    TEST_ASSERT_EQUAL_INT32(32767, nf::build(beyond).current_loop.reactance_q_q13);
    TEST_ASSERT_EQUAL_size_t(2, told(beyond).size());
    TEST_ASSERT_EQUAL_STRING(
        "--set: motor.inductance_q_h = 0.0001815: the firmware holds at most 0.000145 with the "
        "scales of this board and motor.max_speed_rpm, and reckons with that: above some speed the "
        "axes are decoupled in part only",
        told(beyond).back().c_str());
}

// φ/L_d = 27.7778 A; with L −40 %, φ +25 %: 57.87 A; three phases at 18 A make 2/√3·18 = 20.785 A:
// 78.66 A < 2·40 A. The gains are κ·I_b·I_x/(φ/L_d)²·4/2π·2^12 steps.
TEST(observer)
{
    const nn_observer_cfg_t c = motor_b().observer;
    expect(1, c.current_shift);
    expect_mantissa(1e-4 / 0.0135 * 450 / 80 * 4096, c.volt_gain, c.weight_shift);
    expect(27.7777778 / 80 * 134217728, c.flux_q27);
    expect(13.5 / 23.5 * 16384, c.iq_gain_q14);
    expect(23.5 / 13.5 * 8192, c.saliency_q13);
    const double one = 40.0 * 80 / (27.7777778 * 27.7777778) * 4 / 6.283185307 * 4096;
    expect_mantissa(0.038 * one, c.eta, c.eta_shift);
    expect_mantissa(0.32 * one, c.kappa_p, c.kappa_p_shift);
}

// D = T·R/L_d + f, of which the network's mantissa, the share f/D and the corner of ρ are made.
TEST(observer_feedback)
{
    const nn_observer_cfg_t c = motor_b({"observer.feedback=0.08"}).observer;
    const double winding = 1e-4 * 0.405 / 0.0135;
    expect(std::ldexp((winding + 0.08) / 2 * 4096, static_cast<int>(c.weight_shift)), c.decay);
    // f is rounded to a unit of the decay.
    TEST_ASSERT_DOUBLE_WITHIN(0.5 + 0.5 / c.decay * 32768, 0.08 / (winding + 0.08) * 32768,
                              c.feedback_q15);
    expect((winding + 0.08) / 6.283185307 * 4294967296.0, c.corner);
    TEST_ASSERT_EQUAL_INT32(0, motor_b().observer.feedback_q15);
}

// Ω_b = 2^15·2^10 steps, the first above 2250 rpm: 2^25/2^32·2π·10 kHz = 490.874 rad/s.
TEST(the_current_loop_has_the_inductance_of_each_axis)
{
    const current_loop_cfg_t c = motor_b().current_loop;
    expect(490.873852 * 0.0135 * 40 / 450 * 8192, c.reactance_d_q13);
    expect(490.873852 * 0.0235 * 40 / 450 * 8192, c.reactance_q_q13);
    const double omega = 6.283185307 * 500;
    expect_gain(omega * 0.0135 * 40 / 450, c.pi_d);
    expect_integral(omega * 0.0135 * 40 / 450 * omega / 10 * 1e-4, c.pi_d);
}

// The integral's corner is R/L where that is the faster one: 30/s and 17.2/s beside 20 Hz, a tenth
// of which is 12.6/s.
TEST(a_slow_current_loop_integrates_as_fast_as_the_winding)
{
    const current_loop_cfg_t c = motor_b({"current_loop.bandwidth_hz=20"}).current_loop;
    const double kp_per_henry = 6.283185307 * 20 * 40 / 450;
    expect_integral(kp_per_henry * 0.405 * 1e-4, c.pi_d);
    expect_integral(kp_per_henry * 0.405 * 1e-4, c.pi_q);
    expect_gain(kp_per_henry * 0.0235, c.pi_q);
}

// By rule, with a = 1.5·2·0.375·6.3/0.011 = 644.318 rad/s²: ω = 4.3·a/(1200 rpm) = 22.0474 rad/s;
// 0.27 and 0.2 of a in a millisecond; braking from 600 rpm, 62.83185 rad/s, takes 0.9·0.2·a.
TEST(motion)
{
    const drive_cfg_t c = motor_b();
    const double a_step = 644.31818 * 1e-3 * 30 / 3.141592654 * STEPS_PER_RPM;
    expect(0.27 * a_step, c.speed_loop.ramp);
    expect(0.20 * a_step, c.position_loop.ramp);
    expect(600 * STEPS_PER_RPM, c.position_loop.speed_max);
    expect_mantissa(22.0474 / 2.8 * 1e-4 * 65536, c.position_loop.gain, c.position_loop.gain_shift);
    expect(115.97727 * 0.3 / (22.0474 / 2.8) / 62.83185 * 32768, c.position_loop.softness_q15);
}

// An ampere makes 1.5·2²·0.375/0.011 = 204.545 rad/s² electrical; 1 rad/s² is 1e-3·1e-4/2π·2^32
// steps a millisecond.
constexpr double STEPS_PER_RAD_S2 = 68.35653;

// J of 0.3 kg·m² takes 1.598 LSB a step of speed, and of these 2^14 are a mantissa.
TEST(a_heavy_rotor_lifts_its_inertia)
{
    const speed_loop_cfg_t c = motor_b({"motor.inertia_kg_m2=0.3"}).speed_loop;
    const double inertia = 32768 / (STEPS_PER_RAD_S2 * 1.5 * 4 * 0.375 / 0.3 * 40);
    expect(0, c.inertia_shift);
    expect(2, c.inertia_lift);
    expect_mantissa(inertia * 65536 / 4, c.inertia, 0);
}

// Three times either way. On the ramp 2^17 stand for its torque, in Q26.
TEST(how_far_the_inertia_is_corrected)
{
    const speed_loop_cfg_t c = motor_b({"adaptation.inertia_pct=200"}).speed_loop;
    const double torque_q15 =
        std::ldexp(static_cast<double>(c.ramp) * c.inertia,
                   static_cast<int>(c.inertia_lift) - 16 - static_cast<int>(c.inertia_shift));
    expect(8192.0 / 3, c.inertia_least_q13);
    expect(8192.0 * 3, c.inertia_most_q13);
    TEST_ASSERT_DOUBLE_WITHIN(
        1e-3, 1,
        std::ldexp(c.inertia_rate, -16 - static_cast<int>(c.inertia_rate_shift)) * torque_q15 *
            2048 / 131072);
}

// 0.95/√3 is 17972.7 and 0.9895/√3 18719.97: rounded down. 310 V·T/(6·(L_d + L_q)).
TEST(modulator)
{
    const modulator_cfg_t c = motor_b().modulator;
    TEST_ASSERT_EQUAL_INT32(17972, c.ratio_max_q15);
    TEST_ASSERT_EQUAL_INT32(18719, motor_b({"board.duty_margin_pct=1.05"}).modulator.ratio_max_q15);
    expect(310 * 1e-4 / (6 * 0.037) / 40 * 32768, c.ripple_q15);
}

// α halves what a sample adds.
TEST(momentum)
{
    const nn_observer_cfg_t none = motor_b().observer;
    const nn_observer_cfg_t c = motor_b({"observer.momentum=0.5"}).observer;
    TEST_ASSERT_EQUAL_INT32(16384, c.momentum_q15);
    const double eta = std::ldexp(none.eta, -static_cast<int>(none.eta_shift));
    expect_mantissa(eta / 2, c.eta, c.eta_shift);
}

TEST(the_angle_of_a_sensor_is_counted_in_pole_pairs)
{
    TEST_ASSERT_EQUAL_UINT32(0, motor_b().sampling.sensor_pole_pairs);
    TEST_ASSERT_EQUAL_UINT32(2, motor_b({"drive.angle_source=sensor"}).sampling.sensor_pole_pairs);
}

// 0.5 A: what the converter's noise makes is more than the shares. 5 over 2 Hz are 625 periods of 4
// ms.
TEST(a_weak_motor_is_judged_above_the_noise_and_a_slow_one_late)
{
    const supervision_cfg_t c =
        motor_b({"motor.continuous_current_a=0.5", "speed_loop.bandwidth_hz=2"}).supervision;
    expect(65 * 8, c.phase_range_min);
    expect(65 * 2, c.phase_zero_max);
    expect(16 * 8, c.follow_error_max);
    expect(0.75 * 0.5 / 40 * 32768, c.residual_max);
    expect(625, c.speed_error_periods);
}

// K_p = 1.5·φ and K_i = 8/s·K_p of 2·Ω_b/U_b; 240 rpm; 25 % of the continuous current;
// −0.8·atan(R/(ω·L_d)) at 1200 rpm is −5.446°. 0.45·ω·L of U_b/I_b, and 0.6·ω·T.
TEST(voltage_drive)
{
    const voltage_drive_cfg_t c = motor_b({}, "voltage_phase").voltage_drive;
    const double base = 2 * 490.873852 / 450;
    expect(1, c.enabled);
    expect_gain(1.5 * 0.375 * base, c.pi);
    expect_integral(8 * 1.5 * 0.375 * base * 1e-3, c.pi);
    expect(240 * STEPS_PER_RPM, c.speed_min);
    expect(100, c.settle_periods);
    expect_mantissa(0.003 * 65536, c.compensator.gain, c.compensator.gain_shift);
    expect(40.0 / 360 * 4294967296.0, c.compensator.lead_max);
    const double brake = 0.8 * std::atan(0.405 / (125.6637061 * 2 * 0.0135)) / 6.283185307;
    TEST_ASSERT_DOUBLE_WITHIN(2, brake * 4294967296.0, c.compensator.brake_max);
    expect(0.25 * CONTINUOUS_Q15, c.compensator.current_min);
    const double omega = 2 * 125.6637061;
    const double inductance = 2 / (1 / 0.0135 + 1 / 0.0235);
    expect(0.45 * omega * inductance * 40 / 450 * 32768, c.damping.resistance_q15);
    expect(0.6 * omega * 1e-4 * 32768, c.damping.mean_rate_q15);
    // One and a half hand-over speeds of 15 % are more than 20 %.
    expect(270 * STEPS_PER_RPM,
           motor_b({"startup.handover_speed_pct=15"}, "voltage_phase").voltage_drive.speed_min);
}

// At 1 kHz 200 Hz turn by 72° in a sample, and the band of 100 Hz makes t = tan 18°; 100 Hz make r
// = 1 − exp(−0.2π).
TEST(torque_filter)
{
    const torque_filter_cfg_t none = motor_b().torque_filter;
    TEST_ASSERT_FALSE(torque_filter_acts(&none));
    const torque_filter_cfg_t c =
        motor_b({"speed_loop.notch_hz=200", "speed_loop.notch_width_pct=50",
                 "speed_loop.torque_filter_hz=100"})
            .torque_filter;
    expect(0.951056516 * 32768, c.notch_turn.sin);
    expect(0.309016994 * 32768, c.notch_turn.cos);
    expect(2 * 0.324919696 / 1.324919696 * 32768, c.notch_share_q15);
    expect((1 - 0.533488091) * 32768, c.smooth_rate_q15);
    // The band ends at a quarter of the rate, where t = 1; and at half of the rate a sample turns
    // by half a turn.
    const torque_filter_cfg_t fast =
        motor_b({"speed_loop.notch_hz=500", "speed_loop.notch_width_pct=100"}).torque_filter;
    TEST_ASSERT_EQUAL_INT32(32767, fast.notch_share_q15);
    TEST_ASSERT_EQUAL_INT32(0, fast.notch_turn.sin);
    TEST_ASSERT_EQUAL_INT32(-32767, fast.notch_turn.cos);
    // 40 kHz over 20: the same turns for twice the frequency.
    const torque_filter_cfg_t twice =
        motor_b({"board.pwm_frequency_hz=40000", "speed_loop.slow_ticks=20",
                 "speed_loop.notch_hz=400", "speed_loop.notch_width_pct=50"})
            .torque_filter;
    TEST_ASSERT_EQUAL_INT32(c.notch_turn.sin, twice.notch_turn.sin);
    TEST_ASSERT_EQUAL_INT32(c.notch_share_q15, twice.notch_share_q15);
}

TEST(steps_and_rpm_are_turned_into_each_other)
{
    const nf::Config c = nf::load_parts("motor_b", "bench_310v", "robust_motor_a", {}, {});
    const nf::Bases b = nf::make_bases(c.motor, c.board);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1800 * STEPS_PER_RPM, b.step_from_rpm(1800));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING / STEPS_PER_RPM, 1800,
                              b.rpm_from_step(1800 * STEPS_PER_RPM));
}

// The reluctance takes 0.01 H · 3.53778 A off φ. In the field of 3.53778 A the rotor swings with
// √(204.545·3.53778·0.905659) = 25.6001 rad/s.
constexpr double ACTIVE_FLUX = 0.375 - 0.01 * 3.53778;
constexpr double SWING = 25.6001;

TEST(start)
{
    const startup_cfg_t c = motor_b().startup;
    expect(1.5 * CONTINUOUS_Q15, c.align.current_high);
    expect(0.62 * 1.5 * CONTINUOUS_Q15, c.align.current_low);
    expect(10, c.align.slope);         // 0.8/ω_n are 313 ticks
    expect(3125, c.align.sweep_ticks); // 80/ω_n
    // L·2.01653 A at 93 V takes 2.93 ticks; in 3 it takes 90.74 V, and R·3·T/(2·L) = 0.0045 more.
    const inductance_cfg_t &l = c.align.inductance;
    expect(3, l.step_ticks);
    const double volts = 0.0135 * 0.38 * 1.5 * 3.53778 / 3e-4 * 1.0045;
    expect(volts / 450 * 32768, l.step_voltage);
    expect(volts * 3e-4 / 0.0135 / 40 * 32768, l.step_response);
    // L_q·1.592 A at 93 V takes 4.02 ticks; in 5 it takes 74.82 V. Four times that is for L_d
    // 4·1.592·23.5/13.5 A.
    expect(5, l.pulse_ticks);
    const double swing = 0.3 * 1.5 * 3.53778;
    expect(0.0235 * swing / 5e-4 / 450 * 32768, l.pulse_voltage);
    expect(4 * swing * 23.5 / 13.5 / 40 * 32768, l.pulse_response);
    // 0.15 of the hand-over speed on the vector's ramp; a light rotor is that fast at once, a heavy
    // one not in half of the time allowed.
    expect(std::floor(0.15 * c.handover_speed / c.ramp), c.settle_periods);
    expect(0, motor_b({"motor.inertia_kg_m2=0.0001"}).startup.settle_periods);
    expect(50, motor_b({"motor.inertia_kg_m2=1"}).startup.settle_periods);
}

// φ/(L_q − L_d) = 0.375/0.0375 = 10 A, half of it lies between the hold and the largest current;
// The EMF at 120 rpm is 9.42478 V; three times that over R is 5 A.
TEST(a_motor_of_much_saliency_or_resistance_is_dragged_with_less_current)
{
    for (const char *set : {"motor.inductance_q_h=0.051", "motor.resistance_ohm=5.654867"}) {
        const startup_cfg_t less = motor_b({set}).startup;
        expect(5.0 / 40 * 32768, less.current_move);
        TEST_ASSERT_DOUBLE_WITHIN(1, 0.07 * 204.54545 * 5.0 * STEPS_PER_RAD_S2 + 0.5, less.ramp);
    }
}

// 0.375/0.19 A: at half of it the rotor has the largest stiffness, whatever the motor bears.
TEST(no_current_along_the_flux_takes_more_than_half_of_the_stiffness)
{
    constexpr double STIFF_A = 0.5 * 0.375 / 0.19;
    const drive_cfg_t c = motor_b({"motor.inductance_d_h=0.065", "motor.inductance_q_h=0.255",
                                   "startup.align_current_pct=150", "current_loop.floor_pct=50",
                                   "board.dead_time_s=1e-6"});
    for (const int32_t current : {c.startup.align.current_high, c.startup.current_hold,
                                  c.startup.current_move, c.current_reference.floor}) {
        expect(STIFF_A / 40 * 32768, current);
    }
}

// The reluctance of L_q < L_d holds the rotor as the magnet does.
TEST(a_smaller_l_q_leaves_the_currents_along_the_flux_to_the_motor)
{
    const startup_cfg_t c = motor_b({"motor.inductance_d_h=0.25", "motor.inductance_q_h=0.13",
                                     "startup.align_current_pct=150"})
                                .startup;
    expect(1.5 * CONTINUOUS_Q15, c.align.current_high);
    expect(6.3 / 40 * 32768, c.current_move);
}

// A least current of a fifth of the continuous 3.53778 A takes 0.2·3.53778·ΔL of φ = 0.375 Wb: an
// eighth of it with ΔL = 66.25 mH.
TEST(a_least_current_that_takes_an_eighth_of_the_flux_falls_at_once)
{
    const auto fall = [](const char *inductance_q) {
        return motor_b({"motor.inductance_d_h=0.03", inductance_q, "current_loop.floor_pct=20",
                        "board.dead_time_s=1e-6"})
            .current_reference.slope_down;
    };
    expect(1, fall("motor.inductance_q_h=0.0960"));
    expect(16384, fall("motor.inductance_q_h=0.0965"));
}

// An eighth of the EMF at 120 rpm over ω_n·ψ/(1.4·3.53778 A) = 1.75541 ohm; at most a fifth of the
// current, and at least 12 counts of 20 A/2048. A winding of 5.654867 ohm keeps 0.6 of them.
TEST(a_rotor_rests_with_less_than_a_slip_drives_across)
{
    const auto swing = [](const std::vector<std::string> &set) {
        return motor_b(set).startup.align.swing_max;
    };
    expect(9.42478 / 8 / 1.75541 / 40 * 32768, swing({}));
    expect(0.2 * 1.5 * CONTINUOUS_Q15, swing({"startup.handover_speed_pct=30"}));
    expect(12.0 * 20 / 2048 / 40 * 32768,
           swing({"startup.handover_speed_pct=1", "startup.loaded_speed_pct=0"}));
    expect(9.42478 / 8 / (0.6 * 5.654867) / 40 * 32768, swing({"motor.resistance_ohm=5.654867"}));
}

// Of twice the continuous current what the motor bears, and 1/1.8 of what the board does.
TEST(a_start_imposes_what_motor_and_board_bear)
{
    expect(6.3 / 40 * 32768, motor_b({"startup.current_pct=200"}).startup.current_hold);
    expect(5.0 / 40 * 32768,
           motor_b({"startup.current_pct=200", "board.overcurrent_a=9", "board.trip_a=10"})
               .startup.current_hold);
}

// A pulse of 0.315 A turns the rotor by 0.315·L_q/φ, 0.0031418 turn: 46 pauses and the pulse make
// 0.15. The first fast motor turns by 0.039270 turn, which makes 2, the second by 0.016711, which
// makes 7; but 24000 rpm are 0.08 turn in a tick, and 4 and one make 0.4. With L_d for L_q it is
// 0.0018049 turn, which makes 82, and 0.006 turn in a tick make 65.
TEST(the_pause_of_a_flying_start_makes_a_turn_of_0_15)
{
    const auto gap = [](const std::vector<std::string> &set) {
        return motor_b(set).startup.flying_start.gap_factor;
    };
    std::vector<std::string> fast = {"motor.max_speed_rpm=24000", "motor.flux_linkage_wb=0.03",
                                     "motor.rated_torque_nm=0.3"};

    expect(46, gap({}));
    expect(2, gap(fast));
    fast.emplace_back("motor.inductance_q_h=0.01");
    fast.emplace_back("motor.inductance_d_h=0.01");
    expect(4, gap(fast));
    expect(64, gap({"motor.inductance_q_h=0.0135"}));
}

// Rated torque takes 521 ms to 1800 rpm: a tenth is more than 256 ticks. With a fifth of the
// inertia it is 104 ticks, with a hundredth 5.
TEST(a_pause_of_a_flying_start_is_a_tenth_of_the_time_to_the_highest_speed)
{
    const auto most = [](const char *inertia) {
        return motor_b({inertia}).startup.flying_start.pause_max;
    };

    expect(256, most("motor.inertia_kg_m2=0.011"));
    expect(104, most("motor.inertia_kg_m2=0.0022"));
    expect(32, most("motor.inertia_kg_m2=0.00011"));
}

// 0.05·6.3 A, or 25 counts of 20 A/2048.
TEST(flying_start)
{
    const flying_start_cfg_t c = motor_b().startup.flying_start;
    expect(0.315 / 40 * 32768, c.current);
    // φ/L_q = 15.95745 A, of which R leaves (1 − e^−a)/a = 0.999139 in a tick, a = T·R/L_q =
    // 0.00172340.
    expect_mantissa(15.95745 * 0.999139 / 40 * 32768 / 683565275.6 * 65536, c.emf_current,
                    c.emf_shift);
    expect(0.00172192 * 32768, c.decay_q15);
    expect(25.0 * 20 / 2048 / 40 * 32768,
           motor_b({"motor.max_current_a=4"}).startup.flying_start.current);
}

// At 10 kHz 1 s where nothing is written; 0.1 of a tick counts as one, or it would mean never.
TEST(the_time_without_a_typed_byte)
{
    expect(100000, motor_b().console.timeout_ticks);
    expect(0, motor_b({"tuning.console_timeout_s=0"}).console.timeout_ticks);
    expect(1, motor_b({"tuning.console_timeout_s=1e-5"}).console.timeout_ticks);
}

TEST(without_a_word_of_it_there_is_no_input)
{
    expect(0, motor_b().input.kind);
    expect(0, motor_b().input.button);
}

// Readings are tenths of a microsecond.
TEST(servo_pulses)
{
    const input_cfg_t c = motor_b({"input.kind=rc_pulse"}).input;
    expect(2, c.kind);
    expect(8000, c.least);
    expect(10000, c.low);
    expect(10000, c.middle);
    expect(20000, c.high);
    expect(22000, c.most);
    expect(32767, c.share_q15);
    const input_cfg_t other =
        motor_b({"input.kind=rc_pulse", "input.both_ways=true", "input.reversed=true",
                 "input.largest_pct=50", "input.pulse_low_s=0.0011", "input.pulse_high_s=0.0019",
                 "input.pulse_margin_s=0.0001", "input.expo_pct=100", "input.commands=torque",
                 "input.button=start_stop"})
            .input;
    expect(10000, other.least);
    expect(11000, other.low);
    expect(15000, other.middle);
    expect(19000, other.high);
    expect(20000, other.most);
    expect(-16384, other.share_q15);
    expect(32767, other.expo_q15);
    expect(1, other.commands);
    expect(2, other.button);
}

// A voltage that is read every 256 ticks at worst is not lost when one reading is missing.
TEST(the_time_out_of_an_input_is_a_tenth_of_a_second_or_400_ticks)
{
    for (const char *kind : {"input.kind=voltage", "input.kind=rc_pulse", "input.kind=dshot"}) {
        expect(1000, motor_b({kind}).input.timeout_ticks);
        expect(400, motor_b({kind, "board.pwm_frequency_hz=3000"}).input.timeout_ticks);
        expect(900, motor_b({kind, "board.pwm_frequency_hz=3000", "input.timeout_s=0.3"})
                        .input.timeout_ticks);
        expect(500, motor_b({kind, "input.timeout_s=0.05"}).input.timeout_ticks);
    }
    expect(150, motor_b({"input.kind=dshot", "board.pwm_frequency_hz=3000", "input.timeout_s=0.05"})
                    .input.timeout_ticks);
}

// Throttle 48 to 2047, less 47.
TEST(dshot)
{
    const input_cfg_t c = motor_b({"input.kind=dshot"}).input;
    expect(3, c.kind);
    expect(0, c.low);
    expect(0, c.middle);
    expect(2000, c.high);
    expect(1000, motor_b({"input.kind=dshot", "input.both_ways=true"}).input.middle);
}

TEST(the_time_without_a_message)
{
    expect(10000, motor_b().link.timeout_ticks);
    expect(0, motor_b({"tuning.command_timeout_s=0"}).link.timeout_ticks);
    expect(2500, motor_b({"tuning.command_timeout_s=0.25"}).link.timeout_ticks);
    expect(1, motor_b({"tuning.command_timeout_s=1e-5"}).link.timeout_ticks);
}

// T_b = 1.5·P·U_b·I_b/Ω_b. Without a speed of its own the window ends where the speed loop does.
TEST(torque)
{
    const nf::Config config = nf::load_parts("motor_b", "bench_310v", "robust_motor_a", {}, {});
    const nf::Bases bases = nf::make_bases(config.motor, config.board);
    const double base = 1.5 * 2 * bases.voltage_v * bases.current_a / bases.speed_el_rad_s;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * base, base, bases.torque_nm());
    const torque_loop_cfg_t own =
        motor_b({"torque_loop.slope_nm_s=100", "torque_loop.speed_forward_rpm=900",
                 "torque_loop.speed_backward_rpm=0"})
            .torque_loop;
    TEST_ASSERT_DOUBLE_WITHIN(1, 100 * 1e-3 / base * std::ldexp(1.0, 28), own.slope);
    TEST_ASSERT_DOUBLE_WITHIN(1, bases.step_from_rpm(900), own.speed_forward);
    TEST_ASSERT_EQUAL_INT32(0, own.speed_backward);
    const drive_cfg_t ruled = motor_b();
    TEST_ASSERT_EQUAL_INT32(ruled.speed_loop.speed_max, ruled.torque_loop.speed_forward);
    TEST_ASSERT_EQUAL_INT32(ruled.speed_loop.speed_max, ruled.torque_loop.speed_backward);
}

// K_p/K_i in slow periods, as the nearest power of two.
TEST(the_load_of_a_torque_is_found_as_fast_as_the_speed_loop_finds_it)
{
    for (const double hz : {5.0, 10.0, 20.0, 40.0}) {
        const drive_cfg_t c = motor_b({fmt::format("speed_loop.bandwidth_hz={}", hz)});
        const pi_cfg_t &pi = c.speed_loop.pi;
        const double periods =
            std::ldexp(double{1} * pi.kp / pi.ki,
                       static_cast<int>(pi.ki_shift) + 11 - static_cast<int>(pi.kp_shift));
        TEST_ASSERT_DOUBLE_WITHIN(0.5, std::log2(periods), c.torque_loop.load_shift);
    }
}

// Motor B: 6.3 A of 40 A are 5161 of Q15.
TEST(the_field_is_weakened_by_a_share_of_the_largest_current_and_no_more_than_the_magnets_bear)
{
    expect(0.95 * 6.3 / 40 * 32768, motor_b().current_reference.deepest);
    expect(0.5 * 6.3 / 40 * 32768,
           motor_b({"current_loop.weakening_pct=50"}).current_reference.deepest);
    expect(4.0 / 40 * 32768,
           motor_b({"motor.demagnetising_current_a=4"}).current_reference.deepest);
    expect(0.95 * 6.3 / 40 * 32768,
           motor_b({"motor.demagnetising_current_a=40"}).current_reference.deepest);
    expect(0, motor_b({"drive.method=voltage_phase"}).current_reference.deepest);
}

// Motor B, L_q − L_d and φ as in its file, 6.3 A.
TEST(the_magnets_bear_the_current_of_the_largest_torque)
{
    nf::Config config = nf::load_parts("motor_b", "bench_310v", "robust_motor_a", {}, {});
    const double saliency = config.motor.inductance_q_h - config.motor.inductance_d_h;
    const double flux = config.motor.flux_linkage_wb;
    const double c = flux / (2 * saliency);
    const double most = config.motor.max_current_a;
    // √(c² + i_q²) − c with i_q² = I² − i_d²
    const double depth = (std::sqrt(c * c + 2 * most * most) - c) / 2;
    const auto blamed = [&](double bearing_a) -> std::string {
        config.motor.demagnetising_current_a = bearing_a;
        try {
            (void)nf::make_drive_cfg(config.motor, config.board, config.tuning, config.model);
        } catch (const nf::SettingError &error) {
            return error.key;
        }
        return "";
    };
    TEST_ASSERT_EQUAL_STRING("", blamed(1.001 * depth).c_str());
    TEST_ASSERT_EQUAL_STRING("motor.max_current_a", blamed(0.999 * depth).c_str());
    config.tuning.most_torque = 0;
    TEST_ASSERT_EQUAL_STRING("", blamed(0.999 * depth).c_str());
    // The drive imposes no i_d on a motor of L_q < L_d for the sake of torque.
    config.tuning.most_torque = 1;
    std::swap(config.motor.inductance_d_h, config.motor.inductance_q_h);
    TEST_ASSERT_EQUAL_STRING("", blamed(0.999 * depth).c_str());
}

// Without a start of its own the run's current changes as with one of 100 %.
TEST(run)
{
    // A 32nd of the slope, at least one; a voltage drive takes over from no i_d* at all, so it goes
    // as it came.
    expect(1, motor_b().current_reference.slope_down);
    expect(91 / 32, motor_b({"drive.angle_source=sensor", "motor.inertia_kg_m2=0.00011"})
                        .current_reference.slope_down);
    expect(10, motor_b({"drive.method=voltage_phase", "drive.angle_source=sensor"})
                   .current_reference.slope_down);
    expect(16384, motor_b().run.acceleration_q14);
    expect(0.75 * 16384, motor_b({"observer.acceleration_feed_forward=0.75"}).run.acceleration_q14);
    expect(0, motor_b({"drive.angle_source=sensor", "observer.acceleration_feed_forward=1"})
                  .run.acceleration_q14);
    expect(10, motor_b({"drive.angle_source=sensor"}).current_reference.slope);
    // A hundredth of the inertia: 0.8/ω_n are 32 ticks of 90.6.
    expect(91, motor_b({"drive.angle_source=sensor", "motor.inertia_kg_m2=0.00011"})
                   .current_reference.slope);
}

// 0.7 of critical damping beside R, 0.2·ω_n of integral.
TEST(hold_loop)
{
    const pi_cfg_t c = motor_b().hold_loop.pi_d;
    const double ohms = SWING * ACTIVE_FLUX / (2 * 0.7 * 3.53778);
    expect_gain((ohms - 0.405) / 11.25, c);
    expect_integral(ohms * 0.2 * SWING * 1e-4 / 11.25, c);
}

// A winding whose L_q·I is more than 0.7·φ lags: 0.1 H of both axes, ω_n = √723.637.
TEST(a_swing_is_damped_by_no_less_than_its_reactance)
{
    const pi_cfg_t c =
        motor_b({"motor.inductance_d_h=0.1", "motor.inductance_q_h=0.1"}).hold_loop.pi_d;
    expect_gain((26.9005 * 0.1 - 0.405) / 11.25, c);
}

// With L_d of 0.03 H the rotor is stiff up to 0.375/(2*0.07) = 2.67857 A: half of the stiffness at
// 2.67857/3.53778 of the current leaves ω_n = √(723.637*0.378567). What lags is L_q.
TEST(the_reactance_of_a_salient_motor_is_that_of_l_q)
{
    const pi_cfg_t c =
        motor_b({"motor.inductance_d_h=0.03", "motor.inductance_q_h=0.1"}).hold_loop.pi_d;
    expect_gain((16.5513 * 0.1 - 0.405) / 11.25, c);
}

// A heavy rotor asks for little damping. 4/3·(310 V · 5 µs · 10 kHz) of 3.53778 A, and a fifth of
// it.
TEST(an_imposed_current_is_controlled_firmly_enough_for_the_dead_time)
{
    const pi_cfg_t c =
        motor_b({"motor.inertia_kg_m2=1.1", "board.dead_time_s=5e-6"}).hold_loop.pi_d;
    expect_gain((0.2 * 4 / 3 * 15.5 / 3.53778 - 0.405) / 11.25, c);
}

// With ten times the resistance K_p takes off what is more than the damping asks for, but 0.4 of it
// at most.
TEST(a_large_resistance_is_relieved)
{
    const pi_cfg_t c = motor_b({"motor.resistance_ohm=4.05"}).hold_loop.pi_q;
    expect_mantissa(0.4 * 4.05 / 11.25, -c.kp, c.kp_shift);
    expect_integral(0.6 * 4.05 * 0.2 * SWING * 1e-4 / 11.25, c);
}

// Three and a half knees C·u/t_d of I_b = 40 A. Where the board says nothing: 320 pF and 17 pF for
// each of the 18 A.
TEST(the_edge_of_the_compensation)
{
    const struct {
        const char *set;
        double capacitance_f;
    } cases[] = {
        {"board.output_capacitance_f=1e-9", 1e-9},
        {"board.output_capacitance_f=-1", 320e-12 + 17e-12 * 18},
        {"model.output_capacitance_f=1e-9", 1e-9},
    };
    for (const auto &[set, capacitance_f] : cases) {
        const double edge_a = 3.5 * capacitance_f * 310 / 1e-6;
        const double slope = 40.0 / edge_a;
        expect(slope, motor_b({set, "board.dead_time_s=1e-6"}).modulator.edge_slope);
    }
}

TEST(model)
{
    const model_cfg_t c = motor_b().model;
    expect(1e-3 / 0.05 * 40 / 27.7777778 * 32768, c.flux_rate);
    expect(240 * STEPS_PER_RPM, c.flux_speed_min);
    TEST_ASSERT_EQUAL_INT32(0, motor_b({"observer.pace_speed_pct=0"}).model.pace.full_speed);
}

// 12 % and 80 % of 1200 rpm.
TEST(the_gains_by_the_speed)
{
    const model_cfg_t c = motor_b({"observer.pace_speed_pct=12", "observer.pace_least=0.3",
                                   "observer.kappa_speed_pct=80", "observer.kappa_least=0.6"})
                              .model;
    expect(144 * STEPS_PER_RPM, c.pace.full_speed);
    expect(0.3 * 16384, c.pace.least_q14);
    expect(960 * STEPS_PER_RPM, c.kappa.full_speed);
    expect(0.6 * 16384, c.kappa.least_q14);
    for (const gain_share_cfg_t &share : {c.pace, c.kappa}) {
        const int32_t turns = share.full_speed >> share.shift;
        TEST_ASSERT_TRUE(turns < 16384 && turns >= 8192);
        expect(std::ldexp(1.0, 28) / turns, share.gain);
    }
    const model_cfg_t sensed = motor_b({"drive.angle_source=sensor"}).model;
    TEST_ASSERT_EQUAL_INT32(0, sensed.pace.full_speed);
    TEST_ASSERT_EQUAL_INT32(0, sensed.kappa.full_speed);
}

// RUN with a load down to 3 % of 1200 rpm, ρ from half of it; a load is 15 % of the continuous
// current.
TEST(the_lowest_speed_of_run_with_a_load)
{
    const drive_cfg_t c = motor_b({"startup.loaded_speed_pct=3"});
    expect(36 * STEPS_PER_RPM, c.startup.loaded_speed);
    expect(0.15 * CONTINUOUS_Q15, c.startup.load_current);
    expect(18 * STEPS_PER_RPM, c.observer.rho_speed_min);
    const startup_cfg_t without = motor_b({"startup.loaded_speed_pct=0"}).startup;
    TEST_ASSERT_EQUAL_INT32(without.hold_speed, without.loaded_speed);
}

// Flying start 274 ticks, pull and settling 30/ω_n, twice 2^11 ticks of measuring, 16 of the
// voltage step and 4 times as many of the pulse; the charge on top.
// With 1 % of the current ω_n is a tenth.
TEST(the_time_of_a_start)
{
    constexpr double swing_error_s = 1e-5; // four digits of ω_n
    const nf::Config c = nf::load_parts("motor_b", "bench_310v", "robust_motor_a", {},
                                        {"board.bootstrap_charge_s=0.01"});
    TEST_ASSERT_DOUBLE_WITHIN(swing_error_s, (274 + 4096 + 80) * 1e-4 + 30 / SWING + 0.01,
                              nf::startup_time(c.motor, c.board, c.tuning));
    const nf::Config least =
        nf::load_parts("motor_b", "bench_310v", "robust_motor_a", {}, {"startup.current_pct=1"});
    TEST_ASSERT_TRUE(nf::startup_time(least.motor, least.board, least.tuning) > 10 * 30 / SWING);
}

// A sensor that falls: 90 °C are 18 %, the warning 20 °C below 34 %.
TEST(temperature)
{
    const fade_t c =
        motor_b({"board.temperature_points_c=[0, 50, 100]",
                 "board.temperature_points_pct=[80, 50, 10]", "board.temperature_max_c=90"})
            .derating.temperature;
    expect(0.18 * 4096, c.zero);
    expect_mantissa(-32768 / (0.16 * 4096), c.gain, c.shift);
}

// A quarter of the way from the ends of the converter to those of the line, whichever of them is
// the cold one.
TEST(a_count_that_a_whole_sensor_does_not_have_is_told_where_the_line_leaves_room)
{
    const derating_cfg_t c =
        motor_b({"board.temperature_points_c=[0, 50, 100]",
                 "board.temperature_points_pct=[80, 50, 10]", "board.temperature_max_c=90"})
            .derating;
    expect(0.025 * 4096, c.temperature_lowest);
    expect(0.95 * 4096, c.temperature_highest);
    const derating_cfg_t whole =
        motor_b({"board.temperature_points_c=[-50, 150]", "board.temperature_points_pct=[0, 100]"})
            .derating;
    TEST_ASSERT_EQUAL_INT32(0, whole.temperature_lowest);
    TEST_ASSERT_EQUAL_INT32(4095, whole.temperature_highest);
}

TEST(the_supply_gives_what_a_start_imposes)
{
    expect(0.0778 / 60 * 32768,
           motor_b({"board.bus_current_max_a=0.0778"}).derating.bus_current_max);
}

// Four swings are 77654 ticks of measuring, 24 of them 466145: of a rotor of 0.3 kg·m² in 1 % of
// the current. One of 10 kg·m² takes more than the counters hold.
TEST(a_slow_rotor_takes_what_the_counters_hold)
{
    const drive_cfg_t slow = motor_b({"startup.current_pct=1", "motor.inertia_kg_m2=0.3"});
    TEST_ASSERT_EQUAL_UINT32(16, slow.startup.align.measure_log2);
    TEST_ASSERT_EQUAL_UINT32(466145, slow.startup.align.pull_ticks);
    const drive_cfg_t slower = motor_b({"startup.current_pct=1", "motor.inertia_kg_m2=10"});
    TEST_ASSERT_EQUAL_UINT32(1048576, slower.startup.align.pull_ticks);
    TEST_ASSERT_EQUAL_UINT32(60000, slower.supervision.swing_periods);
}

// 1 to 30 bits behind the point, 15 before it at most: above 16383.5 there is none, and below 2^-15
// they stay 30.
TEST(a_gain_has_1_to_30_bits_behind_the_point)
{
    const struct {
        double gain;
        int32_t mantissa;
        uint32_t shift;
    } cases[] = {{16383.5, 32767, 1}, {1.0 / 1048576, 1024, 30}};
    for (const auto &[gain, mantissa, shift] : cases) {
        const pi_cfg_t c = nf::make_pi(gain, gain / 2048, 1, "key", 1);
        TEST_ASSERT_EQUAL_INT32(mantissa, c.kp);
        TEST_ASSERT_EQUAL_UINT32(shift, c.kp_shift);
        TEST_ASSERT_EQUAL_INT32(mantissa, c.ki);
        TEST_ASSERT_EQUAL_UINT32(shift, c.ki_shift);
    }
    try {
        nf::make_pi(20000, 0, 1, "key", 2);
        TEST_FAIL_MESSAGE("a gain of 20000 is accepted");
    } catch (const nf::SettingError &error) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2 * 16383.5 / 20000, error.limit.value);
    }
}

TEST(what_a_field_cannot_hold_is_refused_with_what_it_can)
{
    const struct {
        std::vector<std::string> set; // the first is blamed
        const char *limit;            // and the beginning of the reason
        const char *tuning = "robust_motor_a";
    } cases[] = {
        // The lowest speed of a voltage drive is above the highest speed: the rated one may be at
        // most 1000/0.9.
        {{"motor.rated_speed_rpm=1200", "motor.max_speed_rpm=1000",
          "voltage_loop.speed_min_pct=90"},
         "at most 1111 rpm: the share voltage_loop.speed_min_pct",
         "voltage_phase"},
        // A tenth of 3000 rpm is above the highest speed.
        {{"motor.rated_speed_rpm=3000", "motor.max_speed_rpm=250"},
         "at most 2500 rpm: the share startup.handover_speed_pct"},
        {{"startup.loaded_speed_pct=8"}, "at most 7 %: 0.7 of startup.handover_speed_pct"},
        // Half of 0.375/0.19 A is 20.21 counts of 100 A/2048.
        {{"board.current_full_scale_a=100", "current_loop.bandwidth_hz=100",
          "motor.inductance_d_h=0.065", "motor.inductance_q_h=0.255"},
         "at most 84.21 A: half of motor.flux_linkage_wb/"},
        {{"speed_loop.inertia_feed_forward=0.5", "adaptation.inertia_pct=100"}, ""},
        // phi/L_d, 25 % more over 40 % less, is below 511 times 40 A: with 20 uH phi is up to
        // 0.196224 Wb.
        {{"motor.flux_linkage_wb=0.375", "motor.inductance_d_h=2e-5"}, "at most 0.1962 Wb: "},
        // A count from one end is 0.0244 % at 80/50 °C per %, two from the other 0.0488 % at 20/50.
        {{"board.temperature_max_c=99.97", "board.temperature_points_c=[0, 20, 100]",
          "board.temperature_points_pct=[100, 50, 0]"},
         "at most 99.96 °C: what the sensor can measure"},
        {{"board.temperature_max_c=0.0195", "board.temperature_points_c=[0, 20, 100]",
          "board.temperature_points_pct=[100, 50, 0]"},
         "at least 0.01954 °C: what the sensor can measure"},
        // 1.5·R·(6.3 A)² of 310 V is 0.07778 A.
        {{"board.bus_current_max_a=0.0777"},
         "at least 0.07779 A: what the current that a start imposes"},
        // A step of current is 40 A/2^15 = 1.2207 mA, that of 1.5·2·0.375 N·m/A 1.3733 mN·m.
        {{"motor.continuous_current_a=0.001"},
         "at least 0.001221 A: the firmware's steps of current"},
        {{"motor.rated_torque_nm=0.001"}, "at least 0.001374 N·m: the firmware's steps of current"},
        // Heat is looked at every 4·100/5000 s, in Q16 at most 32767 of the time constant.
        {{"motor.thermal_time_constant_s=0.1", "speed_loop.slow_ticks=100",
          "board.pwm_frequency_hz=5000"},
         "at least 0.1601 s: the time between two looks"},
    };
    for (const auto &[set, limit, tuning] : cases) {
        const std::string key = set[0].substr(0, set[0].find('='));
        const std::string expected = "--set: " + key + " = " + set[0].substr(key.size() + 1) +
                                     ": does not fit the firmware; allowed: " + limit;
        std::string refused = "accepted";
        try {
            motor_b(set, tuning);
        } catch (const nf::ConfigError &error) {
            refused = error.what();
        }
        TEST_ASSERT_EQUAL_STRING(expected.c_str(), refused.substr(0, expected.size()).c_str());
    }
}

} // namespace
