// SPDX-License-Identifier: MIT
// What a page does with the board that it follows beyond a line: the drive measures its motor, and
// a block comes and goes as a file.
#include "calls.h"
#include "live_board.h"

#include "demands.h"
#include "findings.h"

namespace nf::web::board_setup
{
namespace
{

// Of a file in the working folder, whatever its ending is.
std::string path_of(const Json &given)
{
    return "./" + given.at("file").get<std::string>();
}

// What it says, and what the motor will see; nothing moves.
Json plate(const Json &given)
{
    const Config known = live_board::commands().plate(path_of(given));
    const identify::Demands demands = identify::demands_of(known);
    const MotorSettings &said = known.motor;
    return {{"name", said.name},
            {"pole_pairs", said.pole_pairs},
            {"max_speed_rpm", said.max_speed_rpm},
            {"continuous_current_a", said.continuous_current_a},
            {"max_current_a", said.max_current_a},
            {"thermal_time_constant_s", said.thermal_time_constant_s},
            {"demands",
             {{"current_a", demands.current_a},
              {"largest_current_a", demands.largest_current_a},
              {"speed_rpm", demands.speed_rpm}}}};
}

// The page follows the board meanwhile: live.pass says how far it is.
Json begin(const Json &given)
{
    return live_board::said_or_thrown(live_board::commands().begin_identification(path_of(given)));
}

Json rows_json(const identify::Result &result)
{
    Json rows = Json::array();
    for (const identify::Finding &found : identify::findings_of(result)) {
        rows.push_back({{"title", found.title},
                        {"value", found.value},
                        {"bar", found.bar},
                        {"unit", found.unit}});
    }
    return rows;
}

Json measured(const Json &given)
{
    (void)given;
    const live::MeasuredMotor found = live_board::commands().take_identification();
    return {{"name", found.result.motor.name},
            {"rows", rows_json(found.result)},
            {"remarks", found.result.remarks},
            {"file", found.file_text()}};
}

// A whole motor file, and no name plate.
Json motor(const Json &given)
{
    return load_motor(path_of(given)).motor.name;
}

Json dump(const Json &given)
{
    return live_board::told("dump", given);
}

Json load(const Json &given)
{
    return live_board::told("load", given);
}

} // namespace

const Calls &calls()
{
    static const Calls all = {{"board.plate", plate},       {"board.identify", begin},
                              {"board.measured", measured}, {"board.motor", motor},
                              {"board.dump", dump},         {"board.load", load}};
    return all;
}

} // namespace nf::web::board_setup
