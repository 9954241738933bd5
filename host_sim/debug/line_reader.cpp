// SPDX-License-Identifier: MIT
#include "line_reader.h"

#include "readable.h"
#include "whole_input.h"

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

class Stream : public LineReader
{
public:
    Stream(std::FILE *from, std::FILE *echo, const std::string &name)
        : from_(from), echo_(echo), collector_(name, fileno(from))
    {
    }

    std::optional<std::string> next(const std::string &prompt) override
    {
        int c = std::fgetc(from_);
        while (c != EOF && !collector_.add(static_cast<char>(c))) {
            c = std::fgetc(from_);
        }
        if (c == EOF && !collector_.has_begun()) {
            return std::nullopt;
        }
        std::string line = collector_.take();
        fmt::print(echo_, "{}{}\n", prompt, readable(line, LINE_READABLE));
        return line;
    }

    bool is_unattended() const override
    {
        return true;
    }

private:
    std::FILE *from_;
    std::FILE *echo_;
    LineCollector collector_;
};

} // namespace

std::unique_ptr<LineReader> stream_reader(std::FILE *from, std::FILE *echo, const std::string &name)
{
    return std::make_unique<Stream>(from, echo, name);
}

} // namespace nf::debug
