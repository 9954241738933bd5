// SPDX-License-Identifier: MIT
#include "scope.h"

#include "vocabulary.h"

#include <cmath>

namespace nf::web
{
namespace
{

void begin(Scope::Trace &trace, float value)
{
    trace.lowest = value;
    trace.highest = value;
    trace.rose = true;
}

void widen(Scope::Trace &trace, float value)
{
    if (value < trace.lowest) {
        trace.lowest = value;
        trace.rose = false;
    }
    if (value > trace.highest) {
        trace.highest = value;
        trace.rose = true;
    }
}

} // namespace

Scope::Scope(const std::vector<std::string> &names, int64_t ticks_in_bucket)
    : ticks_in_bucket_(ticks_in_bucket)
{
    for (const std::string &name : names) {
        traces_.push_back({debug::named_signal(name).signal, {}, 0, 0, true});
    }
}

void Scope::add(const Tick &tick)
{
    if (ticks_ == 0) {
        from_s_ = tick.time_s;
    }
    for (Trace &trace : traces_) {
        const auto value = static_cast<float>(si_value(*trace.signal, tick));
        if (ticks_ == 0 || std::isnan(trace.lowest)) { // not known before this tick
            begin(trace, value);
        } else {
            widen(trace, value);
        }
    }
    ticks_++;
    if (ticks_ == ticks_in_bucket_) {
        close_bucket(tick.time_s);
    }
}

void Scope::close_bucket(double end_s)
{
    const double quarter_s = (end_s - from_s_) / 4;
    times_s_.push_back(from_s_ + quarter_s);
    times_s_.push_back(end_s - quarter_s);
    for (Trace &trace : traces_) {
        trace.points.push_back(trace.rose ? trace.lowest : trace.highest);
        trace.points.push_back(trace.rose ? trace.highest : trace.lowest);
    }
    ticks_ = 0;
}

void Scope::skip()
{
    ticks_ = 0;
}

void Scope::clear()
{
    times_s_.clear();
    for (Trace &trace : traces_) {
        trace.points.clear();
    }
}

} // namespace nf::web
