/* SPDX-License-Identifier: MIT */
// A board that answers as it is told, on a clock that only waiting moves.
#pragma once

#include "client.h"

#include <deque>
#include <functional>
#include <vector>

class FakeBoard : public nf::live::Channel
{
public:
    std::vector<uint8_t> read(double wait_s) override
    {
        if (to_pc.empty()) {
            now += wait_s;
            return {};
        }
        nf::live::Bytes bytes = to_pc.front();
        to_pc.pop_front();
        return bytes;
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        for (const nf::live::Message &question : reader.add(bytes)) {
            questions.push_back(question);
            if (answer) {
                answer(question);
            }
        }
    }
    double now_s() const override
    {
        return now;
    }
    void say(const nf::live::Message &message)
    {
        to_pc.push_back(frame_of(message));
    }

    std::function<void(const nf::live::Message &)> answer;
    std::vector<nf::live::Message> questions;
    std::deque<nf::live::Bytes> to_pc;
    nf::live::FrameReader reader;
    double now = 0;
};
