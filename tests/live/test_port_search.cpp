// SPDX-License-Identifier: MIT
// A board is found at whatever known rate its line has, and ports are listed by the names of their
// adapters.
#include "client.h"
#include "port_search.h"
#include "simulated_board.h"

#include <algorithm>
#include <cstring>
#include <fstream>

#include <unistd.h>

extern "C" {
#include "testing.h"
}

namespace
{

namespace fs = std::filesystem;
using nf::live::Channel;

// At another rate than the board's a port carries other bytes.
class WrongRate : public Channel
{
public:
    std::vector<uint8_t> read(double wait_s) override
    {
        now_ += wait_s;
        return {0xF0, 0x00, 0x3C, 0x00};
    }
    void write(const std::vector<uint8_t> & /*bytes*/) override
    {
    }
    double now_s() const override
    {
        return now_;
    }

private:
    double now_ = 0;
};

// A port that a board of this rate is at, and the rates at which it was opened.
struct Port {
    nf::Config config;
    nf::live::SimulatedBoard board;
    unsigned rate;
    std::vector<unsigned> opened;

    explicit Port(unsigned baud)
        : config(nf::load_scenario(
              "any", {},
              {"motor=outrunner_24v", "board=b_g431b_esc1", "board.baud=" + std::to_string(baud)})),
          board(config), rate(baud)
    {
    }
    std::unique_ptr<Channel> open(unsigned at)
    {
        opened.push_back(at);
        if (at == rate) {
            return std::make_unique<nf::live::BoardChannel>(board);
        }
        return std::make_unique<WrongRate>();
    }
    unsigned find(const std::vector<unsigned> &rates)
    {
        return nf::live::find_rate([this](unsigned at) { return open(at); }, rates);
    }
};

TEST(the_rate_of_each_shipped_board_and_of_a_board_file_without_one_is_known)
{
    std::vector<unsigned> rates = nf::live::known_rates();
    TEST_ASSERT_TRUE(std::is_sorted(rates.rbegin(), rates.rend()));
    TEST_ASSERT_TRUE(std::adjacent_find(rates.begin(), rates.end()) == rates.end());
    for (const char *board : {"b_g431b_esc1", "g431_bench"}) {
        const auto rate = static_cast<unsigned>(nf::load_board(board).baud);
        TEST_ASSERT_TRUE(std::count(rates.begin(), rates.end(), rate) == 1);
    }
    TEST_ASSERT_TRUE(std::count(rates.begin(), rates.end(), 115200U) == 1);
}

TEST(a_board_is_found_at_any_known_rate_and_the_port_is_opened_no_further)
{
    const std::vector<unsigned> rates = {921600, 460800, 115200};
    for (std::size_t k = 0; k < rates.size(); k++) {
        Port port(rates[k]);
        TEST_ASSERT_EQUAL_UINT(rates[k], port.find(rates));
        TEST_ASSERT_EQUAL_UINT(k + 1, port.opened.size());
    }
}

TEST(without_an_answer_the_message_names_each_rate_and_the_option)
{
    Port port(57600);
    try {
        port.find({921600, 115200});
        TEST_FAIL_MESSAGE("a board was found");
    } catch (const nf::live::LinkError &error) {
        for (const char *part : {"921600", "115200", "--baud"}) {
            TEST_ASSERT_NOT_NULL_MESSAGE(std::strstr(error.what(), part), error.what());
        }
    }
}

TEST(a_port_is_listed_once_by_the_name_of_its_adapter_or_its_own)
{
    const fs::path devices = fs::temp_directory_path() / ("ports" + std::to_string(getpid()));
    fs::create_directories(devices / "serial" / "by-id");
    for (const char *name : {"ttyACM0", "ttyUSB3", "tty7", "null"}) {
        std::ofstream(devices / name) << "";
    }
    const fs::path adapter = devices / "serial" / "by-id" / "usb-an_adapter";
    fs::create_symlink("../../ttyACM0", adapter);
    const std::vector<std::string> ports = nf::live::list_ports(devices);
    const std::vector<std::string> none = nf::live::list_ports(devices / "nowhere");
    fs::remove_all(devices);
    TEST_ASSERT_EQUAL_UINT(2, ports.size());
    TEST_ASSERT_EQUAL_STRING(adapter.c_str(), ports[0].c_str());
    TEST_ASSERT_EQUAL_STRING((devices / "ttyUSB3").c_str(), ports[1].c_str());
    TEST_ASSERT_TRUE(none.empty());
}

} // namespace
