#include "text_guard.h"

#include "origin.h"

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr unsigned DOTS_MAX = 64; // in one line, outside strings and comments

// Follows strings and comments through a text, byte by byte.
class Scanner
{
public:
    Scanner(const std::string &name, const std::string &text) : m_name(name), m_text(text)
    {
        const std::string byte_order_mark = "\xEF\xBB\xBF";
        m_at = text.compare(0, 3, byte_order_mark) == 0 ? 3 : 0;
    }

    void run()
    {
        while (m_at < m_text.size()) {
            step(m_text[m_at]);
        }
    }

private:
    void step(char c)
    {
        if (c == '\n') {
            m_line++;
            m_dots = 0;
            m_at++;
        } else if (c == '#') {
            skip_comment();
        } else if (c == '"' || c == '\'') {
            skip_string(c);
        } else {
            check(c);
            m_at++;
        }
    }

    void check(char c)
    {
        if (static_cast<unsigned char>(c) >= 0x80) {
            refuse("a character outside ASCII that is in no string or comment");
        }
        m_dots += c == '.' ? 1U : 0U;
        if (m_dots > DOTS_MAX) {
            refuse(fmt::format("more than {} dots in a line", DOTS_MAX));
        }
    }

    [[noreturn]] void refuse(const std::string &why) const
    {
        fail({m_name, m_line}, "", "", "TOML syntax: " + why, "");
    }

    void skip_comment()
    {
        while (m_at < m_text.size() && m_text[m_at] != '\n') {
            m_at++;
        }
    }

    std::size_t run_of(char c) const
    {
        const std::size_t end = m_text.find_first_not_of(c, m_at);
        return (end == std::string::npos ? m_text.size() : end) - m_at;
    }

    void skip_string(char quote)
    {
        const std::size_t quotes = run_of(quote);
        if (quotes == 2) {
            m_at += 2; // empty
        } else if (quotes < 3) {
            m_at++;
            skip_line_string(quote);
        } else {
            m_at += 3;
            skip_block_string(quote);
        }
    }

    // Skips a byte of a string, and the one after a backslash.
    void skip_byte(char quote)
    {
        const bool escapes = quote == '"' && m_text[m_at] == '\\';
        if (escapes && m_at + 1 < m_text.size() && m_text[m_at + 1] != '\n') {
            m_at++;
        }
        m_at++;
    }

    void skip_line_string(char quote)
    {
        while (m_at < m_text.size() && m_text[m_at] != '\n') {
            if (m_text[m_at] == quote) {
                m_at++;
                return;
            }
            skip_byte(quote);
        }
    }

    // Three quotes end it; up to two more before them belong to it.
    void skip_block_string(char quote)
    {
        while (m_at < m_text.size()) {
            const std::size_t quotes = run_of(quote);
            if (quotes >= 3) {
                m_at += quotes < 5 ? quotes : 5;
                return;
            }
            m_line += m_text[m_at] == '\n' ? 1U : 0U;
            skip_byte(quote);
        }
    }

    const std::string &m_name;
    const std::string &m_text;
    std::size_t m_at = 0;
    unsigned m_line = 1;
    unsigned m_dots = 0;
};

} // namespace

void guard_text(const std::string &name, const std::string &text)
{
    Scanner(name, text).run();
}

} // namespace nf
