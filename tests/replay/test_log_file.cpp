// SPDX-License-Identifier: MIT
// What terminal programs write: marks, UTF-16 and ends of lines do not reach who reads a log.
#include "log_file.h"

#include <string>
#include <vector>

#include "testing.h"
#include "whole_input.h"

namespace
{

using namespace std::string_literals;

// In UTF-16, the low byte of a character first or the high one.
std::string wide(const std::string &text, bool low_first)
{
    std::string bytes;
    for (const char c : text) {
        bytes += low_first ? std::string{c, '\0'} : std::string{'\0', c};
    }
    return bytes;
}

void expect_lines(const std::vector<std::string> &expected, const std::string &bytes)
{
    const std::vector<std::string> found = nf::log_lines(bytes);
    TEST_ASSERT_EQUAL_size_t(expected.size(), found.size());
    for (std::size_t k = 0; k < expected.size(); k++) {
        TEST_ASSERT_EQUAL_STRING(expected[k].c_str(), found[k].c_str());
    }
}

TEST(a_line_ends_with_any_of_the_usual_ends)
{
    for (const char *const end : {"\n", "\r", "\r\n", "\r\r\n"}) {
        expect_lines({"one", "two", "", "three"}, "one"s + end + "two" + end + end + "three" + end);
        expect_lines({"one", "two"}, "one"s + end + "two");
    }
    expect_lines({}, "");
    expect_lines({"", "", "x"}, "\n\nx");
}

TEST(blanks_behind_a_line_are_none_of_it)
{
    expect_lines({" one", "two"}, " one \t \ntwo ");
}

TEST(a_byte_order_mark_is_no_text)
{
    expect_lines({"one", "two"}, "\xEF\xBB\xBFone\r\ntwo\r\n");
}

TEST(utf_16_of_either_order_is_read_with_and_without_its_mark)
{
    const std::string text = "= one 1\r\ntwo\r\n";
    const std::vector<std::string> expected = {"= one 1", "two"};
    expect_lines(expected, "\xFF\xFE" + wide(text, true));
    expect_lines(expected, "\xFE\xFF" + wide(text, false));
    expect_lines(expected, wide(text, true));
    expect_lines(expected, wide(text, false));
    expect_lines(expected, "\xFF\xFE" + wide(text, true) + "x"); // half a character at the end
}

TEST(a_character_beyond_ascii_is_one_in_utf_16_and_its_bytes_otherwise)
{
    expect_lines({"2?A"}, "\xFF\xFE"
                          "2\0\xB5\0A\0"s);
    expect_lines({"2?A"}, "\xFF\xFE"
                          "2\0\x0A\x01"
                          "A\0"s); // U+010A is no end of a line
    expect_lines({"2\xC2\xB5"}, "2\xC2\xB5");
}

TEST(zeros_alone_are_no_utf_16)
{
    TEST_ASSERT_EQUAL_size_t(100, nf::plain_text(std::string(100, '\0')).size());
    TEST_ASSERT_EQUAL_size_t(3, nf::plain_text("a\0b"s).size());
}

TEST(a_file_that_cannot_be_read_is_named)
{
    try {
        nf::read_log("no/such/file.log", "");
        TEST_FAIL_MESSAGE("it was read");
    } catch (const nf::InputError &error) {
        TEST_ASSERT_EQUAL_STRING("no/such/file.log: cannot read: No such file or directory",
                                 error.what());
    }
}

} // namespace
