/* SPDX-License-Identifier: MIT */
// How far a run stays from its limits, looked at tick by tick. A margin is 1 where nothing is used
// of a limit, 0 at it, and below 0 beyond it.
#pragma once

#include "tick.h"
#include "timetable.h"

namespace nf::certify
{

// All that is known of a run that went to its end or stopped with a fault.
struct Margins {
    double current = 0; // largest phase current, of the lower one of trip and over-current level
    double voltage = 0; // mean of the demand under the load at rated speed, of the voltage circle
    double speed =
        0; // mean square of the speed error as in `locked`, its root over 5 % of rated speed
    double angle = 0; // largest angle error over 90 degrees
    // Mean speed at the end of the load, and at the end of the reversal, as a share of the command:
    // the lower one.
    double reached = 0;
    double highest_rpm = 0; // either way

    // The least of current, speed and angle. A drive at its voltage limit is slow, not lost.
    double worst() const;
};

class MarginWatch : public TickSink
{
public:
    // `believed` is what the drive takes the motor and the board for.
    MarginWatch(const Config &believed, const ScenarioSettings &scenario);

    void add(const Tick &tick) override;
    Margins margins() const;

private:
    // A mean over a window.
    struct Mean {
        double sum = 0;
        int count = 0;

        void add(double value)
        {
            sum += value;
            count++;
        }
        double get() const
        {
            return count > 0 ? sum / count : 0;
        }
    };

    void watch_estimate(const Tick &tick, double error_rpm);

    Windows windows_;
    double evaluate_from_s_;
    double limit_a_;
    double circle_; // largest phase voltage, of the bus
    double rated_rpm_;
    double mean_gain_; // a tick's share in the mean square
    double largest_a_ = 0;
    double largest_deg_ = 0;
    double highest_rpm_ = 0;
    double square_rpm_ = 0; // mean square of the speed error now, and the largest
    double largest_square_ = 0;
    Mean loaded_rpm_;
    Mean reversed_rpm_;
    Mean voltage_;
};

} // namespace nf::certify
