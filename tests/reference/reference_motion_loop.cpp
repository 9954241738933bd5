// SPDX-License-Identifier: MIT
// Speed and position loops beside their twins.
#include "settings_under_test.h"
#include "twin_motion_loop.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::Setup;
using nf::reference::STEPS_PER_TURN;
using nf::reference::TWO_PI;

static constexpr double LEAST_SHARE = 0.1;

static Setup setup_a()
{
    return Setup(nf::reference::motor_a(), nf::reference::board(), nf::reference::tuning());
}

static torque_range_t torque_range(const Setup &s)
{
    return {-s.cfg.derating.current_max, s.cfg.derating.current_max};
}

// Current demand in LSB of I_b: proportional part, integral and feed-forward rounded down, 3; the
// error rounded down to its Q15 counts K_p, and K_i·T in each step into the integral, which nothing
// contracts.
TEST(test_current_demand_stays_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 60;
    const Setup s = setup_a();
    const speed_loop_cfg_t &c = s.cfg.speed_loop;
    const double kp = std::ldexp(c.pi.kp, -static_cast<int>(c.pi.kp_shift));
    const double ki_t = std::ldexp(c.pi.ki, -static_cast<int>(c.pi.ki_shift) - 11);
    const double bound = 3.0 + kp + STEPS * (ki_t + 1.0 / 2048.0);
    Seeded seeded(1);
    double worst = 0;

    for (int run = 0; run < 100; run++) {
        const torque_range_t torque = torque_range(s);
        speed_loop_t loop{};
        nf::twin::SpeedLoop twin(nf::reference::speed_loop_params(s));
        const step_t target = seeded.in(-300000, 300000);
        step_t measured = 0;

        speed_loop_init(&loop);
        for (int k = 0; k < STEPS; k++) {
            const step_t reference = speed_loop_ramp(&loop, &c, target);
            const double exact_reference = twin.ramp(s.speed_of_step(target));

            measured += seeded.in(-2000, 2000) + (reference - measured) / 4;
            const int32_t demand = speed_loop_step(&loop, &c, reference, measured, torque);
            const double exact = twin.step(exact_reference, s.speed_of_step(measured));
            TEST_ASSERT_TRUE(std::abs(demand) < torque.upper);
            worst = std::max(worst, std::abs(demand - exact / s.current(1)));
            // The ramp is exact in both; the twin's own rounding stays far below one step.
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, reference, s.step_of_speed(exact_reference));
        }
    }
    figure_check("current demand beside its twin, LSB", worst, bound, LEAST_SHARE);
}

// Saturated demands are equal but for the roundings inside the limit, so the limit itself must
// agree.
TEST(test_saturated_demand_equals_the_twin)
{
    const Setup s = setup_a();
    speed_loop_t loop{};
    nf::twin::SpeedLoop twin(nf::reference::speed_loop_params(s));

    speed_loop_init(&loop);
    for (int k = 0; k < 20; k++) {
        const int32_t demand = speed_loop_step(&loop, &s.cfg.speed_loop, s.cfg.speed_loop.speed_max,
                                               0, torque_range(s));
        const double exact = twin.step(s.speed_of_step(s.cfg.speed_loop.speed_max), 0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, demand, exact / s.current(1));
    }
}

// Profile, distances in units u, B = 2^30/braking_inverse of them, s = √(d/B + c²) ≤ √(1 + c²).
// In one period v errs by v_max·(1/(2Bs) for d rounded down to a unit + 2^-15 for the root) + 2
// steps. The braking law itself contracts an error of d: in the long run it is the error of v over
// dv/dd = v_max/(2Bs): 1 + 2Bs·2^-15 + 2·2Bs/v_max units, and v errs by its own error and by dv/dd
// of that: twice. At the end the firmware rests on the target from less than one unit away: 1 unit
// more, and the speed of it, v_max/(2Bc).
struct ProfileBound {
    explicit ProfileBound(const Setup &s)
    {
        const position_loop_cfg_t &c = s.cfg.position_loop;
        const double braking = 1073741824.0 / c.braking_inverse;
        const double soft = c.softness_q15 / Q15;
        const double widest = std::sqrt(1.0 + soft * soft);
        position_units = 2.0 + 2.0 * braking * widest / Q15 + 4.0 * braking * widest / c.speed_max;
        speed_steps = 2.0 * (c.speed_max * (1.0 / (2.0 * braking * soft) + 1.0 / Q15) + 2.0) +
                      c.speed_max / (2.0 * braking * soft);
    }
    double position_units;
    double speed_steps;
};

struct ProfileErrors {
    double position_units = 0;
    double speed_steps = 0;
    double reference_steps = 0;
};

// One way of the profile from a seeded start beside its twin; the largest differences.
static void run_profile(const Setup &s, Seeded &seeded, ProfileErrors &worst)
{
    const position_loop_cfg_t &c = s.cfg.position_loop;
    const double unit = std::ldexp(1.0, static_cast<int>(c.distance_shift));
    const double radian_q32 = STEPS_PER_TURN / TWO_PI;
    const int64_t start = static_cast<int64_t>(seeded.in(-100000, 100000)) * 65536;
    const int64_t target = start + static_cast<int64_t>(seeded.in(-600000, 600000)) * 65536;
    const int64_t measured_behind = seeded.in(-20000, 20000) * int64_t{65536};
    // Up to twice the profile's own limit, as after a change of mode.
    const step_t speed = seeded.in(-2 * c.speed_max, 2 * c.speed_max);
    nf::twin::PositionLoop twin(nf::reference::position_loop_params(s));
    position_loop_t loop;

    position_loop_reset(&loop, start, speed);
    twin.reset(static_cast<double>(start) / radian_q32, s.speed_of_step(speed));
    for (int k = 0; k < 600; k++) {
        const int64_t measured = loop.profile_q32 - measured_behind;
        const step_t reference = position_loop_step(&loop, &c, target, measured, s.cfg.slow_ticks);
        const double exact = twin.step(static_cast<double>(target) / radian_q32,
                                       static_cast<double>(measured) / radian_q32);
        const double off = static_cast<double>(loop.profile_q32) - twin.position() * radian_q32;

        worst.position_units = std::max(worst.position_units, std::abs(off) / unit);
        worst.speed_steps = std::max(worst.speed_steps,
                                     std::abs(loop.profile_speed - s.step_of_speed(twin.speed())));
        worst.reference_steps =
            std::max(worst.reference_steps, std::abs(reference - s.step_of_speed(exact)));
    }
}

TEST(test_profile_stays_within_the_roundings_of_the_twin)
{
    const Setup s = setup_a();
    const position_loop_cfg_t &c = s.cfg.position_loop;
    const ProfileBound bound(s);
    const double unit = std::ldexp(1.0, static_cast<int>(c.distance_shift));
    const double gain = std::ldexp(c.gain, -static_cast<int>(c.gain_shift));
    Seeded seeded(2);
    ProfileErrors worst;

    for (int run = 0; run < 60; run++) {
        run_profile(s, seeded, worst);
    }
    figure_check("profile position beside its twin, units", worst.position_units,
                 bound.position_units, LEAST_SHARE);
    figure_check("profile speed beside its twin, steps", worst.speed_steps, bound.speed_steps,
                 LEAST_SHARE);
    // The reference adds the lag: rounded down to Q16 turns and by the position error, times the
    // gain; 1.
    figure_check("speed reference beside its twin, steps", worst.reference_steps,
                 bound.speed_steps + gain * (1.0 + bound.position_units * unit / 65536.0) + 1.0,
                 LEAST_SHARE);
}
