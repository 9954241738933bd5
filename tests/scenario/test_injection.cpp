// SPDX-License-Identifier: MIT
// Injected faults change what the drive sees, when they shall and no tick earlier; and the user's
// requests.
#include "scenario.h"
#include "temperature_sensor.h"
#include "tick.h"

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using nf::Config;

// One tick as the drive had it, and the truth.
struct Row {
    drive_in_t in;
    drive_out_t out;
    drive_state_t state;
    plant_view_t truth;
    uint32_t preloaded; // of phase a
    bool gates_on;
    unsigned char cfg_byte;
};

constexpr std::size_t CFG_BYTE = offsetof(drive_cfg_t, slow_ticks);

class Rows : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        const nf::Simulation &sim = *tick.sim;
        unsigned char cfg[sizeof(drive_cfg_t)];
        std::memcpy(cfg, &sim.cfg(), sizeof cfg);
        all.push_back({sim.in(), sim.out(), sim.drive().state, tick.truth,
                       sim.plant().compare_next[0], sim.plant().gates_on, cfg[CFG_BYTE]});
    }
    std::vector<Row> all;
};

// Scenario s2, 1800 rpm under 3 N·m from 0.5 s on. Ticks of 0.1 ms, t = 0 is tick 8000.
constexpr int64_t FAULT_TICK = 14000;
constexpr const char *FAULT_TIME = "0.6";
constexpr int64_t END_TICK = 15000;
constexpr std::size_t SLOW_TICKS = 10;
constexpr std::size_t AT = FAULT_TICK;

std::vector<Row> run(const std::string &scenario, const std::vector<std::string> &set)
{
    Rows rows;
    nf::RunOptions options;
    options.sink = &rows;
    (void)nf::run_scenario(nf::load_scenario(scenario, {}, set), options);
    return rows.all;
}

std::vector<Row> run_with(const std::string &fault)
{
    return run("s2", {"scenario.duration_s=0.7",
                      fmt::format("scenario.fault=[{{time_s = {}, {}}}]", FAULT_TIME, fault)});
}

const std::vector<Row> &healthy()
{
    static const std::vector<Row> rows = run("s2", {"scenario.duration_s=0.7"});
    return rows;
}

bool same(const drive_in_t &a, const drive_in_t &b)
{
    return a.adc_ia == b.adc_ia && a.adc_ib == b.adc_ib && a.adc_bus == b.adc_bus &&
           a.adc_temperature == b.adc_temperature && a.angle == b.angle && a.flags == b.flags;
}

struct Case {
    const char *fault;
    int64_t delay; // ticks until the frame differs, at most
};

// What is seen at once is in the frame of its tick; what the plant has to turn into currents first
// is in the next, or in one of the slow period's.
TEST(test_each_fault_changes_the_frame_and_none_before_it)
{
    const Case cases[] = {
        {"what = 'adc_a_stuck', value = 3", 0},
        {"what = 'adc_a_stuck'", 1},
        {"what = 'adc_a_high'", 0},
        {"what = 'adc_a_low'", 0},
        {"what = 'adc_b_stuck', value = 3", 0},
        {"what = 'adc_b_stuck'", 1},
        {"what = 'adc_b_high'", 0},
        {"what = 'adc_b_low'", 0},
        {"what = 'adc_bus_stuck', value = 300", 0},
        {"what = 'angle_stuck'", 1},
        {"what = 'angle_offset', value = 30", 0},
        {"what = 'overcurrent', value = 15", 0},
        {"what = 'phase_a_open'", 0},
        {"what = 'phase_b_open'", 0},
        {"what = 'phase_c_open'", 0},
        {"what = 'bus_voltage', value = 250", 0},
        {"what = 'temperature', value = 90", 0},
        {"what = 'rotor_blocked'", 1},
        {"what = 'rotor_jump', value = 30", 1},
        {"what = 'break_input'", 0},
        {"what = 'late_isr'", 1},
        {"what = 'config_corrupt', value = 0", 40},
    };
    for (const Case &one : cases) {
        const std::vector<Row> rows = run_with(one.fault);
        std::size_t first = 0;
        while (first < rows.size() && same(rows[first].in, healthy()[first].in)) {
            first++;
        }
        const auto tick = static_cast<int64_t>(first);
        TEST_ASSERT_TRUE_MESSAGE(tick >= FAULT_TICK, one.fault);
        TEST_ASSERT_TRUE_MESSAGE(tick <= FAULT_TICK + one.delay, one.fault);
    }
}

TEST(test_a_channel_that_is_stuck_keeps_what_it_read_last_until_it_recovers)
{
    const std::vector<Row> rows = run_with("what = 'adc_a_stuck', until_s = 0.601");
    const uint16_t last = rows[AT - 1].in.adc_ia;
    for (std::size_t k = AT; k < AT + 10; k++) {
        TEST_ASSERT_EQUAL_UINT16(last, rows[k].in.adc_ia);
    }
    TEST_ASSERT_NOT_EQUAL_UINT16(last, rows[AT + 10].in.adc_ia);
}

TEST(test_an_angle_sensor_that_is_stuck_keeps_its_count_and_one_that_slips_adds_to_it)
{
    const std::vector<Row> stuck = run_with("what = 'angle_stuck', until_s = 0.601");
    for (std::size_t k = AT; k < AT + 10; k++) {
        TEST_ASSERT_EQUAL_UINT16(healthy()[AT - 1].in.angle, stuck[k].in.angle);
    }
    TEST_ASSERT_EQUAL_UINT16(healthy()[AT + 10].in.angle, stuck[AT + 10].in.angle);
    const std::vector<Row> turned = run_with("what = 'angle_offset', value = -90");
    for (std::size_t k = AT; k < turned.size(); k++) { // nothing of s2 reads the sensor
        TEST_ASSERT_EQUAL_UINT16(static_cast<uint16_t>(healthy()[k].in.angle - 16384),
                                 turned[k].in.angle);
    }
}

// 12 bits over ±20 A and 450 V.
TEST(test_a_value_in_si_is_what_an_ideal_sensor_reads)
{
    TEST_ASSERT_EQUAL_UINT16(2048 + 307, run_with("what = 'adc_a_stuck', value = 3")[AT].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(2048 - 307,
                             run_with("what = 'adc_b_stuck', value = -3")[AT].in.adc_ib);
    TEST_ASSERT_EQUAL_UINT16(2731, run_with("what = 'adc_bus_stuck', value = 300")[AT].in.adc_bus);
    TEST_ASSERT_EQUAL_UINT16(4095, run_with("what = 'adc_a_stuck', value = 99")[AT].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(4095, run_with("what = 'adc_a_high'")[AT].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(0, run_with("what = 'adc_b_low'")[AT].in.adc_ib);
}

TEST(test_overcurrent_flows_in_at_a_and_out_at_b_for_one_tick)
{
    const std::vector<Row> rows = run_with("what = 'overcurrent', value = 15");
    TEST_ASSERT_EQUAL_UINT16(2048 + 1536, rows[AT].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(2048 - 1536, rows[AT].in.adc_ib);
    TEST_ASSERT_TRUE(rows[AT + 1].in.adc_ia < 2048 + 1000);
}

// A: what is left of 5 A by roundings.
TEST(test_an_open_phase_carries_no_current)
{
    constexpr double NOTHING_A = 1e-9;
    const char *const faults[] = {"what = 'phase_a_open'", "what = 'phase_b_open'",
                                  "what = 'phase_c_open'"};
    for (std::size_t phase = 0; phase < 3; phase++) {
        const std::vector<Row> rows = run_with(faults[phase]);
        for (std::size_t k = AT; k < AT + 20; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(NOTHING_A, 0.0, rows[k].truth.i_abc_a[phase]);
        }
    }
}

TEST(test_the_supply_jumps_and_comes_back)
{
    const std::vector<Row> rows = run_with("what = 'bus_voltage', value = 250, until_s = 0.602");
    TEST_ASSERT_EQUAL_UINT16(2276, rows[AT].in.adc_bus); // 250 of 450 V
    TEST_ASSERT_EQUAL_UINT16(2276, rows[AT + 19].in.adc_bus);
    TEST_ASSERT_EQUAL_UINT16(2822, rows[AT + 20].in.adc_bus);
}

// The plant's sensor and the number that a limit is made of are one description.
TEST(test_the_temperature_reads_as_the_board_file_says)
{
    const Config config = nf::load_scenario("s2");
    const std::vector<Row> rows = run_with("what = 'temperature', value = 90");
    TEST_ASSERT_EQUAL_UINT16(nf::temperature_count(config.board, PLANT_AMBIENT_C) + 0.5,
                             rows[AT - 1].in.adc_temperature);
    TEST_ASSERT_EQUAL_UINT16(nf::temperature_count(config.board, 90) + 0.5,
                             rows[AT].in.adc_temperature);
    TEST_ASSERT_EQUAL_UINT16(rows[AT].in.adc_temperature, rows.back().in.adc_temperature);
}

TEST(test_a_blocked_rotor_stands_at_once_and_turns_again_when_released)
{
    const std::vector<Row> rows = run_with("what = 'rotor_blocked', until_s = 0.605");
    TEST_ASSERT_TRUE(rows[AT - 1].truth.omega_mech_rad_s > 180);
    for (std::size_t k = AT; k <= AT + 50; k++) {
        TEST_ASSERT_TRUE(rows[k].truth.omega_mech_rad_s == 0.0);
    }
    TEST_ASSERT_FALSE(rows[AT + 51].truth.omega_mech_rad_s == 0.0);
}

TEST(test_the_rotor_jumps_by_the_angle)
{
    constexpr double DEG = 3.14159265358979323846 / 180.0;
    const std::vector<Row> rows = run_with("what = 'rotor_jump', value = 60");
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 60 * DEG / 2,
                              rows[AT].truth.theta_mech_rad - healthy()[AT].truth.theta_mech_rad);
}

TEST(test_a_break_opens_the_gates_whatever_the_drive_wants_and_says_so)
{
    const std::vector<Row> rows = run_with("what = 'break_input'");
    TEST_ASSERT_TRUE(rows[AT - 1].gates_on);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_FLAG_BREAK, rows[AT].in.flags);
    TEST_ASSERT_FALSE(rows[AT].gates_on);
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT + 1].in.flags);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, rows[AT].state);
}

TEST(test_a_late_tick_leaves_a_rest_duty_and_the_next_frame_says_so)
{
    const std::vector<Row> rows = run_with("what = 'late_isr'");
    const uint32_t rest = 170000000 / 10000 / 2 / 2;
    TEST_ASSERT_NOT_EQUAL_UINT32(rest, rows[AT].out.compare.phase[0]);
    TEST_ASSERT_EQUAL_UINT32(rest, rows[AT].preloaded);
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT].in.flags);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_FLAG_LATE, rows[AT + 1].in.flags);
    TEST_ASSERT_EQUAL_UINT32(rows[AT + 1].out.compare.phase[0], rows[AT + 1].preloaded);
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT + 2].in.flags);
}

TEST(test_late_ticks_may_last)
{
    const std::vector<Row> rows = run_with("what = 'late_isr', until_s = 0.6005");
    for (std::size_t k = AT + 1; k <= AT + 5; k++) {
        TEST_ASSERT_EQUAL_UINT16(DRIVE_FLAG_LATE, rows[k].in.flags);
    }
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT + 6].in.flags);
}

TEST(test_a_bit_of_the_configuration_flips)
{
    const std::vector<Row> rows =
        run_with(fmt::format("what = 'config_corrupt', value = {}", CFG_BYTE));
    TEST_ASSERT_EQUAL_UINT8(rows[AT - 1].cfg_byte ^ 1U, rows[AT].cfg_byte);
    TEST_ASSERT_EQUAL_UINT8(rows[AT].cfg_byte, rows.back().cfg_byte);
}

TEST(test_several_faults_add_and_each_ends_by_itself)
{
    const std::vector<Row> rows =
        run("s2", {"scenario.duration_s=0.7",
                   "scenario.fault=[{time_s = 0.6, what = 'adc_a_high', until_s = 0.604},"
                   "{time_s = 0.602, what = 'adc_b_low', until_s = 0.606}]"});
    TEST_ASSERT_EQUAL_UINT16(4095, rows[AT].in.adc_ia);
    TEST_ASSERT_NOT_EQUAL_UINT16(0, rows[AT].in.adc_ib);
    TEST_ASSERT_EQUAL_UINT16(4095, rows[AT + 20].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT + 20].in.adc_ib);
    TEST_ASSERT_NOT_EQUAL_UINT16(4095, rows[AT + 40].in.adc_ia);
    TEST_ASSERT_EQUAL_UINT16(0, rows[AT + 40].in.adc_ib);
    TEST_ASSERT_NOT_EQUAL_UINT16(0, rows[AT + 60].in.adc_ib);
}

// Scenario s1 stands until 0.2 s; t = 0 is tick 500, calibration takes 257 ticks. A request is
// taken within a slow period, 1 ms.
TEST(test_the_drive_is_started_stopped_cleared_and_started_again)
{
    const struct {
        double time_s;
        drive_state_t state;
    } expected[] = {
        {0.0, DRIVE_STATE_RUN},      {0.021, DRIVE_STATE_READY},
        {0.041, DRIVE_STATE_RUN},    {0.06, DRIVE_STATE_FAULT},
        {0.0799, DRIVE_STATE_FAULT}, {0.081, DRIVE_STATE_OFFSET_CAL},
        {0.119, DRIVE_STATE_READY},  {0.121, DRIVE_STATE_RUN},
        {0.14, DRIVE_STATE_FAULT},   {0.151, DRIVE_STATE_OFFSET_CAL},
        {0.18, DRIVE_STATE_RUN},
    };
    const std::vector<Row> rows =
        run("s1", {"scenario.duration_s=0.2",
                   "scenario.request=[{time_s = 0.02, run = false}, {time_s = 0.04, run = true},"
                   "{time_s = 0.05, clear = true, run = true}, {time_s = 0.08, clear = true},"
                   "{time_s = 0.12, run = true}, {time_s = 0.15, clear = true, run = true}]",
                   "scenario.fault=[{time_s = 0.06, what = 'break_input'},"
                   "{time_s = 0.14, what = 'break_input'}]"});
    const std::size_t zero = rows.size() - 2000;
    for (const auto &[time_s, state] : expected) {
        const std::size_t tick = zero + static_cast<std::size_t>(time_s * 1e4 + 0.5);
        TEST_ASSERT_EQUAL_INT(state, rows[tick].state);
    }
}

TEST(test_without_requests_the_drive_is_started_when_it_is_ready_and_stays_in_a_fault)
{
    const std::vector<Row> rows = run_with("what = 'break_input'");
    std::size_t ready = 0;
    while (rows[ready].state != DRIVE_STATE_READY) {
        TEST_ASSERT_EQUAL_UINT8(0, rows[ready].in.command.request);
        ready++;
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, rows[ready + SLOW_TICKS].state);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, rows[END_TICK - 1].state);
}

} // namespace
