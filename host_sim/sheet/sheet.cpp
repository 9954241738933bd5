// SPDX-License-Identifier: MIT
#include "sheet.h"

#include "remarks.h"
#include "schema.h"
#include "spelling.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

using Group = std::vector<std::string>;

constexpr const char *HEAD =
    "# From a data sheet, by motorsim motor; behind each value what was typed.\n";

void check_name(const std::string &typed)
{
    Node node;
    node.kind = Node::Kind::text;
    node.text = typed;
    node.origin = {"--name", 0};
    check_value(*find_field("motor.name"), node);
}

void check_rivals(const Given &given, const std::string &option)
{
    for (const Group &rivals : rival_options()) {
        const bool is_one = std::count(rivals.begin(), rivals.end(), option) != 0;
        const auto other = std::find_if(rivals.begin(), rivals.end(), [&](const std::string &one) {
            return one != option && given.count(one) != 0;
        });
        if (is_one && other != rivals.end()) {
            refuse(option, given.at(option).front().typed,
                   fmt::format("{} \"{}\" gives the same; leave one of them out", *other,
                               given.at(*other).front().typed));
        }
    }
}

std::string setting_of(const Made &made)
{
    return fmt::format("{} = {}", made.key, made.value());
}

std::string comment_of(const Made &made)
{
    return fmt::format("# {} {}{}{}", made.option, made.from.typed,
                       made.comment.empty() ? "" : "; ", made.comment);
}

// As the schema, and so each other writer of motor files, orders them.
std::vector<Made> in_order(const std::vector<Made> &made)
{
    std::vector<Made> sorted;
    for (const Field &field : schema()) {
        std::copy_if(made.begin(), made.end(), std::back_inserter(sorted), [&](const Made &one) {
            return field.name() == std::string("motor.") + one.key;
        });
    }
    return sorted;
}

} // namespace

void Sheet::give(const std::string &option, const std::string &typed)
{
    if (option == "--name") {
        check_name(typed);
        name_ = typed;
        return;
    }
    Given more = given_;
    more[option] = read_option(sheet_option(option), typed);
    check_rivals(more, option);
    for (const Made &made : make_all(more)) {
        check_range(made);
    }
    given_ = std::move(more);
}

std::vector<Group> Sheet::missing() const
{
    std::vector<Group> open;
    for (const Group &group : needed_options()) {
        const bool is_there = std::any_of(group.begin(), group.end(), [&](const std::string &one) {
            return one == "--name" ? !name_.empty() : given_.count(one) != 0;
        });
        if (!is_there) {
            open.push_back(group);
        }
    }
    return open;
}

std::vector<std::string> Sheet::remarks() const
{
    return remarks_on(given_);
}

std::string Sheet::motor_file() const
{
    const std::vector<Made> made = in_order(make_all(given_));
    std::size_t width = 0;
    for (const Made &one : made) {
        width = std::max(width, setting_of(one).size());
    }
    std::string text = HEAD;
    for (const std::string &remark : remarks()) {
        text += fmt::format("# note: {}\n", remark);
    }
    text += fmt::format("\n[motor]\nname = {}\n", toml_string(name_));
    for (const Made &one : made) {
        text += fmt::format("{:<{}} {}\n", setting_of(one), width, comment_of(one));
    }
    return text;
}

} // namespace nf::sheet
