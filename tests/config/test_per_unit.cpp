// Motor A on its bench, per unit: every field against a number that was worked out by hand, most of them in example_cfg.h of
// the firmware's own tests, with their way of getting there.
#include "config.h"
#include "describe.h"

#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "unity.h"

extern "C" drive_cfg_t example_cfg(void);

namespace
{

// What example_cfg.h takes in place of the tuning `published` and of what follows from the motor.
const std::vector<std::string> AS_BY_HAND = {
    "motor.continuous_current_a=6.719",
    "startup.current_pct=119.0653", // 8 A
    "observer.kappa=0.005",
    "observer.kappa_p=0.1",
    "observer.rho_max=2",
    "model.dead_time_s=2e-6",
    "model.device_drop_v=1.2",
};

// Where example_cfg.h has another number than follows from the bench and the rules.
const std::map<std::string, std::int64_t> FROM_THE_RULES = {
    {"derating.temperature.zero", 3072}, // 100 °C of -50 °C to 150 °C: 3/4 of 4096
    {"derating.bus_high.zero", 28308},   // 355 V and 3/4 of the way to 400 V: 388.75 V of 450 V
    {"derating.bus_high.gain", 27307},   // 2^15 · 2^11 over 33.75 V of 450 V, 2457.6
    {"startup.residual_max", 1376},      // 1/4 of the continuous current, 5504
    {"startup.residual_lost", 4128},     // 3/4 of it
};

// Not of this tuning, or a sum over all others.
const std::vector<std::string> NOT_BY_HAND = {"voltage_drive.", "model.",
                                              "startup.catch_spin.gap_factor", "crc"};

// Each number by hand was rounded, of a physical value with four digits and more.
constexpr std::int64_t ROUNDED = 1;
constexpr std::size_t BY_HAND_LEAST = 100;

bool is_by_hand(const std::string &path)
{
    for (const std::string &start : NOT_BY_HAND) {
        if (path.rfind(start, 0) == 0) {
            return false;
        }
    }
    return true;
}

// A power of two is exact.
std::int64_t tolerance(const std::string &path)
{
    const bool is_power =
        path.find("shift") != std::string::npos || path.find("log2") != std::string::npos;
    return is_power ? 0 : ROUNDED;
}

void every_field_is_what_was_worked_out_by_hand()
{
    const nf::Config config = nf::load_parts("motor_a", "bench_310v", "published", {}, AS_BY_HAND);
    const std::vector<nf::ConfigRow> built = nf::describe(config, nf::build(config));
    const std::vector<nf::ConfigRow> hand = nf::describe(config, example_cfg());
    std::size_t compared = 0;
    std::string wrong;
    for (std::size_t k = 0; k < built.size(); k++) {
        const std::string &path = built[k].path;
        const auto rule = FROM_THE_RULES.find(path);
        const std::int64_t expected = rule == FROM_THE_RULES.end() ? hand[k].value : rule->second;
        if (is_by_hand(path)) {
            compared++;
            if (std::abs(built[k].value - expected) > tolerance(path)) {
                wrong += path + " is " + std::to_string(built[k].value) + " and not " +
                         std::to_string(expected) + "; ";
            }
        }
    }
    TEST_ASSERT_EQUAL_STRING("", wrong.c_str());
    TEST_ASSERT_GREATER_THAN(BY_HAND_LEAST, compared);
}

std::uint32_t observer_shift(const char *flux)
{
    const nf::Config config =
        nf::load_parts("motor_a", "bench_310v", "published", {},
                       {std::string("motor.flux_linkage_wb=") + flux, "motor.rated_torque_nm=4"});
    return nf::build(config).observer.current_shift;
}

// 2/sqrt(3) of 18 A, which three phases within the over-current limit make, is 20.785 A; I_b is 40 A. With phi/L of 19.095 A
// the sum is 39.88 A and fits it, with 19.31 A it is 40.095 A and takes twice of it.
void the_observers_base_holds_the_longest_vector_that_protection_lets_through()
{
    TEST_ASSERT_EQUAL_UINT32(0U, observer_shift("0.2215"));
    TEST_ASSERT_EQUAL_UINT32(1U, observer_shift("0.2240"));
}

} // namespace

void setUp()
{
}

void tearDown()
{
}

int main()
{
    UNITY_BEGIN();
    RUN_TEST(every_field_is_what_was_worked_out_by_hand);
    RUN_TEST(the_observers_base_holds_the_longest_vector_that_protection_lets_through);
    return UNITY_END();
}
