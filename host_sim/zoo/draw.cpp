// SPDX-License-Identifier: MIT
#include "draw.h"

extern "C" {
#include "random.h"
}

#include <cmath>
#include <cstdint>

namespace nf::zoo
{
namespace
{

// FNV-1a: two texts that differ in a letter give different numbers. random.h spreads their bits.
uint64_t number_of(const std::string &text)
{
    constexpr uint64_t basis = 0xCBF29CE484222325U;
    constexpr uint64_t prime = 0x100000001B3U;
    uint64_t number = basis;
    for (const char letter : text) {
        number = (number ^ static_cast<unsigned char>(letter)) * prime;
    }
    return number;
}

} // namespace

Draw::Draw(std::string key) : key_(std::move(key))
{
}

double Draw::share(const char *name) const
{
    constexpr unsigned spare_bits = 64 - 53; // beyond what a double holds
    plant_random_t random;
    plant_random_init(&random, number_of(key_ + '/' + name));
    return std::ldexp(static_cast<double>(plant_random_bits(&random) >> spare_bits), -53);
}

double Draw::uniform(const char *name, Range range) const
{
    return range.low + (range.high - range.low) * share(name);
}

double Draw::log_uniform(const char *name, Range range) const
{
    return range.low * std::pow(range.high / range.low, share(name));
}

int Draw::whole(const char *name, int low, int high) const
{
    return low + static_cast<int>(share(name) * (high - low + 1));
}

std::size_t Draw::below(const char *name, std::size_t count) const
{
    return static_cast<std::size_t>(share(name) * static_cast<double>(count));
}

} // namespace nf::zoo
