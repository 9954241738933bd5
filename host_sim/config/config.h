/* SPDX-License-Identifier: MIT */
// Reads a complete configuration from the motor, board, tuning, scenario and imperfection files.
//
// Layers, later ones override earlier ones key by key:
//     motor, board and tuning file; the scenario's own tables; imperfection sets in the order
//     given; `--set section.key=value` in the order given.
// Every value is checked on its own in its layer, so a wrong line is named even if it is
// overridden. Every function here throws ConfigError, and nothing else, for whatever the files
// hold. A name plate (plate.h) is refused by all but load_plate().
#pragma once

#include "configuration.h"
#include "per_unit.h"

#include <filesystem>
#include <string>
#include <vector>

namespace nf
{

struct ScenarioInfo {
    std::string id;
    std::string title;
    std::string paper_figure;
};

// A scenario by its name in the data folder or by a path, with imperfection sets (names or paths)
// and overrides ("section.key=value"; also "motor=NAME", "board=NAME", "tuning=NAME").
Config load_scenario(const std::string &id_or_path, const std::vector<std::string> &with = {},
                     const std::vector<std::string> &set = {});

// The tuning of what names none: of scenario `any`, image, certificate, zoo and name plate. Its
// gains follow from the motor.
inline constexpr const char *DEFAULT_TUNING = "any";

// Motor, board and tuning alone, each by name or path.
Config load_parts(const std::string &motor, const std::string &board, const std::string &tuning,
                  const std::vector<std::string> &with = {},
                  const std::vector<std::string> &set = {});

// A motor of which only the name plate is known, with a board and the tuning `any`. The motor file
// is a name plate: [motor] has name, pole_pairs, max_speed_rpm, max_current_a and
// continuous_current_a, and no value that has to be measured; these are 0 in `motor`, and typical()
// of plate.h fills them in. Of a complete motor file the name plate alone is taken: what it says of
// R, L, φ, J, friction, rated torque and rated speed, and its [measured], are ignored. Overrides as
// those of load_parts(), also "tuning=NAME". Refuses a file that is neither, and one without a
// continuous current.
Config load_plate(const std::string &motor, const std::string &board,
                  const std::vector<std::string> &with = {},
                  const std::vector<std::string> &set = {});

// A motor alone, by name or path, with overrides "motor.key=value"; the rest is at its defaults.
Config load_motor(const std::string &motor, const std::vector<std::string> &set = {});

// A board alone, by name or path.
BoardSettings load_board(const std::string &board);

// Refuses to write over a file that the configuration was read from. `option` is for the message.
void check_output(const Config &config, const std::string &option,
                  const std::filesystem::path &path);

// The firmware's configuration. What does not fit is reported with the file and line it came from.
drive_cfg_t build(const Config &config);

// What the data folder holds, sorted by name.
std::vector<ScenarioInfo> list_scenarios();
std::vector<std::string> list_imperfections();
std::vector<std::string> list_motors();
std::vector<std::string> list_boards();
std::vector<std::string> list_tunings();

} // namespace nf
