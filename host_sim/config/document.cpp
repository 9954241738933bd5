// SPDX-License-Identifier: MIT
#include "document.h"

#include "readable.h"
#include "text_guard.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include <fmt/format.h>

// The parser asserts, and in a release build assumes, what some broken texts violate; behind each
// of these places it reports the error properly, so neither is wanted. It recurses into nested
// values: their depth is bounded so that no text can exhaust the stack.
#undef NDEBUG
#define TOML_ASSERT(condition) static_cast<void>(0)
#define TOML_MAX_NESTED_VALUES 16
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace nf
{
namespace
{

constexpr int REPLACED_MAX = 16; // numbers too large in a text; each is a pass of the parser
constexpr std::size_t SYNTAX_READABLE = 200; // what the parser says repeats a key whole

Node convert(const toml::node &source, const std::string &file);

Origin origin_of(const toml::source_region &region, const std::string &file)
{
    return {file, region.begin.line};
}

void convert_table(const toml::table &table, const std::string &file, Node &node)
{
    using Place = std::tuple<unsigned, unsigned, const toml::key *, const toml::node *>;
    std::vector<Place> places;
    for (const auto &[key, value] : table) {
        const auto &begin = key.source().begin;
        places.emplace_back(begin.line, begin.column, &key, &value);
    }
    std::sort(places.begin(), places.end(), [](const Place &a, const Place &b) {
        return std::tie(std::get<0>(a), std::get<1>(a)) < std::tie(std::get<0>(b), std::get<1>(b));
    });
    for (const auto &[line, column, key, value] : places) {
        Node member = convert(*value, file);
        if (member.kind != Node::Kind::table && member.kind != Node::Kind::list) {
            member.origin.line = line;
        }
        node.members.emplace_back(std::string(key->str()), std::move(member));
    }
}

void convert_list(const toml::array &list, const std::string &file, Node &node)
{
    for (const auto &item : list) {
        node.items.push_back(convert(item, file));
    }
}

Node convert(const toml::node &source, const std::string &file)
{
    Node node;
    node.origin = origin_of(source.source(), file);
    if (const auto *table = source.as_table()) {
        convert_table(*table, file, node);
    } else if (const auto *list = source.as_array()) {
        node.kind = Node::Kind::list;
        convert_list(*list, file, node);
    } else if (const auto *boolean = source.as_boolean()) {
        node.kind = Node::Kind::boolean;
        node.boolean = boolean->get();
    } else if (const auto *integer = source.as_integer()) {
        node.kind = Node::Kind::integer;
        node.integer = integer->get();
    } else if (const auto *real = source.as_floating_point()) {
        node.kind = Node::Kind::real;
        node.real = real->get();
    } else if (const auto *text = source.as_string()) {
        node.kind = Node::Kind::text;
        node.text = text->get();
    } else {
        node.kind = Node::Kind::time;
    }
    return node;
}

std::string shown_list(const Node &node)
{
    std::string text = "[";
    for (const Node &item : node.items) {
        if (text.size() > READABLE) {
            break;
        }
        text += (text.size() > 1 ? ", " : "") + shown(item);
    }
    return text + "]";
}

// Of UTF-8: any byte of a character but its first.
bool is_inside_character(char c)
{
    return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

bool is_safe(const std::string &text)
{
    try {
        guard_text("", text);
    } catch (const ConfigError &) {
        return false; // a bare word of any language
    }
    return true;
}

bool is_part_of_number(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.' ||
           c == '_';
}

// The byte at a position, which counts characters.
std::size_t place_of(const std::string &text, const toml::source_position &position)
{
    std::size_t place = 0;
    for (unsigned line = 1; line < position.line; line++) {
        place = text.find('\n', place) + 1;
    }
    for (unsigned column = 1; column < position.column && place < text.size(); column++) {
        place++;
        while (place < text.size() && is_inside_character(text[place])) {
            place++;
        }
    }
    return place;
}

// Writes a number that is too large for a double, and at whose end the parser stopped, as infinity.
// False when there is none.
bool replace_too_large(std::string &text, const toml::source_position &stopped)
{
    const std::size_t end = place_of(text, stopped);
    std::size_t begin = end;
    while (begin > 0 && is_part_of_number(text[begin - 1])) {
        begin--;
    }
    std::string number = text.substr(begin, end - begin);
    number.erase(std::remove(number.begin(), number.end(), '_'), number.end());
    char *rest = nullptr;
    const bool too_large = std::isinf(std::strtod(number.c_str(), &rest)) && *rest == '\0' &&
                           number.find_first_of("0123456789") != std::string::npos;
    if (too_large) {
        text.replace(begin, end - begin, number[0] == '-' ? "-inf" : "+inf");
    }
    return too_large;
}

// The parser refuses a number too large for it as bad syntax. As infinity it gets to where its key
// is known, and is refused there with the range.
toml::parse_result parse(std::string text)
{
    toml::parse_result result = toml::parse(text);
    for (int k = 0; k < REPLACED_MAX && !result; k++) {
        if (!replace_too_large(text, result.error().source().begin)) {
            break;
        }
        result = toml::parse(text);
    }
    return result;
}

bool is_digit(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// A person writes .5 and 7. too: a zero to each point that has a digit on one side only.
std::string with_digits_at_points(const std::string &text)
{
    std::string found;
    for (std::size_t k = 0; k < text.size(); k++) {
        const bool digit_before = k > 0 && is_digit(text[k - 1]);
        const bool digit_behind = k + 1 < text.size() && is_digit(text[k + 1]);
        const bool point = text[k] == '.' && digit_before != digit_behind;
        found += point && !digit_before ? "0" : "";
        found += text[k];
        found += point && digit_before ? "0" : "";
    }
    return found;
}

toml::parse_result parse_value(const std::string &text)
{
    toml::parse_result result = parse("value = " + text);
    return result ? std::move(result) : parse("value = " + with_digits_at_points(text));
}

// An override has no lines, nor has what is in it.
void set_origin(Node &node, const Origin &origin)
{
    node.origin = origin;
    for (Node &item : node.items) {
        set_origin(item, origin);
    }
    for (auto &[key, value] : node.members) {
        set_origin(value, origin);
    }
}

} // namespace

bool Node::is_number() const
{
    return kind == Kind::integer || kind == Kind::real;
}

double Node::number() const
{
    return kind == Kind::integer ? static_cast<double>(integer) : real;
}

std::optional<int64_t> Node::whole() const
{
    constexpr double LARGEST = 9007199254740992; // a double has each whole number up to it
    const bool exact = kind == Kind::real && std::abs(real) <= LARGEST && real == std::round(real);
    if (kind != Kind::integer && !exact) {
        return std::nullopt;
    }
    return kind == Kind::integer ? integer : static_cast<int64_t>(real);
}

Node parse_document(const std::string &name, const std::string &text)
{
    guard_text(name, text);
    const toml::parse_result result = parse(text);
    if (!result) {
        const toml::parse_error &error = result.error();
        fail({name, error.source().begin.line}, "", "",
             "TOML syntax: " + readable(error.description(), SYNTAX_READABLE), "");
    }
    return convert(result.table(), name);
}

Node parse_override(const std::string &key, const std::string &value)
{
    const Origin origin = {"--set", 0};
    if (value.empty()) {
        fail(origin, readable(key), "", "has no value", "KEY=VALUE");
    }
    Node node;
    node.kind = Node::Kind::text;
    node.text = value;
    if (value.find_first_of("\r\n") == std::string::npos && is_safe(value)) {
        const toml::parse_result result = parse_value(value);
        if (result && result.table().size() == 1) {
            node = convert(*result.table().get("value"), origin.file);
        }
    }
    set_origin(node, origin);
    return node;
}

std::string shown(const Node &node)
{
    switch (node.kind) {
    case Node::Kind::table:
        return "{…}";
    case Node::Kind::list:
        return readable(shown_list(node));
    case Node::Kind::boolean:
        return node.boolean ? "true" : "false";
    case Node::Kind::integer:
        return fmt::format("{}", node.integer);
    case Node::Kind::real:
        return fmt::format("{}", node.real);
    case Node::Kind::text:
        return '"' + readable(node.text) + '"';
    case Node::Kind::time:
        break;
    }
    return "a date or time";
}

std::string toml_string(const std::string &text)
{
    std::string safe;
    for (const char c : text) {
        safe += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    }
    return '"' + safe + '"';
}

const char *kind_name(const Node &node)
{
    switch (node.kind) {
    case Node::Kind::table:
        return "a table";
    case Node::Kind::list:
        return "a list";
    case Node::Kind::boolean:
        return "a boolean";
    case Node::Kind::integer:
        return "a whole number";
    case Node::Kind::real:
        return "a number with a fraction";
    case Node::Kind::text:
        return "a string";
    case Node::Kind::time:
        break;
    }
    return "a date or time";
}

} // namespace nf
