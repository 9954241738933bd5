/* SPDX-License-Identifier: MIT */
// TOML text to a plain tree in which every value knows its line.
#pragma once

#include "origin.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace nf
{

struct Node {
    enum class Kind {
        table,
        list,
        boolean,
        integer,
        real,
        text,
        time
    };
    Kind kind = Kind::table;
    bool boolean = false;
    std::int64_t integer = 0;
    double real = 0;
    std::string text;
    std::vector<std::pair<std::string, Node>> members; // of a table, in the order of the file
    std::vector<Node> items;                           // of a list
    Origin origin;

    bool is_number() const;
    double number() const; // of an integer or real
    // Of a number without a fraction, written with a point or without; nothing of any other.
    std::optional<int64_t> whole() const;
};

// A document as a table. `name` is the file's name for messages. Any bytes are allowed; throws
// ConfigError for what is not TOML.
Node parse_document(const std::string &name, const std::string &text);

// The value of an override: TOML, or a bare word as text. `key` is for the message.
Node parse_override(const std::string &key, const std::string &value);

// The value as in the file, shortened to fit a message.
std::string shown(const Node &node);

// A text as a TOML string, in quotes. It has no control character.
std::string toml_string(const std::string &text);

// "a string", "a table", …
const char *kind_name(const Node &node);

} // namespace nf
