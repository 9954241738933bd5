// SPDX-License-Identifier: MIT
// Every fault in every state of the drive: how soon the gates are open for good and what is
// latched, or why nothing is and what the motor does meanwhile. The tables are part of the design:
// docs/protection.md, "Fault injection".
//
//     test_fault_table            holds the tables
//     test_fault_table --measure  prints them as they are measured now; tools/dev figures --write
//                                 puts them there
#include "found_fault.h"
#include "measure.h"
#include "plate.h"
#include "scripted_run.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

// Where in a run a fault strikes: in the tick after the one in which the drive has come there.
struct Place {
    const char *name;
    bool moves; // the command is 1000 rpm from 0.2 s on, with 3 N·m from 1.5 s on; else it stays 0
};

enum PlaceId {
    READY,
    START,
    FLYING_START,
    PULL,
    MEASURE,
    HELD,
    RAMP,
    HANDOVER,
    RUNNING,
    PROBE_REST,
    PROBE_TURNS,
    PLACES
};

constexpr Place PLACE[PLACES] = {
    {"READY", false},       {"start", true},           {"FLYING_START", false},
    {"ALIGN, pull", false}, {"ALIGN, measure", false}, {"HOLD", false},
    {"IF_RAMP", true},      {"HANDOVER", true},        {"RUN", true},
    {"PROBE, rest", false}, {"PROBE, turns", false},
};

bool is_probe(PlaceId place)
{
    return place == PROBE_REST || place == PROBE_TURNS;
}

constexpr double RPM_PER_RAD_S = 30.0 / 3.14159265358979323846;

struct Row {
    drive_state_t state;
    bool gates;
    align_phase_t align;
    double current_a; // the largest true phase current
    double rpm;       // true
};

struct Rows {
    std::vector<Row> all;
    nf::FoundFault fault{};
    std::string refusal; // of the identification

    void add(const nf::Simulation &sim, const plant_view_t &truth)
    {
        const drive_t &drive = sim.drive();
        double current_a = 0;
        for (const double i : truth.i_abc_a) {
            current_a = std::max(current_a, std::fabs(i));
        }
        all.push_back({drive.state, sim.out().gate_enable, drive.start.align.phase, current_a,
                       truth.omega_mech_rad_s * RPM_PER_RAD_S});
        if (drive.state == DRIVE_STATE_FAULT) {
            fault = nf::found_fault(drive, sim.bases());
        }
    }
};

std::vector<std::string> settings(PlaceId place, double duration_s)
{
    std::vector<std::string> set = {fmt::format("scenario.duration_s={}", duration_s)};
    if (PLACE[place].moves) {
        set.emplace_back("scenario.command=[{time_s = 0.2, speed_rpm = 1000}]");
        set.emplace_back("scenario.load=[{time_s = 1.5, torque_nm = 3}]");
    } else {
        set.emplace_back("scenario.command=[{time_s = 0, speed_rpm = 0}]");
    }
    if (place == READY || place == START) {
        set.emplace_back("scenario.request=[{time_s = -1, run = false}]");
    }
    return set;
}

nf::Config config_of(const std::vector<std::string> &set)
{
    return nf::load_scenario("s1_robust", {"ideal"}, set);
}

// Nobody clears a fault: once it is latched a run shows that the gates stay open for so long, and
// ends.
constexpr std::size_t LATCHED_TICKS = 5000;

Rows run(const nf::Config &config)
{
    Rows rows;
    nf::ScriptedRun run(config);
    std::size_t latched = 0;
    while (run.tick() < run.end() && latched < LATCHED_TICKS) {
        const nf::Tick tick = run.control();
        rows.add(*tick.sim, tick.truth);
        run.advance();
        latched += rows.all.back().state == DRIVE_STATE_FAULT ? 1U : 0U;
    }
    return rows;
}

// An identification with the faults of the scenario, and what follows for as long as above. `phase`
// is told of each of its lines, and of the tick.
using Phase = std::function<void(const std::string &, std::size_t)>;

Rows run_identification(const nf::Config &config, const Phase &phase = {})
{
    nf::Simulation sim(config, nf::with_typical(nf::known_from_plate(config)));
    const double period_s = sim.bases().control_period_s;
    nf::Injection injection(config, period_s, std::llround(config.scenario.prelude_s / period_s));
    Rows rows;
    const auto add = [&] {
        plant_view_t truth{};
        plant_view(&sim.plant(), &truth);
        rows.add(sim, truth);
    };
    int64_t tick = 0;
    const auto before_tick = [&](nf::Simulation &now) {
        if (tick > 0) {
            add(); // of the tick before
        }
        injection.act(tick, now);
        tick++;
    };
    const auto line = [&](const std::string &text) {
        if (phase) {
            phase(text, rows.all.size());
        }
    };
    rows.refusal = nf::identify::measure(sim, line, before_tick).refusal;
    for (std::size_t k = 0; k < LATCHED_TICKS; k++) {
        before_tick(sim);
        sim.control();
        sim.advance();
    }
    add();
    return rows;
}

// In the middle of the phase whose line begins with `first`; `next` is the line behind it.
std::size_t middle_of_phase(const char *first, const char *next)
{
    std::size_t from = 0;
    std::size_t to = 0;
    run_identification(config_of(settings(PROBE_REST, 1)),
                       [&](const std::string &line, std::size_t tick) {
                           from = line.rfind(first, 0) == 0 ? tick : from;
                           to = line.rfind(next, 0) == 0 ? tick : to;
                       });
    return (from + to) / 2;
}

// The ticks after which a healthy drive is in the middle of each place.
std::size_t first_with(const Rows &rows, drive_state_t state, align_phase_t phase = ALIGN_DONE)
{
    const bool aligning = state == DRIVE_STATE_ALIGN;
    std::size_t k = 0;
    while (rows.all.at(k).state != state || (aligning && rows.all[k].align != phase)) {
        k++;
    }
    return k;
}

// Ticks from entering a place to the fault there.
std::size_t place_tick(PlaceId place, const drive_cfg_t &cfg)
{
    static const Rows standing = run(config_of(settings(HELD, 1)));
    static const Rows moving = run(config_of(settings(RUNNING, 1)));
    const align_cfg_t &align = cfg.startup.align;
    switch (place) {
    case READY:
    case START: // the request to run comes with the fault
        return first_with(standing, DRIVE_STATE_READY) + 100;
    case FLYING_START:
        return first_with(standing, DRIVE_STATE_FLYING_START) + 1;
    case PULL: // the vector turns
        return first_with(standing, DRIVE_STATE_ALIGN, ALIGN_PULL) + align.sweep_ticks / 2;
    case MEASURE:
        return first_with(standing, DRIVE_STATE_ALIGN, ALIGN_MEASURE_HIGH) +
               (1U << align.measure_log2) / 2;
    case HELD:
        return first_with(standing, DRIVE_STATE_HOLD) + 1000;
    case RAMP: // half of the way
        return (first_with(moving, DRIVE_STATE_IF_RAMP) +
                first_with(moving, DRIVE_STATE_HANDOVER)) /
               2;
    case HANDOVER:
        return first_with(moving, DRIVE_STATE_HANDOVER) + 1;
    case PROBE_REST:
        return middle_of_phase("the shaft goes to three angles", "the shaft turns");
    case PROBE_TURNS:
        return middle_of_phase("the shaft turns, up to", "between half of that speed");
    default: // a second after the load step
        return first_with(moving, DRIVE_STATE_RUN) + 17500;
    }
}

enum class Kind {
    electrical,
    temperature,
    wire,
    sensor,
    bus,
    late,
    blocked,
    jump,
    memory
};

struct Fault {
    const char *name;
    const char *text; // of the scenario
    Kind kind;
    const char *later = ""; // what else is so half a second later
    const char *board = ""; // a setting of the board
};

constexpr const char *NO_COMPARATORS = "board.trip_a=0";

constexpr Fault FAULTS[] = {
    {"break_input", "what = 'break_input'", Kind::electrical},
    {"overcurrent, 19 A", "what = 'overcurrent', value = 19", Kind::electrical},
    {"adc_a_high", "what = 'adc_a_high'", Kind::electrical},
    {"adc_a_low", "what = 'adc_a_low'", Kind::electrical},
    {"adc_b_high", "what = 'adc_b_high'", Kind::electrical},
    {"adc_b_low", "what = 'adc_b_low'", Kind::electrical},
    {"bus_voltage, 405 V", "what = 'bus_voltage', value = 405", Kind::electrical},
    {"bus_voltage, 190 V", "what = 'bus_voltage', value = 190", Kind::electrical},
    {"temperature, 105 °C", "what = 'temperature', value = 105", Kind::temperature},
    {"phase_a_open", "what = 'phase_a_open'", Kind::wire},
    {"phase_b_open", "what = 'phase_b_open'", Kind::wire},
    {"phase_c_open", "what = 'phase_c_open'", Kind::wire},
    {"adc_a_stuck", "what = 'adc_a_stuck'", Kind::sensor},
    {"adc_b_stuck", "what = 'adc_b_stuck'", Kind::sensor},
    {"adc_a_stuck, no comparators", "what = 'adc_a_stuck'", Kind::sensor, "", NO_COMPARATORS},
    {"adc_b_stuck, no comparators", "what = 'adc_b_stuck'", Kind::sensor, "", NO_COMPARATORS},
    {"adc_bus_stuck", "what = 'adc_bus_stuck'", Kind::bus},
    {"adc_bus_stuck, bus 405 V", "what = 'adc_bus_stuck'", Kind::bus,
     "what = 'bus_voltage', value = 405"},
    {"late_isr, lasting", "what = 'late_isr', until_s = 1e3", Kind::late},
    {"rotor_blocked", "what = 'rotor_blocked'", Kind::blocked},
    {"rotor_jump, 120°", "what = 'rotor_jump', value = 120", Kind::jump},
    {"config_corrupt", "what = 'config_corrupt', value = 30", Kind::memory},
};

struct Found {
    nf::FoundFault fault{};  // latched at the end, else FAULT_NONE
    bool is_refused = false; // the identification
    std::size_t at = 0;      // the tick of the fault
    int64_t ticks = 0;       // from then until it is latched
    int64_t gates_after = 0; // from the tick that latches it on, ticks with gates enabled
    drive_state_t end = DRIVE_STATE_INIT;
    bool gates_at_end = false;
    double current_a = 0; // until then: the largest true phase current
    double rpm = 0;       // and the largest true speed
    double rpm_end = 0;
};

constexpr double LATER_S = 0.5;
constexpr double OBSERVED_S = 6; // more than the largest of the bounds below

// What became of a run with a fault in the tick found.at.
void observe(const Rows &rows, Found &found)
{
    std::size_t open = found.at;
    for (std::size_t k = found.at; k < rows.all.size(); k++) {
        open = rows.all[k].gates ? k + 1 : open;
    }
    for (std::size_t k = found.at; k <= open && k < rows.all.size(); k++) {
        found.current_a = std::max(found.current_a, rows.all[k].current_a);
        found.rpm = std::max(found.rpm, std::fabs(rows.all[k].rpm));
    }
    found.ticks = static_cast<int64_t>(open - found.at);
    found.end = rows.all.back().state;
    found.gates_at_end = rows.all.back().gates;
    found.is_refused = !rows.refusal.empty();
    found.rpm_end = rows.all.back().rpm;
    if (found.end == DRIVE_STATE_FAULT) {
        found.fault = rows.fault;
        found.gates_after = static_cast<int64_t>(open) - static_cast<int64_t>(rows.fault.tick);
        found.ticks = static_cast<int64_t>(rows.fault.tick) - static_cast<int64_t>(found.at);
    }
}

Found inject(const Fault &fault, PlaceId place)
{
    const nf::Config plain = config_of(settings(place, 1));
    const double period_s = nf::make_bases(plain.motor, plain.board).control_period_s;
    const auto zero = static_cast<int64_t>(std::llround(plain.scenario.prelude_s / period_s));
    Found found;
    found.at = place_tick(place, nf::build(plain));
    const double time_s = static_cast<double>(static_cast<int64_t>(found.at) - zero) * period_s;
    std::vector<std::string> set = settings(place, time_s + OBSERVED_S);
    const bool lasts = place == START && fault.kind == Kind::electrical;
    std::string faults = fmt::format("{{time_s = {:.6f}, {}{}}}", time_s, fault.text,
                                     lasts ? ", until_s = 1e3" : "");
    if (*fault.later != '\0') {
        faults += fmt::format(", {{time_s = {:.6f}, {}}}", time_s + LATER_S, fault.later);
    }
    set.push_back(fmt::format("scenario.fault=[{}]", faults));
    if (*fault.board != '\0') {
        set.emplace_back(fault.board);
    }
    if (place == START) {
        set.push_back(fmt::format("scenario.request=[{{time_s = -1, run = false}}, "
                                  "{{time_s = {:.6f}, run = true}}]",
                                  time_s));
    }
    const nf::Config config = config_of(set);
    observe(is_probe(place) ? run_identification(config) : run(config), found);
    return found;
}

// What the imposed current takes to the speed of the hand-over; a drive with a sensor has no such
// start.
int64_t ramp_ticks(const drive_cfg_t &cfg)
{
    const startup_cfg_t &start = cfg.startup;
    const int64_t slow = cfg.slow_ticks;
    return start.ramp == 0 ? 0 : start.handover_speed / start.ramp * slow;
}

// Within how many ticks a fault has to be found, by the configuration.
int64_t bound_of(Kind kind, PlaceId place, const drive_cfg_t &cfg)
{
    const startup_cfg_t &start = cfg.startup;
    const int64_t slow = cfg.slow_ticks;
    const int64_t round = slow * SUPERVISION_STEPS; // a supervision period
    const int64_t judged = start.handover_periods * slow;
    const int64_t lost = start.lost_periods * slow;
    const int64_t aligned = start.align.pull_ticks + start.align.settle_ticks +
                            (int64_t{2} << start.align.measure_log2);
    const int64_t given_up = start.attempts * (aligned + ramp_ticks(cfg) + judged + lost);
    switch (kind) {
    case Kind::electrical:
        return 0;
    case Kind::temperature: // it may just have been looked at
        return (cfg.derating.temperature_periods + 2) * round;
    case Kind::late:
        return cfg.supervision.late_max + 1;
    case Kind::blocked: // a rotor that does not turn is not handed over
        return std::max(place == RUNNING ? 0 : given_up,
                        cfg.supervision.stall_periods * round + judged);
    case Kind::memory:
        return static_cast<int64_t>(2 * CONFIG_GUARD_STEPS) * round;
    default: // at worst the start-up gives up
        return given_up;
    }
}

// Where an identification ends as if nothing were.
const char *excuse_of_probe(const Fault &fault, PlaceId place)
{
    const char *excuse = nullptr;
    if (fault.kind == Kind::bus) {
        excuse = "not seen";
    } else if (fault.kind == Kind::jump) {
        excuse = place == PROBE_REST ? "pulled back" : "caught again";
    }
    return excuse;
}

// Where nothing is to be found while gates are closed or the rotor stands.
const char *excuse_of(const Fault &fault, PlaceId place)
{
    if (is_probe(place)) {
        return excuse_of_probe(fault, place);
    }
    const bool stands = place != READY && !PLACE[place].moves;
    const bool seen_without_current =
        std::strcmp(fault.name, "break_input") == 0 || fault.kind == Kind::temperature ||
        fault.kind == Kind::memory || std::strstr(fault.name, "405 V") != nullptr;
    const char *excuse = nullptr;
    if (fault.kind == Kind::bus && PLACE[place].moves && *fault.later != '\0') {
        excuse = "not seen, speed off"; // the observer's voltage is not what acts
    } else if (fault.kind == Kind::bus) {
        excuse = "not seen";
    } else if (place == READY && !seen_without_current) {
        excuse = "no current";
    } else if (stands && fault.kind == Kind::blocked) {
        excuse = "is to stand";
    } else if (fault.kind == Kind::jump) {
        excuse = place <= START || stands ? "pulled back" : "caught again";
    } else if (stands && fault.kind == Kind::sensor && place >= MEASURE) {
        excuse = "nothing changes";
    }
    return excuse;
}

drive_state_t healthy_end(PlaceId place)
{
    const drive_state_t standing = place == READY ? DRIVE_STATE_READY : DRIVE_STATE_HOLD;
    return PLACE[place].moves ? DRIVE_STATE_RUN : standing;
}

constexpr double OVERCURRENT_A = 18; // of the board

std::string cell(const Fault &fault, PlaceId place, const Found &found)
{
    const bool latched = found.fault.id != FAULT_NONE;
    std::string text;
    if (latched) {
        text = fmt::format("{} {}", fault_text(found.fault.id)->name, found.ticks);
    } else if (found.is_refused) {
        text = fmt::format("refused {}", found.ticks);
    } else {
        text = excuse_of(fault, place) ? excuse_of(fault, place) : "NOT FOUND";
    }
    if (found.current_a > OVERCURRENT_A) {
        text += fmt::format(", {:.0f} A", found.current_a);
    }
    return text;
}

std::string label(const Fault &fault, PlaceId place, const Found &found)
{
    return fmt::format("{} in {}: {}, state {}, {:.1f} A, {:.0f} rpm", fault.name,
                       PLACE[place].name, cell(fault, place, found), static_cast<int>(found.end),
                       found.current_a, found.rpm);
}

struct Cell {
    const Fault *fault;
    PlaceId place;
    Found found;
};

const std::vector<Cell> &cells()
{
    static const std::vector<Cell> all = [] {
        std::vector<Cell> made;
        for (const Fault &fault : FAULTS) {
            for (int p = 0; p < PLACES; p++) {
                const auto place = static_cast<PlaceId>(p);
                made.push_back({&fault, place, inject(fault, place)});
            }
        }
        return made;
    }();
    return all;
}

std::vector<std::string> table()
{
    std::string head = "| fault |";
    std::string rule = "| --- |";
    for (const Place &place : PLACE) {
        head += fmt::format(" {} |", place.name);
        rule += " --- |";
    }
    std::vector<std::string> lines = {head, rule};
    for (const Cell &one : cells()) {
        if (one.place == READY) {
            lines.push_back(fmt::format("| {} |", one.fault->name));
        }
        lines.back() += fmt::format(" {} |", cell(*one.fault, one.place, one.found));
    }
    return lines;
}

// A drive with an angle sensor: from READY it is in RUN at once, so there is only to tell at rest
// from in motion.
struct SensorFault {
    const char *name;
    const char *text;
};

constexpr SensorFault SENSOR_FAULTS[] = {
    {"angle_stuck", "what = 'angle_stuck'"},
    {"angle_offset, 15°", "what = 'angle_offset', value = 15"},
    {"angle_offset, 45°", "what = 'angle_offset', value = 45"},
};
constexpr PlaceId SENSOR_PLACES[] = {READY, HELD, RUNNING};
constexpr double SENSOR_FAULT_S = 3; // long after the load step

struct SensorCell {
    const SensorFault *fault;
    PlaceId place;
    Found found;
    double command;
};

SensorCell inject_sensor(const SensorFault &fault, PlaceId place)
{
    std::vector<std::string> set = settings(place, SENSOR_FAULT_S + OBSERVED_S);
    set.emplace_back("drive.angle_source=sensor");
    set.push_back(fmt::format("scenario.fault=[{{time_s = {}, {}}}]", SENSOR_FAULT_S, fault.text));
    const nf::Config config = config_of(set);
    const double period_s = nf::make_bases(config.motor, config.board).control_period_s;
    SensorCell made = {&fault, place, {}, PLACE[place].moves ? 1000.0 : 0.0};
    made.found.at = static_cast<std::size_t>(
        std::llround((SENSOR_FAULT_S + config.scenario.prelude_s) / period_s));
    observe(run(config), made.found);
    return made;
}

const std::vector<SensorCell> &sensor_cells()
{
    static const std::vector<SensorCell> all = [] {
        std::vector<SensorCell> made;
        for (const SensorFault &fault : SENSOR_FAULTS) {
            for (const PlaceId place : SENSOR_PLACES) {
                made.push_back(inject_sensor(fault, place));
            }
        }
        return made;
    }();
    return all;
}

std::string sensor_cell(const SensorCell &one)
{
    std::string text =
        one.found.fault.id != FAULT_NONE
            ? fmt::format("{} {}", fault_text(one.found.fault.id)->name, one.found.ticks)
            : std::string("not seen");
    text += fmt::format(", {:.0f} A, {:.0f} rpm", one.found.current_a, one.found.rpm);
    return text;
}

std::vector<std::string> sensor_table()
{
    std::vector<std::string> lines = {"| fault, angle from a sensor | READY | at rest | 1000 rpm |",
                                      "| --- | --- | --- | --- |"};
    for (const SensorCell &one : sensor_cells()) {
        if (one.place == READY) {
            lines.push_back(fmt::format("| {} |", one.fault->name));
        }
        lines.back() += fmt::format(" {} |", sensor_cell(one));
    }
    return lines;
}

TEST(test_what_is_found_is_latched_with_its_numbers_in_its_time)
{
    const drive_cfg_t cfg = nf::build(config_of(settings(HELD, 1)));
    for (const Cell &one : cells()) {
        const std::string text = label(*one.fault, one.place, one.found);
        if (one.found.fault.id != FAULT_NONE) {
            const int64_t bound = bound_of(one.fault->kind, one.place, cfg);
            TEST_ASSERT_TRUE_MESSAGE(one.found.ticks >= 0 && one.found.ticks <= bound,
                                     text.c_str());
            TEST_ASSERT_TRUE_MESSAGE(one.found.gates_after <= 0, text.c_str());
            TEST_ASSERT_TRUE_MESSAGE(one.found.fault.id == FAULT_BREAK ||
                                         one.found.fault.value != one.found.fault.limit ||
                                         one.found.fault.id == FAULT_SPEED_IMPLAUSIBLE,
                                     text.c_str());
        }
    }
}

// rpm of 1000: what is left of the jump after seconds.
TEST(test_what_is_not_found_has_a_reason_and_leaves_the_drive_in_control)
{
    constexpr double SETTLED_RPM = 5;
    for (const Cell &one : cells()) {
        const std::string text = label(*one.fault, one.place, one.found);
        if (one.found.fault.id == FAULT_NONE && !is_probe(one.place)) {
            const double command = PLACE[one.place].moves ? 1000 : 0;
            TEST_ASSERT_NOT_NULL_MESSAGE(excuse_of(*one.fault, one.place), text.c_str());
            TEST_ASSERT_EQUAL_INT_MESSAGE(healthy_end(one.place), one.found.end, text.c_str());
            const bool misled =
                std::strstr(excuse_of(*one.fault, one.place), "speed off") != nullptr;
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(misled ? command / 2 : SETTLED_RPM, command,
                                              one.found.rpm_end, text.c_str());
        }
    }
}

// What the drive lets pass the identification refuses, or it comes to its end. Then the gates are
// open, and nothing turns the shaft.
TEST(test_what_the_drive_does_not_find_in_probe_ends_the_identification_with_open_gates)
{
    for (const Cell &one : cells()) {
        const std::string text = label(*one.fault, one.place, one.found);
        if (one.found.fault.id == FAULT_NONE && is_probe(one.place)) {
            TEST_ASSERT_TRUE_MESSAGE(one.found.is_refused || excuse_of(*one.fault, one.place),
                                     text.c_str());
            TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_STATE_READY, one.found.end, text.c_str());
            TEST_ASSERT_FALSE_MESSAGE(one.found.gates_at_end, text.c_str());
        }
    }
}

// A tick of the whole bus on one winding takes the current beyond its limit by 2/3·310 V·0.1
// ms/11.6 mH. What a sensor that stands still does not show the comparators do; without them the
// table says how far it got.
TEST(test_current_and_speed_stay_within_their_limits_until_the_gates_open)
{
    constexpr double TICK_A = 1.8;
    const nf::Config config = config_of(settings(HELD, 1));
    for (const Cell &one : cells()) {
        const std::string text = label(*one.fault, one.place, one.found);
        const double limit_a = one.fault->kind == Kind::sensor
                                   ? config.board.trip_a
                                   : config.board.overcurrent_a + TICK_A;
        if (*one.fault->board == '\0') {
            TEST_ASSERT_TRUE_MESSAGE(one.found.current_a <= limit_a, text.c_str());
        }
        TEST_ASSERT_TRUE_MESSAGE(one.found.rpm <= 1.15 * config.motor.max_speed_rpm, text.c_str());
    }
}

// A mean that an error 5 % above its limit passes in three of its time constants. A stall counts
// from when the rotor has come to rest at its new place, in two tenths of its own time at most.
int64_t sensor_bound(const Found &found, const drive_cfg_t &cfg)
{
    const int64_t round = static_cast<int64_t>(cfg.slow_ticks) * SUPERVISION_STEPS;
    return found.fault.id == FAULT_STALL ? bound_of(Kind::blocked, HELD, cfg) * 12 / 10
                                         : (int64_t{3} << cfg.supervision.mean_shift) * round;
}

TEST(test_a_wrong_angle_sensor_is_found_in_motion_and_else_leaves_the_drive_in_control)
{
    constexpr double SETTLED_RPM = 5;
    const drive_cfg_t cfg = nf::build(config_of({"drive.angle_source=sensor"}));
    for (const SensorCell &one : sensor_cells()) {
        const std::string text =
            fmt::format("{} in {}: {}", one.fault->name, PLACE[one.place].name, sensor_cell(one));
        if (one.found.fault.id == FAULT_NONE) {
            TEST_ASSERT_TRUE_MESSAGE(one.place != RUNNING, text.c_str());
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SETTLED_RPM, one.command, one.found.rpm_end,
                                              text.c_str());
        } else {
            TEST_ASSERT_TRUE_MESSAGE(one.found.ticks <= sensor_bound(one.found, cfg), text.c_str());
            TEST_ASSERT_TRUE_MESSAGE(one.found.gates_after <= 0, text.c_str());
        }
        TEST_ASSERT_TRUE_MESSAGE(one.found.current_a <= OVERCURRENT_A, text.c_str());
    }
}

// What is printed with a fault leads to what really is wrong, whichever fault an open wire or a
// current sensor ends in.
TEST(test_the_advice_of_a_fault_names_what_it_was_made_by)
{
    const std::map<Kind, const char *> causes = {{Kind::wire, "wire"}, {Kind::sensor, "sensor"}};
    for (const Cell &one : cells()) {
        const auto cause = causes.find(one.fault->kind);
        if (one.found.fault.id != FAULT_NONE && cause != causes.end()) {
            const std::string advice = one.found.fault.advice;
            TEST_ASSERT_TRUE_MESSAGE(
                advice.find(cause->second) != std::string::npos,
                (label(*one.fault, one.place, one.found) + ": " + advice).c_str());
        }
    }
}

TEST(test_the_table_of_the_design_is_the_measured_one)
{
    std::ifstream file(NF_DESIGN_FILE);
    const std::string design((std::istreambuf_iterator<char>(file)), {});
    std::vector<std::string> lines = table();
    const std::vector<std::string> sensor = sensor_table();
    lines.insert(lines.end(), sensor.begin(), sensor.end());
    for (const std::string &line : lines) {
        TEST_ASSERT_TRUE_MESSAGE(design.find(line + "\n") != std::string::npos, line.c_str());
    }
}

} // namespace

int main(int argc, char **argv)
{
    if (argc > 1 && std::strcmp(argv[1], "--measure") == 0) {
        for (const std::string &line : table()) {
            fmt::print("{}\n", line);
        }
        fmt::print("\n");
        for (const std::string &line : sensor_table()) {
            fmt::print("{}\n", line);
        }
        return 0;
    }
    return testing_main(argc, argv);
}
