/* SPDX-License-Identifier: MIT */
// The lists of a scenario that disturb it and ask for things: [[scenario.fault]],
// [[scenario.request]].
#pragma once

#include "configuration.h"
#include "document.h"

#include <vector>

namespace nf
{

// Both throw ConfigError for whatever the list holds that it must not.
std::vector<FaultEntry> read_faults(const Node &list);
std::vector<RequestEntry> read_requests(const Node &list);

// A list of tables, as `name`, in which each has only the keys given. For all lists of a scenario.
void check_list(const std::string &name, const std::vector<std::string> &keys, const Node &list);

// The value of a key of such a table, or null.
const Node *member(const Node &entry, const std::string &key);

// The number at a key that has to be there.
double needed_number(const std::string &name, const Node &entry, const std::string &key, double min,
                     double max, const std::string &unit);

// The key of every entry of every list; seconds.
double read_time(const std::string &name, const Node &entry);

} // namespace nf
