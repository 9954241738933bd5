/* SPDX-License-Identifier: MIT */
// A number as a data sheet prints it: with a unit and, where sheets differ, a convention.
#pragma once

#include "convention.h"

#include <string>
#include <vector>

namespace nf::sheet
{

struct Unit {
    const char *symbol;    // as it is shown: "mN.m/A"
    double si;             // one of it, in the SI unit of the quantity
    const char *also = ""; // other spellings: "ozf.in|in.oz"
};

struct Quantity {
    const char *noun; // "a resistance"
    std::vector<Unit> units;
    Needs needs = Needs::nothing;
    bool is_bare_allowed = false;  // a number without a unit is in the first one
    bool may_leave_unsaid = false; // what it needs may follow from elsewhere
};

struct Printed {
    std::string typed; // for messages
    double number = 0; // of the unit
    Unit unit = {"", 1};
    Convention convention;

    double si() const; // in the SI unit of its quantity
    // A number in the unit and convention that were typed: "0.7 ohm phase to phase".
    std::string as_typed(const std::string &other_number) const;
};

// Throws std::runtime_error, one line that names `option`, what was typed and what is allowed. A 0
// needs no unit where `quantity` needs no convention.
Printed read_printed(const std::string &option, const Quantity &quantity, const std::string &typed);

// Whether the text begins with a number in one of the quantity's units, whatever comes after it.
bool has_unit_of(const Quantity &quantity, const std::string &typed);

// Whether the text is a number of the quantity without a unit, and read_printed() takes it.
bool needs_no_unit(const Quantity &quantity, const std::string &typed);

// "ohm, mohm"
std::string unit_names(const Quantity &quantity);

} // namespace nf::sheet
