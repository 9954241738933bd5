// SPDX-License-Identifier: MIT
// What a message repeats of what it was given.
#include "readable.h"

extern "C" {
#include "testing.h"
}

#include <string>

namespace
{

void expect_shown(const std::string &expected, const std::string &text)
{
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), nf::readable(text).c_str());
}

TEST(what_is_short_text_is_shown_as_it_is)
{
    expect_shown("", "");
    expect_shown("N·m °€ 𝄞 \\n", "N·m °€ 𝄞 \\n");
    expect_shown(std::string(nf::READABLE, 'a'), std::string(nf::READABLE, 'a'));
}

TEST(what_is_long_is_cut_between_two_characters)
{
    expect_shown(std::string(nf::READABLE, 'a') + "…", std::string(nf::READABLE + 1, 'a'));
    TEST_ASSERT_EQUAL_STRING("€€…", nf::readable("€€€", 2).c_str());
}

TEST(a_control_character_is_shown_by_its_number)
{
    expect_shown("a\\n\\r\\tb\\x1b[31m\\x7f\\x00\\u0085",
                 std::string("a\n\r\tb\x1B[31m\x7F\0\xC2\x85", 14));
}

TEST(a_byte_that_is_not_utf_8_is_shown_and_named)
{
    const char *const WRONG[] = {"\xFF",         "\x80",
                                 "\xC0\x80",     "\xE2\x82",
                                 "\xED\xA0\x80", "\xF4\x90\x80\x80",
                                 "\xE0\x9F\xBF", "\xF0\x8F\xBF\xBF",
                                 "\xC3"};
    for (const char *const wrong : WRONG) {
        const std::string problem = nf::utf8_problem(std::string("ab") + wrong);
        TEST_ASSERT_TRUE_MESSAGE(problem.find("byte 3 is \\x") != std::string::npos,
                                 problem.c_str());
        TEST_ASSERT_EQUAL_STRING("", nf::utf8_problem(nf::readable(wrong)).c_str());
    }
    TEST_ASSERT_EQUAL_STRING("", nf::utf8_problem("N·m €𝄞 \xF4\x8F\xBF\xBF\xEF\xBF\xBF").c_str());
    TEST_ASSERT_EQUAL_STRING("\"a\\xff\" is not UTF-8: byte 2 is \\xff; allowed: UTF-8 text",
                             nf::utf8_problem("a\xFF").c_str());
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
