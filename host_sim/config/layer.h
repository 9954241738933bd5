/* SPDX-License-Identifier: MIT */
// One file or override as a list of checked settings: what is wrong with it is found here,
// whether or not another layer overrides it.
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

// A file of a kind from its text, without looking at the files that it refers to. Any bytes are
// allowed; throws ConfigError for what is wrong.
Layer read_layer(FileKind kind, const std::string &file, const std::string &text);

// An override "section.key=value", or "motor=NAME" and the like.
Layer read_override(const std::string &text);

// Notes the layer's settings in the configuration.
void apply_layer(const Layer &layer, Config &config);

} // namespace nf
