/* SPDX-License-Identifier: MIT */
// Messages of the link (firmware/app/link_messages.h) as bytes on a line, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

extern "C" {
#include "link_messages.h"
}

namespace nf::live
{

using Bytes = std::vector<uint8_t>;

struct Message {
    uint8_t type;
    uint8_t tag;
    Bytes body;
};

// With a 0 in front and behind: what a line has lost or added before does not spoil it.
Bytes frame_of(const Message &message);

// Numbers into a body, the lowest byte first.
class BodyWriter
{
public:
    BodyWriter &u8(uint32_t value)
    {
        return number(value, 1);
    }
    BodyWriter &u16(uint32_t value)
    {
        return number(value, 2);
    }
    BodyWriter &u32(uint32_t value)
    {
        return number(value, 4);
    }
    BodyWriter &text(const std::string &characters);
    Bytes body() const
    {
        return body_;
    }

private:
    BodyWriter &number(uint32_t value, unsigned bytes);

    Bytes body_;
};

// And out of it. What is not there any more reads as 0, and is_good() is false from then on.
class BodyReader
{
public:
    explicit BodyReader(const Bytes &body) : body_(body)
    {
    }
    uint8_t u8()
    {
        return static_cast<uint8_t>(number(1));
    }
    uint16_t u16()
    {
        return static_cast<uint16_t>(number(2));
    }
    uint32_t u32()
    {
        return number(4);
    }
    // All that is left.
    Bytes rest();
    bool is_good() const
    {
        return good_;
    }
    // Everything was read, and was there.
    bool is_done() const
    {
        return good_ && at_ == body_.size();
    }

private:
    uint32_t number(unsigned bytes);

    const Bytes &body_;
    std::size_t at_ = 0;
    bool good_ = true;
};

// Finds the messages in what comes in.
class FrameReader
{
public:
    // Those that are whole with these bytes. Whatever has a wrong CRC, or a length that no message
    // has, is left out.
    std::vector<Message> add(const Bytes &bytes);

    uint64_t whole() const
    {
        return whole_;
    }
    uint64_t broken() const
    {
        return broken_;
    }

private:
    void end_frame(std::vector<Message> &found);

    Bytes frame_; // since the last 0
    bool too_long_ = false;
    uint64_t whole_ = 0;
    uint64_t broken_ = 0;
};

std::string text_of(const Bytes &bytes);

} // namespace nf::live
