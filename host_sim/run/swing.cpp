// SPDX-License-Identifier: MIT
#include "swing.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double PERIODS = 3;
constexpr double KEPT = 0.5; // of a half-swing's height, so many periods later

} // namespace

SwingFinder::SwingFinder(double least, double period_s) : least_(least), period_s_(period_s)
{
}

void SwingFinder::restart()
{
    begun_ = false;
    direction_ = 0;
    count_ = 0;
}

void SwingFinder::add(double value, double signal)
{
    tick_++;
    if (!begun_) {
        begun_ = true;
        low_ = high_ = {tick_, value, signal};
    }
    low_ = value < low_.value ? Turn{tick_, value, signal} : low_;
    high_ = value > high_.value ? Turn{tick_, value, signal} : high_;
    const bool falls = direction_ >= 0 && high_.value - value >= least_;
    const bool rises = direction_ <= 0 && value - low_.value >= least_;
    if (!falls && !rises) {
        return;
    }
    if (direction_ != 0) { // else nothing was under way
        turned_at(falls ? high_ : low_);
    }
    direction_ = falls ? -1 : 1;
    low_ = high_ = {tick_, value, signal};
}

void SwingFinder::turned_at(const Turn &found)
{
    if (count_ == turns_.size()) {
        std::rotate(turns_.begin(), turns_.begin() + 1, turns_.end());
        count_--;
    }
    turns_[count_] = found;
    count_++;
    judge();
}

void SwingFinder::judge()
{
    if (count_ < turns_.size()) {
        return;
    }
    const double oldest = std::abs(turns_[1].value - turns_[0].value);
    const double newest = std::abs(turns_[HALVES + 1].value - turns_[HALVES].value);
    if (newest < KEPT * oldest) {
        return;
    }
    double sum = 0;
    double along = 0; // how far the signal itself goes the same ways
    for (std::size_t k = 1; k <= HALVES; k++) {
        const double way = turns_[k + 1].value - turns_[k].value;
        const double signal = turns_[k + 1].signal - turns_[k].signal;
        sum += std::abs(way);
        along += way > 0 ? signal : -signal;
    }
    if (along < KEPT * sum) {
        return;
    }
    const double amplitude = sum / HALVES / 2;
    const double seconds =
        static_cast<double>(turns_[HALVES + 1].tick - turns_[1].tick) * period_s_;
    if (!largest_ || amplitude > largest_->amplitude) {
        largest_ = Swing{amplitude, PERIODS / seconds};
    }
}

} // namespace nf
