/* SPDX-License-Identifier: MIT */
// A place in the folder of temporary files that is this process's own: other builds may run the
// same test at the same time.
#pragma once

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

inline std::string own_path(const std::string &name)
{
    return (std::filesystem::temp_directory_path() / fmt::format("{}.{}", name, getpid())).string();
}
