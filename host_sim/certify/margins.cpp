// SPDX-License-Identifier: MIT
#include "margins.h"

#include "metrics.h"
#include "modulator_units.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf::certify
{
namespace
{

constexpr double RPM_PER_RAD_S = 60 / TWO_PI;

double limit_of(const BoardSettings &board)
{
    return board.trip_a > 0 ? std::min(board.trip_a, board.overcurrent_a) : board.overcurrent_a;
}

bool is_running(const Tick &tick)
{
    const drive_state_t state = tick.sim->drive().state;
    return state > DRIVE_STATE_READY && state < DRIVE_STATE_FAULT;
}

} // namespace

double Margins::worst() const
{
    return std::min({current, speed, angle});
}

MarginWatch::MarginWatch(const Config &believed, const ScenarioSettings &scenario)
    : windows_(windows_of(scenario)), evaluate_from_s_(scenario.evaluate_from_s),
      limit_a_(limit_of(believed.board)), circle_(largest_ratio(believed.board)),
      rated_rpm_(believed.motor.rated_speed_rpm),
      mean_gain_(1 / (LOST_MEAN_S * believed.board.pwm_frequency_hz))
{
}

void MarginWatch::watch_estimate(const Tick &tick, double error_rpm)
{
    square_rpm_ += (error_rpm * error_rpm - square_rpm_) * mean_gain_;
    largest_square_ = std::max(largest_square_, square_rpm_);
    largest_deg_ = std::max(largest_deg_, std::abs(angle_error_deg(tick)));
}

void MarginWatch::add(const Tick &tick)
{
    const double rpm = tick.truth.omega_mech_rad_s * RPM_PER_RAD_S;
    highest_rpm_ = std::max(highest_rpm_, std::abs(rpm));
    for (const double ampere : tick.truth.i_abc_a) {
        largest_a_ = std::max(largest_a_, std::abs(ampere));
    }
    if (tick.time_s >= evaluate_from_s_ && is_running(tick)) {
        watch_estimate(tick, rpm - tick.sim->bases().rpm_from_step(tick.speed_estimate));
    }
    if (windows_.loaded.holds(tick.time_s)) {
        loaded_rpm_.add(rpm);
        voltage_.add(std::hypot(tick.ratio_acted.alpha, tick.ratio_acted.beta) / Q15);
    }
    if (windows_.reversed.holds(tick.time_s)) {
        reversed_rpm_.add(rpm);
    }
}

Margins MarginWatch::margins() const
{
    Margins found;
    found.current = 1 - largest_a_ / limit_a_;
    found.voltage = 1 - voltage_.get() / circle_;
    found.speed = 1 - std::sqrt(largest_square_) / (LOST_SPEED * rated_rpm_);
    found.angle = 1 - largest_deg_ / LOST_DEG;
    found.reached = std::min(loaded_rpm_.get(), -reversed_rpm_.get() / REVERSED_SPEED) / rated_rpm_;
    found.highest_rpm = highest_rpm_;
    return found;
}

} // namespace nf::certify
