// SPDX-License-Identifier: MIT
#include "line_reader.h"

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

class Stream : public LineReader
{
public:
    Stream(std::FILE *from, std::FILE *echo) : from_(from), echo_(echo)
    {
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        std::string line;
        int c = std::fgetc(from_);
        if (c == EOF) {
            return std::nullopt;
        }
        for (; c != EOF && c != '\n'; c = std::fgetc(from_)) {
            line.push_back(static_cast<char>(c));
        }
        if (!line.empty() && line.back() == '\r') {
            line.pop_back();
        }
        fmt::print(echo_, "{}{}\n", prompt, line);
        return line;
    }

    bool is_unattended() const override
    {
        return true;
    }

private:
    std::FILE *from_;
    std::FILE *echo_;
};

} // namespace

std::unique_ptr<LineReader> stream_reader(std::FILE *from, std::FILE *echo)
{
    return std::make_unique<Stream>(from, echo);
}

} // namespace nf::debug
