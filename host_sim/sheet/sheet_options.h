/* SPDX-License-Identifier: MIT */
// What a data sheet prints of a motor: an option each, with its quantity and how it is written.
#pragma once

#include "printed.h"

#include <string>
#include <vector>

namespace nf::sheet
{

struct SheetOption {
    const char *name; // "--resistance"
    const char *help;
    const char *example;              // as it is typed
    std::vector<Quantity> quantities; // one; two of --no-load; none of --name
};

const std::vector<SheetOption> &sheet_options();

// One of them, by its name.
const SheetOption &sheet_option(const std::string &name);

// What has to be known of a motor. The options of one line are alternatives.
const std::vector<std::vector<std::string>> &needed_options();

// Options that give the same thing, so that one of them is too much.
const std::vector<std::vector<std::string>> &rival_options();

// The quantities of an option that has several, in their order, whatever the order in which they
// were typed. Throws as read_printed().
std::vector<Printed> read_option(const SheetOption &option, const std::string &typed);

} // namespace nf::sheet
