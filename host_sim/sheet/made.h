/* SPDX-License-Identifier: MIT */
// Values of a motor file, each made of what a data sheet prints.
#pragma once

#include "sheet_options.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace nf::sheet
{

using Given =
    std::map<std::string, std::vector<Printed>>; // by option; what is absent was not given

bool has(const Given &given, const std::string &option);

// value = factor · number^power + more, of the key's unit
struct Made {
    const char *key;    // of [motor]
    std::string option; // that gave the number
    Printed from;
    double factor = 1;
    int power = 1; // 1 or −1
    double more = 0;
    std::string comment; // beside what was typed

    double value() const; // rounded to six digits, as it is written
};

// All that follows from what is given, in the order in which it is checked. Throws
// std::runtime_error for what needs more words.
std::vector<Made> make_all(const Given &given);

// The flux linkage that follows from one option of it, in a convention. The pole pairs are given.
double flux_of(const Given &given, const std::string &option, const Convention &convention);

// That of the flux linkage which is taken, "" where none is given: the torque constant's, else the
// EMF constant's, else Kv's.
std::string flux_option(const Given &given);

// Throws std::runtime_error where a value is out of the range of its key, with the range in the
// unit that was typed.
void check_range(const Made &made);

// The pole pairs, 0 where none are given or none that a motor can have.
int pole_pairs(const Given &given);

} // namespace nf::sheet
