/* SPDX-License-Identifier: MIT */
// Conventions of data sheets: between what a quantity is measured, and which number stands for a
// sine.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nf::sheet
{

enum class Across {
    unsaid,
    terminals, // phase to phase
    phase,     // of the star
    winding    // of a triangle
};

enum class Sort {
    unsaid,
    peak,
    rms,
    six_step // block commutation, the current or voltage of the dc side
};

struct Convention {
    Across across = Across::unsaid;
    Sort sort = Sort::unsaid;
};

// What has to be said of a quantity beside its unit.
enum class Needs {
    nothing,
    across,   // resistance, inductance
    sort,     // a current: peak or rms
    any_sort, // a torque per ampere: peak, rms or six-step
    voltage   // a voltage per speed: peak or rms and across what, or six-step
};

// The words of a convention, as a refusal names them and a user can type them: "rms phase to
// phase". "" for none.
std::string words(const Convention &convention);

// The convention that `said`, words in lower case, say of a quantity. Nothing may be unsaid that it
// needs, nor may a word be left over; else `problem` says what is wrong, which words are allowed,
// and by which factor they differ, and nothing is returned.
std::optional<Convention> convention_of(Needs needs, const std::vector<std::string> &said,
                                        std::string &problem);

// All conventions that a quantity can have, one without words for what needs none.
std::vector<Convention> conventions_of(Needs needs);

} // namespace nf::sheet
