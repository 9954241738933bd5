// SPDX-License-Identifier: MIT
// What the host computes of a tick once more is what the drive had: beside words in which the drive
// keeps something of it.
#include "measured.h"
#include "run_bench.h"

#include <algorithm>
#include <map>

namespace
{

using nf::Machine;
using nf::Words;
using Bench = nf::RunBench;

constexpr Machine MOTOR_A = {"motor_a", "bench_310v", "robust_motor_a"};

constexpr int32_t ERROR_MAX = 8191; // of the observer, where it saturates
constexpr unsigned MEAN_SHIFT = 5;  // of the imposed current's filter
// The hand-back turns the current of the rotor's frame by the angle between both frames; two
// roundings more than one turn by the vector's angle.
constexpr int32_t TURNED_TWICE_LSB = 2;

int32_t saturated(int32_t error)
{
    return std::clamp(error, -ERROR_MAX - 1, ERROR_MAX);
}

// The observer's error is what was measured less what its network has predicted.
void check_rotor_frame(const drive_t &drive, const dq_t &current)
{
    const nn_observer_t &network = drive.rotor.observer;
    TEST_ASSERT_EQUAL_INT32(saturated(current.d - network.current.d), network.error.d);
    TEST_ASSERT_EQUAL_INT32(saturated(current.q - network.current.q), network.error.q);
}

void check_vector_frame(const dq_t &mean_before, const dq_t &mean, const dq_t &current)
{
    TEST_ASSERT_EQUAL_INT32(fx_approach(mean_before.d, fx_sat15(current.d), MEAN_SHIFT), mean.d);
    TEST_ASSERT_EQUAL_INT32(fx_approach(mean_before.q, fx_sat15(current.q), MEAN_SHIFT), mean.q);
}

// Counts the ticks that were looked at, by the state in which they ended.
class Watched
{
public:
    explicit Watched(const Words &set) : bench_(MOTOR_A, {"all"}, set)
    {
    }

    void seconds(double time_s)
    {
        const long ticks = std::lround(time_s / bench_.sim.bases().control_period_s);
        for (long k = 0; k < ticks; k++) {
            tick();
        }
    }

    Bench &bench()
    {
        return bench_;
    }

    long looked_at(drive_state_t state) const
    {
        return looked_at_.count(state) == 0 ? 0 : looked_at_.at(state);
    }

    long handed_back() const
    {
        return handed_back_;
    }

private:
    // In a tick that changes the state the drive may begin anew with what these words hold.
    void tick()
    {
        const drive_t &drive = bench_.sim.drive();
        const drive_state_t state = drive.state;
        const dq_t mean = drive.vector.current_mean;
        bench_.tick();
        const instant_t now = nf::measured(bench_.now);
        if (state == DRIVE_STATE_RUN && drive.state == DRIVE_STATE_HOLD) {
            TEST_ASSERT_INT32_WITHIN(TURNED_TWICE_LSB, now.along_vector.d,
                                     drive.vector.current_mean.d);
            TEST_ASSERT_INT32_WITHIN(TURNED_TWICE_LSB, now.along_vector.q,
                                     drive.vector.current_mean.q);
            handed_back_++;
        } else if (state == drive.state && drive_is_controlled(state)) {
            check_rotor_frame(drive, now.along_rotor);
            if (drive_is_imposed(state)) {
                check_vector_frame(mean, drive.vector.current_mean, now.along_vector);
            }
            looked_at_[state]++;
        }
    }

    Bench bench_;
    std::map<drive_state_t, long> looked_at_;
    long handed_back_ = 0;
};

} // namespace

TEST(the_currents_of_each_tick_are_those_that_observer_and_vector_were_given)
{
    Watched run({});
    run.bench().ask_speed(0.4);
    run.seconds(0.2);
    run.bench().sim.request(DRIVE_REQUEST_RUN);
    run.seconds(2);
    run.bench().ask_speed(0);
    run.seconds(2);
    for (const drive_state_t state : {DRIVE_STATE_ALIGN, DRIVE_STATE_HOLD, DRIVE_STATE_IF_RAMP,
                                      DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN}) {
        TEST_ASSERT_TRUE(run.looked_at(state) > 0);
    }
    TEST_ASSERT_TRUE(run.handed_back() > 0);
}

TEST(with_a_sensor_the_currents_are_those_along_its_angle)
{
    Watched run({"drive.angle_source=sensor"});
    run.seconds(0.2);
    run.bench().sim.request(DRIVE_REQUEST_RUN);
    run.bench().ask_speed(0.4);
    run.seconds(1);
    TEST_ASSERT_TRUE(run.looked_at(DRIVE_STATE_RUN) > 0);
}
