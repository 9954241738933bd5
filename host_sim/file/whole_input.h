/* SPDX-License-Identifier: MIT */
// What the programs read: never a folder, and never more than there is memory for.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace nf
{

// what() is the complete line for the user: PATH: what is wrong.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// A descriptor that the caller closes. Throws InputError; a folder is no file.
int open_input(const std::filesystem::path &path);
// Throws InputError where standard input is a folder.
void check_standard_input();

// All bytes of a file or a pipe. Throws InputError where it cannot be read, and where it goes on
// behind `most` bytes. `instead` says what the user can do then.
std::string read_whole(const std::filesystem::path &path, std::size_t most,
                       const std::string &instead);

// Bytes put together to lines, as a script has them: without LF and CR. It holds one line at most.
class LineCollector
{
public:
    static constexpr std::size_t LINE_BYTES_MAX = std::size_t{1} << 20U;

    // `name` is the script's, for messages. A device that is no terminal has as many bytes as a
    // line at most: one that has more, as /dev/urandom, has no end.
    LineCollector(std::string name, int file);

    // Whether a line has become complete with this byte. Throws InputError where it is too long,
    // and for a device without an end.
    bool add(char c);
    bool has_begun() const
    {
        return !line_.empty();
    }
    // The line so far; the next byte begins another one.
    std::string take();

private:
    std::string name_;
    bool is_device_;
    std::string line_;
    std::size_t number_ = 1;
    std::size_t bytes_ = 0;
};

} // namespace nf
