// SPDX-License-Identifier: MIT
// Every key of motor, board and tuning, changed while the motor turns under load: effective at one
// tick, without a fault and without a dip of the speed; or refused by the name of a setting for
// which the drive has to be at rest.
#include "config.h"
#include "identity.h"
#include "numbers.h"
#include "per_unit.h"
#include "schema.h"
#include "sim.h"

extern "C" {
#include "config_change.h"
#include "config_guard.h"
#include "drive_words.h"
}

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

constexpr double CHANGE = 1.05; // of a number; a whole one changes by 1
constexpr int PATIENCE_TICKS = 60000;
constexpr int SETTLE_TICKS = 10000;
constexpr int LOADED_TICKS = 8000;
constexpr int WATCHED_TICKS = 3000; // after a change: 2 to 5 time constants of the speed loops here
constexpr double SPEED_SHARE = 0.6; // of rated speed
constexpr double LOAD_SHARE = 0.5;  // of rated torque

// What the speed may be off its command, as a share of it. A motor that is believed to be 5 %
// another one has another EMF, from which the estimate is made, until the correction of the flux
// has found it: no more than these 5 %. What else changes by 5 % gives no torque of its own: half
// of a percent is two of the estimate's ripple.
constexpr double MODEL_ERROR = CHANGE - 1;
constexpr double OTHER_ERROR = 0.005;

struct Machine {
    const char *motor;
    const char *board;
    const char *tuning;
};

const Machine MOTOR_A = {"motor_a", "bench_310v", "robust_motor_a"};
const Machine SERVO = {"teknic_m2310p", "frdm_mc_lvpmsm", "any"};
const Machine VOLTAGE = {"motor_a", "bench_310v", "voltage_phase"};

const std::set<std::string> TABLES = {"motor",         "board",        "tuning",
                                      "drive",         "observer",     "startup",
                                      "adaptation",    "current_loop", "speed_loop",
                                      "position_loop", "voltage_loop", "phase_compensator",
                                      "supervision",   "model"};

// As a file says it whose rules have all been followed: each key alone changes what it is for.
nf::Config load(const Machine &machine)
{
    nf::Config config = nf::load_parts(machine.motor, machine.board, machine.tuning, {}, {});
    config.tuning = nf::settled_tuning(config.motor, config.board, config.tuning, config.model);
    return config;
}

// Where it stays within the key's range.
template <typename Number> bool set_within(const nf::Field &field, Number *place, Number value)
{
    const bool is_within = value >= field.min && value <= field.max;
    *place = is_within ? value : *place;
    return is_within;
}

// False where the key has no number, or no other one.
bool alter(nf::Config &config, const nf::Field &field, double factor)
{
    const nf::Target target = field.target(config);
    if (auto *const *real = std::get_if<double *>(&target)) {
        return **real > 0 && set_within(field, *real, **real * factor);
    }
    if (auto *const *whole = std::get_if<int *>(&target)) {
        return set_within(field, *whole, **whole + (factor > 1 ? 1 : -1));
    }
    return false;
}

struct Changed {
    std::string key;
    drive_cfg_t cfg;
    bool other_board; // the image does not take its block: the scales of the board are no settings
};

// The configurations that one key makes, where it makes one that the firmware takes and that
// differs.
std::vector<Changed> changed_by_a_key(const nf::Config &config)
{
    const drive_cfg_t as_it_is = nf::build(config);
    std::vector<Changed> found;
    for (const nf::Field &field : nf::schema()) {
        nf::Config copy = config;
        if (TABLES.count(field.section) == 0) {
            continue;
        }
        for (const double factor : {CHANGE, 1 / CHANGE}) {
            copy = config;
            if (!alter(copy, field, factor)) {
                continue;
            }
            try {
                const drive_cfg_t cfg = nf::build(copy);
                if (cfg.crc != as_it_is.crc) {
                    const bool other_board =
                        nf::identity_of(copy).board != nf::identity_of(config).board;
                    found.push_back(
                        {fmt::format("{} times {:.3f}", field.name(), factor), cfg, other_board});
                }
            } catch (const nf::ConfigError &) {
                continue; // beyond a limit of another key
            }
        }
    }
    return found;
}

// In RUN at a speed and under load.
class Loaded
{
public:
    explicit Loaded(const nf::Config &config)
        : sim(config), command_rpm_(SPEED_SHARE * config.motor.rated_speed_rpm)
    {
        sim.command_speed_rpm(command_rpm_);
        for (int k = 0; k < PATIENCE_TICKS && sim.drive().state != DRIVE_STATE_RUN; k++) {
            if (sim.drive().state == DRIVE_STATE_READY) {
                sim.request(DRIVE_REQUEST_RUN);
            }
            tick();
        }
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, sim.drive().state);
        ticks(SETTLE_TICKS);
        sim.set_load_nm(LOAD_SHARE * config.motor.rated_torque_nm);
        ticks(LOADED_TICKS);
        watch(OTHER_ERROR, "before any change");
    }

    void tick()
    {
        sim.control();
        sim.advance();
    }
    void ticks(int count)
    {
        for (int k = 0; k < count; k++) {
            tick();
        }
    }

    // In RUN, and at its speed within a share of it.
    void watch(double most, const std::string &what)
    {
        double share = 0;
        for (int k = 0; k < WATCHED_TICKS; k++) {
            tick();
            plant_view_t truth;
            plant_view(&sim.plant(), &truth);
            const double rpm = truth.omega_mech_rad_s / nf::rad_s_from_rpm(1);
            share = std::max(share, std::abs(rpm / command_rpm_ - 1));
        }
        worst = std::max(worst, share);
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_NONE, sim.drive().fault.id, what.c_str());
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_STATE_RUN, sim.drive().state, what.c_str());
        TEST_ASSERT_TRUE_MESSAGE(share < most,
                                 fmt::format("{}: {:.5f} of the speed off", what, share).c_str());
    }

    // Posts a configuration and counts the ticks in which another one came into force.
    int change(const drive_cfg_t &cfg)
    {
        int changes = 0;
        app_change(&sim.app(), &cfg);
        for (uint32_t k = 0; k < sim.drive().cfg->slow_ticks; k++) {
            const drive_cfg_t *const before = sim.drive().cfg;
            tick();
            changes += sim.drive().cfg != before ? 1 : 0;
        }
        TEST_ASSERT_FALSE(app_changes(&sim.app()));
        return changes;
    }

    nf::Simulation sim;
    double worst = 0;

private:
    double command_rpm_;
};

// What the drive believes of the motor.
bool is_of_motor(const std::string &key)
{
    return key.rfind("motor.", 0) == 0 || key.rfind("model.", 0) == 0;
}

struct Outcome {
    std::set<std::string> taken;
    std::map<std::string, std::string> refused; // by this setting
};

// The setting for which a change is refused, or "board"; else "".
std::string refused_by(const drive_cfg_t &from, const Changed &to)
{
    const char *const setting = config_change_refused(&from, &to.cfg);
    return to.other_board ? "board" : setting != nullptr ? setting : "";
}

// Each change for a while, then the configuration of before for a while.
Outcome change_one_by_one(const Machine &machine)
{
    const nf::Config config = load(machine);
    const drive_cfg_t as_it_is = nf::build(config);
    const std::vector<Changed> all = changed_by_a_key(config);
    Loaded run(config);
    Outcome outcome;
    const auto key_of = [](const std::string &text) { return text.substr(0, text.find(' ')); };
    for (const Changed &changed : all) {
        const std::string refused = refused_by(as_it_is, changed);
        if (!refused.empty()) {
            outcome.refused.emplace(key_of(changed.key), refused);
            continue;
        }
        const double most = is_of_motor(changed.key) ? MODEL_ERROR : OTHER_ERROR;
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, run.change(changed.cfg), changed.key.c_str());
        run.watch(most, changed.key);
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, run.change(as_it_is), changed.key.c_str());
        run.watch(most, changed.key + " and back");
        outcome.taken.insert(key_of(changed.key));
    }
    fmt::print("{}: {} keys taken, {} refused, at most {:.2f} % of the speed off\n", machine.motor,
               outcome.taken.size(), outcome.refused.size(), 100 * run.worst);
    for (const auto &[key, setting] : outcome.refused) {
        fmt::print("    {} by {}\n", key, setting);
    }
    return outcome;
}

void expect_taken(const Outcome &outcome, const std::vector<std::string> &keys)
{
    for (const std::string &key : keys) {
        TEST_ASSERT_EQUAL_size_t_MESSAGE(1, outcome.taken.count(key), key.c_str());
    }
}

void expect_refused(const Outcome &outcome, const std::map<std::string, std::string> &keys)
{
    for (const auto &[key, setting] : keys) {
        const auto found = outcome.refused.find(key);
        TEST_ASSERT_TRUE_MESSAGE(found != outcome.refused.end(), key.c_str());
        TEST_ASSERT_EQUAL_STRING_MESSAGE(setting.c_str(), found->second.c_str(), key.c_str());
    }
}

const std::vector<std::string> GAINS_AND_LIMITS = {
    "observer.kappa",          "observer.kappa_p",      "current_loop.bandwidth_hz",
    "speed_loop.bandwidth_hz", "speed_loop.ramp_rpm_s", "position_loop.bandwidth_hz",
    "motor.resistance_ohm",    "motor.flux_linkage_wb", "motor.inertia_kg_m2",
    "motor.max_current_a",     "board.overcurrent_a",   "board.bus_max_v",
    "adaptation.flux_pct"};

const std::map<std::string, std::string> BASES = {
    {"motor.max_speed_rpm", "observer.speed_limit"},
    {"motor.pole_pairs", "observer.speed_limit"},
    {"board.current_full_scale_a", "board"},
    {"board.adc_bits", "board"},
    {"board.timer_clock_hz", "modulator.timer_counts"},
    {"speed_loop.slow_ticks", "slow_ticks"}};

TEST(motor_a_takes_every_key_that_may_change_in_run)
{
    const Outcome outcome = change_one_by_one(MOTOR_A);
    expect_taken(outcome, GAINS_AND_LIMITS);
    expect_taken(outcome, {"motor.continuous_current_a", "startup.current_pct"});
    expect_refused(outcome, BASES);
}

TEST(a_servo_takes_every_key_that_may_change_in_run)
{
    const Outcome outcome = change_one_by_one(SERVO);
    expect_taken(outcome, GAINS_AND_LIMITS);
}

TEST(a_voltage_drive_takes_its_own_keys)
{
    const Outcome outcome = change_one_by_one(VOLTAGE);
    expect_taken(outcome, {"voltage_loop.kp_v_s_per_rad", "phase_compensator.gain"});
}

// Up to the tick that takes it a change is not there; the tick is one that reads the slow inputs.
TEST(until_its_tick_a_change_does_nothing)
{
    const nf::Config config = load(MOTOR_A);
    drive_cfg_t faster = nf::build(config);
    Loaded with(config);
    Loaded without(config);
    faster.current_loop.pi_q.kp = faster.current_loop.pi_q.kp / 2;
    faster.crc = config_guard_crc(&faster);
    app_change(&with.sim.app(), &faster);
    while (app_changes(&with.sim.app())) {
        TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&without.sim.drive()),
                                drive_words_hash(&with.sim.drive()));
        with.tick();
        without.tick();
    }
    TEST_ASSERT_TRUE(drive_has_read_slow_inputs(&with.sim.drive()));
    TEST_ASSERT_TRUE(drive_words_hash(&without.sim.drive()) != drive_words_hash(&with.sim.drive()));
}

// The inputs of a run, and between them what changed: a drive without a motor repeats it.
TEST(a_replay_with_the_same_changes_ends_in_the_same_state)
{
    const nf::Config config = load(SERVO);
    const drive_cfg_t as_it_is = nf::build(config);
    const std::vector<Changed> all = changed_by_a_key(config);
    Loaded run(config);
    drive_t replayed = run.sim.drive();
    drive_out_t out = run.sim.out();
    std::size_t changes = 0;
    for (const Changed &changed : all) {
        if (!refused_by(as_it_is, changed).empty()) {
            continue;
        }
        app_change(&run.sim.app(), changes % 2 == 0 ? &changed.cfg : &as_it_is);
        for (int k = 0; k < 200; k++) {
            run.tick();
            if (replayed.cfg != run.sim.drive().cfg) {
                drive_change(&replayed, run.sim.drive().cfg);
                changes++;
            }
            drive_step(&replayed, &run.sim.in(), &out);
        }
        TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.sim.drive()), drive_words_hash(&replayed));
    }
    TEST_ASSERT_TRUE(changes > 20);
}

} // namespace
