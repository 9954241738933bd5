// SPDX-License-Identifier: MIT
#include "stream.h"

#include <algorithm>

namespace nf::live
{

namespace
{

constexpr uint64_t LAP = UINT32_MAX; // numbers, and so places, until a number comes again

uint32_t number_at(uint64_t place)
{
    return static_cast<uint32_t>((place - 1) % LAP) + 1;
}

} // namespace

// The first segment that is heard of has a place of the second lap: there is room before it.
Stream::Place Stream::place_of(uint32_t segment) const
{
    const Place nearest_to = newest_ == 0 ? LAP + segment : newest_;
    const Place ahead = (segment + LAP - number_at(nearest_to)) % LAP;
    return ahead <= LAP / 2 ? nearest_to + ahead : nearest_to + ahead - LAP;
}

Stream::Part *Stream::part(uint32_t segment)
{
    const Place place = place_of(segment);
    if (segment == 0 || place < oldest_) {
        return nullptr;
    }
    // Of those between two nothing may have come at all; of those that the ring has lost nothing
    // will.
    const Place known = newest_ == 0 ? place : std::max(newest_ + 1, place - RECORDER_SEGMENTS);
    for (Place at = known; at < place; at++) {
        (void)parts_[at];
    }
    newest_ = std::max(newest_, place);
    return &parts_[place];
}

// What lies behind the end came of another segment of this number, before the board started anew.
void Stream::fit(Part &part)
{
    if (part.total) {
        part.entries.resize(*part.total);
    }
}

void Stream::add(const SegmentInfo &info)
{
    Part *const of = part(info.number);
    if (of == nullptr) {
        return;
    }
    of->info = info;
    const auto before = parts_.find(place_of(info.number) - 1);
    if (before != parts_.end() && info.entries_before != 0) {
        before->second.total = std::min(info.entries_before, segment_entries_);
        fit(before->second);
    }
}

void Stream::add(const Entries &entries)
{
    const std::size_t end = std::size_t{entries.first} + entries.entries.size();
    Part *const to = end > segment_entries_ ? nullptr : part(entries.segment);
    if (to == nullptr) {
        return;
    }
    to->entries.resize(std::max(to->entries.size(), end));
    std::copy(entries.entries.begin(), entries.entries.end(), to->entries.begin() + entries.first);
    if (!to->total && end == segment_entries_) {
        to->total = segment_entries_; // it has no room for more, whoever says so
    }
    fit(*to);
}

bool Stream::is_whole(const Part &part) const
{
    return part.total && std::all_of(part.entries.begin(), part.entries.end(),
                                     [](const auto &entry) { return entry.has_value(); });
}

// Of a segment whose end was not announced, behind what came of it, once a newer one has begun.
std::optional<Missing> Stream::missing_of(Place place, const Part &part) const
{
    const uint32_t segment = number_at(place);
    const auto hole = std::find(part.entries.begin(), part.entries.end(), std::nullopt);
    const auto first = static_cast<uint16_t>(hole - part.entries.begin());
    if (hole != part.entries.end()) {
        const auto until =
            std::find_if(hole, hole + std::min<std::ptrdiff_t>(PIECE, part.entries.end() - hole),
                         [](const auto &entry) { return entry.has_value(); });
        return Missing{segment, first, static_cast<uint8_t>(until - hole)};
    }
    const bool open = !part.total && place != newest_ && first < segment_entries_;
    const auto room = static_cast<uint16_t>(segment_entries_ - first);
    return open ? std::optional<Missing>(
                      {segment, first, static_cast<uint8_t>(std::min(PIECE, room))})
                : std::nullopt;
}

std::optional<Missing> Stream::missing() const
{
    for (const auto &[place, part] : parts_) {
        if (const std::optional<Missing> found = missing_of(place, part)) {
            return found;
        }
    }
    return std::nullopt;
}

void Stream::ends_before(const Missing &missing)
{
    Part *const at = part(missing.segment);
    if (at != nullptr && !is_overwritten(missing.segment) && !at->total &&
        missing.first == at->entries.size()) {
        at->total = missing.first;
    }
}

std::optional<Stretch> Stream::take(uint32_t first)
{
    Stretch stretch{};
    const Place begins = place_of(first);
    auto at = parts_.find(begins);
    if (at == parts_.end()) {
        return std::nullopt;
    }
    const std::optional<SegmentInfo> begin = at->second.info;
    if (!begin) {
        return std::nullopt;
    }
    stretch.begin = *begin;
    for (Place place = begins; at != parts_.end() && at->first == place; ++at, place++) {
        const std::optional<SegmentInfo> info = at->second.info;
        if (place != begins && info) {
            stretch.end = *info;
            forget_to(place);
            return stretch;
        }
        if (!is_whole(at->second)) {
            return std::nullopt;
        }
        for (const auto &entry : at->second.entries) {
            if (entry) {
                stretch.entries.push_back(*entry);
            }
        }
    }
    return std::nullopt;
}

std::optional<SegmentInfo> Stream::newest_after(uint32_t than) const
{
    const Place after = than == 0 ? 0 : place_of(than);
    for (auto at = parts_.rbegin(); at != parts_.rend() && at->first > after; ++at) {
        if (at->second.info) {
            return at->second.info;
        }
    }
    return std::nullopt;
}

// The newest of its RECORDER_SEGMENTS overwrites the oldest.
bool Stream::is_overwritten(uint32_t segment) const
{
    return place_of(segment) + RECORDER_SEGMENTS <= newest_;
}

bool Stream::has_lost(uint32_t segment) const
{
    return has_lost_at(place_of(segment));
}

bool Stream::has_lost_at(Place place) const
{
    const auto at = parts_.find(place);
    return place + RECORDER_SEGMENTS <= newest_ && (at == parts_.end() || !is_whole(at->second));
}

double Stream::share(uint32_t segment) const
{
    const auto at = parts_.find(place_of(segment));
    if (at == parts_.end()) {
        return 0;
    }
    const auto come = std::count_if(at->second.entries.begin(), at->second.entries.end(),
                                    [](const auto &entry) { return entry.has_value(); });
    return is_whole(at->second) ? 1 : static_cast<double>(come) / segment_entries_;
}

bool Stream::is_lost(uint32_t first) const
{
    for (Place place = place_of(first); place + RECORDER_SEGMENTS <= newest_; place++) {
        if (has_lost_at(place)) {
            return true;
        }
    }
    return false;
}

void Stream::forget_before(uint32_t segment)
{
    forget_to(place_of(segment));
}

void Stream::forget_up_to(uint32_t segment)
{
    forget_to(place_of(segment) + 1);
}

void Stream::forget_to(Place place)
{
    oldest_ = std::max(oldest_, place);
    parts_.erase(parts_.begin(), parts_.lower_bound(place));
}

} // namespace nf::live
