// SPDX-License-Identifier: MIT
#include "printed_matrices.h"

#include "document.h"
#include "files.h"
#include "readable.h"
#include "schema.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf::design
{
namespace
{

constexpr double ENTRY_MAX = 1e9;
constexpr double TIME_MAX_S = 1;
constexpr double TIME_MIN_S = 1e-6;

// Keys of a table that must all be there, and no other.
class Table
{
public:
    Table(const Node &table, std::string where) : table_(table), where_(std::move(where))
    {
    }

    void allow_only(const std::vector<std::string> &keys) const
    {
        for (const auto &[key, value] : table_.members) {
            if (std::count(keys.begin(), keys.end(), key) == 0) {
                fail(value.origin, where_ + readable(key), shown(value), "unknown key",
                     fmt::format("{}", fmt::join(keys, ", ")));
            }
        }
    }

    const Node *find(const std::string &key) const
    {
        const auto found = std::find_if(table_.members.begin(), table_.members.end(),
                                        [&](const auto &member) { return member.first == key; });
        return found == table_.members.end() ? nullptr : &found->second;
    }

    const Node &get(const std::string &key) const
    {
        const Node *const found = find(key);
        if (found == nullptr) {
            fail(table_.origin, where_ + key, "", "is missing", "");
        }
        return *found;
    }

    double number(const std::string &key, double min, double max) const
    {
        const Node &value = get(key);
        check_number(where_ + key, value, min, max, range_text(min, max, ""));
        return value.number();
    }

    int whole(const std::string &key, int min, int max) const
    {
        const Node &value = get(key);
        if (value.kind != Node::Kind::integer) {
            fail(value.origin, where_ + key, shown(value), std::string("is ") + kind_name(value),
                 fmt::format("a whole number, {} to {}", min, max));
        }
        return static_cast<int>(number(key, min, max));
    }

    std::string text(const std::string &key) const
    {
        const Node &value = get(key);
        if (value.kind != Node::Kind::text) {
            fail(value.origin, where_ + key, shown(value), std::string("is ") + kind_name(value),
                 "a string");
        }
        return value.text;
    }

private:
    const Node &table_;
    std::string where_;
};

template <typename Matrix> Matrix read_matrix(const Table &document, const std::string &key)
{
    Matrix matrix;
    const Node &rows = document.get(key);
    const std::string size = fmt::format("{} rows of {}", matrix.rows(), matrix.cols());
    if (rows.items.size() != static_cast<std::size_t>(matrix.rows())) {
        fail(rows.origin, key, shown(rows), fmt::format("has {} rows", rows.items.size()), size);
    }
    for (Eigen::Index r = 0; r < matrix.rows(); r++) {
        const Node &row = rows.items[static_cast<std::size_t>(r)];
        if (row.items.size() != static_cast<std::size_t>(matrix.cols())) {
            fail(row.origin, key, shown(row), fmt::format("has {} entries", row.items.size()),
                 size);
        }
        for (Eigen::Index c = 0; c < matrix.cols(); c++) {
            const Node &entry = row.items[static_cast<std::size_t>(c)];
            check_number(key, entry, -ENTRY_MAX, ENTRY_MAX, range_text(-ENTRY_MAX, ENTRY_MAX, ""));
            matrix(r, c) = entry.number();
        }
    }
    return matrix;
}

Correction read_correction(const Node &node)
{
    const Table table(node, "correction.");
    table.allow_only({"matrix", "row", "column", "printed", "used", "reason"});
    const std::string matrix = table.text("matrix");
    if (matrix != "phi" && matrix != "theta") {
        fail(table.get("matrix").origin, "correction.matrix", '"' + readable(matrix) + '"',
             "is no matrix", "\"phi\", \"theta\"");
    }
    return {matrix,
            table.whole("row", 1, MOTOR_STATES),
            table.whole("column", 1, matrix == "phi" ? MOTOR_STATES : INPUT_COUNT),
            table.number("printed", -ENTRY_MAX, ENTRY_MAX),
            table.number("used", -ENTRY_MAX, ENTRY_MAX),
            table.text("reason")};
}

void apply(const Correction &correction, const Origin &origin, Discrete &model)
{
    double &entry = correction.matrix == "phi"
                        ? model.phi(correction.row - 1, correction.column - 1)
                        : model.theta(correction.row - 1, correction.column - 1);
    if (entry != correction.printed) {
        fail(origin, "correction.printed", fmt::format("{}", correction.printed),
             "is not the entry of the matrix", fmt::format("{}", entry));
    }
    entry = correction.used;
}

} // namespace

PrintedMatrices read_matrices(const std::string &path)
{
    const Node document = parse_document(display_name(path), read_bytes(path));
    const Table table(document, "");
    table.allow_only({"sample_time_s", "phi", "theta", "correction"});
    PrintedMatrices matrices{{read_matrix<MotorMatrix>(table, "phi"),
                              read_matrix<MotorInputs>(table, "theta"),
                              table.number("sample_time_s", TIME_MIN_S, TIME_MAX_S)},
                             {}};
    if (const Node *const corrections = table.find("correction")) {
        for (const Node &node : corrections->items) {
            matrices.corrections.push_back(read_correction(node));
            apply(matrices.corrections.back(), node.origin, matrices.model);
        }
    }
    return matrices;
}

} // namespace nf::design
