// SPDX-License-Identifier: MIT
#include "read_layer.h"

#include "readable.h"
#include "scenario_file.h"
#include "suggest.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

const std::vector<std::string> PARTS = {"motor", "board", "tuning"};

bool is_part(const std::string &key)
{
    return std::count(PARTS.begin(), PARTS.end(), key) != 0;
}

// Whether a kind of file has `key` above its tables.
bool has_top(FileKind kind, const std::string &key)
{
    return (kind == FileKind::scenario && (is_part(key) || key == "base")) ||
           (kind == FileKind::imperfection && key == "include");
}

bool is_list(const std::string &section, const std::string &key)
{
    const std::vector<std::string> &lists = scenario_lists();
    return section == "scenario" && std::count(lists.begin(), lists.end(), key) != 0;
}

std::vector<std::string> keys_of(const std::vector<std::string> &sections)
{
    std::vector<std::string> keys;
    for (const Field &field : schema()) {
        if (std::count(sections.begin(), sections.end(), field.section) != 0) {
            keys.push_back(field.name());
        }
    }
    if (std::count(sections.begin(), sections.end(), "scenario") != 0) {
        for (const std::string &list : scenario_lists()) {
            keys.push_back("scenario." + list);
        }
    }
    return keys;
}

std::vector<std::string> all_sections()
{
    std::vector<std::string> sections;
    for (const Field &field : schema()) {
        if (sections.empty() || sections.back() != field.section) {
            sections.emplace_back(field.section);
        }
    }
    return sections;
}

[[noreturn]] void unknown_key(const std::string &name, const Node &value,
                              const std::vector<std::string> &sections)
{
    const std::string near = nearest(name, keys_of(sections));
    const std::string section = name.substr(0, name.find('.'));
    const bool known = std::count(sections.begin(), sections.end(), section) != 0;
    const std::vector<std::string> offered = known ? keys_of({section}) : sections;
    fail(value.origin, readable(name), shown(value),
         near.empty() ? "unknown key" : fmt::format("unknown key, did you mean {}?", near),
         near.empty() ? fmt::format("{}", fmt::join(offered, ", ")) : "");
}

[[noreturn]] void unknown_section(FileKind kind, const std::string &section, const Origin &origin)
{
    const std::vector<std::string> sections = sections_of(kind);
    const std::string near = nearest(section, sections);
    const std::string problem = fmt::format("no table of {} files", kind_name(kind));
    fail(origin, '[' + readable(section) + ']', "",
         near.empty() ? problem : fmt::format("{}, did you mean [{}]?", problem, near),
         fmt::format("[{}]", fmt::join(sections, "], [")));
}

void read_section(FileKind kind, const std::string &section, const Node &table, Layer &layer)
{
    layer.tables[section] = table.origin;
    for (const auto &[key, value] : table.members) {
        const std::string name = fmt::format("{}.{}", section, key);
        const Field *field = find_field(name);
        if (is_list(section, key)) {
            layer.extra[key] = value;
        } else if (field == nullptr) {
            unknown_key(name, value, sections_of(kind));
        } else {
            check_value(*field, value);
            layer.settings.push_back({field, value});
        }
    }
}

bool is_text(const Node &value)
{
    return value.kind == Node::Kind::text;
}

void read_top(FileKind kind, const std::string &key, const Node &value, Layer &layer)
{
    if (!has_top(kind, key)) {
        unknown_key(key, value, sections_of(kind));
    }
    if (key != "include" && !is_text(value)) {
        fail(value.origin, key, shown(value), std::string("is ") + kind_name(value),
             "a string, the name or path of a file");
    }
    if (key == "include" && (value.kind != Node::Kind::list ||
                             !std::all_of(value.items.begin(), value.items.end(), is_text))) {
        fail(value.origin, key, shown(value), "is no list of strings",
             "names or paths of imperfection sets");
    }
    layer.top[key] = value;
}

void read_member(FileKind kind, const std::string &key, const Node &value, Layer &layer)
{
    const bool is_table = value.kind == Node::Kind::table;
    if (has_top(kind, key) || !is_table) {
        if (!has_top(kind, key) && may_hold(kind, key)) {
            fail(value.origin, key, shown(value), std::string("is ") + kind_name(value),
                 fmt::format("a table [{}]", key));
        }
        read_top(kind, key, value, layer);
    } else if (!may_hold(kind, key)) {
        unknown_section(kind, key, value.origin);
    } else if (key == "accept") {
        layer.extra[key] = value;
    } else {
        read_section(kind, key, value, layer);
    }
}

} // namespace

Layer read_layer(FileKind kind, const std::string &file, const std::string &text)
{
    Layer layer;
    layer.kind = kind;
    layer.file = file;
    const Node document = parse_document(file, text);
    for (const auto &[key, value] : document.members) {
        read_member(kind, key, value, layer);
    }
    if (kind == FileKind::scenario) {
        check_scenario(layer);
    }
    return layer;
}

Layer read_override(const std::string &text)
{
    Layer layer;
    layer.file = "--set";
    const std::size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    if (equals == std::string::npos || name.empty()) {
        fail({layer.file, 0}, '"' + readable(text) + '"', "", "is no override",
             "section.key=value");
    }
    const std::string written = text.substr(equals + 1);
    const Node value = parse_override(name, written);
    if (is_part(name)) {
        layer.top[name] = value;
        layer.top[name].text = is_text(value) ? value.text : written;
        return layer;
    }
    const std::size_t dot = std::min(name.find('.'), name.size());
    if (dot < name.size() && is_list(name.substr(0, dot), name.substr(dot + 1))) {
        layer.extra[name.substr(dot + 1)] = value;
        return layer;
    }
    const Field *field = find_field(name);
    if (field == nullptr) {
        unknown_key(name, value, all_sections());
    }
    check_value(*field, value);
    layer.settings.push_back({field, value});
    return layer;
}

} // namespace nf
