/* SPDX-License-Identifier: MIT */
// Random numbers by name: each is a function of a key and of its own name alone. So one more number
// leaves the others as they were, and every motor can be drawn by itself, on any specimen.
#pragma once

#include <cstddef>
#include <string>

namespace nf::zoo
{

struct Range {
    double low;
    double high;
};

class Draw
{
public:
    explicit Draw(std::string key);

    double uniform(const char *name, Range range) const;
    // Each octave is as likely as the others. `low` is above 0.
    double log_uniform(const char *name, Range range) const;
    // Both ends included.
    int whole(const char *name, int low, int high) const;
    // 0 to count − 1.
    std::size_t below(const char *name, std::size_t count) const;

private:
    double share(const char *name) const; // 0 up to but not including 1

    std::string key_;
};

} // namespace nf::zoo
