// SPDX-License-Identifier: MIT
// The motor and the power stage of a scenario, tick by tick, for an image in an emulator whose
// drive the host does not repeat:
//
//     bil_motor SCENARIO [SET...]
//
// SET is an override as of `motorsim run --set`. Each order from stdin is answered by what the
// converters measure then (test_identify.py, little-endian both); the first answer comes unasked.
// Exit status: 0 the orders end, 2 bad input.
#include "config.h"
#include "machine.h"
#include "per_unit.h"

#include <cstdint>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

constexpr int BAD_INPUT = 2;

enum Act : std::uint16_t {
    STEP = 0,
    KEEP = 1, // the machine as it is
    BACK = 2  // to what was kept
};

struct Order {
    std::uint16_t compare[PLANT_LEGS];
    std::uint16_t gates;
    std::uint16_t broken; // mask of open phases
    std::uint16_t blocked;
    std::uint16_t act;
    std::uint16_t unused;
    double load_nm;
    double supply_v; // 0: the board's
};
static_assert(sizeof(Order) == 32, "no padding");

struct Seen {
    std::uint16_t current_a;
    std::uint16_t current_b;
    std::uint16_t bus;
    std::uint16_t temperature;
    std::uint32_t trips;
    std::uint32_t unused;
    double angle_rad; // of the shaft
    double speed_rad_s;
};
static_assert(sizeof(Seen) == 32, "no padding");

class Machine
{
public:
    explicit Machine(const nf::Config &config) : supply_v_(config.board.bus_nominal_v)
    {
        const plant_cfg_t cfg = nf::make_plant_cfg(config, nf::build(config));
        const char *bad = nullptr;
        if (!plant_init(&plant_, &cfg, &bad)) {
            throw std::runtime_error(bad);
        }
        kept_ = plant_;
    }

    Seen look()
    {
        plant_adc_t adc{};
        plant_view_t view{};
        plant_sample(&plant_, &adc);
        plant_view(&plant_, &view);
        return {adc.ia,
                adc.ib,
                adc.bus,
                adc.temperature,
                trips_,
                0,
                view.theta_mech_rad,
                view.omega_mech_rad_s};
    }

    void obey(const Order &order)
    {
        if (order.act == KEEP) {
            kept_ = plant_;
        } else if (order.act == BACK) {
            plant_ = kept_;
            state_ = {};
        } else {
            step(order);
        }
    }

private:
    void step(const Order &order)
    {
        change(order);
        const std::uint32_t compare[] = {order.compare[0], order.compare[1], order.compare[2]};
        plant_write_compare(&plant_, compare);
        plant_set_gates(&plant_, order.gates != 0);
        plant_set_load_torque(&plant_, order.load_nm);
        plant_step(&plant_);
        trips_ += plant_take_trip(&plant_) ? 1U : 0U;
    }

    void change(const Order &order)
    {
        if (order.broken != state_.broken) {
            plant_break_phases(&plant_, order.broken);
        }
        if (order.blocked != state_.blocked) {
            plant_block_rotor(&plant_, order.blocked != 0);
        }
        plant_set_supply(&plant_, order.supply_v > 0 ? order.supply_v : supply_v_);
        state_ = order;
    }

    plant_t plant_{};
    plant_t kept_{};
    Order state_{};
    double supply_v_;
    std::uint32_t trips_ = 0;
};

int run(const std::vector<std::string> &arguments)
{
    Machine machine(
        nf::load_scenario(arguments.at(0), {}, {arguments.begin() + 1, arguments.end()}));
    Order order{};
    do {
        const Seen seen = machine.look();
        if (std::fwrite(&seen, sizeof seen, 1, stdout) != 1 || std::fflush(stdout) != 0) {
            throw std::runtime_error("nobody listens");
        }
        if (std::fread(&order, sizeof order, 1, stdin) != 1) {
            return 0;
        }
        machine.obey(order);
    } while (true);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 2) {
        std::fputs("usage: bil_motor SCENARIO [SET...]\n", stderr);
        return BAD_INPUT;
    }
    try {
        return run({argv + 1, argv + argc});
    } catch (const std::exception &error) {
        fmt::print(stderr, "bil_motor: {}\n", error.what());
        return BAD_INPUT;
    }
}
