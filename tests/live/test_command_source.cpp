// SPDX-License-Identifier: MIT
// Commands of a file or a pipe: whole lines, in their order, and nobody waits for them.
#include "command_source.h"

#include "own_path.h"

#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" {
#include "testing.h"
}

namespace
{

using nf::live::CommandSource;

TEST(the_last_line_of_a_file_needs_no_end)
{
    const std::string path = own_path("commands");
    std::ofstream(path) << "run\nstop";
    CommandSource source(path);
    TEST_ASSERT_EQUAL_STRING("run", source.next().value_or("none").c_str());
    TEST_ASSERT_FALSE(source.has_ended());
    TEST_ASSERT_EQUAL_STRING("stop", source.next().value_or("none").c_str());
    TEST_ASSERT_FALSE(source.next().has_value());
    TEST_ASSERT_TRUE(source.has_ended());
    std::filesystem::remove(path);
}

TEST(a_line_that_has_come_in_part_is_given_when_it_is_whole)
{
    const std::string path = own_path("pipe");
    TEST_ASSERT_EQUAL(0, mkfifo(path.c_str(), S_IRUSR | S_IWUSR));
    const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
    TEST_ASSERT_TRUE(file >= 0);
    {
        CommandSource source(path);
        TEST_ASSERT_FALSE(source.next().has_value());
        TEST_ASSERT_EQUAL(2, write(file, "st", 2));
        TEST_ASSERT_FALSE(source.next().has_value());
        TEST_ASSERT_EQUAL(3, write(file, "op\n", 3));
        TEST_ASSERT_EQUAL_STRING("stop", source.next().value_or("none").c_str());
        TEST_ASSERT_FALSE(source.has_ended());
    }
    close(file);
    std::filesystem::remove(path);
}

} // namespace
