/* SPDX-License-Identifier: MIT */
// The table of every setting: section, key, unit, range, default, place in Config, help and when it
// acts. Reading, range checks, messages and the list of keys all work from it.
#pragma once

#include "acts.h"
#include "configuration.h"
#include "document.h"

#include <array>
#include <string>
#include <variant>
#include <vector>

namespace nf
{

enum class FileKind {
    motor,
    board,
    tuning,
    scenario,
    imperfection
};

const char *kind_name(FileKind kind);

using Target = std::variant<double *, int *, unsigned *, bool *, std::string *,
                            std::array<double, 2> *, std::array<double, 3> *, std::vector<double> *,
                            std::vector<std::string> *, DriveMode *, ControlMethod *, AngleSource *,
                            SensorKind *, OscillationAct *, SafeState *, Wires *, Polarity *,
                            CurrentPosition *, InputKind *, InputCommands *, InputButton *>;

struct Field {
    const char *section;
    const char *key;
    const char *unit; // "" for a plain number
    double min;       // of numbers, both ends allowed; of strings, their length
    double max;
    bool required; // without a default
    Target (*target)(Config &config);
    const char *help;
    Acting acting = {};

    std::string name() const;                            // "section.key"
    std::string allowed() const;                         // "0.001 to 50 Ω"
    std::string default_text() const;                    // "required", or the default as in a file
    std::string meaning() const;                         // the help, and when the key acts
    std::string value_text(const Config &config) const;  // as in a file
    std::string number_text(const Config &config) const; // likewise; "" where it is no number
};

const std::vector<Field> &schema();

// The field of "section.key", or null.
const Field *find_field(const std::string &name);

// Whether a kind of file may hold a section.
bool may_hold(FileKind kind, const std::string &section);

// The sections that a kind of file may hold.
std::vector<std::string> sections_of(FileKind kind);

// Throws ConfigError unless the value has the field's type and range.
void check_value(const Field &field, const Node &value);

// Puts a checked value into its place and notes its origin.
void apply_value(const Field &field, const Node &value, Config &config);

// Whether `value` is a finite number within the range; else throws. `key` is for the message.
void check_number(const std::string &key, const Node &value, double min, double max,
                  const std::string &allowed);

// Throws the ConfigError that `fields`, one or more, are missing at a place, each with its range.
// `need` says who needs what is missing, "" for everybody: ", and a hardware binding needs ".
[[noreturn]] void refuse_missing(const Origin &place, const std::vector<const Field *> &fields,
                                 const std::string &need = "");

// "MIN to MAX UNIT"
std::string range_text(double min, double max, const std::string &unit);

} // namespace nf
