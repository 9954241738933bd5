// SPDX-License-Identifier: MIT
#include "text_guard.h"

#include "origin.h"

#include <fmt/format.h>

#include <string_view>

namespace nf
{
namespace
{

constexpr unsigned DOTS_MAX = 64; // in one line, outside strings and comments

// Follows strings and comments through a text, byte by byte.
class Scanner
{
public:
    Scanner(const std::string &name, const std::string &text) : name_(name), text_(text)
    {
        const std::string byte_order_mark = "\xEF\xBB\xBF";
        at_ = text.compare(0, 3, byte_order_mark) == 0 ? 3 : 0;
    }

    void run()
    {
        while (at_ < text_.size()) {
            step(text_[at_]);
        }
    }

private:
    void step(char c)
    {
        if (c == '\n') {
            line_++;
            dots_ = 0;
            follow_number(c);
            at_++;
        } else if (c == '#') {
            skip_comment();
        } else if (c == '"' || c == '\'') {
            skip_string(c);
        } else {
            check(c);
            at_++;
        }
    }

    void check(char c)
    {
        check_ascii(c);
        follow_number(c);
        follow_dot(c);
        if (dots_ > DOTS_MAX) {
            refuse(fmt::format("more than {} dots in a line", DOTS_MAX));
        }
    }

    // The first dot of a number is no path of a key.
    void follow_dot(char c)
    {
        if (c == '.' && number_ && !has_point_) {
            has_point_ = true;
        } else {
            dots_ += c == '.' ? 1U : 0U;
        }
        has_point_ = has_point_ && number_;
    }

    void check_ascii(char c) const
    {
        if (static_cast<unsigned char>(c) >= 0x80) {
            refuse("a character outside ASCII that is in no string or comment");
        }
    }

    // The parser reads a number up to a blank, a comma or a closing bracket, also over quotes: what
    // looks like a string there is none.
    void follow_number(char c)
    {
        const bool ends_value = is_in(" \t\r\n,]}", c);
        const bool begins = may_begin_ && is_in("+-0123456789", c);
        number_ = !ends_value && (number_ || begins);
        may_begin_ = ends_value || is_in("=[{", c);
    }

    static bool is_in(std::string_view set, char c)
    {
        return set.find(c) != std::string_view::npos;
    }

    [[noreturn]] void refuse(const std::string &why) const
    {
        fail({name_, line_}, "", "", "TOML syntax: " + why, "");
    }

    void skip_comment()
    {
        while (at_ < text_.size() && text_[at_] != '\n') {
            at_++;
        }
    }

    std::size_t run_of(char c) const
    {
        const std::size_t end = text_.find_first_not_of(c, at_);
        return (end == std::string::npos ? text_.size() : end) - at_;
    }

    void skip_string(char quote)
    {
        const std::size_t quotes = run_of(quote);
        if (quotes == 2) {
            at_ += 2; // empty
        } else if (quotes < 3) {
            at_++;
            skip_line_string(quote);
        } else {
            at_ += 3;
            skip_block_string(quote);
        }
    }

    // Skips a byte of a string, and the one after a backslash.
    void skip_byte(char quote)
    {
        if (number_) {
            check_ascii(text_[at_]);
        }
        const bool escapes = quote == '"' && text_[at_] == '\\';
        if (escapes && at_ + 1 < text_.size() && text_[at_ + 1] != '\n') {
            at_++;
        }
        at_++;
    }

    void skip_line_string(char quote)
    {
        while (at_ < text_.size() && text_[at_] != '\n') {
            if (text_[at_] == quote) {
                at_++;
                return;
            }
            skip_byte(quote);
        }
    }

    // Three quotes end it; up to two more before them belong to it.
    void skip_block_string(char quote)
    {
        while (at_ < text_.size()) {
            const std::size_t quotes = run_of(quote);
            if (quotes >= 3) {
                at_ += quotes < 5 ? quotes : 5;
                return;
            }
            line_ += text_[at_] == '\n' ? 1U : 0U;
            skip_byte(quote);
        }
    }

    const std::string &name_;
    const std::string &text_;
    std::size_t at_ = 0;
    unsigned line_ = 1;
    unsigned dots_ = 0;
    bool number_ = false;    // this is part of one
    bool has_point_ = false; // that number has one
    bool may_begin_ = true;  // one, with the next character
};

// By its mark, or a first character of ASCII with a byte of 0 beside it.
bool is_utf16(std::string_view text)
{
    const std::string_view begin = text.substr(0, 2);
    return begin == "\xFF\xFE" || begin == "\xFE\xFF" || begin.find('\0') != std::string_view::npos;
}

} // namespace

void guard_text(const std::string &name, const std::string &text)
{
    if (is_utf16(text)) {
        fail({name, 1}, "", "", "is UTF-16 text", "UTF-8, which an editor's \"save as\" offers");
    }
    Scanner(name, text).run();
}

} // namespace nf
