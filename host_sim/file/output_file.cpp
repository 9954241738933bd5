// SPDX-License-Identifier: MIT
#include "output_file.h"

#include "readable.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <unistd.h>

#include <fmt/format.h>

namespace fs = std::filesystem;

namespace nf
{

namespace
{

constexpr int LINKS_MAX = 40; // in a row; the system follows no more either

// Whether a path leads through /proc to a file that is open already, as /dev/stdout does: others
// write to it too.
bool is_open_already(fs::path path)
{
    std::error_code error;
    for (int k = 0; k < LINKS_MAX && fs::is_symlink(path, error); k++) {
        const fs::path folder = fs::canonical(fs::absolute(path, error).parent_path(), error);
        if (folder.string().rfind("/proc/", 0) == 0) {
            return true;
        }
        path = folder / fs::read_symlink(path, error);
    }
    return false;
}

// A device or pipe, or a file that is open already, is not exchanged.
bool is_written_in_place(const fs::path &path, const fs::file_status &there)
{
    return (fs::exists(there) && !fs::is_regular_file(there)) || is_open_already(path);
}

} // namespace

bool is_there(const std::filesystem::path &path)
{
    std::error_code ignored;
    return fs::exists(path, ignored);
}

OutputFile::OutputFile(const std::string &path) : path_(path), target_(path)
{
    std::error_code ignored;
    const fs::file_status there = fs::status(target_, ignored);
    if (fs::is_regular_file(there)) {
        target_ = fs::canonical(target_, ignored);
        if (access(target_.c_str(), W_OK) != 0) {
            fail(errno);
        }
    }
    if (!is_written_in_place(path, there)) {
        beside_ = fmt::format("{}.{}.part", target_.string(), getpid());
    }
    if (!beside_.empty()) {
        unfinished_.emplace(beside_);
    }
    file_.reset(unfinished_ ? unfinished_->file() : std::fopen(target_.c_str(), "wb"));
    if (!file_) {
        const int error = errno;
        beside_.clear(); // it is none of this
        fail(error);
    }
    if (fs::is_regular_file(there) && !beside_.empty()) {
        fs::permissions(beside_, there.permissions(), ignored);
    }
}

OutputFile::~OutputFile()
{
    if (!beside_.empty()) {
        std::error_code ignored;
        fs::remove(beside_, ignored);
    }
}

void OutputFile::write(std::string_view bytes)
{
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
        fail(errno);
    }
}

void OutputFile::close()
{
    if (std::fclose(file_.release()) != 0) {
        fail(errno);
    }
    if (!beside_.empty()) {
        std::error_code error;
        fs::rename(beside_, target_, error);
        if (error) {
            fail(error.value());
        }
        beside_.clear();
    }
}

void OutputFile::fail(int error) const
{
    throw OutputError(
        fmt::format("{}: cannot write: {}", readable(path_, READABLE_PATH), std::strerror(error)));
}

} // namespace nf
