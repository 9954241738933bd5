// SPDX-License-Identifier: MIT
#include "files.h"

#include "output_file.h"
#include "readable.h"
#include "suggest.h"
#include "whole_input.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

namespace fs = std::filesystem;

namespace nf
{
namespace
{

constexpr std::size_t BYTES_MAX = 1U << 20U;

fs::path folder_of(FileKind kind)
{
    return data_folder() / (std::string(kind_name(kind)) + "s");
}

// `path` relative to `folder`, or empty when it is not inside.
std::string inside(const fs::path &path, const fs::path &folder)
{
    const std::string relative =
        path.lexically_normal().lexically_relative(folder.lexically_normal()).string();
    return relative.compare(0, 2, "..") == 0 ? "" : relative;
}

fs::path made_absolute(const fs::path &path)
{
    std::error_code error;
    const fs::path result = fs::absolute(path, error);
    return error ? path : result;
}

std::vector<std::string> names_in(const fs::path &folder)
{
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() == ".toml") {
            names.push_back(at->path().stem().string());
        }
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::string references_to(const std::vector<std::string> &names)
{
    return fmt::format("{}{}a path ending in .toml", fmt::join(names, ", "),
                       names.empty() ? "" : " or ");
}

[[noreturn]] void not_found(const fs::path &folder, const std::string &reference,
                            const std::string &key, const Origin &origin)
{
    const std::vector<std::string> names = names_in(folder);
    const std::string near = nearest(reference, names);
    fail(origin, key, '"' + readable(reference) + '"',
         near.empty() ? "not found" : fmt::format("not found, did you mean {}?", near),
         references_to(names));
}

// The folder that the user has chosen has to hold all that can be referred to.
void check_chosen(const fs::path &folder)
{
    std::vector<std::string> lacking;
    for (const FileKind kind : {FileKind::motor, FileKind::board, FileKind::tuning,
                                FileKind::scenario, FileKind::imperfection}) {
        const std::string name = std::string(kind_name(kind)) + "s/";
        std::error_code ignored;
        if (!fs::is_directory(folder / name, ignored)) {
            lacking.push_back(name);
        }
    }
    if (!lacking.empty()) {
        fail({"environment", 0}, "NEUROFOC_DATA",
             '"' + readable(folder.string(), READABLE_PATH) + '"',
             is_there(folder) ? fmt::format("lacks {}", fmt::join(lacking, ", ")) : "not found",
             "a folder like host_sim/ of the project");
    }
}

// host_sim/ of the installed package that the running program belongs to, else of the source tree.
fs::path shipped_data_folder()
{
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    const fs::path installed = program.parent_path().parent_path() / "share/neurofoc/host_sim";
    return !error && is_there(installed) ? installed : fs::path(NF_DATA_FOLDER);
}

// `path` relative to the data folder, or empty when it is not inside.
std::string in_data_folder(const fs::path &path)
{
    return inside(made_absolute(path), made_absolute(data_folder()));
}

} // namespace

fs::path data_folder()
{
    const char *chosen = std::getenv("NEUROFOC_DATA");
    if (chosen == nullptr || *chosen == '\0') {
        static const fs::path shipped = shipped_data_folder();
        return shipped;
    }
    check_chosen(chosen);
    return chosen;
}

std::vector<std::string> list_names(FileKind kind)
{
    return names_in(folder_of(kind));
}

std::string allowed_references(FileKind kind)
{
    return references_to(list_names(kind));
}

bool is_path(const std::string &reference)
{
    const std::string end = ".toml";
    return reference.find('/') != std::string::npos ||
           (reference.size() > end.size() &&
            reference.compare(reference.size() - end.size(), end.size(), end) == 0);
}

fs::path resolve_in(const fs::path &folder, const std::string &reference, const fs::path &base,
                    const std::string &key, const Origin &origin)
{
    if (reference.empty() || reference.find('\0') != std::string::npos) {
        not_found(folder, reference, key, origin);
    }
    const fs::path path = is_path(reference) ? base / reference : folder / (reference + ".toml");
    if (!is_there(path)) {
        not_found(folder, reference, key, origin);
    }
    return path;
}

fs::path resolve(FileKind kind, const std::string &reference, const fs::path &base,
                 const std::string &key, const Origin &origin)
{
    return resolve_in(folder_of(kind), reference, base, key, origin);
}

std::string read_bytes(const fs::path &path)
{
    const Origin origin = {display_name(path), 0};
    std::error_code error;
    if (!fs::is_regular_file(path, error)) {
        fail(origin, "", "", "cannot be read", "a regular file");
    }
    if (fs::file_size(path, error) > BYTES_MAX || error) {
        fail(origin, "", "", "is too large", fmt::format("at most {} bytes", BYTES_MAX));
    }
    try {
        return read_whole(path, BYTES_MAX, "");
    } catch (const InputError &) {
        fail(origin, "", "", "cannot be read", "a file that you may read");
    }
}

std::string display_name(const fs::path &path)
{
    std::error_code error;
    const fs::path here = fs::current_path(error);
    const std::string relative = error ? "" : inside(made_absolute(path), here);
    return relative.empty() ? path.lexically_normal().string() : relative;
}

bool is_own(const fs::path &path)
{
    return in_data_folder(path).empty();
}

std::string provenance_name(const fs::path &path)
{
    const std::string relative = in_data_folder(path);
    return relative.empty() ? path.filename().string() : relative;
}

} // namespace nf
