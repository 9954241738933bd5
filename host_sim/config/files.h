/* SPDX-License-Identifier: MIT */
// Where the files are and what they hold.
#pragma once

#include "schema.h"

#include <filesystem>
#include <string>
#include <vector>

namespace nf
{

// The folder that holds motors/, boards/, tunings/, imperfections/ and scenarios/: NEUROFOC_DATA of
// the environment, else host_sim/ of the installed package that the program belongs to, else of the
// source tree. Throws ConfigError if NEUROFOC_DATA is no such folder.
std::filesystem::path data_folder();

// The names of the files of a kind in the data folder, sorted.
std::vector<std::string> list_names(FileKind kind);

// What may stand where a file of a kind is referred to: the names there are, or a path.
std::string allowed_references(FileKind kind);

// A reference to the path of its file. With a '/' or ending in ".toml" it is a path, relative to
// `base`; else a name in the data folder. `key` and `origin` say who asks; throws ConfigError with
// the names there are.
std::filesystem::path resolve(FileKind kind, const std::string &reference,
                              const std::filesystem::path &base, const std::string &key,
                              const Origin &origin);

// The same where the names are those of the TOML files in `folder`.
std::filesystem::path resolve_in(const std::filesystem::path &folder, const std::string &reference,
                                 const std::filesystem::path &base, const std::string &key,
                                 const Origin &origin);

// Whether a reference is a path: with a '/' or ending in ".toml".
bool is_path(const std::string &reference);

// The bytes of a regular file of sensible size.
std::string read_bytes(const std::filesystem::path &path);

// A path as the user should see it: relative to the working folder when it is inside.
std::string display_name(const std::filesystem::path &path);

// Whether a file lies outside the data folder.
bool is_own(const std::filesystem::path &path);

// A path that says the same on every machine: relative to the data folder, else the bare name.
std::string provenance_name(const std::filesystem::path &path);

} // namespace nf
