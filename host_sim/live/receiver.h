/* SPDX-License-Identifier: MIT */
// Takes the bytes of a file in a thread of its own, as fast as they come: the system keeps some
// 4000 bytes of a serial port, which is 0.2 s of a board's stream, and whoever works on a command
// may look away for longer.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace nf::live
{

class Receiver
{
public:
    // Of an open file that does not block and outlives it.
    explicit Receiver(int file);
    ~Receiver();
    Receiver(const Receiver &) = delete;
    Receiver &operator=(const Receiver &) = delete;

    struct Received {
        std::vector<uint8_t> bytes;
        std::string end; // why there will be no more; empty while there may be
    };
    // What has come; waits for it for `wait_s` at most.
    Received take(double wait_s);

private:
    void receive();
    std::string wait_for_bytes() const;
    std::string read_on();

    int file_;
    int stop_; // becomes readable when the thread shall end
    std::mutex guard_;
    std::condition_variable came_;
    std::vector<uint8_t> bytes_;
    std::string end_;
    std::thread thread_;
};

} // namespace nf::live
