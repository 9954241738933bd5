// SPDX-License-Identifier: MIT
#include "lossy_channel.h"

namespace nf::live
{

// The distributions of the standard library are not the same everywhere; this one is.
std::vector<uint8_t> LossyChannel::spoilt(const std::vector<uint8_t> &bytes, const Loss &loss)
{
    std::vector<uint8_t> out;
    for (const uint8_t byte : bytes) {
        const double draw = static_cast<double>(random_()) / 4294967296.0;
        const auto other = static_cast<uint8_t>(byte ^ (1 + random_() % 255));
        const bool is_dropped = draw < loss.dropped;
        const bool is_doubled = !is_dropped && draw < loss.dropped + loss.doubled;
        const bool is_changed =
            !is_dropped && !is_doubled && draw < loss.dropped + loss.doubled + loss.changed;
        if (!is_dropped) {
            out.push_back(is_changed ? other : byte);
        }
        if (is_doubled) {
            out.push_back(byte);
        }
        spoilt_bytes_ += is_dropped || is_doubled || is_changed ? 1 : 0;
    }
    return out;
}

} // namespace nf::live
