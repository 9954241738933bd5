// SPDX-License-Identifier: MIT
// The safe state in whole runs: what the bus and the windings bear when the gates open or the motor
// is shorted, from any point of operation; each fault at speeds at which open gates would
// overcharge the bus.
#include "config.h"
#include "injection.h"
#include "machine.h"
#include "modulator_units.h"
#include "numbers.h"
#include "per_unit.h"
#include "safe_state_units.h"
#include "sim.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using Words = std::vector<std::string>;

constexpr double ROOT_3 = 1.7320508075688772;

struct Machine {
    const char *motor;
    const char *board;
    const char *tuning;
    Words set;
    double load_rpm; // highest speed to which a load takes it: its EMF is above the bus's limit
};
const Machine COMPRESSOR = {"compressor",
                            "compressor_310v",
                            "any",
                            {"plant.bus_capacitance_f=680e-6", "plant.bus_source_resistance_ohm=1"},
                            8000};
const Machine MOTOR_A = {"motor_a_weakened",
                         "bench_310v_short",
                         "robust_motor_a",
                         {"plant.bus_capacitance_f=1e-3", "plant.bus_source_resistance_ohm=1"},
                         3000};

nf::Config configured(const Machine &machine, const Words &more = {})
{
    Words set = machine.set;
    set.insert(set.end(), more.begin(), more.end());
    return nf::load_parts(machine.motor, machine.board, machine.tuning, {}, set);
}

double rpm_of(const nf::Config &config, double speed_el)
{
    return speed_el / config.motor.pole_pairs / nf::rad_s_from_rpm(1);
}

// ---- the plant alone: the formulas

constexpr double STILL_INERTIA = 1e3; // the speed stays

double uniform(std::mt19937 &random, double low, double high)
{
    return std::uniform_real_distribution<double>(low, high)(random);
}

struct Vector {
    double amplitude;
    double angle;
};

// Any current of up to this amplitude, each as likely as another.
Vector any_vector(std::mt19937 &random, double most, double from = -nf::PI, double to = nf::PI)
{
    const double angle = uniform(random, from, to);
    return {most * std::sqrt(uniform(random, 0, 1)), angle};
}

// A machine that turns, with this current in its windings and this voltage on its bus.
plant_t machine_at(const nf::Config &config, double speed_el, const Vector &current, double bus_v)
{
    const double i_d = current.amplitude * std::cos(current.angle);
    const double i_q = current.amplitude * std::sin(current.angle);
    const drive_cfg_t cfg =
        nf::make_drive_cfg(config.motor, config.board, config.tuning, config.model);
    plant_cfg_t plant_cfg = nf::make_plant_cfg(config, cfg);
    plant_cfg.motor.inertia_kg_m2 = STILL_INERTIA;
    plant_cfg.motor.initial_speed_mech_rad_s = speed_el / config.motor.pole_pairs;
    plant_cfg.supply.voltage_v = bus_v;
    plant_cfg.trip_a = 0;
    plant_t plant;
    const char *bad = nullptr;
    TEST_ASSERT_TRUE_MESSAGE(plant_init(&plant, &plant_cfg, &bad), bad);
    plant.motor.now.flux_d_wb = config.motor.flux_linkage_wb + config.motor.inductance_d_h * i_d;
    plant.motor.now.flux_q_wb = config.motor.inductance_q_h * i_q;
    return plant;
}

double amplitude_a(const plant_t &plant)
{
    return std::hypot(plant_motor_i_d(&plant.motor), plant_motor_i_q(&plant.motor));
}

struct Peak {
    double bus_v = 0;
    double current_a = 0;
};

Peak peak_of(plant_t plant, bool shorted, double time_s)
{
    Peak peak;
    plant_set_gates(&plant, shorted); // all compare values are 0
    const long periods = std::lround(time_s / plant.inverter.period_s);
    for (long k = 0; k < periods; k++) {
        plant_step(&plant);
        peak.bus_v = std::max(peak.bus_v, plant.bus_v);
        peak.current_a = std::max(peak.current_a, amplitude_a(plant));
    }
    return peak;
}

const int POINTS = static_cast<int>(testing_runs(80, 400));
constexpr double OPEN_TIME_S = 0.2;  // 40 electrical turns: the bus has settled
constexpr double SHORT_TIME_S = 0.1; // 5 of L/R
// The bound is for the worst angle of all, at which the EMF of two phases stands still. It does
// not, so some room is left, but not so much that the formula would be of no use.
constexpr double BUS_SHARE_LEAST = 0.75;

// Whatever current flows, and whatever the bus between its lowest and its nominal voltage.
TEST(test_up_to_the_safe_speed_open_gates_leave_the_bus_within_its_limit)
{
    for (const char *capacitance : {"150e-6", "680e-6", "2e-3"}) {
        const nf::Config config =
            configured(COMPRESSOR, {fmt::format("plant.bus_capacitance_f={}", capacitance),
                                    fmt::format("board.bus_capacitance_f={}", capacitance)});
        const double safe = nf::safe_open_speed(config.motor, config.board);
        std::mt19937 random(1);
        double highest_v = 0;
        for (int k = 0; k < POINTS; k++) {
            const Vector current = any_vector(random, config.board.overcurrent_a);
            const double bus_v =
                k % 2 == 0 ? config.board.bus_min_v
                           : uniform(random, config.board.bus_min_v, config.board.bus_nominal_v);
            const plant_t plant = machine_at(config, safe, current, bus_v);
            highest_v = std::max(highest_v, peak_of(plant, false, OPEN_TIME_S).bus_v);
        }
        fmt::print("{} F: safe up to {:.0f} rpm, EMF {:.1f} V, highest bus {:.1f} V of {:g} V\n",
                   capacitance, rpm_of(config, safe), ROOT_3 * safe * config.motor.flux_linkage_wb,
                   highest_v, nf::acting_bus_limit(config.board));
        TEST_ASSERT_TRUE(highest_v <= nf::acting_bus_limit(config.board));
        TEST_ASSERT_TRUE(highest_v >= BUS_SHARE_LEAST * config.board.bus_max_v);
    }
}

// What a break does at the highest speed of a motor that weakens its field: the bound of
// docs/protection.md.
TEST(test_a_break_charges_the_bus_to_the_emf_and_its_overshoot)
{
    const nf::Config config = configured(COMPRESSOR);
    const double speed = nf::rad_s_from_rpm(COMPRESSOR.load_rpm) * config.motor.pole_pairs;
    const double emf = ROOT_3 * speed * config.motor.flux_linkage_wb;
    for (const double bus_v : {config.board.bus_nominal_v, config.board.bus_min_v}) {
        double highest_v = 0;
        for (int k = 0; k < POINTS; k++) {
            const Vector current = {k % 4 * config.board.overcurrent_a / 3,
                                    nf::TWO_PI * k / POINTS};
            const plant_t plant = machine_at(config, speed, current, bus_v);
            highest_v = std::max(highest_v, peak_of(plant, false, OPEN_TIME_S).bus_v);
        }
        fmt::print("break at {:.0f} rpm from {:.0f} V: EMF {:.1f} V, highest bus {:.1f} V\n",
                   COMPRESSOR.load_rpm, bus_v, emf, highest_v);
        TEST_ASSERT_TRUE(highest_v > config.board.bus_max_v);
        TEST_ASSERT_TRUE(highest_v <= 2 * emf - bus_v);
    }
}

// The peak is computed for the largest flux that a point of operation has, at the lowest speed, and
// the slowest decay, at the highest one.
constexpr double PEAK_SHARE_LEAST = 0.75;

TEST(test_the_peak_of_the_short_circuit_current_is_within_the_computed_one)
{
    const nf::Config config = configured(COMPRESSOR);
    const double safe = nf::safe_open_speed(config.motor, config.board);
    const double fastest = nf::rad_s_from_rpm(COMPRESSOR.load_rpm) * config.motor.pole_pairs;
    const double bound = nf::short_circuit_peak(config.motor, config.board, fastest);
    std::mt19937 random(1);
    double highest_a = 0;
    for (int k = 0; k < POINTS; k++) {
        // A point of operation: no current along the magnets, and the flux that the voltage can
        // turn.
        const Vector current =
            any_vector(random, config.motor.max_current_a, nf::PI / 2, 3 * nf::PI / 2);
        const double speed = uniform(random, safe, fastest);
        const plant_t plant = machine_at(config, speed, current, config.board.bus_nominal_v);
        const double flux = std::hypot(plant.motor.now.flux_d_wb, plant.motor.now.flux_q_wb);
        if (speed * flux <= nf::largest_ratio(config.board) * config.board.bus_max_v) {
            highest_a = std::max(highest_a, peak_of(plant, true, SHORT_TIME_S).current_a);
        }
    }
    fmt::print("short circuit: highest {:.1f} A, computed {:.1f} A, in the end {:.2f} A\n",
               highest_a, bound, nf::short_circuit_current(config.motor, fastest));
    TEST_ASSERT_TRUE(highest_a <= bound);
    TEST_ASSERT_TRUE(highest_a >= PEAK_SHARE_LEAST * bound);
}

constexpr double STEADY_TOLERANCE =
    0.002; // the plant's integration, and what has not decayed after 0.5 s

TEST(test_the_short_circuit_current_in_the_end_is_the_computed_one)
{
    const nf::Config config = configured(COMPRESSOR);
    for (const double rpm : {200.0, 1000.0, 4000.0, COMPRESSOR.load_rpm}) {
        const double speed = nf::rad_s_from_rpm(rpm) * config.motor.pole_pairs;
        plant_t plant = machine_at(config, speed, {}, config.board.bus_nominal_v);
        plant_set_gates(&plant, true);
        for (int k = 0; k < 5000; k++) {
            plant_step(&plant);
        }
        const double computed = nf::short_circuit_current(config.motor, speed);
        TEST_ASSERT_DOUBLE_WITHIN(STEADY_TOLERANCE * computed, computed, amplitude_a(plant));
    }
}

// ---- the drive

using Fault = nf::FaultKind;

struct Strike {
    const char *name;
    std::vector<nf::FaultEntry> entries; // none: a stop, unless the observer is lost
    bool loses_observer = false;         // the estimate is half a turn off, and says standstill
    bool blinds = false;                 // no current tells how fast the rotor is, only the bus
};

nf::FaultEntry lasting(Fault kind, std::optional<double> value = {})
{
    return {0, kind, nf::FaultSpan::lasting, value, {}};
}

nf::FaultEntry once(Fault kind, std::optional<double> value = {})
{
    return {0, kind, nf::FaultSpan::tick, value, {}};
}

Strike blinding(const char *name, Fault a, Fault b)
{
    return {name, {lasting(a), lasting(b)}, false, true};
}

const Strike BLIND = blinding("adc_a_stuck, adc_b_high", Fault::adc_a_stuck, Fault::adc_b_high);

// What may go wrong in RUN, and a stop. Not here, see docs/protection.md: a bus sensor that stands
// still, as nothing else in the drive sees the bus; a supply beyond bus_max_v; a configuration that
// is corrupt, which may be that of the safe state; angle sensors.
std::vector<Strike> strikes_of(const nf::BoardSettings &board)
{
    return {
        {"stop", {}},
        {"overcurrent", {once(Fault::overcurrent, 1.1 * board.overcurrent_a)}},
        {"adc_a_high", {lasting(Fault::adc_a_high)}},
        {"adc_a_low", {lasting(Fault::adc_a_low)}},
        {"adc_b_high", {lasting(Fault::adc_b_high)}},
        {"adc_b_low", {lasting(Fault::adc_b_low)}},
        {"adc_a_stuck", {lasting(Fault::adc_a_stuck)}},
        {"adc_b_stuck", {lasting(Fault::adc_b_stuck)}},
        BLIND,
        blinding("adc_a_high, adc_b_low", Fault::adc_a_high, Fault::adc_b_low),
        {"adc_bus high", {once(Fault::adc_bus_stuck, board.bus_max_v + 10)}},
        {"adc_bus low", {once(Fault::adc_bus_stuck, board.bus_min_v - 30)}},
        {"supply low", {lasting(Fault::bus_voltage, board.bus_min_v - 30)}},
        {"temperature", {lasting(Fault::temperature, 110)}},
        {"phase_a_open", {lasting(Fault::phase_a_open)}},
        {"phase_b_open", {lasting(Fault::phase_b_open)}},
        {"phase_c_open", {lasting(Fault::phase_c_open)}},
        {"late_isr", {lasting(Fault::late_isr)}},
        {"observer lost", {}, true},
        {"rotor_jump", {{0, Fault::rotor_jump, nf::FaultSpan::instant, 150, {}}}},
        {"rotor_blocked", {lasting(Fault::rotor_blocked)}},
        {"break_input", {once(Fault::break_input)}},
    };
}

// Of the speed up to which opening is safe: rounding of the drive's numbers.
constexpr double FAST = 1.001;

// A load that holds a speed whatever the motor does: twice the largest torque, and so stiff that an
// excess decays in 3 ms.
constexpr double LOAD_SHARE = 2;
constexpr double LOAD_TIME_S = 3e-3;

double largest_torque_nm(const nf::MotorSettings &motor)
{
    return 1.5 * motor.pole_pairs * motor.flux_linkage_wb * motor.max_current_a;
}

// Of the speed up to which opening is safe: where the gates open below 3/4 of its change of the
// current, and slower, where the current is still as large.
constexpr double DWELLS[] = {0.6, 0.3, 0.16, 0.1};

constexpr int BUS_SLACK = 16; // two steps of a converter of 12 bits, in Q15: noise and rounding

class Ride
{
public:
    explicit Ride(const Machine &machine, const Words &more = {})
        : config(configured(machine, more)), sim(config),
          injection(config, sim.bases().control_period_s, 0),
          safe_rad_s(nf::safe_open_speed(config.motor, config.board) / config.motor.pole_pairs)
    {
    }

    void tick()
    {
        (void)injection.act(now, sim);
        if (held_rpm) {
            const double excess = speed() - nf::rad_s_from_rpm(*held_rpm);
            const double most = LOAD_SHARE * largest_torque_nm(config.motor);
            sim.set_load_nm(
                std::clamp(config.motor.inertia_kg_m2 / LOAD_TIME_S * excess, -most, most));
        }
        sim.control();
        watch();
        sim.advance();
        now++;
    }
    void seconds(double time_s)
    {
        const long ticks = std::lround(time_s / sim.bases().control_period_s);
        for (long k = 0; k < ticks; k++) {
            tick();
        }
    }
    // The drive brings the motor there by itself.
    void run_at(double rpm)
    {
        sim.command_speed_rpm(rpm);
        for (int k = 0; k < 200000 && std::abs(speed() - nf::rad_s_from_rpm(rpm)) >
                                          0.01 * nf::rad_s_from_rpm(rpm);
             k++) {
            if (sim.drive().state == DRIVE_STATE_READY) {
                sim.request(DRIVE_REQUEST_RUN);
            }
            tick();
        }
        seconds(0.1);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, sim.drive().state);
        peak = {};
    }
    void strike(const Strike &what)
    {
        struck = now;
        for (const nf::FaultEntry &entry : what.entries) {
            injection.begin(entry, now);
        }
        if (what.loses_observer) {
            drive_t &drive = sim.seam().drive;
            rotor_position_step(&drive.rotor.position, INT32_MIN); // half a turn
            drive.rotor.observer.speed = 0;
        } else if (what.entries.empty()) {
            sim.request(0);
        }
    }
    // Whatever still drives is stopped; the load goes with the rotor to a speed and stays there. It
    // dwells where the rotor is slow enough for open gates, goes up in between, and lets it come to
    // rest. At last the bus is discharged.
    void outlive(double rpm)
    {
        held_rpm = rpm;
        seconds(0.4);
        sim.request(0);
        seconds(0.2);
        for (const double share : DWELLS) {
            held_rpm = share * safe_rad_s / nf::rad_s_from_rpm(1);
            seconds(0.2);
            held_rpm = rpm;
            seconds(0.1);
        }
        held_rpm = 0;
        seconds(0.8);
        // At rest only a high bus keeps the motor shorted.
        TEST_ASSERT_TRUE(!sim.out().gate_enable ||
                         sim.plant().bus_v > sim.bases().voltage_v / 32768 *
                                                 (sim.cfg().protection.bus_max - BUS_SLACK));
        sim.seam().plant.bus_v = config.board.bus_nominal_v;
        seconds(0.1);
    }

    double speed() const
    {
        return sim.plant().motor.now.omega_el_rad_s / config.motor.pole_pairs;
    }
    bool drives() const
    {
        return drive_is_driving(sim.drive().state);
    }
    bool is_broken() const
    {
        return sim.drive().safe_state.phase == SAFE_STATE_BROKEN;
    }

    nf::Config config;
    nf::Simulation sim;
    nf::Injection injection;
    double safe_rad_s;
    int64_t now = 0;
    std::optional<double> held_rpm;
    Peak peak;
    bool was_short = false;
    int openings = 0;               // behind a short circuit
    std::optional<double> driven_s; // from the strike until the drive had found it, or was stopped
    // In the tick that ended driving, and the drive knew the rotor to be fast.
    bool opened_fast = false;
    double opened_rad_s = 0; // fastest at which the gates opened behind a short circuit

private:
    double believed_rad_s() const
    {
        return nf::rad_s_from_rpm(
            std::abs(sim.bases().rpm_from_step(sim.drive().rotor.observer.speed)));
    }
    void watch()
    {
        const drive_out_t &out = sim.out();
        const bool is_short = !drives() && out.gate_enable;
        if (is_short) {
            for (const uint16_t compare : out.compare.phase) {
                TEST_ASSERT_EQUAL_UINT16(0, compare);
            }
        }
        opened_fast |= drove_ && !drives() && !is_short && !is_broken() &&
                       believed_rad_s() > FAST * safe_rad_s;
        drove_ = drives();
        if (!driven_s && struck > 0 && !drives()) {
            driven_s = static_cast<double>(now - struck) * sim.bases().control_period_s;
        }
        if (short_ && !is_short && !drives() && !is_broken()) {
            openings++;
            opened_rad_s = std::max(opened_rad_s, std::abs(speed()));
        }
        was_short |= is_short;
        short_ = is_short;
        peak.bus_v = std::max(peak.bus_v, sim.plant().bus_v);
        double current[PLANT_LEGS];
        plant_phases(plant_motor_current(&sim.plant().motor), current);
        for (const double a : current) {
            peak.current_a = std::max(peak.current_a, std::abs(a));
        }
    }

    int64_t struck = 0;
    bool short_ = false;
    bool drove_ = false; // in the tick before
};

// A break opens the gates at any speed: the bus goes to the EMF and, as an undamped circuit, as far
// beyond.
double broken_bus_v(const nf::Config &config, double rpm)
{
    const double emf =
        ROOT_3 * nf::rad_s_from_rpm(rpm) * config.motor.pole_pairs * config.motor.flux_linkage_wb;
    return std::max(config.board.bus_max_v, 2 * emf - config.board.bus_min_v);
}

// The comparators open the gates at their current, unless the drive's own control was lost before
// and they have. Then the windings keep their flux while the rotor turns on, which may turn the
// magnets' against it.
double current_limit_a(const Ride &ride)
{
    const nf::MotorSettings &motor = ride.config.motor;
    const double trip_a = ride.config.board.trip_a;
    return ride.is_broken()
               ? (2 * motor.flux_linkage_wb + motor.inductance_q_h * trip_a) / motor.inductance_d_h
               : trip_a;
}

// The short circuit of the stop or the fault ends once. One that a high bus begins ends only as the
// bus is discharged.
constexpr int OPENINGS_MOST = 2;

void assert_survived(const Machine &machine, const Ride &ride, const Strike &strike,
                     const std::string &what)
{
    const double limit = ride.is_broken() ? broken_bus_v(ride.config, machine.load_rpm)
                                          : ride.config.board.bus_max_v;
    TEST_ASSERT_TRUE_MESSAGE(ride.peak.bus_v <= limit, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(ride.peak.current_a <= current_limit_a(ride), what.c_str());
    TEST_ASSERT_FALSE_MESSAGE(ride.opened_fast, what.c_str());
    TEST_ASSERT_FALSE_MESSAGE(ride.sim.out().gate_enable, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(ride.openings <= OPENINGS_MOST, what.c_str());
    if (!strike.blinds) {
        TEST_ASSERT_TRUE_MESSAGE(ride.opened_rad_s <= ride.safe_rad_s, what.c_str());
    }
}

std::string told(const Ride &ride, const Strike &strike, double rpm, double load_rpm)
{
    return fmt::format("{} at {:.0f} rpm, load to {:.0f} rpm: fault {}, {}, bus {:.1f} V, phase "
                       "{:.1f} A, opened {} times, at {:.0f} rpm at most, found after {:.1f} ms",
                       strike.name, rpm, load_rpm, static_cast<int>(ride.sim.drive().fault.id),
                       ride.is_broken() ? "broken" : (ride.was_short ? "shorted" : "open"),
                       ride.peak.bus_v, ride.peak.current_a, ride.openings,
                       ride.opened_rad_s / nf::rad_s_from_rpm(1),
                       1e3 * ride.driven_s.value_or(NAN));
}

// Base speed, 1.3 of it, right above the speed up to which opening is safe, and the highest.
std::vector<double> speeds_of(const nf::Config &config)
{
    const nf::MotorSettings &motor = config.motor;
    const double safe_rpm = rpm_of(config, nf::safe_open_speed(motor, config.board));
    return {motor.rated_speed_rpm, 1.3 * motor.rated_speed_rpm,
            std::min(1.02 * safe_rpm, motor.max_speed_rpm), motor.max_speed_rpm};
}

// The ride, the strike in it at its speed, and what the load does then.
void survive(const Machine &machine, Ride &ride, const Strike &strike, double rpm, double load_rpm)
{
    ride.strike(strike);
    ride.outlive(load_rpm);
    const std::string what = told(ride, strike, rpm, load_rpm);
    fmt::print("{}: {}\n", machine.motor, what);
    assert_survived(machine, ride, strike, what);
}

TEST(test_no_fault_at_any_speed_overcharges_the_bus_or_exceeds_the_trip_current)
{
    // No divisor of the speeds and loads: each strike, speed and load is there.
    const unsigned step = testing_has_many_runs() ? 1 : 3;
    for (const Machine &machine : {COMPRESSOR, MOTOR_A}) {
        const nf::Config config = configured(machine);
        unsigned at = 0;
        for (const Strike &strike : strikes_of(config.board)) {
            for (const double rpm : speeds_of(config)) {
                for (const double load_rpm : {rpm, machine.load_rpm}) {
                    if (at++ % step == 0) {
                        Ride ride(machine);
                        ride.run_at(rpm);
                        survive(machine, ride, strike, rpm, load_rpm);
                    }
                }
            }
        }
    }
}

// Rounded down; OVERSPEED is at 1.15 of the highest speed.
double highest_open_rpm()
{
    const nf::Config config = configured(COMPRESSOR, {"board.bus_capacitance_f=0"});
    const double safe = nf::safe_open_speed(config.motor, config.board);
    return std::floor(rpm_of(config, safe) / nf::OVERSPEED_SHARE);
}

// The same load without the short circuit, and the highest speed that the drive is given then: what
// the load does beyond it overcharges the bus.
TEST(test_with_open_gates_the_same_load_overcharges_the_bus)
{
    Ride ride(COMPRESSOR, {"board.safe_state=open", "board.bus_capacitance_f=0",
                           fmt::format("motor.max_speed_rpm={:.0f}", highest_open_rpm())});
    ride.run_at(ride.config.motor.max_speed_rpm);
    ride.strike({"stop", {}});
    ride.outlive(COMPRESSOR.load_rpm);
    fmt::print("open: bus {:.1f} V\n", ride.peak.bus_v);
    TEST_ASSERT_TRUE(ride.peak.bus_v > ride.config.board.bus_max_v);
}

// There the drive acts closest to what the bus bears.
TEST(test_with_a_large_capacitor_dead_sensors_do_not_overcharge_it_either)
{
    for (const Machine &machine : {COMPRESSOR, MOTOR_A}) {
        for (const char *capacitance : {"2e-3", "5e-3"}) {
            Ride ride(machine, {fmt::format("plant.bus_capacitance_f={}", capacitance),
                                fmt::format("board.bus_capacitance_f={}", capacitance)});
            const double rpm = ride.config.motor.max_speed_rpm;
            ride.run_at(rpm);
            survive(machine, ride, BLIND, rpm, machine.load_rpm);
        }
    }
}

// Nothing else in the drive sees the bus: what the board then needs is in docs/protection.md.
TEST(test_a_bus_sensor_that_stands_still_lets_a_brake_overcharge_the_bus)
{
    for (const Machine &machine : {COMPRESSOR, MOTOR_A}) {
        Ride ride(machine);
        ride.run_at(ride.config.motor.max_speed_rpm);
        ride.strike({"adc_bus_stuck", {lasting(Fault::adc_bus_stuck)}});
        ride.sim.command_speed_rpm(0);
        ride.seconds(1);
        fmt::print("{}: bus sensor stands still, braked from {:.0f} rpm: bus {:.1f} V\n",
                   machine.motor, ride.config.motor.max_speed_rpm, ride.peak.bus_v);
        TEST_ASSERT_TRUE(ride.peak.bus_v > ride.config.board.bus_max_v);
    }
}

// At random instants of the ramp, with random loads.
TEST(test_random_faults_are_survived)
{
    const unsigned strikes_of_each = testing_runs(20, 250);
    std::mt19937 random(7);
    for (unsigned k = 0; k < 2 * strikes_of_each; k++) {
        const Machine &machine = k % 2 == 0 ? COMPRESSOR : MOTOR_A;
        Ride ride(machine);
        const std::vector<Strike> strikes = strikes_of(ride.config.board);
        const Strike &strike = strikes[random() % strikes.size()];
        const double rpm = uniform(random, 0.3, 1) * ride.config.motor.max_speed_rpm;
        const double load_rpm = uniform(random, 0.5 * rpm, machine.load_rpm);
        ride.run_at(rpm);
        ride.held_rpm = rpm;
        ride.seconds(uniform(random, 0, 0.02));
        survive(machine, ride, strike, rpm, load_rpm);
    }
}

} // namespace
