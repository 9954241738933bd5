/* SPDX-License-Identifier: MIT */
// One file or override as a list of checked settings.
#pragma once

#include "schema.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace nf
{

struct Setting {
    const Field *field = nullptr;
    Node value;
};

struct Layer {
    FileKind kind = FileKind::scenario; // of a file
    std::string file;                   // as shown to the user
    std::filesystem::path path;         // empty for what is no file
    std::string provenance;             // what it is called on every machine; empty for an override
    std::vector<Setting> settings;      // checked
    std::map<std::string, Node> top; // of a scenario `base`, `motor`, `board`, `tuning`; `include`
    std::map<std::string, Node> extra;    // of a scenario: its lists, "accept"
    std::map<std::string, Origin> tables; // where each section starts
};

// Notes the layer's settings in the configuration.
void apply_layer(const Layer &layer, Config &config);

} // namespace nf
