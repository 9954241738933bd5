// SPDX-License-Identifier: MIT
#include "suggest.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace nf
{
namespace
{

constexpr std::size_t NAME_MAX_LENGTH = 100; // a longer text is no misspelling
constexpr std::size_t SECTION_MAX = 3;       // a quite different table counts no more than this
constexpr std::size_t NO_MATCH = std::numeric_limits<std::size_t>::max();

// Levenshtein distance.
std::size_t distance(const std::string &a, const std::string &b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); i++) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); j++) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
        }
    }
    return row.back();
}

bool starts_with(const std::string &text, const std::string &start)
{
    return text.compare(0, start.size(), start) == 0;
}

// How far a key is from a known one; a missing or different unit at its end counts little.
std::size_t key_distance(const std::string &wrong, const std::string &known)
{
    constexpr std::size_t stem = 4;
    if (wrong.size() >= stem && (starts_with(known, wrong) || starts_with(wrong, known))) {
        return wrong == known ? 0 : 1;
    }
    // Without what the known one has beyond it, which may be a unit; then with all of it.
    const std::size_t shortened = distance(wrong, known.substr(0, wrong.size()));
    if (wrong.size() >= stem && shortened <= wrong.size() / 3) {
        return shortened + (known.size() > wrong.size() ? 1 : 0);
    }
    const std::size_t found = distance(wrong, known);
    return found <= std::max<std::size_t>(1, known.size() / 3) ? found : NO_MATCH;
}

std::string before_dot(const std::string &name)
{
    const std::size_t dot = name.rfind('.');
    return dot == std::string::npos ? "" : name.substr(0, dot);
}

std::string after_dot(const std::string &name)
{
    return name.substr(name.rfind('.') + 1);
}

// Distances with the places in `known`; of two that are equally far the earlier comes first.
using Found = std::vector<std::pair<std::size_t, std::size_t>>;

std::vector<std::string> names_of_nearest(Found found, const std::vector<std::string> &known,
                                          std::size_t count)
{
    std::sort(found.begin(), found.end());
    found.resize(std::min(found.size(), count));
    std::vector<std::string> names;
    names.reserve(found.size());
    for (const auto &[far, index] : found) {
        names.push_back(known[index]);
    }
    return names;
}

} // namespace

std::vector<std::string> nearest(const std::string &wrong, const std::vector<std::string> &known,
                                 std::size_t count)
{
    Found found;
    for (std::size_t k = 0; k < known.size() && wrong.size() <= NAME_MAX_LENGTH; k++) {
        const std::size_t key = key_distance(after_dot(wrong), after_dot(known[k]));
        if (key != NO_MATCH) {
            const std::size_t section = distance(before_dot(wrong), before_dot(known[k]));
            found.emplace_back(key + std::min(section, SECTION_MAX), k);
        }
    }
    return names_of_nearest(std::move(found), known, count);
}

std::vector<std::string> nearest_at_all(const std::string &wrong,
                                        const std::vector<std::string> &known, std::size_t count)
{
    std::vector<std::string> names = nearest(wrong, known, count);
    if (!names.empty() || wrong.empty() || wrong.size() > NAME_MAX_LENGTH) {
        return names;
    }
    Found found;
    for (std::size_t k = 0; k < known.size(); k++) {
        const bool part = known[k].find(wrong) != std::string::npos;
        const std::size_t far =
            std::min(distance(wrong, known[k]), distance(after_dot(wrong), after_dot(known[k])));
        found.emplace_back(part ? 0 : far, k);
    }
    return names_of_nearest(std::move(found), known, count);
}

std::string nearest(const std::string &wrong, const std::vector<std::string> &known)
{
    const std::vector<std::string> best = nearest(wrong, known, 1);
    return best.empty() ? "" : best.front();
}

} // namespace nf
