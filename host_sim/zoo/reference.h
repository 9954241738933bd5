/* SPDX-License-Identifier: MIT */
// How a motor of the zoo is named: `zoo:17`, `zoo:servo:17`, `zoo:17@3`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace nf::zoo
{

// Motor NUMBER of a class. The classes take turns: `zoo:17` is number 17 of class 17 modulo their
// count.
struct Reference {
    std::string kind; // of CLASSES
    uint32_t number = 0;
    uint32_t seed = 1; // other seeds are other zoos
    bool user = false; // a scenario: of a motor that differs from its file, as a user's does

    // `zoo:servo:17@1`: all that is drawn depends on it.
    std::string key() const;
    // As it can be written, with the variant.
    std::string name() const;
};

// Whether a text is meant as a reference to the zoo.
bool is_reference(const std::string &text);

// Empty for what is none.
std::optional<Reference> parse(const std::string &text);

// What a reference may look like, for messages.
std::string allowed();

} // namespace nf::zoo
