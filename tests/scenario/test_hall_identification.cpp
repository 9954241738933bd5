// SPDX-License-Identifier: MIT
// Three Hall signals are learned by the identification: any order of the wires, sensors that sit
// off by up to 15°, that switch with hysteresis, late and noisily. What was found drives the motor.
// A fault of the wiring is named, and loses nothing else of the identification.
#include "bars.h"
#include "evaluate.h"
#include "measure.h"
#include "numbers.h"
#include "plate.h"
#include "scenario.h"
#include "truth.h"

#include "testing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace
{

using Lines = std::vector<std::string>;
constexpr double PI = 3.14159265358979323846;
constexpr std::size_t SENSORS = 3;

// ---- what is asked for ----

constexpr double WITHIN_BARS = 0.95; // of the edges
// An edge is off by no more than this: a window has some 4 turns or more, whose edges fall evenly
// on a tick by the golden section, so half a tick counts by a quarter at most. The vector turns by
// less than 0.35 rad, 20°, in a tick at half of the highest speed that a configuration may have.
constexpr double EDGE_MOST_DEG = 20.0 / 2 / 4;

double wrapped(double deg)
{
    return std::remainder(deg, 360.0);
}

// A sensor that is high about `middle_deg`, over `width_deg`.
struct Sensor {
    double middle_deg;
    double width_deg;
    double hysteresis_deg; // each edge comes later by it, in either direction
    bool high = false;

    void see(double deg)
    {
        const double half = width_deg / 2 + (high ? hysteresis_deg : -hysteresis_deg);
        high = std::abs(wrapped(deg - middle_deg)) < half;
    }
};

class Sensors
{
public:
    explicit Sensors(unsigned seed) : generator_(seed)
    {
        std::array<int, SENSORS> order = {0, 1, 2};
        for (unsigned k = 0; k < seed % 6; k++) {
            std::next_permutation(order.begin(), order.end());
        }
        const double inverted_deg = seed / 6 % 2 == 0 ? 0 : 180;
        const double all_deg = uniform(0, 360) + inverted_deg;
        const double hysteresis_deg = uniform(0, 6);
        for (std::size_t k = 0; k < SENSORS; k++) {
            sensors_[k] = {all_deg + 120 * order[k] + uniform(-15, 15), 180 + uniform(-12, 12),
                           hysteresis_deg};
        }
        noise_deg_ = uniform(0, 2);
        late_s_ = uniform(0, 2e-5);
    }

    // Before a tick.
    void act(nf::Simulation &sim, int pole_pairs)
    {
        plant_view_t view{};
        plant_view(&sim.seam().plant, &view);
        const double late_rad = view.omega_mech_rad_s * late_s_;
        const double deg = (view.theta_mech_rad - late_rad) * pole_pairs * 180 / PI;
        unsigned levels = 0;
        for (std::size_t k = 0; k < SENSORS; k++) {
            sensors_[k].see(deg + noise_deg_ * normal_(generator_));
            levels |= sensors_[k].high ? 1U << k : 0U;
        }
        sim.seam().hal.shaft = {true, static_cast<uint16_t>(broken ? broken(levels) : levels)};
    }

    // The edge of the sensor whose bit changes, forwards.
    double edge_deg(unsigned before, unsigned after) const
    {
        const unsigned changed = before ^ after;
        const Sensor &sensor = sensors_[changed == 1 ? 0 : changed / 2];
        return sensor.middle_deg +
               ((after & changed) != 0 ? -sensor.width_deg : sensor.width_deg) / 2;
    }

    std::function<unsigned(unsigned)> broken; // what the wires make of the levels

private:
    double uniform(double low, double high)
    {
        return low + (high - low) * static_cast<double>(generator_()) / 4294967296.0;
    }

    std::mt19937 generator_;
    std::normal_distribution<> normal_;
    std::array<Sensor, SENSORS> sensors_{};
    double noise_deg_ = 0;
    double late_s_ = 0;
};

const Lines WITH_HALLS = {"sensor.kind=hall"};

nf::identify::Result identified(const nf::Config &config, Sensors &sensors, std::string &refusal)
{
    const nf::Config plate = nf::known_from_plate(config);
    nf::Simulation sim(config, nf::with_typical(plate));
    const nf::identify::Measurement measurement = nf::identify::measure(
        sim, {}, [&](nf::Simulation &now) { sensors.act(now, config.motor.pole_pairs); });
    refusal = measurement.refusal;
    if (!refusal.empty()) {
        return {};
    }
    return nf::identify::evaluate(nf::identify::read_records(measurement.lines, "records"), plate,
                                  25);
}

std::string motor_of(unsigned k)
{
    const char *const classes[] = {"outrunner", "hub",        "servo",
                                   "gimbal",    "compressor", "industrial"};
    return fmt::format("zoo:{}:{}@77:user", classes[k / 12 % std::size(classes)], k);
}

struct Count {
    unsigned edges = 0;
    unsigned within = 0;
    unsigned measured = 0;
    unsigned refused = 0;
    double largest_deg = 0;
    std::vector<double> errors;
    std::vector<double> bars;
};

void count(const nf::identify::Halls &halls, const Sensors &sensors, const std::string &what,
           Count &counted)
{
    for (std::size_t k = 0; k < halls.edges.size(); k++) {
        const auto &edge = halls.edges[k];
        const auto &before = halls.edges[(k + halls.edges.size() - 1) % halls.edges.size()];
        const double truth = sensors.edge_deg(static_cast<unsigned>(before.pattern),
                                              static_cast<unsigned>(edge.pattern));
        const double off = std::abs(wrapped(edge.deg.value - truth));
        const double bar = nf::error_bar(edge.deg.std, edge.deg.bound);
        counted.edges++;
        counted.within += off <= bar ? 1 : 0;
        counted.errors.push_back(off);
        counted.bars.push_back(bar);
        if (off > bar || off > EDGE_MOST_DEG) {
            std::printf("%s: pattern %d from %.2f, is %.2f, bar %.2f\n", what.c_str(), edge.pattern,
                        edge.deg.value, edge.deg.value - wrapped(edge.deg.value - truth), bar);
        }
        counted.largest_deg = std::max(counted.largest_deg, off);
    }
}

double quantile(std::vector<double> values, double share)
{
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(sensors_of_any_order_and_place_are_learned_within_their_bars)
{
    const unsigned runs = testing_runs(3, 144);
    Count counted;
    for (unsigned k = 0; k < runs; k++) {
        const unsigned number = testing_has_many_runs() ? k : 17 * k;
        const std::string motor = motor_of(number);
        const nf::Config config = nf::load_scenario(motor, {}, WITH_HALLS);
        Sensors sensors(number);
        std::string refusal;
        const auto result = identified(config, sensors, refusal);
        const std::string what = fmt::format("{}, sensors {}", motor, number);
        if (!refusal.empty()) {
            std::printf("%s: refused: %s\n", what.c_str(), refusal.c_str());
            counted.refused++;
        } else if (!result.halls.measured) {
            std::printf("%s: %s\n", what.c_str(), result.halls.trouble.c_str());
        } else {
            counted.measured++;
            count(result.halls, sensors, what, counted);
        }
    }
    std::printf(
        "%u of %u motors measured, %u refused; %u of %u edges within their bars; error %.3f° "
        "median, %.3f° 95 %%, %.3f° largest; bar %.2f° median, %.2f° 95 %%\n",
        counted.measured, runs, counted.refused, counted.within, counted.edges,
        quantile(counted.errors, 0.5), quantile(counted.errors, 0.95), counted.largest_deg,
        quantile(counted.bars, 0.5), quantile(counted.bars, 0.95));
    TEST_ASSERT_TRUE(counted.within >= WITHIN_BARS * counted.edges);
    TEST_ASSERT_TRUE(counted.largest_deg <= EDGE_MOST_DEG);
    // What is not refused before is measured, but for one in fifty.
    TEST_ASSERT_TRUE(counted.measured >= 0.98 * (runs - counted.refused));
}

// ---- wiring ----

unsigned exchanged(unsigned levels)
{
    return levels & 4U ? levels & 3U : levels | 4U;
}

TEST(a_fault_of_the_wiring_is_named_and_the_motor_is_measured)
{
    const struct {
        const char *why;
        std::function<unsigned(unsigned)> wires;
    } faults[] = {
        {"Hall signal 1 stays high: is its wire open?", [](unsigned l) { return l | 1U; }},
        {"Hall signal 3 stays low: is it shorted to ground, or has its sensor no supply?",
         [](unsigned l) { return l & 3U; }},
        {"Hall signals 1 and 2 are the same: are their wires shorted to each other?",
         [](unsigned l) { return (l & 3U) == 3U ? l : l & 4U; }},
        {"Hall signals 2 and 3 are the same: are their wires shorted to each other?",
         [](unsigned l) { return (l & 6U) == 6U ? l : l & 1U; }},
        {"Hall signal 3 is inverted against the other two", exchanged},
        {"Hall signal 2 does not repeat in each electrical turn",
         [turn = 0U](unsigned l) mutable { return l ^ (++turn / 137 % 2 == 0 ? 2U : 0U); }},
    };
    const nf::Config config = nf::load_scenario("s1", {}, WITH_HALLS);
    const double ohm = nf::identify::truth_of(config).resistance_ohm;
    for (const auto &fault : faults) {
        Sensors sensors(5);
        sensors.broken = fault.wires;
        std::string refusal;
        const auto result = identified(config, sensors, refusal);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("", refusal.c_str(), fault.why);
        TEST_ASSERT_FALSE_MESSAGE(result.halls.measured, fault.why);
        TEST_ASSERT_EQUAL_size_t_MESSAGE(0, result.halls.trouble.find(fault.why),
                                         result.halls.trouble.c_str());
        TEST_ASSERT_EQUAL_STRING(result.halls.trouble.c_str(), result.remarks.back().c_str());
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * ohm, ohm, result.motor.resistance_ohm);
    }
}

TEST(a_rotor_that_stops_before_it_turns_backwards_loses_nothing_else)
{
    const nf::Config config = nf::load_scenario("s1", {}, WITH_HALLS);
    const nf::Config plate = nf::known_from_plate(config);
    nf::Simulation sim(config, nf::with_typical(plate));
    bool backwards = false;
    const auto measurement = nf::identify::measure(
        sim,
        [&](const std::string &line) { backwards |= line.find("backwards") != std::string::npos; },
        [&](nf::Simulation &now) {
            if (backwards) {
                plant_block_rotor(&now.seam().plant, true);
            }
        });
    TEST_ASSERT_TRUE(backwards);
    TEST_ASSERT_EQUAL_STRING("", measurement.refusal.c_str());
    const auto result =
        nf::identify::evaluate(nf::identify::read_records(measurement.lines, "records"), plate, 25);
    TEST_ASSERT_EQUAL_STRING("the rotor has not turned backwards and forwards for the Hall sensors",
                             result.halls.trouble.c_str());
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * 0.003, 0.003, result.motor.inertia_kg_m2);
}

// ---- what was found drives the motor ----

std::string list_of(const std::vector<double> &values)
{
    std::string text;
    for (const double value : values) {
        text += fmt::format("{}{:.6g}", text.empty() ? "[" : ",", value);
    }
    return text + "]";
}

// The drive has what was found; the machine has its sensors where they are.
Lines found_sensors(const nf::identify::Result &result, const Sensors &sensors)
{
    const nf::SensorSettings &found = result.motor.sensor;
    std::vector<double> errors;
    for (std::size_t k = 0; k < found.hall_edges_deg.size(); k++) {
        const std::size_t before = (k + 5) % 6;
        const double truth = sensors.edge_deg(static_cast<unsigned>(found.hall_patterns[before]),
                                              static_cast<unsigned>(found.hall_patterns[k]));
        errors.push_back(wrapped(truth - found.hall_edges_deg[k]));
    }
    return {"sensor.kind=hall", "drive.angle_source=both",
            "sensor.hall_patterns=" + list_of(found.hall_patterns),
            "sensor.hall_edges_deg=" + list_of(found.hall_edges_deg),
            "plant.hall_error_deg=" + list_of(errors)};
}

double end_rpm(const nf::Config &config)
{
    class Speed : public nf::TickSink
    {
    public:
        void add(const nf::Tick &tick) override
        {
            rpm = tick.truth.omega_mech_rad_s * 30 / PI;
        }
        double rpm = 0;
    } speed;
    nf::RunOptions options;
    options.sink = &speed;
    const nf::RunResult result = nf::run_scenario(config, options);
    TEST_ASSERT_TRUE(result.faults.empty());
    return speed.rpm;
}

// Against a friction of half the rated torque, as with sensors whose place is known.
TEST(what_was_found_starts_an_outrunner_under_half_load)
{
    const Lines halls = {"sensor.kind=hall"};
    nf::Config config = nf::load_parts("outrunner_24v", "b_g431b_esc1", "any", {}, halls);
    for (const unsigned seed : {3U, 10U}) {
        Sensors sensors(seed);
        std::string refusal;
        const auto result = identified(config, sensors, refusal);
        TEST_ASSERT_EQUAL_STRING("", refusal.c_str());
        TEST_ASSERT_TRUE_MESSAGE(result.halls.measured, result.halls.trouble.c_str());
        for (const double angle : {0, 75, 150, 255, 330}) {
            Lines set = found_sensors(result, sensors);
            set.emplace_back("plant.coulomb_friction_nm=0.3");
            nf::Config run = nf::load_parts("outrunner_24v", "b_g431b_esc1", "any", {}, set);
            run.scenario = nf::load_scenario("s1", {}, {}).scenario;
            run.scenario.initial_angle_el_deg = angle;
            run.scenario.command = {{0.05, 2000}};
            run.scenario.load = {};
            run.scenario.duration_s = 1;
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2000, 2000, end_rpm(run));
        }
    }
}

// S4 with what was found: the same limits as with the places that are known.
TEST(what_was_found_holds_speed_and_current_of_s4)
{
    constexpr double RATED_A = 4.2;
    for (const unsigned seed : {1U, 8U}) {
        Sensors sensors(seed);
        std::string refusal;
        const auto result = identified(nf::load_scenario("s4", {}, WITH_HALLS), sensors, refusal);
        TEST_ASSERT_EQUAL_STRING("", refusal.c_str());
        TEST_ASSERT_TRUE_MESSAGE(result.halls.measured, result.halls.trouble.c_str());
        Lines set = found_sensors(result, sensors);
        set.emplace_back("startup.current_pct=50");
        const nf::RunResult run = nf::run_scenario(nf::load_scenario("s4", {}, set));
        TEST_ASSERT_TRUE(run.faults.empty());
        TEST_ASSERT_TRUE(nf::figure(run, "speed_error_max_pct").value() <= 2);
        TEST_ASSERT_TRUE(nf::figure(run, "id_settled_a").value() <= 0.03 * RATED_A);
    }
}

} // namespace
