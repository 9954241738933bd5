/* SPDX-License-Identifier: MIT */
// The input of a program, read from its beginning; zeros behind its end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace fuzz
{

class Bytes
{
public:
    Bytes(const uint8_t *data, std::size_t size) : at_(data), left_(size)
    {
    }

    bool empty() const
    {
        return left_ == 0;
    }

    uint8_t byte()
    {
        if (left_ == 0) {
            return 0;
        }
        left_--;
        return *at_++;
    }

    // Lowest byte first.
    uint16_t half()
    {
        const unsigned low = byte();
        return static_cast<uint16_t>(low | static_cast<unsigned>(byte()) << 8U);
    }

    uint32_t word()
    {
        const uint32_t low = half();
        return low | static_cast<uint32_t>(half()) << 16U;
    }

    std::string rest()
    {
        std::string text(reinterpret_cast<const char *>(at_), left_);
        at_ += left_;
        left_ = 0;
        return text;
    }

private:
    const uint8_t *at_;
    std::size_t left_;
};

} // namespace fuzz
