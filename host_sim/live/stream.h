/* SPDX-License-Identifier: MIT */
// The segments of the board's ring, put together of what the line brings.
//
// A segment counts as a whole or not at all: only the hash behind it says whether it is right. A
// stretch is a segment whose begin was announced, and those behind it whose announcements the line
// has lost, up to the next announced one.
//
// The board's numbers count from 1 on and begin again behind the largest one, as 0 is none. So each
// has a place here, which counts on: of all places with this number, the one nearest to the newest
// segment.
#pragma once

#include "client.h"

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace nf::live
{

// Whole segments, one behind the other, and what the board says of the state behind the last entry.
struct Stretch {
    SegmentInfo begin;
    SegmentInfo end; // of the segment behind it
    std::vector<recorder_entry_t> entries;
};

// Entries that have not come.
struct Missing {
    uint32_t segment;
    uint16_t first;
    uint8_t count;
};

class Stream
{
public:
    static constexpr uint16_t PIECE =
        16; // entries that are asked for at once: short enough for a bad line

    explicit Stream(uint16_t segment_entries) : segment_entries_(segment_entries)
    {
    }

    void add(const SegmentInfo &info);
    void add(const Entries &entries);

    // What to ask for next, of the oldest segment first; nothing while all that was sent has come.
    std::optional<Missing> missing() const;
    // Nothing came for a question that was answered: there is no entry from here on in a segment
    // that is complete.
    void ends_before(const Missing &missing);

    // The next whole stretch from the segment `first` on, which was announced; it is forgotten here
    // with all before it.
    std::optional<Stretch> take(uint32_t first);

    // The newest announced segment, if it is newer than `than`; 0: than none.
    std::optional<SegmentInfo> newest_after(uint32_t than) const;
    // What the ring has no more of is not waited for: whether some of a segment, or of one from
    // `first` on, will not come.
    bool has_lost(uint32_t segment) const;
    bool is_lost(uint32_t first) const;
    // How much of a segment has come, 0…1; 1: all of it.
    double share(uint32_t segment) const;
    // Forgets all before a segment; or all up to it, itself too.
    void forget_before(uint32_t segment);
    void forget_up_to(uint32_t segment);

    // Whether the ring has no such segment any more, by the newest one that was heard of.
    bool is_overwritten(uint32_t segment) const;

private:
    struct Part {
        std::optional<SegmentInfo> info;
        std::vector<std::optional<recorder_entry_t>> entries; // as far as they were sent
        std::optional<std::size_t> total;
    };
    using Place = uint64_t;
    Place place_of(uint32_t segment) const;
    Part *part(uint32_t segment);
    bool is_whole(const Part &part) const;
    std::optional<Missing> missing_of(Place place, const Part &part) const;
    bool has_lost_at(Place place) const;
    void forget_to(Place place);
    void fit(Part &part);

    uint16_t segment_entries_;
    Place oldest_ = 0; // what is before it is forgotten
    Place newest_ = 0; // 0: none was heard of
    std::map<Place, Part> parts_;
};

} // namespace nf::live
