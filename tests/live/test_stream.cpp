// SPDX-License-Identifier: MIT
// The stream put together: a gapless list of entries, or what is missing of it.
#include "stream.h"

extern "C" {
#include "testing.h"
}

namespace
{

using nf::live::Entries;
using nf::live::Missing;
using nf::live::SegmentInfo;
using nf::live::Stream;
using nf::live::Stretch;

constexpr uint16_t ROOM = 64; // of a segment

recorder_entry_t entry(uint32_t segment, uint32_t at)
{
    return {{segment, at, 0, 0}};
}

Entries entries(uint32_t segment, uint16_t first, uint16_t count)
{
    Entries made{segment, first, {}};
    for (uint16_t k = 0; k < count; k++) {
        made.entries.push_back(entry(segment, first + k));
    }
    return made;
}

SegmentInfo begin(uint32_t number, uint16_t entries_before)
{
    return {number, number * 100, number, 0, entries_before, true};
}

void assert_missing(const std::optional<Missing> &missing, uint32_t segment, uint16_t first,
                    uint8_t count)
{
    TEST_ASSERT_TRUE(missing.has_value());
    TEST_ASSERT_EQUAL(segment, missing->segment);
    TEST_ASSERT_EQUAL(first, missing->first);
    TEST_ASSERT_EQUAL(count, missing->count);
}

TEST(a_segment_is_taken_once_it_is_whole_and_its_end_is_announced)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    TEST_ASSERT_FALSE(stream.take(7).has_value());
    stream.add(begin(8, 40));
    const std::optional<Stretch> stretch = stream.take(7);
    TEST_ASSERT_TRUE(stretch.has_value());
    TEST_ASSERT_EQUAL(40, stretch->entries.size());
    TEST_ASSERT_EQUAL(8, stretch->end.number);
    TEST_ASSERT_FALSE(stream.missing().has_value());
}

TEST(a_hole_is_asked_for_in_pieces_that_a_bad_line_lets_through)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 5));
    stream.add(entries(7, 30, 4));
    assert_missing(stream.missing(), 7, 5, Stream::PIECE);
    stream.add(entries(7, 5, Stream::PIECE));
    assert_missing(stream.missing(), 7, 21, 9);
}

TEST(entries_come_in_any_order_and_more_than_once)
{
    Stream stream(ROOM);
    stream.add(begin(8, 40));
    stream.add(entries(8, 20, 20));
    stream.add(begin(9, 40));
    stream.add(entries(8, 0, 30));
    stream.add(entries(8, 10, 10));
    const std::optional<Stretch> stretch = stream.take(8);
    TEST_ASSERT_TRUE(stretch.has_value());
    for (uint32_t k = 0; k < 40; k++) {
        TEST_ASSERT_EQUAL(k, stretch->entries[k].word[1]);
    }
}

TEST(a_lost_announcement_makes_one_stretch_of_two_segments)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    stream.add(entries(8, 0, 40));
    // That segment 7 has no more than these 40 nobody has said.
    assert_missing(stream.missing(), 7, 40, Stream::PIECE);
    stream.ends_before({7, 40, Stream::PIECE});
    stream.add(begin(9, 40));
    const std::optional<Stretch> stretch = stream.take(7);
    TEST_ASSERT_TRUE(stretch.has_value());
    TEST_ASSERT_EQUAL(80, stretch->entries.size());
    TEST_ASSERT_EQUAL(9, stretch->end.number);
}

TEST(a_segment_of_which_nothing_came_is_asked_for)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    stream.add(begin(9, 40));
    assert_missing(stream.missing(), 7, 40, Stream::PIECE);
    stream.ends_before({7, 40, Stream::PIECE});
    assert_missing(stream.missing(), 8, 0, Stream::PIECE);
}

TEST(what_has_come_of_a_segment_is_a_share_of_the_whole_segment)
{
    Stream stream(ROOM);
    TEST_ASSERT_EQUAL_DOUBLE(0, stream.share(7));
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 16));
    TEST_ASSERT_EQUAL_DOUBLE(16.0 / ROOM, stream.share(7));
    stream.add(entries(7, 32, 8));
    TEST_ASSERT_EQUAL_DOUBLE(24.0 / ROOM, stream.share(7));
}

TEST(what_the_ring_has_no_more_of_is_lost)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 1, 39));
    stream.add(begin(7 + RECORDER_SEGMENTS - 1, 40));
    TEST_ASSERT_FALSE(stream.is_lost(7));
    stream.add(begin(7 + RECORDER_SEGMENTS, 40));
    TEST_ASSERT_TRUE(stream.is_lost(7));
}

// Behind the largest number comes 1.
TEST(a_stretch_goes_on_where_the_numbers_begin_again)
{
    Stream stream(ROOM);
    stream.add(begin(UINT32_MAX, 0));
    stream.add(entries(UINT32_MAX, 0, 40));
    stream.add(entries(1, 0, 40));
    assert_missing(stream.missing(), UINT32_MAX, 40, Stream::PIECE);
    stream.add(begin(1, 40));
    stream.add(begin(2, 40));
    const std::optional<Stretch> stretch = stream.take(UINT32_MAX);
    TEST_ASSERT_TRUE(stretch.has_value());
    TEST_ASSERT_EQUAL(40, stretch->entries.size());
    TEST_ASSERT_EQUAL_UINT32(1, stretch->end.number);
    TEST_ASSERT_EQUAL_UINT32(2, stream.take(1)->end.number);
}

TEST(a_segment_of_before_the_numbers_began_again_is_asked_for_and_comes_late)
{
    Stream stream(ROOM);
    stream.add(begin(UINT32_MAX - 1, 0));
    stream.add(entries(UINT32_MAX - 1, 0, 40));
    stream.add(begin(1, 40));
    assert_missing(stream.missing(), UINT32_MAX - 1, 40, Stream::PIECE);
    stream.ends_before({UINT32_MAX - 1, 40, Stream::PIECE});
    assert_missing(stream.missing(), UINT32_MAX, 0, Stream::PIECE);
    stream.add(entries(UINT32_MAX, 0, 40));
    TEST_ASSERT_EQUAL(80, stream.take(UINT32_MAX - 1)->entries.size());
}

TEST(what_the_ring_has_no_more_of_is_lost_where_the_numbers_begin_again)
{
    Stream stream(ROOM);
    stream.add(begin(UINT32_MAX, 0));
    stream.add(begin(RECORDER_SEGMENTS - 1, 40));
    TEST_ASSERT_FALSE(stream.is_lost(UINT32_MAX));
    TEST_ASSERT_FALSE(stream.is_overwritten(UINT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(RECORDER_SEGMENTS - 1, stream.newest_after(UINT32_MAX)->number);
    stream.add(begin(RECORDER_SEGMENTS, 40));
    TEST_ASSERT_TRUE(stream.is_lost(UINT32_MAX));
    TEST_ASSERT_TRUE(stream.is_overwritten(UINT32_MAX));
    stream.forget_up_to(UINT32_MAX);
    TEST_ASSERT_FALSE(stream.is_lost(1));
}

TEST(a_number_far_below_the_newest_is_of_a_board_that_counts_anew)
{
    Stream stream(ROOM);
    stream.add(begin(1000, 0));
    TEST_ASSERT_TRUE(stream.is_overwritten(1));
    TEST_ASSERT_FALSE(stream.is_overwritten(1001));
}

TEST(what_is_forgotten_does_not_come_back)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(begin(8, 40));
    stream.forget_before(8);
    stream.add(entries(7, 3, 4));
    stream.add(begin(7, 0));
    TEST_ASSERT_FALSE(stream.missing().has_value());
    TEST_ASSERT_EQUAL(8, stream.newest_after(0)->number);
}

TEST(entries_beyond_the_end_of_a_segment_are_none)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, ROOM - 2, 3));
    TEST_ASSERT_FALSE(stream.missing().has_value());
    stream.add(entries(7, ROOM - 2, 2));
    assert_missing(stream.missing(), 7, 0, Stream::PIECE);
}

void assert_taken(Stream &stream, uint32_t segment, std::size_t count)
{
    const std::optional<Stretch> stretch = stream.take(segment);
    TEST_ASSERT_TRUE(stretch.has_value());
    TEST_ASSERT_EQUAL(count, stretch->entries.size());
}

// They were of a segment of this number before the board began anew.
TEST(entries_behind_the_announced_end_are_none_whichever_came_first)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 50));
    stream.add(begin(8, 40));
    assert_taken(stream, 7, 40);
    stream.add(begin(9, 30));
    stream.add(entries(8, 0, 50));
    assert_taken(stream, 8, 30);
}

TEST(a_segment_ends_with_its_room_whatever_is_announced)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, ROOM));
    stream.add(begin(8, ROOM + 5));
    assert_taken(stream, 7, ROOM);
}

TEST(a_segment_that_is_full_has_its_end_where_the_next_announcement_is_lost)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, ROOM));
    stream.add(entries(8, 0, 40));
    stream.add(begin(9, 40));
    TEST_ASSERT_FALSE(stream.missing().has_value());
    assert_taken(stream, 7, ROOM + 40);
}

TEST(an_end_that_the_board_does_not_know_is_asked_for)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    stream.add(begin(8, 0));
    assert_missing(stream.missing(), 7, 40, Stream::PIECE);
}

// Of a hole in the middle: behind it something has come.
TEST(an_answer_without_entries_ends_a_segment_behind_all_that_came_only)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 5));
    stream.add(entries(7, 30, 4));
    stream.add(begin(8, 0));
    stream.ends_before({7, 5, Stream::PIECE});
    stream.add(entries(7, 5, 25));
    assert_missing(stream.missing(), 7, 34, Stream::PIECE);
}

// The board has nothing of it any more, and no answer says where it ended.
TEST(an_answer_without_entries_does_not_end_a_segment_that_is_overwritten)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    stream.add(begin(7 + RECORDER_SEGMENTS, 0));
    stream.ends_before({7, 40, Stream::PIECE});
    TEST_ASSERT_TRUE(stream.is_lost(7));
}

TEST(behind_a_long_pause_only_what_the_ring_may_have_is_asked_for)
{
    constexpr uint32_t FAR = 1000;
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(begin(FAR, 0));
    stream.forget_before(8);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(FAR - RECORDER_SEGMENTS, stream.missing()->segment);
}

TEST(a_whole_segment_is_all_of_its_share_however_short_it_is)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    stream.add(entries(7, 0, 40));
    stream.add(begin(8, 40));
    TEST_ASSERT_EQUAL_DOUBLE(1, stream.share(7));
}

TEST(the_newest_segment_is_not_newer_than_itself)
{
    Stream stream(ROOM);
    stream.add(begin(7, 0));
    TEST_ASSERT_EQUAL(7, stream.newest_after(6)->number);
    TEST_ASSERT_FALSE(stream.newest_after(7).has_value());
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
