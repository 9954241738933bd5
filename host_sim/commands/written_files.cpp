// SPDX-License-Identifier: MIT
#include "written_files.h"

#include "ending.h"
#include "output_file.h"
#include "readable.h"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

namespace nf::commands
{
namespace
{

// Whether two names are of one file, which need not be there yet.
bool same_file(const std::filesystem::path &a, const std::filesystem::path &b)
{
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::equivalent(a, b, error)) {
        return true;
    }
    const fs::path one = fs::weakly_canonical(fs::absolute(a, error), error);
    return !error && one == fs::weakly_canonical(fs::absolute(b, error), error);
}

bool is_same(const NamedFile &a, const NamedFile &b)
{
    return !a.path.empty() && !b.path.empty() && same_file(a.path, b.path);
}

} // namespace

std::string not_a_file(const std::string &name)
{
    return name.empty() ? "needs the name of a file" : "";
}

std::string not_a_trace_file(const std::string &name)
{
    return name == "-" ? "standard output is for the results" : not_a_file(name);
}

void check_outputs(const Config &config, const NamedFiles &outputs, const NamedFiles &inputs)
{
    for (auto output = outputs.begin(); output != outputs.end(); ++output) {
        check_output(config, output->option, output->path);
        for (const NamedFile &input : inputs) {
            if (is_same(*output, input)) {
                throw FileError(fmt::format("{}: {} would replace what {} reads", output->path,
                                            output->option, input.option));
            }
        }
        for (auto before = outputs.begin(); before != output; ++before) {
            if (is_same(*before, *output)) {
                throw FileError(fmt::format("{}: {} and {} cannot go to the same file",
                                            before->path, before->option, output->option));
            }
        }
    }
}

void check_new(const std::string &output, bool overwrite)
{
    if (!overwrite && !output.empty() && is_there(output)) {
        throw FileError(fmt::format("{}: is there already; --overwrite replaces it",
                                    readable(output, READABLE_PATH)));
    }
}

void check_writable(const std::vector<std::string> &paths)
{
    for (const std::string &path : paths) {
        if (!path.empty() && path != "-") {
            OutputFile{path};
        }
    }
}

} // namespace nf::commands
