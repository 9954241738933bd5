/* SPDX-License-Identifier: MIT */
// Chosen signals for a screen: of each bucket of ticks the smallest and the largest value, in the
// order in which they came. So no peak is lost, however few points are drawn.
#pragma once

#include "signals.h"

#include <string>
#include <vector>

namespace nf::web
{

class Scope
{
public:
    // Throws for an unknown name, with the near ones. At least one tick a bucket.
    Scope(const std::vector<std::string> &names, int64_t ticks_in_bucket);

    void add(const Tick &tick);
    // Ticks are missing behind the last one: no bucket has both sides of them.
    void skip();
    // What was handed over is forgotten.
    void clear();

    struct Trace {
        const SignalInfo *signal;
        std::vector<float> points; // two a whole bucket
        float lowest;
        float highest;
        bool rose; // the highest came behind the lowest
    };
    // Of the points: the middles of a bucket's halves.
    const std::vector<double> &times_s() const
    {
        return times_s_;
    }
    const std::vector<Trace> &traces() const
    {
        return traces_;
    }

private:
    void close_bucket(double end_s);

    int64_t ticks_in_bucket_;
    int64_t ticks_ = 0; // of the open bucket
    double from_s_ = 0;
    std::vector<double> times_s_;
    std::vector<Trace> traces_;
};

} // namespace nf::web
