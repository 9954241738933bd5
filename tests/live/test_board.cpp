// SPDX-License-Identifier: MIT
// The simulated board: its script, who takes over from it, its flash, and its port.
#include "client.h"
#include "lossy_channel.h"
#include "own_path.h"
#include "pty_server.h"
#include "serial_port.h"
#include "simulated_board.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <utility>

extern "C" {
#include "config_guard.h"
#include "drive_words.h"
#include "testing.h"
}

namespace
{

using nf::live::BoardChannel;
using nf::live::SimulatedBoard;

constexpr int READY_TICKS = 300; // 256 of them calibrate
constexpr int RUN_TICKS = 20000;
constexpr double ANSWERED_BY_S =
    10; // of the board: its time outruns the threads that pass the bytes

nf::Config bench(const std::vector<std::string> &set = {})
{
    return nf::load_scenario("s1_robust", {"adc"}, set);
}

void pass(SimulatedBoard &board, int ticks)
{
    for (int k = 0; k < ticks; k++) {
        (void)board.tick();
    }
}

std::string text(const std::vector<uint8_t> &bytes)
{
    return {bytes.begin(), bytes.end()};
}

void type(SimulatedBoard &board, const std::string &line)
{
    board.put({line.begin(), line.end()});
}

void assert_has(const std::string &expected, const std::string &said)
{
    TEST_ASSERT_TRUE_MESSAGE(said.find(expected) != std::string::npos, said.c_str());
}

TEST(until_somebody_commands_each_tick_is_that_of_the_scenario)
{
    const nf::Config config = bench();
    SimulatedBoard board(config);
    nf::ScriptedRun native(config);
    for (int k = 0; k < RUN_TICKS; k++) {
        (void)native.control();
        (void)board.tick();
        native.advance();
        TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&native.sim().drive()),
                                drive_words_hash(&board.run().sim().drive()));
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, native.sim().drive().state);
    TEST_ASSERT_TRUE(board.follows_script());
}

TEST(a_question_leaves_the_script_in_command_and_a_command_ends_that)
{
    const nf::Config config = bench();
    SimulatedBoard board(config);
    pass(board, RUN_TICKS);
    type(board, "status\r");
    pass(board, READY_TICKS);
    TEST_ASSERT_TRUE(board.follows_script());
    type(board, "stop\r");
    pass(board, READY_TICKS);
    TEST_ASSERT_FALSE(board.follows_script());
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, board.run().sim().drive().state);
    assert_has("ok\r\n", text(board.take()));
}

TEST(the_script_clears_a_fault_itself)
{
    const nf::Config config = bench();
    nf::Config failing = config;
    failing.scenario.faults = {{0.3, nf::FaultKind::break_input, nf::FaultSpan::tick, {}, {}}};
    failing.scenario.requests = {{0.4, true, true}};
    SimulatedBoard board(failing);
    bool had_fault = false;
    while (board.now_s() < board.script_s()) {
        had_fault = board.tick().sim->drive().state == DRIVE_STATE_FAULT || had_fault;
    }
    TEST_ASSERT_TRUE(had_fault);
    TEST_ASSERT_TRUE(board.follows_script());
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, board.run().sim().drive().state);
}

TEST(what_is_stored_is_what_the_next_start_begins_with)
{
    const nf::Config config = bench();
    SimulatedBoard board(config);
    BoardChannel channel(board);
    nf::live::Client client(channel, {}, {});
    (void)client.hello();
    (void)client.line("stop");
    const config_block_t before = client.read_block();
    drive_cfg_t cfg = before.cfg;
    cfg.speed_loop.speed_max -= 1;
    cfg.crc = config_guard_crc(&cfg);
    config_block_t block{};
    config_block_make(&block, &before.identity, &before.about, &cfg);
    pass(board, READY_TICKS); // calibrates, and rests
    TEST_ASSERT_EQUAL_STRING("", client.write_block(block).c_str());
    pass(board, READY_TICKS);
    TEST_ASSERT_EQUAL_STRING("", client.store().c_str());
    SimulatedBoard again(config, &board.flash());
    TEST_ASSERT_EQUAL_HEX32(block.cfg.crc, again.run().sim().cfg().crc);
    pass(again, READY_TICKS);
    assert_has("configuration: the stored one", text(again.take()));
}

TEST(a_client_of_the_port_speaks_with_the_board)
{
    const nf::Config config = bench();
    SimulatedBoard board(config);
    const std::string link = own_path("test_board_port");
    {
        nf::live::Pty pty(link);
        nf::live::SerialPort port(link, 115200);
        port.write({'s', 't', 'a', 't', 'u', 's', '\r'});
        nf::live::Serving serving;
        serving.pace = 0;
        std::string said;
        serving.stops = [&] {
            said += text(port.read(0));
            return said.find("speed unknown") != std::string::npos || board.now_s() > ANSWERED_BY_S;
        };
        nf::live::serve(board, pty, serving);
        assert_has("speed unknown", said);
        TEST_ASSERT_TRUE(std::filesystem::is_symlink(link));
    }
    TEST_ASSERT_FALSE(std::filesystem::is_symlink(link));
}

// What is written to it comes back.
class Echo : public nf::live::Channel
{
public:
    std::vector<uint8_t> read(double) override
    {
        return std::exchange(bytes_, {});
    }
    void write(const std::vector<uint8_t> &bytes) override
    {
        bytes_ = bytes;
    }
    double now_s() const override
    {
        return 0;
    }

private:
    std::vector<uint8_t> bytes_;
};

TEST(a_bad_line_spoils_as_many_bytes_as_it_is_told)
{
    constexpr int BYTES = 100000;
    constexpr int EXPECTED = 3 * BYTES / 100;
    constexpr int FIVE_SIGMA = 270; // of a binomial of 100000 and 3 %: 54
    Echo echo;
    nf::live::LossyChannel bad(echo, {0.01, 0.01, 0.01}, {}, 1);
    bad.write(std::vector<uint8_t>(BYTES, 7));
    const std::vector<uint8_t> came = bad.read(0);
    TEST_ASSERT_INT_WITHIN(FIVE_SIGMA, EXPECTED, static_cast<int>(bad.spoilt_bytes()));
    const auto same = std::count(came.begin(), came.end(), uint8_t{7});
    TEST_ASSERT_INT_WITHIN(FIVE_SIGMA, BYTES / 100,
                           static_cast<int>(came.size()) - static_cast<int>(same));
}

constexpr int SECOND = 10000;
constexpr uint16_t REST = 164; // 4 % of full scale
// By then an input has started the motor: eight servo pulses, three of the median and the search.
constexpr int LATEST_START = 3000;

// Without anybody at the line: closed loop with the motor of the scenario.
TEST(a_potentiometer_turns_the_motor_and_its_open_wire_ramps_it_to_a_stop)
{
    constexpr uint16_t HALF = 2048;
    constexpr double SHARE = (0.5 - 0.03) / 0.97; // behind the dead band
    constexpr double STEADY = 0.02;               // ripple and steps of the converter
    const nf::Config config =
        nf::load_scenario("any", {}, {"input.kind=voltage", "input.arm_s=0.2"});
    SimulatedBoard board(config);
    board.inputs().now.throttle = REST;
    pass(board, READY_TICKS);
    type(board, "stop\n"); // the script's run
    pass(board, SECOND);
    const drive_t &drive = board.run().sim().drive();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, drive.state);
    board.inputs().now.throttle = HALF;
    pass(board, 4 * SECOND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(
        STEADY, SHARE, static_cast<double>(drive_speed(&drive)) / drive.cfg->speed_loop.speed_max);
    (void)board.take();
    board.inputs().now.throttle = 0;
    pass(board, SECOND / 10 + 2 * SECOND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, drive.state);
    assert_has("the input is lost: its voltage is below its range: the drive stops",
               text(board.take()));
    board.inputs().now.throttle = HALF;
    pass(board, SECOND);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, drive.state);
}

// What comes to the command pin: servo pulses at 50 Hz or frames of DShot300 at 1 kHz, of no
// throttle, half of it, or what no receiver sends.
class Sender
{
public:
    enum class Sends {
        nothing,
        rest,
        half,
        rubbish // servo pulses of 3 ms; frames with wrong checksums
    };

    Sender(SimulatedBoard &board, const std::string &kind) : board_(board), kind_(kind)
    {
    }

    void set(Sends sends)
    {
        sends_ = sends;
    }

    // A PWM period of 0.1 ms goes by, so many times.
    void pass(int ticks)
    {
        for (int k = 0; k < ticks; k++) {
            if (sends_ != Sends::nothing && kind_ == "rc_pulse" && tick_ % 200 == 0) {
                send(0, sends_ == Sends::rest ? 10000 : sends_ == Sends::half ? 15000 : 30000);
            } else if (sends_ != Sends::nothing && kind_ == "dshot" && tick_ % 10 == 0) {
                send_frame();
            }
            (void)board_.tick();
            tick_++;
        }
    }

private:
    void send(uint32_t after, uint32_t width)
    {
        const hal_pulse_t pulse = {hal_pulse_now(&board_.run().sim().hal()) + 10 + after, width};
        hal_host_inputs_send(&board_.inputs(), &pulse);
    }
    void send_frame()
    {
        const uint32_t data = (sends_ == Sends::rest ? 0U : 1047U) << 1U;
        const uint32_t sum = (data ^ (data >> 4U) ^ (data >> 8U)) & 0xFU;
        const uint32_t frame = (data << 4U) | (sends_ == Sends::rubbish ? sum ^ 1U : sum);
        for (uint32_t k = 0; k < 16; k++) {
            send(k * 100 / 3, ((frame >> (15 - k)) & 1U) != 0 ? 25 : 12);
        }
    }

    SimulatedBoard &board_;
    std::string kind_;
    Sends sends_ = Sends::rest;
    int tick_ = 0;
};

// A source that commands half of the speed, and is lost at some instant.
struct Source {
    const char *name;
    const char *kind; // of the input
    void (*begin)(SimulatedBoard &board, nf::live::Client &client, Sender &sender);
    void (*go_on)(SimulatedBoard &board, nf::live::Client &client); // heard again
    void (*die)(SimulatedBoard &board, Sender &sender);
    const char *says;
};

drive_command_t run_at_half(const SimulatedBoard &board)
{
    return {board.run().sim().cfg().speed_loop.speed_max / 2,
            static_cast<uint8_t>(DRIVE_MODE_SPEED), DRIVE_REQUEST_RUN};
}

void begin_half(SimulatedBoard &, nf::live::Client &, Sender &sender)
{
    sender.set(Sender::Sends::half);
}

void send_nothing(SimulatedBoard &, Sender &sender)
{
    sender.set(Sender::Sends::nothing);
}

void send_rubbish(SimulatedBoard &, Sender &sender)
{
    sender.set(Sender::Sends::rubbish);
}

void need_nothing(SimulatedBoard &, nf::live::Client &)
{
}

const std::vector<Source> MORTALS = {
    {"link", "voltage",
     [](SimulatedBoard &board, nf::live::Client &client, Sender &) {
         (void)client.hello();
         TEST_ASSERT_EQUAL_STRING("", client.command(run_at_half(board)).c_str());
     },
     [](SimulatedBoard &, nf::live::Client &client) { (void)client.ping(); }, send_nothing,
     "the link is silent: the drive stops"},
    {"console", "voltage",
     [](SimulatedBoard &board, nf::live::Client &, Sender &) { type(board, "speed 700\rrun\r"); },
     [](SimulatedBoard &board, nf::live::Client &) { type(board, "\r"); }, send_nothing,
     "nothing is typed: the drive stops; Enter keeps it running"},
    {"potentiometer", "voltage",
     [](SimulatedBoard &board, nf::live::Client &, Sender &) {
         board.inputs().now.throttle = 2048;
     },
     need_nothing, [](SimulatedBoard &board, Sender &) { board.inputs().now.throttle = 4095; },
     "the input is lost: its voltage is above its range: the drive stops"},
    {"receiver that is off", "rc_pulse", begin_half, need_nothing, send_nothing,
     "the input is lost: no signal: the drive stops"},
    {"receiver that sends no servo pulses", "rc_pulse", begin_half, need_nothing, send_rubbish,
     "the input is lost: its pulses have wrong widths or periods: the drive stops"},
    {"flight controller that is off", "dshot", begin_half, need_nothing, send_nothing,
     "the input is lost: no signal: the drive stops"},
    {"flight controller that is misread", "dshot", begin_half, need_nothing, send_rubbish,
     "the input is lost: its checksums are wrong: the drive stops"},
};

// PC killed, nobody at the console, a wire of the potentiometer open, a receiver or a flight
// controller that is off or misread, at random instants from the start on: at rest within the
// longest time-out, a second, and the ramp.
TEST(a_source_that_is_lost_at_any_instant_leaves_the_motor_at_rest_in_time)
{
    constexpr int RAMP = 2 * SECOND; // from half of the speed, also out of a start
    std::minstd_rand random(46);
    for (unsigned k = 0; k < MORTALS.size() * testing_runs(4, 200); k++) {
        const Source &source = MORTALS[k % MORTALS.size()];
        const nf::Config config =
            nf::load_scenario("any", {},
                              {std::string("input.kind=") + source.kind, "input.arm_s=0.2",
                               "tuning.console_timeout_s=1"});
        SimulatedBoard board(config);
        BoardChannel channel(board);
        nf::live::Client client(channel, {}, {});
        Sender sender(board, source.kind);
        board.inputs().now.throttle = REST;
        sender.pass(READY_TICKS);
        type(board, "stop\n"); // the script's run
        sender.pass(SECOND / 2);
        source.begin(board, client, sender);
        int left = static_cast<int>(random() % (3 * SECOND)) + LATEST_START;
        for (; left > SECOND / 2; left -= SECOND / 2) {
            sender.pass(SECOND / 2);
            source.go_on(board, client);
        }
        sender.pass(left);
        TEST_ASSERT_TRUE_MESSAGE(board.link().live->app->out.gate_enable, source.name);
        (void)board.take();
        source.die(board, sender);
        sender.pass(SECOND + RAMP);
        TEST_ASSERT_EQUAL_MESSAGE(DRIVE_STATE_READY, board.run().sim().drive().state, source.name);
        TEST_ASSERT_FALSE_MESSAGE(board.link().live->app->out.gate_enable, source.name);
        assert_has(source.says, text(board.take()));
    }
}

} // namespace
