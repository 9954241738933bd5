/* SPDX-License-Identifier: MIT */
// A motor as its data sheet prints it, and the motor file that follows.
#pragma once

#include "made.h"

#include <string>
#include <vector>

namespace nf::sheet
{

class Sheet
{
public:
    // Takes what an option of sheet_options() was given. Throws std::runtime_error with one line,
    // in the user's terms, for what cannot be read, is out of its key's range, or gives what
    // another option has given; the sheet is then as before.
    void give(const std::string &option, const std::string &typed);

    // What is missing, in the order of the file: of each the options that would give it, one or
    // more. None: the sheet is whole.
    std::vector<std::vector<std::string>> missing() const;

    // What does not fit together, and what was assumed, a line each.
    std::vector<std::string> remarks() const;

    // The text of the motor file, which load_motor() reads back. Behind each value stands what was
    // typed. The sheet is whole.
    std::string motor_file() const;

private:
    std::string name_;
    Given given_;
};

} // namespace nf::sheet
