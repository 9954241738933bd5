// SPDX-License-Identifier: MIT
// Each clamp of the drive is seen from outside, and nothing is seen just short of it.
#include "saturation.h"

#include <functional>

#include "testing.h"

namespace
{

using nf::Saturations;
using nf::Signal;

constexpr int32_t CURRENT_MAX = 8000;
constexpr int32_t SPEED_LIMIT = 100000;
constexpr int32_t COUNTS = 8500;

drive_cfg_t make_cfg()
{
    drive_cfg_t cfg{};
    cfg.observer.speed_limit = SPEED_LIMIT;
    cfg.modulator.timer_counts = COUNTS;
    cfg.modulator.ratio_max_q15 = 18000;
    return cfg;
}

const drive_cfg_t CFG = make_cfg();

struct Frame {
    drive_t drive{};
    sample_t sample{};
    drive_out_t out{};
};

// A drive well inside all its ranges.
Frame calm()
{
    Frame frame;
    frame.drive.cfg = &CFG;
    frame.drive.motion.torque_range = {-CURRENT_MAX, CURRENT_MAX};
    frame.drive.modulator.inverse_bus_q12 = 5000;
    frame.drive.bus = 21846; // two thirds of 18000 are the circle's 12000
    for (uint16_t &phase : frame.out.compare.phase) {
        phase = COUNTS / 2;
    }
    return frame;
}

uint64_t hits(const Frame &frame, Signal signal)
{
    Saturations saturations;
    saturations.add(frame.drive, frame.sample, frame.out);
    return saturations.ticks()[static_cast<std::size_t>(signal)];
}

// The value one short of the end is not counted, the end is, on both sides.
template <typename Set> void check_ends(Signal signal, int32_t end, Set set)
{
    Frame frame = calm();
    set(frame, end - 1);
    TEST_ASSERT_EQUAL_UINT64(0, hits(frame, signal));
    set(frame, 1 - end);
    TEST_ASSERT_EQUAL_UINT64(0, hits(frame, signal));
    set(frame, end);
    TEST_ASSERT_EQUAL_UINT64(1, hits(frame, signal));
    set(frame, -end);
    TEST_ASSERT_EQUAL_UINT64(1, hits(frame, signal));
}

TEST(test_calm_drive_has_none)
{
    const Frame frame = calm();
    for (std::size_t k = 0; k < nf::SIGNAL_COUNT; k++) {
        TEST_ASSERT_EQUAL_UINT64(0, hits(frame, static_cast<Signal>(k)));
        TEST_ASSERT_NOT_NULL(nf::signal_name(k));
    }
}

TEST(test_measured_currents)
{
    check_ends(Signal::phase_a, 16383, [](Frame &f, int32_t x) { f.sample.phase_a = x; });
    check_ends(Signal::phase_b, 16383, [](Frame &f, int32_t x) { f.sample.phase_b = x; });
}

TEST(test_network)
{
    check_ends(Signal::network_alpha, 134217727,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.alpha_q27 = x; });
    check_ends(Signal::network_beta, 134217727,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.beta_q27 = x; });
    check_ends(Signal::network_error_d, 8191,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.error.d = x; });
    check_ends(Signal::network_error_q, 8191,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.error.q = x; });
    check_ends(Signal::network_speed, SPEED_LIMIT,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.speed = x; });
    check_ends(Signal::network_weight_step, 536870911,
               [](Frame &f, int32_t x) { f.drive.rotor.observer.weight_step = x; });
}

// Saturation to n bits ends one lower on the negative side.
TEST(test_most_negative_values)
{
    Frame frame = calm();
    frame.sample.phase_a = -16384;
    frame.sample.phase_b = -16384;
    frame.drive.rotor.observer.alpha_q27 = -134217728;
    frame.drive.rotor.observer.beta_q27 = -134217728;
    frame.drive.rotor.observer.error = {-8192, -8192};
    frame.drive.rotor.observer.weight_step = -536870912;
    frame.drive.control.current_loop.pi_d.integral_q26 = -67108864;
    frame.drive.control.current_loop.pi_q.integral_q26 = -67108864;
    frame.drive.motion.speed_loop.pi.integral_q26 = -67108864;
    for (const Signal signal :
         {Signal::phase_a, Signal::phase_b, Signal::network_alpha, Signal::network_beta,
          Signal::network_error_d, Signal::network_error_q, Signal::network_weight_step,
          Signal::integral_d, Signal::integral_q, Signal::integral_speed}) {
        TEST_ASSERT_EQUAL_UINT64(1, hits(frame, signal));
    }
}

// 400000 steps in a tick, no end of ω̂.
TEST(test_inner_speed_has_no_end)
{
    Frame frame = calm();
    frame.drive.rotor.observer.speed_out = 4 * SPEED_LIMIT;
    Saturations saturations;
    saturations.add(frame.drive, frame.sample, frame.out);
    TEST_ASSERT_EQUAL_UINT64(0, saturations.internal_count());
}

TEST(test_integrals_saturate_at_one)
{
    check_ends(Signal::integral_d, 67108863,
               [](Frame &f, int32_t x) { f.drive.control.current_loop.pi_d.integral_q26 = x; });
    check_ends(Signal::integral_q, 67108863,
               [](Frame &f, int32_t x) { f.drive.control.current_loop.pi_q.integral_q26 = x; });
    check_ends(Signal::integral_speed, 67108863,
               [](Frame &f, int32_t x) { f.drive.motion.speed_loop.pi.integral_q26 = x; });
}

TEST(test_largest_ratio_of_either_axis)
{
    check_ends(Signal::ratio, 18000,
               [](Frame &f, int32_t x) { f.drive.control.ratio_next.alpha = x; });
    check_ends(Signal::ratio, 18000,
               [](Frame &f, int32_t x) { f.drive.control.ratio_next.beta = x; });
}

TEST(test_limits_are_not_internal)
{
    Frame frame = calm();
    frame.drive.control.current_ref.q = -CURRENT_MAX;
    frame.drive.control.voltage = {0, 12000};
    frame.out.compare.phase[1] = 0;
    Saturations saturations;
    saturations.add(frame.drive, frame.sample, frame.out);
    TEST_ASSERT_EQUAL_UINT64(0, saturations.internal_count());
    for (const Signal signal : {Signal::torque, Signal::voltage, Signal::duty}) {
        TEST_ASSERT_EQUAL_UINT64(1, hits(frame, signal));
    }
}

// v_d = 7200 leaves 9600 of a circle of 12000.
TEST(test_voltage_circle)
{
    Frame frame = calm();
    frame.drive.control.voltage = {7200, 9599};
    TEST_ASSERT_EQUAL_UINT64(0, hits(frame, Signal::voltage));
    frame.drive.control.voltage = {7200, -9600};
    TEST_ASSERT_EQUAL_UINT64(1, hits(frame, Signal::voltage));
}

TEST(test_internal_count_adds_up)
{
    Frame frame = calm();
    frame.sample.phase_a = 16383;
    frame.drive.rotor.observer.error.q = -8191;
    Saturations saturations;
    saturations.add(frame.drive, frame.sample, frame.out);
    saturations.add(frame.drive, frame.sample, frame.out);
    TEST_ASSERT_EQUAL_UINT64(4, saturations.internal_count());
}

TEST(test_position_lag_counts_in_position_mode_only)
{
    Frame frame = calm();
    frame.drive.motion.position_loop.profile_q32 = int64_t{1} << 40;
    TEST_ASSERT_EQUAL_UINT64(0, hits(frame, Signal::position_lag));
    frame.drive.motion.mode = DRIVE_MODE_POSITION;
    TEST_ASSERT_EQUAL_UINT64(1, hits(frame, Signal::position_lag));
}

} // namespace
