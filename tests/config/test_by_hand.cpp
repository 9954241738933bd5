// The firmware's numbers of motor B on the 310 V bench, from SI units by hand: each with its arithmetic, none with the
// code's own constants.
#include "config.h"

#include "unity.h"

#include <cmath>

namespace
{

constexpr double ROUNDING = 0.5 + 1e-6;
constexpr double MANTISSA =
    1e-4; // relative: half a step of a mantissa of 14 bits at least, and counters rounded up

// R 0.405 Ω, L_d 13.5 mH, L_q 23.5 mH, φ 0.375 Wb, P 2, 3.98 N·m, 1200 and 1800 rpm, 6.3 A, J 0.011; 10 kHz, ±20 A,
// 450 V, 310 V (200…400), over-current 18 A. I_b = 40 A, U_b = 450 V, T = 100 µs, slow 1 ms, supervision every 4 ms.
// I_c = 3.98/(1.5·2·0.375) = 3.53778 A. A rpm is 2/60/10000·2^32 = 14316.5577 steps.
constexpr double CONTINUOUS_Q15 = 3.53778 / 40 * 32768; // 2898.15
constexpr double STEPS_PER_RPM = 14316.5577;

drive_cfg_t motor_b()
{
    static const drive_cfg_t cfg = nf::build(nf::load_parts("motor_b", "bench_310v", "robust"));
    return cfg;
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

void protection()
{
    const protection_cfg_t c = motor_b().protection;
    expect(18.0 / 40 * 32768, c.current_max);
    expect(400.0 / 450 * 32768, c.bus_max);
    expect(200.0 / 450 * 32768, c.bus_min);
    expect(1.0 / 40 * 32768, c.offset_max);
}

// 4 ms of 20 s; the fault at 1.2 times the heat, derating from 0.9 on; standing is 1/64 of 1800 rpm.
void derating()
{
    const derating_cfg_t c = motor_b().derating;
    expect(6.3 / 40 * 32768, c.current_max);
    expect(CONTINUOUS_Q15, c.current_continuous);
    expect_mantissa(0.004 / 20 * 65536, c.heat_rate, c.heat_rate_shift);
    expect(1.2 * 16384, c.heat_max_q14);
    expect(16384, c.heat.zero);
    expect_mantissa(32768 / (0.1 * 16384), c.heat.gain, c.heat.shift);
    expect(25, c.temperature_periods); // 0.1 s
    expect(200.0 / 450 * 32768, c.bus_low.zero);
    expect_mantissa(-32768 / (0.25 * 110.0 / 450 * 32768), c.bus_low.gain, c.bus_low.shift);
    expect((355 + 0.75 * 45) / 450 * 32768, c.bus_high.zero);
    expect_mantissa(32768 / (0.75 * 45.0 / 450 * 32768), c.bus_high.gain, c.bus_high.shift);
    expect(1800 * STEPS_PER_RPM / 64, c.regeneration_speed);
    expect(0, c.bus_current_max);
    expect(0, c.bus_regeneration_max);
}

// 6 A and 1.5 A of 1.5·40 A; 100 A is beyond three times the full scale of 20 A, which never flows.
void bus_currents()
{
    const derating_cfg_t c =
        nf::build(nf::load_parts("motor_b", "bench_310v", "robust", {},
                                 {"board.bus_current_max_a=6", "board.bus_regeneration_max_a=1.5"}))
            .derating;
    expect(6.0 / 60 * 32768, c.bus_current_max);
    expect(1.5 / 60 * 32768, c.bus_regeneration_max);
    const derating_cfg_t none = nf::build(nf::load_parts("motor_b", "bench_310v", "robust", {},
                                                         {"board.bus_current_max_a=100",
                                                          "board.bus_regeneration_max_a=100"}))
                                    .derating;
    expect(32767, none.bus_current_max);
    expect(32767, none.bus_regeneration_max);
}

// Over 4 ms: 10 ms, 20 ms, 0.5 s (above 5/bandwidth), 1 s are 3, 5, 125, 250.
void supervision()
{
    const supervision_cfg_t c = motor_b().supervision;
    expect(0.2 * CONTINUOUS_Q15, c.phase_range_min);
    expect(0.2 * CONTINUOUS_Q15, c.follow_error_max);
    expect(0.75 * CONTINUOUS_Q15, c.residual_max);
    expect(0.5 * CONTINUOUS_Q15, c.stall_current);
    expect(0.25 * 1800 * STEPS_PER_RPM, c.speed_error_max);
    expect(1.15 * 1800 * STEPS_PER_RPM, c.overspeed);
    expect(1800 * STEPS_PER_RPM / 64, c.stall_speed);
    expect(0.4 * 4294967296.0 / 10, c.phase_speed_max);
    expect(3, c.runaway_periods);
    expect(5, c.overspeed_periods);
    expect(250, c.stall_periods);
    expect(250, c.late_window);
    expect(10, c.late_max);
    expect(4, c.mean_shift); // 4 ms·2^4 is the first above 50 ms
    expect((0.4 * 0.405 * 6.3 + 0.03 * 310) / 450 * 32768, c.voltage_max);
}

// φ/L_d = 27.7778 A; with L −40 %, φ +25 %: 57.87 A; three phases at 18 A make 2/√3·18 = 20.785 A: 78.66 A < 2·40 A.
void observer_base_and_weights()
{
    const nn_observer_cfg_t c = motor_b().observer;
    expect(1, c.current_shift);
    // One shift for both: that of the larger weight.
    expect(std::ldexp(1e-4 * 0.405 / 0.0135 / 2 * 4096, static_cast<int>(c.weight_shift)), c.decay);
    expect_mantissa(1e-4 / 0.0135 * 450 / 80 * 4096, c.volt_gain, c.weight_shift);
    expect(27.7777778 / 80 * 134217728, c.flux_q27);
    expect(13.5 / 23.5 * 16384, c.iq_gain_q14);
    expect(23.5 / 13.5 * 8192, c.saliency_q13);
    expect(1.25 * 1800 * STEPS_PER_RPM, c.speed_limit);
    expect(30 * 1e-4 / 6.283185307 * 4294967296.0, c.corner);
    expect(2 * 8192, c.rho_max_q13);
    expect(60 * STEPS_PER_RPM, c.rho_speed_min); // half of a tenth of 1200 rpm
}

// κ·I_b·I_x/(φ/L_d)²·4/2π·2^12 steps.
void observer_gains()
{
    const nn_observer_cfg_t c = motor_b().observer;
    const double one = 40.0 * 80 / (27.7777778 * 27.7777778) * 4 / 6.283185307 * 4096;
    expect(12, c.descent_shift);
    expect_mantissa(0.025 * one, c.rate, c.rate_shift);
    expect_mantissa(0.45 * one, c.proportional, c.proportional_shift);
}

// Ω_b = 2^15·2^10 steps, the first above 2250 rpm: 2^25/2^32·2π·10 kHz = 490.874 rad/s.
void loops()
{
    const drive_cfg_t c = motor_b();
    expect(10, c.speed_shift);
    expect(490.873852 * 0.0135 * 40 / 450 * 8192, c.current_loop.reactance_d_q13);
    expect(490.873852 * 0.0235 * 40 / 450 * 8192, c.current_loop.reactance_q_q13);
    expect(490.873852 * 0.375 / 450 * 8192, c.current_loop.emf_q13);
    expect(0.405 * 40 / 450 * 8192, c.current_loop.resistance_q13);
    const double omega = 6.283185307 * 500;
    expect_mantissa(omega * 0.0135 * 40 / 450, c.current_loop.pi_d.kp,
                    c.current_loop.pi_d.kp_shift);
    expect_mantissa(omega * 0.0135 * 40 / 450 * omega / 10 * 1e-4 * 2048, c.current_loop.pi_d.ki,
                    c.current_loop.pi_d.ki_shift);
    // a = 1.5·2·0.375·6.3/0.011 rad/s²; 0.27 of it in a millisecond.
    const double acceleration = 1.125 * 6.3 / 0.011;
    expect(0.27 * acceleration * 1e-3 * 30 / 3.141592654 * STEPS_PER_RPM, c.speed_loop.ramp);
    expect(0.20 * acceleration * 1e-3 * 30 / 3.141592654 * STEPS_PER_RPM, c.position_loop.ramp);
    expect(1800 * STEPS_PER_RPM, c.speed_loop.speed_max);
    expect(600 * STEPS_PER_RPM, c.position_loop.speed_max);
}

} // namespace

void setUp()
{
}

void tearDown()
{
}

int main()
{
    UNITY_BEGIN();
    RUN_TEST(protection);
    RUN_TEST(derating);
    RUN_TEST(bus_currents);
    RUN_TEST(supervision);
    RUN_TEST(observer_base_and_weights);
    RUN_TEST(observer_gains);
    RUN_TEST(loops);
    return UNITY_END();
}
