/* SPDX-License-Identifier: MIT */
// Asks a person for what a data sheet has not said yet.
#pragma once

#include "sheet.h"

#include <functional>
#include <optional>
#include <string>

namespace nf::sheet
{

// Where answers come from and what is said goes to. `line` returns nothing at the end of the input.
struct Dialogue {
    std::function<void(const std::string &)> say; // a text without a line feed at its end
    std::function<std::optional<std::string>()> line;
};

// Asks for each missing value in turn, with an example. Of alternatives the unit of the answer
// decides. An answer that cannot be taken is said and asked for again. Ends when the sheet is
// whole, or with the input.
void ask(Sheet &sheet, const Dialogue &dialogue);

// One line that names all that is missing, with an example of each.
std::string missing_text(const Sheet &sheet);

} // namespace nf::sheet
