/* SPDX-License-Identifier: MIT */
// A file of results: under its name it is there whole, or not at all.
#pragma once

#include "unfinished.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace nf
{

// what() is the complete line for the user: PATH: cannot write: the system's reason.
struct OutputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Whether something has this name. A name that no file can have is that of none.
bool is_there(const std::filesystem::path &path);

// Writes to a new file beside `path` and gives it that name in close(). Until then a file that was
// there under that name stays as it is. So it does without close(), after an exception or a signal
// that ends the program. What is no file, as a pipe or a device, is written to itself.
class OutputFile
{
public:
    static constexpr std::size_t WORTH_WRITING =
        1U << 18U; // bytes that a caller gathers before it calls write()

    explicit OutputFile(const std::string &path); // throws OutputError
    ~OutputFile();
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;

    void write(std::string_view bytes); // throws OutputError
    // Call after the last write; a disk that is full shows here at the latest. Throws OutputError.
    void close();

private:
    struct Closer {
        void operator()(std::FILE *file) const
        {
            std::fclose(file);
        }
    };
    [[noreturn]] void fail(int error) const;

    std::string path_;                         // as the user wrote it
    std::filesystem::path target_;             // behind all links
    std::filesystem::path beside_;             // empty: `target_` itself is written
    std::optional<UnfinishedFile> unfinished_; // of that name
    std::unique_ptr<std::FILE, Closer> file_;
};

} // namespace nf
