// SPDX-License-Identifier: MIT
// In place of libFuzzer: the files of each folder that is named, once.
#include "fuzzed.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

int main(int argc, char **argv)
{
    std::size_t files = 0;
    for (int k = 1; k < argc; k++) {
        for (const auto &entry : std::filesystem::directory_iterator(argv[k])) {
            std::ifstream file(entry.path(), std::ios::binary);
            const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
            std::printf("%s\n", entry.path().c_str());
            std::fflush(stdout); // it may be the last
            LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size());
            files++;
        }
    }
    return files > 0 ? 0 : 1;
}
