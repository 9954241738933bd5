// SPDX-License-Identifier: MIT
// What comes over a file, and that it ends.
#include "receiver.h"

#include <array>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

extern "C" {
#include "testing.h"
}

namespace
{

using nf::live::Receiver;

constexpr double LONGEST_S = 5; // of a wait that is over long before
constexpr int SETTLE_MS = 100;  // the other thread has taken all by then

// Its reading end does not block, as a port's.
class Pipe
{
public:
    Pipe()
    {
        TEST_ASSERT_EQUAL(0, pipe2(ends_.data(), O_NONBLOCK | O_CLOEXEC));
    }
    ~Pipe()
    {
        hang_up();
        close(ends_[0]);
    }
    Pipe(const Pipe &) = delete;
    Pipe &operator=(const Pipe &) = delete;

    int file() const
    {
        return ends_[0];
    }
    void say(const std::vector<uint8_t> &bytes) const
    {
        TEST_ASSERT_EQUAL(bytes.size(), ::write(ends_[1], bytes.data(), bytes.size()));
    }
    void hang_up()
    {
        if (ends_[1] >= 0) {
            close(ends_[1]);
        }
        ends_[1] = -1;
    }

private:
    std::array<int, 2> ends_ = {-1, -1};
};

// As a cable that is pulled out.
TEST(an_end_that_hangs_up_is_said)
{
    Pipe pipe;
    Receiver receiver(pipe.file());
    TEST_ASSERT_EQUAL_STRING("", receiver.take(0).end.c_str());
    pipe.hang_up();
    TEST_ASSERT_EQUAL_STRING("the other end is gone", receiver.take(LONGEST_S).end.c_str());
}

TEST(what_came_before_the_end_is_given_before_it)
{
    const std::vector<uint8_t> last = {1, 2, 3};
    Pipe pipe;
    Receiver receiver(pipe.file());
    pipe.say(last);
    pipe.hang_up();
    poll(nullptr, 0, SETTLE_MS);
    const Receiver::Received received = receiver.take(LONGEST_S);
    TEST_ASSERT_TRUE(received.bytes == last);
    TEST_ASSERT_EQUAL_STRING("", received.end.c_str());
    const Receiver::Received behind = receiver.take(LONGEST_S);
    TEST_ASSERT_TRUE(behind.bytes.empty());
    TEST_ASSERT_EQUAL_STRING("the other end is gone", behind.end.c_str());
}

} // namespace
