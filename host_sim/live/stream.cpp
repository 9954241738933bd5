// SPDX-License-Identifier: MIT
#include "stream.h"

#include <algorithm>

namespace nf::live
{

// Numbers count from 1 on. That they wrap after some years is not provided for.
Stream::Part *Stream::part(uint32_t segment)
{
    if (segment < oldest_) {
        return nullptr;
    }
    // Of those between two nothing may have come at all; of those that the ring has lost nothing will.
    const uint32_t in_ring = segment >= RECORDER_SEGMENTS ? segment - RECORDER_SEGMENTS : 0;
    const uint32_t known = newest_ == 0 ? segment : std::max(newest_ + 1, in_ring);
    for (uint32_t number = known; number < segment; number++) {
        (void)parts_[number];
    }
    newest_ = std::max(newest_, segment);
    return &parts_[segment];
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
    const auto before = parts_.find(info.number - 1);
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
    fit(*to);
}

bool Stream::is_whole(const Part &part) const
{
    return part.total && std::all_of(part.entries.begin(), part.entries.end(),
                                     [](const auto &entry) { return entry.has_value(); });
}

// Of a segment whose end was not announced, behind what came of it, once a newer one has begun.
std::optional<Missing> Stream::missing_of(uint32_t segment, const Part &part) const
{
    const auto hole = std::find(part.entries.begin(), part.entries.end(), std::nullopt);
    const auto first = static_cast<uint16_t>(hole - part.entries.begin());
    if (hole != part.entries.end()) {
        const auto until =
            std::find_if(hole, hole + std::min<std::ptrdiff_t>(PIECE, part.entries.end() - hole),
                         [](const auto &entry) { return entry.has_value(); });
        return Missing{segment, first, static_cast<uint8_t>(until - hole)};
    }
    const bool open = !part.total && segment != newest_ && first < segment_entries_;
    const auto room = static_cast<uint16_t>(segment_entries_ - first);
    return open ? std::optional<Missing>(
                      {segment, first, static_cast<uint8_t>(std::min(PIECE, room))})
                : std::nullopt;
}

std::optional<Missing> Stream::missing() const
{
    for (const auto &[segment, part] : parts_) {
        if (const std::optional<Missing> found = missing_of(segment, part)) {
            return found;
        }
    }
    return std::nullopt;
}

void Stream::ends_before(const Missing &missing)
{
    Part *const at = part(missing.segment);
    const bool is_overwritten = missing.segment + RECORDER_SEGMENTS <= newest_;
    if (at != nullptr && !is_overwritten && !at->total && missing.first == at->entries.size()) {
        at->total = missing.first;
    }
}

std::optional<Stretch> Stream::take(uint32_t first)
{
    Stretch stretch{};
    auto at = parts_.find(first);
    if (at == parts_.end()) {
        return std::nullopt;
    }
    const std::optional<SegmentInfo> begin = at->second.info;
    if (!begin) {
        return std::nullopt;
    }
    stretch.begin = *begin;
    for (uint32_t number = first; at != parts_.end() && at->first == number; ++at, number++) {
        const std::optional<SegmentInfo> info = at->second.info;
        if (number != first && info) {
            stretch.end = *info;
            forget_before(number);
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
    for (auto at = parts_.rbegin(); at != parts_.rend() && at->first > than; ++at) {
        if (at->second.info) {
            return at->second.info;
        }
    }
    return std::nullopt;
}

// The newest of its RECORDER_SEGMENTS overwrites the oldest.
bool Stream::has_lost(uint32_t segment) const
{
    const auto at = parts_.find(segment);
    const bool is_overwritten = segment + RECORDER_SEGMENTS <= newest_;
    return is_overwritten && (at == parts_.end() || !is_whole(at->second));
}

double Stream::share(uint32_t segment) const
{
    const auto at = parts_.find(segment);
    if (at == parts_.end()) {
        return 0;
    }
    const auto come = std::count_if(at->second.entries.begin(), at->second.entries.end(),
                                    [](const auto &entry) { return entry.has_value(); });
    return is_whole(at->second) ? 1 : static_cast<double>(come) / segment_entries_;
}

bool Stream::is_lost(uint32_t first) const
{
    for (uint32_t number = first; number + RECORDER_SEGMENTS <= newest_; number++) {
        if (has_lost(number)) {
            return true;
        }
    }
    return false;
}

void Stream::forget_before(uint32_t segment)
{
    oldest_ = std::max(oldest_, segment);
    parts_.erase(parts_.begin(), parts_.lower_bound(segment));
}

} // namespace nf::live
