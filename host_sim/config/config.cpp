// SPDX-License-Identifier: MIT
#include "config.h"

#include "complete.h"
#include "files.h"
#include "idle.h"
#include "plate.h"
#include "ratings.h"
#include "read_layer.h"
#include "readable.h"
#include "refusal.h"
#include "sampling_units.h"
#include "scenario_file.h"
#include "sensor_units.h"
#include "setting_error.h"
#include "startup_units.h"

#include "zoo.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fs = std::filesystem;

namespace nf
{
namespace
{

const Origin COMMAND_LINE = {"command line", 0};
const Origin WITH = {"--with", 0};
constexpr std::size_t INCLUDE_DEPTH = 8;

// A reference to a file: what was written, where, and what relative paths start from.
struct Reference {
    std::string text;
    Origin origin;
    fs::path base;
};

// The text that the zoo has for a kind of file.
std::string drawn_text(FileKind kind, const zoo::Reference &drawn)
{
    zoo::Reference exact = drawn;
    exact.user = false;
    const std::string name = exact.name();
    switch (kind) {
    case FileKind::motor:
        return zoo::motor_file(drawn);
    case FileKind::board:
        return zoo::board_file(drawn);
    case FileKind::imperfection:
        return zoo::imperfection_file(drawn);
    case FileKind::scenario:
    case FileKind::tuning:
        break;
    }
    return zoo::scenario_file(drawn, {name, name, name});
}

Layer read_drawn(FileKind kind, const Reference &reference, const std::string &key)
{
    const std::optional<zoo::Reference> drawn = zoo::parse(reference.text);
    const bool is_there =
        drawn && kind != FileKind::tuning && (kind == FileKind::scenario || !drawn->user);
    if (!is_there) {
        fail(reference.origin, key, '"' + readable(reference.text) + '"', "is not in the zoo",
             kind == FileKind::tuning ? allowed_references(kind) : zoo::allowed());
    }
    const std::string name = fmt::format("{}/{}.toml", drawn->name(), kind_name(kind));
    Layer layer = read_layer(kind, name, drawn_text(kind, *drawn));
    layer.provenance = drawn->name();
    return layer;
}

// A file's, or that of a motor of the zoo.
Layer read_reference(FileKind kind, const Reference &reference, const std::string &key)
{
    if (zoo::is_reference(reference.text)) {
        return read_drawn(kind, reference, key);
    }
    const fs::path path = resolve(kind, reference.text, reference.base, key, reference.origin);
    Layer layer = read_layer(kind, display_name(path), read_bytes(path));
    layer.path = path;
    layer.provenance = provenance_name(path);
    return layer;
}

// How files of a kind name others that come before them.
struct Chain {
    FileKind kind;
    const char *key; // a name, or a list of names
    const char *loop;
};
constexpr Chain INCLUDES = {FileKind::imperfection, "include", "includes itself"};
constexpr Chain BASES = {FileKind::scenario, "base", "is based on itself"};

// The layers of a file, those of the files that it names first.
void read_chain(const Chain &chain, const Reference &reference, const std::string &key,
                std::size_t depth, std::vector<Layer> &layers)
{
    if (depth > INCLUDE_DEPTH) {
        fail(reference.origin, key, '"' + readable(reference.text) + '"', chain.loop,
             fmt::format("at most {} levels", INCLUDE_DEPTH));
    }
    Layer layer = read_reference(chain.kind, reference, key);
    const auto found = layer.top.find(chain.key);
    if (found != layer.top.end()) {
        const Node &named = found->second;
        const bool is_list = named.kind == Node::Kind::list;
        for (const Node &item : is_list ? named.items : std::vector<Node>{named}) {
            read_chain(chain, {item.text, item.origin, layer.path.parent_path()}, chain.key,
                       depth + 1, layers);
        }
    }
    layers.push_back(std::move(layer));
}

// Everything that a configuration is made of.
struct Sources {
    std::map<FileKind, Reference> parts; // motor, board, tuning
    bool is_plate_enough = false;        // of the motor
    std::vector<Layer> scenario;         // what it is based on first; or none
    std::vector<Layer> imperfections;
    std::vector<Layer> overrides;
};

// A motor of the zoo brings its board along.
void read_overrides(const std::vector<std::string> &set, Sources &sources)
{
    std::map<FileKind, Reference> chosen;
    for (const std::string &text : set) {
        Layer layer = read_override(text);
        for (const auto &[kind, reference] : sources.parts) {
            const auto found = layer.top.find(kind_name(kind));
            if (found != layer.top.end()) {
                chosen[kind] = {found->second.text, found->second.origin, ""};
            }
        }
        sources.overrides.push_back(std::move(layer));
    }
    if (chosen.count(FileKind::motor) != 0 && zoo::is_reference(chosen[FileKind::motor].text)) {
        chosen.insert({FileKind::board, chosen[FileKind::motor]});
    }
    for (const auto &[kind, reference] : chosen) {
        sources.parts[kind] = reference;
    }
}

bool each_above(const std::vector<double> &values)
{
    return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

bool each_below(const std::vector<double> &values)
{
    return std::adjacent_find(values.begin(), values.end(), std::less_equal<>()) == values.end();
}

[[noreturn]] void refuse_list(const Config &config, const char *key,
                              const std::vector<double> &values, const char *problem,
                              const std::string &allowed)
{
    const auto written = config.origins.find(key);
    fail(written == config.origins.end() ? config.origins.at("board.name") : written->second, key,
         fmt::format("[{}]", fmt::join(values, ", ")), problem, allowed);
}

// As many as there are sectors.
void check_six(const Config &config, const char *key, const std::vector<double> &values)
{
    if (values.size() != HALL_SECTORS) {
        refuse_list(config, key, values, "has not one value for each pattern", "six values");
    }
}

// The width of the widest sector between six edges that rise within one turn.
double widest_deg(const std::vector<double> &edges)
{
    double widest = edges.front() + 360 - edges.back();
    for (std::size_t k = 1; k < edges.size(); k++) {
        widest = std::max(widest, edges[k] - edges[k - 1]);
    }
    return widest;
}

// The sectors that six patterns of Hall signals begin, in the order of the rotor's turn.
void check_hall(const Config &config)
{
    const SensorSettings &sensor = config.motor.sensor;
    check_six(config, "sensor.hall_patterns", sensor.hall_patterns);
    check_six(config, "sensor.hall_edges_deg", sensor.hall_edges_deg);
    check_six(config, "plant.hall_error_deg", config.plant.hall_error_deg);
    const bool whole = std::all_of(sensor.hall_patterns.begin(), sensor.hall_patterns.end(),
                                   [](double pattern) { return pattern == std::floor(pattern); });
    if (!whole || !hall_order_holds(hall_patterns(sensor))) {
        refuse_list(config, "sensor.hall_patterns", sensor.hall_patterns, "is no order of a turn",
                    "1 to 6 once each, two neighbours different in one signal");
    }
    std::vector<double> real;
    real.reserve(HALL_SECTORS);
    for (std::size_t k = 0; k < HALL_SECTORS; k++) {
        real.push_back(sensor.hall_edges_deg[k] + config.plant.hall_error_deg[k]);
    }
    const std::vector<double> *const both[] = {&sensor.hall_edges_deg, &real};
    const char *const keys[] = {"sensor.hall_edges_deg", "plant.hall_error_deg"};
    for (std::size_t k = 0; k < 2; k++) {
        if (!each_above(*both[k]) || both[k]->back() - both[k]->front() >= 360) {
            refuse_list(config, keys[k],
                        k == 0 ? sensor.hall_edges_deg : config.plant.hall_error_deg,
                        "makes sectors that overlap", "edges that rise within one turn");
        }
    }
    if (widest_deg(sensor.hall_edges_deg) >= 180) {
        refuse_list(config, "sensor.hall_edges_deg", sensor.hall_edges_deg,
                    "makes a sector of half a turn or more", "sectors of some 60°");
    }
}

// A line that can be read both ways.
void check_temperature_points(const Config &config)
{
    const auto refuse = [&](const char *key, const std::vector<double> &values, const char *problem,
                            const std::string &allowed) {
        refuse_list(config, key, values, problem, allowed);
    };
    const std::vector<double> &points = config.board.temperature_points_c;
    const std::vector<double> &pct = config.board.temperature_points_pct;
    if (!each_above(points)) {
        refuse("board.temperature_points_c", points, "does not rise", "each above the one before");
    }
    if (pct.size() != points.size()) {
        refuse("board.temperature_points_pct", pct, "has not as many points as the temperatures",
               fmt::format("{}, one for each of board.temperature_points_c", points.size()));
    }
    if (!each_above(pct) && !each_below(pct)) {
        refuse("board.temperature_points_pct", pct, "turns around",
               "each above the one before, or each below");
    }
}

// The sensor sees the temperature at which the drive stops, whichever way it counts.
void check_temperature(const Config &config)
{
    const BoardSettings &board = config.board;
    check_temperature_points(config);
    const double lowest = board.temperature_points_c.front();
    const double highest = board.temperature_points_c.back();
    if (lowest < board.temperature_max_c && board.temperature_max_c < highest) {
        return;
    }
    const auto written = config.origins.find("board.temperature_max_c");
    const Origin origin =
        written == config.origins.end() ? config.origins.at("board.name") : written->second;
    fail(origin, "board.temperature_max_c", fmt::format("{}", board.temperature_max_c),
         "is beyond what the sensor sees",
         fmt::format("between {} and {}, the ends of board.temperature_points_c", lowest, highest));
}

// The drive runs from t = 0 on at the latest, or from where the metrics start.
void check_prelude(Config &config)
{
    const auto written = config.origins.find("scenario.prelude_s");
    ScenarioSettings &s = config.scenario;
    const double calibration_s = calibration_time(config.board, config.tuning);
    if (s.prelude_s <= 0) {
        s.prelude_s = calibration_s;
    }
    s.prelude_s += startup_time(config.motor, config.board, config.tuning);
    if (s.prelude_s + s.evaluate_from_s < calibration_s) {
        fail(written->second, written->first, fmt::format("{}", s.prelude_s),
             "ends before the drive has calibrated its sensors",
             fmt::format("0, which is as long as that takes, or at least {:.6g} s",
                         calibration_s - s.evaluate_from_s));
    }
}

std::string &source_name(SourceFiles &files, FileKind kind)
{
    if (kind == FileKind::motor) {
        return files.motor;
    }
    return kind == FileKind::board ? files.board : files.tuning;
}

// Written for one drive: an override, a file outside of the data folder, what is drawn.
bool is_users(const Layer &layer)
{
    return layer.path.empty() || is_own(layer.path);
}

Author author_of(const Layer &layer)
{
    if (is_users(layer)) {
        return Author::user;
    }
    switch (layer.kind) {
    case FileKind::motor:
        return Author::motor;
    case FileKind::board:
        return Author::board;
    case FileKind::scenario:
        return Author::scenario;
    case FileKind::imperfection:
        return Author::imperfection;
    case FileKind::tuning:
        break;
    }
    return Author::tuning;
}

void take(const Layer &layer, Config &config)
{
    apply_layer(layer, config);
    const Author author = author_of(layer);
    for (const Setting &setting : layer.settings) {
        config.origins.at(setting.field->name()).author = author;
    }
    if (!layer.path.empty()) {
        config.sources.read.push_back(layer.path);
    }
}

// What charges between the rails in the measured dead time at the current of the knee: C =
// i_k·t_d/U.
double measured_capacitance_f(const Config &config)
{
    const MeasuredSettings &m = config.measured;
    return m.knee_a * m.dead_time_s / (m.bus_v > 0 ? m.bus_v : config.board.bus_nominal_v);
}

// The plant's dead time and drop are the board's, the model's are the plant's, unless they are
// written; −1 is as if nothing were. A measured dead time is all that the legs lose, the drop with
// it: the model that takes it has no drop beside it. The plant has what it had.
void pass_on_dead_time(Config &config)
{
    const auto take_over = [&](const char *key, double &value, double from) {
        if (value < 0) {
            value = from;
            config.origins.erase(key);
        }
    };
    MeasuredSettings &measured = config.measured;
    take_over("measured.dead_time_s", measured.dead_time_s, NOT_MEASURED);
    take_over("measured.knee_a", measured.knee_a, NOT_MEASURED);
    take_over("plant.dead_time_s", config.plant.dead_time_s, config.board.dead_time_s);
    take_over("plant.device_drop_v", config.plant.device_drop_v, config.board.device_drop_v);
    const bool is_measured = measured.dead_time_s >= 0 && config.model.dead_time_s < 0;
    take_over("model.dead_time_s", config.model.dead_time_s,
              is_measured ? measured.dead_time_s : config.plant.dead_time_s);
    take_over("model.device_drop_v", config.model.device_drop_v,
              is_measured ? 0 : config.plant.device_drop_v);
    take_over("model.output_capacitance_f", config.model.output_capacitance_f,
              has_no_measured_knee(config) ? config.board.output_capacitance_f
                                           : measured_capacitance_f(config));
}

// Those that can hold what a scenario is made of.
std::vector<const Layer *> scenario_layers(const Sources &sources)
{
    std::vector<const Layer *> all;
    for (const auto *layers : {&sources.scenario, &sources.overrides}) {
        for (const Layer &layer : *layers) {
            all.push_back(&layer);
        }
    }
    return all;
}

// Those whose lines are written for this drive. What a shipped motor, tuning or imperfection set
// says is for every mode.
std::vector<const Layer *> own_layers(const Sources &sources,
                                      const std::map<FileKind, Layer> &homes)
{
    std::vector<const Layer *> own = scenario_layers(sources);
    for (const auto &[kind, home] : homes) {
        if (kind == FileKind::board || is_users(home)) {
            own.push_back(&home);
        }
    }
    for (const Layer &layer : sources.imperfections) {
        if (is_users(layer)) {
            own.push_back(&layer);
        }
    }
    return own;
}

// Applies all layers and checks the whole.
Config assemble(const Sources &sources)
{
    Config config;
    std::map<FileKind, Layer> homes;
    for (const auto &[kind, reference] : sources.parts) {
        homes[kind] = read_reference(kind, reference, kind_name(kind));
        take(homes[kind], config);
        source_name(config.sources, kind) = homes[kind].provenance;
    }
    const fs::path &motor = homes[FileKind::motor].path;
    config.sources.motor_is_example = !motor.empty() && !is_own(motor);
    for (const auto *layers : {&sources.scenario, &sources.imperfections, &sources.overrides}) {
        for (const Layer &layer : *layers) {
            take(layer, config);
        }
    }
    for (const auto &[kind, home] : homes) {
        if (kind == FileKind::motor && sources.is_plate_enough) {
            check_plate(home, config);
            forget_measured(config);
        } else {
            check_complete(kind, home, config);
        }
    }
    if (!sources.scenario.empty()) {
        check_complete(FileKind::scenario, sources.scenario.back(), config);
    }
    apply_scenario(scenario_layers(sources), config);
    if (!sources.scenario.empty()) {
        check_prelude(config);
    }
    check_orders(config);
    check_hall(config);
    check_temperature(config);
    pass_on_dead_time(config);
    if (!sources.is_plate_enough) {
        note_ratings(config);
    }
    note_idle(own_layers(sources, homes), config);
    return config;
}

Config finish(Sources &sources, const std::vector<std::string> &with,
              const std::vector<std::string> &set)
{
    std::vector<std::string> names;
    for (const std::string &text : with) {
        read_chain(INCLUDES, {text, WITH, ""}, "imperfection", 0, sources.imperfections);
        names.push_back(sources.imperfections.back().provenance);
    }
    read_overrides(set, sources);
    Config config = assemble(sources);
    config.sources.imperfections = std::move(names);
    config.sources.overrides = set;
    return config;
}

// Where a scenario says which motor, board or tuning it is for.
Reference part_of(const std::vector<Layer> &scenario, FileKind kind)
{
    const std::string key = kind_name(kind);
    const auto layer = std::find_if(scenario.rbegin(), scenario.rend(),
                                    [&](const Layer &l) { return l.top.count(key) != 0; });
    if (layer == scenario.rend()) {
        fail({scenario.back().file, 1}, key, "", "is missing", allowed_references(kind));
    }
    const Node &found = layer->top.at(key);
    return {found.text, found.origin, layer->path.parent_path()};
}

} // namespace

Config load_scenario(const std::string &id_or_path, const std::vector<std::string> &with,
                     const std::vector<std::string> &set)
{
    Sources sources;
    read_chain(BASES, {id_or_path, COMMAND_LINE, ""}, "scenario", 0, sources.scenario);
    const fs::path path = sources.scenario.back().path;
    const std::string provenance = sources.scenario.back().provenance;
    for (const FileKind kind : {FileKind::motor, FileKind::board, FileKind::tuning}) {
        sources.parts[kind] = part_of(sources.scenario, kind);
    }
    Config config = finish(sources, with, set);
    config.scenario.id = path.empty() ? provenance : path.stem().string();
    config.sources.scenario = provenance;
    return config;
}

Config load_parts(const std::string &motor, const std::string &board, const std::string &tuning,
                  const std::vector<std::string> &with, const std::vector<std::string> &set)
{
    Sources sources;
    sources.parts[FileKind::motor] = {motor, COMMAND_LINE, ""};
    sources.parts[FileKind::board] = {board, COMMAND_LINE, ""};
    sources.parts[FileKind::tuning] = {tuning, COMMAND_LINE, ""};
    return finish(sources, with, set);
}

Config load_plate(const std::string &motor, const std::string &board,
                  const std::vector<std::string> &with, const std::vector<std::string> &set)
{
    Sources sources;
    sources.parts[FileKind::motor] = {motor, COMMAND_LINE, ""};
    sources.parts[FileKind::board] = {board, COMMAND_LINE, ""};
    sources.parts[FileKind::tuning] = {DEFAULT_TUNING, COMMAND_LINE, ""};
    sources.is_plate_enough = true;
    return finish(sources, with, set);
}

Config load_motor(const std::string &motor, const std::vector<std::string> &set)
{
    const Layer home = read_reference(FileKind::motor, {motor, COMMAND_LINE, ""}, "motor");
    Config config;
    config.sources.motor = home.provenance;
    config.sources.overrides = set;
    take(home, config);
    for (const std::string &text : set) {
        take(read_override(text), config);
    }
    check_complete(FileKind::motor, home, config);
    return config;
}

BoardSettings load_board(const std::string &board)
{
    const Layer home = read_reference(FileKind::board, {board, COMMAND_LINE, ""}, "board");
    Config config;
    take(home, config);
    check_complete(FileKind::board, home, config);
    return config.board;
}

void check_output(const Config &config, const std::string &option, const fs::path &path)
{
    for (const fs::path &read : config.sources.read) {
        std::error_code error;
        if (fs::equivalent(path, read, error)) {
            fail({option, 0}, readable(path.string(), READABLE_PATH), "",
                 "the configuration is read from this file", "another file");
        }
    }
}

drive_cfg_t build(const Config &config)
{
    try {
        return make_drive_cfg(config.motor, config.board, config.tuning, config.model);
    } catch (const SettingError &error) {
        refuse(config, error);
    }
}

std::vector<ScenarioInfo> list_scenarios()
{
    std::vector<ScenarioInfo> infos;
    for (const std::string &id : list_names(FileKind::scenario)) {
        std::vector<Layer> layers;
        read_chain(BASES, {id, COMMAND_LINE, ""}, "scenario", 0, layers);
        Config config;
        for (const Layer &layer : layers) {
            apply_layer(layer, config);
        }
        infos.push_back({id, config.scenario.title, config.scenario.paper_figure});
    }
    return infos;
}

std::vector<std::string> list_imperfections()
{
    return list_names(FileKind::imperfection);
}

std::vector<std::string> list_motors()
{
    return list_names(FileKind::motor);
}

std::vector<std::string> list_boards()
{
    return list_names(FileKind::board);
}

std::vector<std::string> list_tunings()
{
    return list_names(FileKind::tuning);
}

} // namespace nf
