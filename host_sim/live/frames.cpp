// SPDX-License-Identifier: MIT
#include "frames.h"

#include <optional>

extern "C" {
#include "cobs.h"
#include "crc32.h"
}

namespace nf::live
{
namespace
{

constexpr uint8_t MARK = 0;
constexpr std::size_t FRAME_BYTES_MAX = LINK_MESSAGE_BYTES_MAX + LINK_CRC_BYTES + 1;
constexpr std::size_t HEAD_BYTES = 2; // type and tag

uint32_t crc_of(const Bytes &bytes)
{
    uint32_t crc = CRC32_START;
    for (const uint8_t byte : bytes) {
        crc = crc32_byte(crc, byte);
    }
    return ~crc;
}

// Nothing where it is no code.
std::optional<Bytes> decoded(const Bytes &frame)
{
    cobs_decoder_t decoder{};
    cobs_start(&decoder);
    Bytes bytes;
    for (const uint8_t in : frame) {
        uint8_t out = 0;
        if (cobs_decode(&decoder, in, &out)) {
            bytes.push_back(out);
        }
    }
    return cobs_may_end(&decoder) ? std::optional<Bytes>(bytes) : std::nullopt;
}

std::optional<Message> message_of(const Bytes &frame)
{
    const std::optional<Bytes> bytes = decoded(frame);
    if (!bytes || bytes->size() < HEAD_BYTES + LINK_CRC_BYTES) {
        return std::nullopt;
    }
    const auto crc = bytes->end() - LINK_CRC_BYTES;
    const Bytes sent(bytes->begin(), crc);
    const Bytes sum(crc, bytes->end());
    if (BodyReader(sum).u32() != crc_of(sent)) {
        return std::nullopt;
    }
    return Message{sent[0], sent[1], Bytes(sent.begin() + HEAD_BYTES, sent.end())};
}

} // namespace

Bytes frame_of(const Message &message)
{
    Bytes bytes = {message.type, message.tag};
    bytes.insert(bytes.end(), message.body.begin(), message.body.end());
    const Bytes sum = BodyWriter().u32(crc_of(bytes)).body();
    bytes.insert(bytes.end(), sum.begin(), sum.end());
    Bytes frame = {MARK};
    const auto count = static_cast<uint32_t>(bytes.size());
    for (uint32_t at = 0; at <= count; at++) {
        frame.push_back(cobs_encoded(bytes.data(), count, at));
    }
    frame.push_back(MARK);
    return frame;
}

BodyWriter &BodyWriter::number(uint32_t value, unsigned bytes)
{
    for (unsigned k = 0; k < bytes; k++) {
        body_.push_back(static_cast<uint8_t>(value >> 8U * k & 0xFFU));
    }
    return *this;
}

BodyWriter &BodyWriter::text(const std::string &characters)
{
    body_.insert(body_.end(), characters.begin(), characters.end());
    return *this;
}

uint32_t BodyReader::number(unsigned bytes)
{
    uint32_t value = 0;
    good_ = good_ && at_ + bytes <= body_.size();
    for (unsigned k = 0; k < bytes && good_; k++) {
        value |= uint32_t{body_[at_ + k]} << 8U * k;
    }
    at_ += good_ ? bytes : 0;
    return value;
}

Bytes BodyReader::rest()
{
    const Bytes left(body_.begin() + static_cast<std::ptrdiff_t>(at_), body_.end());
    at_ = body_.size();
    return left;
}

std::vector<Message> FrameReader::add(const Bytes &bytes)
{
    std::vector<Message> found;
    for (const uint8_t byte : bytes) {
        if (byte == MARK) {
            end_frame(found);
        } else if (frame_.size() < FRAME_BYTES_MAX) {
            frame_.push_back(byte);
        } else {
            too_long_ = true;
        }
    }
    return found;
}

void FrameReader::end_frame(std::vector<Message> &found)
{
    if (!frame_.empty()) {
        const std::optional<Message> message = too_long_ ? std::nullopt : message_of(frame_);
        if (message) {
            found.push_back(*message);
            whole_++;
        } else {
            broken_++;
        }
    }
    frame_.clear();
    too_long_ = false;
}

std::string text_of(const Bytes &bytes)
{
    return {bytes.begin(), bytes.end()};
}

} // namespace nf::live
