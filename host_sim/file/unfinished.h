/* SPDX-License-Identifier: MIT */
// Files that a signal must not leave behind: it may end the program while they are written.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>

namespace nf
{

// A new file that is open for writing. Until the end of this object, a signal that ends the program
// removes the file first. That is so of 16 of them at once; a program writes five at most.
class UnfinishedFile
{
public:
    // Opens a file that is not there yet. file() is null, and errno says why, where that fails.
    explicit UnfinishedFile(const std::filesystem::path &path);
    ~UnfinishedFile();
    UnfinishedFile(const UnfinishedFile &) = delete;
    UnfinishedFile &operator=(const UnfinishedFile &) = delete;

    // The caller closes it.
    std::FILE *file() const
    {
        return file_;
    }

private:
    std::FILE *file_;
    std::size_t place_;
};

} // namespace nf
