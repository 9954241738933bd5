// SPDX-License-Identifier: MIT
// From [hal] of a board file to the registers of an STM32G4: pins, converters, clock and codes.
#include "config.h"
#include "g4_header.h"
#include "g4_resolve.h"
#include "hal_header.h"

extern "C" {
#include "testing.h"
}

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

using Lines = std::vector<std::string>;

constexpr unsigned DEAD_TIME_MAX = 1008; // ticks
constexpr unsigned LONGEST_SAMPLING = 4; // code
constexpr double ADC_CLOCK_MHZ = 42.5;

// The board that is sold, without inputs and sensors: their pins are free.
nf::Config esc1_with(const Lines &set)
{
    Lines all = {R"(hal.throttle_pin="")", R"(hal.pulse_pin="")", R"(hal.button_pin="")",
                 "hal.hall_pins=[]", "hal.encoder_pins=[]"};
    all.insert(all.end(), set.begin(), set.end());
    return nf::load_parts("outrunner_24v", "b_g431b_esc1", "any", {}, all);
}

nf::G4Board resolved(const Lines &set)
{
    return nf::resolve_g4_board(esc1_with(set));
}

// ---- codes ----

// RM0440 28.6.20, DTG.
unsigned ticks_of(unsigned code)
{
    if (code < 0x80) {
        return code;
    }
    if (code < 0xC0) {
        return (64 + (code & 0x3F)) * 2;
    }
    return (32 + (code & 0x1F)) * (code < 0xE0 ? 8 : 16);
}

unsigned shortest_of_at_least(unsigned ticks)
{
    unsigned shortest = UINT32_MAX;
    for (unsigned code = 0; code <= 0xFF; code++) {
        const unsigned made = ticks_of(code);
        shortest = made >= ticks && made < shortest ? made : shortest;
    }
    return shortest;
}

TEST(a_dead_time_is_the_shortest_that_is_long_enough)
{
    for (unsigned ticks = 0; ticks <= DEAD_TIME_MAX; ticks++) {
        const unsigned code = nf::g4_dead_time_code(ticks);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(0xFF, code);
        TEST_ASSERT_EQUAL_UINT32(shortest_of_at_least(ticks), ticks_of(code));
    }
}

TEST(a_dead_time_between_two_ticks_is_the_longer_one)
{
    TEST_ASSERT_EQUAL_UINT32(86, ticks_of(nf::g4_dead_time_code(85.1)));
    TEST_ASSERT_EQUAL_UINT32(136, ticks_of(nf::g4_dead_time_code(0.8e-6 * 170e6)));
}

// RM0440 21.7.6, SMP.
double sampling_ns(unsigned code)
{
    const double cycles[] = {2.5, 6.5, 12.5, 24.5, 47.5};
    return cycles[code] / ADC_CLOCK_MHZ * 1000;
}

TEST(a_sampling_time_is_the_shortest_that_is_long_enough)
{
    for (unsigned ns = 0; ns <= 1100; ns++) { // what nfconfig accepts
        const unsigned code = nf::g4_sampling_code(ns);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(LONGEST_SAMPLING, code);
        TEST_ASSERT_TRUE(sampling_ns(code) >= ns);
        TEST_ASSERT_TRUE(code == 0 || sampling_ns(code - 1) < ns);
    }
}

TEST(no_sampling_time_is_longer_than_that_of_the_bus)
{
    TEST_ASSERT_EQUAL_UINT32(LONGEST_SAMPLING, nf::g4_sampling_code(1118));
    TEST_ASSERT_EQUAL_UINT32(LONGEST_SAMPLING, nf::g4_sampling_code(100000));
}

// ---- clock ----

void assert_pll(double crystal_hz, int divider, int factor)
{
    const nf::G4Board board = resolved({fmt::format("hal.crystal_hz={}", crystal_hz)});
    const std::string name = fmt::format("{} Hz", crystal_hz);
    TEST_ASSERT_EQUAL_INT_MESSAGE(divider, board.pll_divider, name.c_str());
    TEST_ASSERT_EQUAL_INT_MESSAGE(factor, board.pll_factor, name.c_str());
    const double in_hz = (crystal_hz > 0 ? crystal_hz : 16e6) / divider;
    TEST_ASSERT_EQUAL_DOUBLE(2 * 170e6, in_hz * factor);
    TEST_ASSERT_TRUE(in_hz >= 2.66e6 && in_hz <= 16e6);
}

TEST(usual_crystals_give_170_mhz)
{
    assert_pll(0, 4, 85);
    assert_pll(8e6, 2, 85);
    assert_pll(10e6, 3, 102);
    assert_pll(12e6, 3, 85);
    assert_pll(16e6, 4, 85);
    assert_pll(24e6, 6, 85);
    assert_pll(25e6, 5, 68);
    assert_pll(48e6, 12, 85);
}

void assert_refused(const Lines &set, const std::string &words)
{
    std::string said;
    try {
        (void)nf::make_hal_header(esc1_with(set));
    } catch (const nf::ConfigError &error) {
        said = error.what();
    }
    TEST_ASSERT_TRUE_MESSAGE(said.find(words) != std::string::npos, said.c_str());
}

// The first two would give 170 MHz exactly, but no crystal of the chip is so slow.
TEST(a_crystal_that_the_chip_does_not_take_or_that_gives_another_clock_is_refused)
{
    for (const double hz : {3.4e6, 3.2e6, 9e6, 14.7456e6, 26e6, 8000001.0}) {
        assert_refused({fmt::format("hal.crystal_hz={}", hz)},
                       fmt::format("hal.crystal_hz = {:.10g}: gives no clock", hz));
    }
}

// ---- pins ----

std::string shown(const nf::G4Input &input)
{
    return fmt::format("ADC{}_IN{}", input.converter, input.channel);
}

void assert_inputs(const nf::G4Board &board, const Lines &currents, const char *bus)
{
    TEST_ASSERT_EQUAL_size_t(currents.size(), board.currents.size());
    for (std::size_t phase = 0; phase < currents.size(); phase++) {
        TEST_ASSERT_EQUAL_STRING(currents[phase].c_str(), shown(board.currents[phase]).c_str());
    }
    TEST_ASSERT_EQUAL_STRING(bus, shown(board.bus).c_str());
}

const nf::G4Pin *pin_of(const nf::G4Board &board, const std::string &name)
{
    const auto found = std::find_if(board.pins.begin(), board.pins.end(),
                                    [&](const nf::G4Pin &pin) { return pin.name == name; });
    return found == board.pins.end() ? nullptr : &*found;
}

TEST(the_board_that_is_sold_samples_at_its_amplifiers_output_pins_where_both_converters_are_used)
{
    const nf::G4Board board = resolved({});
    assert_inputs(board, {"ADC1_IN3", "ADC2_IN3", "ADC2_IN18"}, "ADC1_IN1");
    TEST_ASSERT_EQUAL_STRING("ADC1_IN5", shown(board.temperature).c_str());
    const int amplifiers[] = {1, 2, 3};
    const int comparators[] = {1, 2, 4};
    for (std::size_t phase = 0; phase < 3; phase++) {
        TEST_ASSERT_EQUAL_INT(amplifiers[phase], board.amplifiers[phase].number);
        TEST_ASSERT_EQUAL_INT(0, board.amplifiers[phase].plus);
        TEST_ASSERT_EQUAL(phase == 2, board.amplifiers[phase].internal);
        TEST_ASSERT_EQUAL_INT(comparators[phase], board.comparators[phase].number);
        TEST_ASSERT_EQUAL_INT(0, board.comparators[phase].plus);
        TEST_ASSERT_EQUAL_INT(static_cast<int>(phase) + 1, board.channels[phase]);
    }
    TEST_ASSERT_EQUAL_INT(2, board.usart);
}

TEST(an_output_pin_that_is_used_for_something_else_leaves_the_amplifier_the_path_in_the_chip)
{
    const nf::G4Board board = resolved({"hal.led_pin=PA2"});
    assert_inputs(board, {"ADC1_IN13", "ADC2_IN3", "ADC2_IN18"}, "ADC1_IN1");
    TEST_ASSERT_TRUE(board.amplifiers[0].internal);
    TEST_ASSERT_TRUE(pin_of(board, "PA2")->mode == nf::PinMode::output);
    TEST_ASSERT_TRUE(pin_of(board, "PA6")->mode == nf::PinMode::analog);
}

TEST(phases_may_be_on_any_channels)
{
    const nf::G4Board board = resolved({R"(hal.gate_high_pins=["PA10","PA8","PA9"])",
                                        R"(hal.gate_low_pins=["PB15","PC13","PA12"])"});
    const int channels[] = {3, 1, 2};
    for (std::size_t phase = 0; phase < 3; phase++) {
        TEST_ASSERT_EQUAL_INT(channels[phase], board.channels[phase]);
    }
    TEST_ASSERT_EQUAL_INT(4, pin_of(board, "PB15")->function);
    TEST_ASSERT_EQUAL_INT(6, pin_of(board, "PA12")->function);
}

TEST(phases_may_be_on_the_other_converters)
{
    const nf::G4Board board = resolved(
        {R"(hal.shunt_pins=["PA7","PA1","PB0"])", R"(hal.shunt_ground_pins=["PA5","PA3","PB2"])"});
    assert_inputs(board, {"ADC2_IN3", "ADC1_IN3", "ADC2_IN18"}, "ADC1_IN1");
}

TEST(a_bus_that_one_converter_alone_reaches_leaves_the_other_one_to_phase_c)
{
    const nf::G4Board board = resolved({"hal.bus_pin=PA4"});
    assert_inputs(board, {"ADC1_IN3", "ADC2_IN3", "ADC1_IN12"}, "ADC2_IN17");
    TEST_ASSERT_FALSE(board.amplifiers[2].internal);
}

const Lines TWO_SENSORS = {"board.current_sensors=2", R"(hal.shunt_pins=["PA1","PA7"])",
                           R"(hal.shunt_ground_pins=["PA3","PA5"])"};

TEST(two_sensors_have_two_amplifiers_and_two_comparators)
{
    const nf::G4Board board = resolved(TWO_SENSORS);
    assert_inputs(board, {"ADC1_IN3", "ADC2_IN3"}, "ADC1_IN1");
    TEST_ASSERT_EQUAL_size_t(2, board.amplifiers.size());
    TEST_ASSERT_EQUAL_size_t(2, board.comparators.size());
    TEST_ASSERT_NULL(pin_of(board, "PB0"));
}

// ---- gates ----

// Words that the header has to have.
void assert_header(const Lines &set, const Lines &words)
{
    const std::string header = nf::make_hal_header(esc1_with(set));
    for (const std::string &word : words) {
        TEST_ASSERT_TRUE_MESSAGE(header.find(word) != std::string::npos, word.c_str());
    }
}

// RM0440 28.6.11: CCxE 1, CCxP 2, CCxNE 4, CCxNP 8 of each channel; 28.6.2: OISx, OISxN.
TEST(a_gate_has_the_polarity_of_the_board_and_its_idle_level_opens_it)
{
    const std::string high = "hal.gate_high_polarity=active_low";
    const std::string low = "hal.gate_low_polarity=active_low";
    assert_header({}, {"HAL_OUTPUTS (0x555UL)", "HAL_IDLE_LEVELS (0x0UL)"});
    assert_header({high}, {"HAL_OUTPUTS (0x777UL)", "HAL_IDLE_LEVELS (0x1500UL)"});
    assert_header({low}, {"HAL_OUTPUTS (0xDDDUL)", "HAL_IDLE_LEVELS (0x2A00UL)"});
    assert_header({high, low}, {"HAL_OUTPUTS (0xFFFUL)", "HAL_IDLE_LEVELS (0x3F00UL)"});
}

TEST(a_pin_of_a_gate_is_pulled_to_where_the_gate_is_off)
{
    const nf::G4Board board = resolved({"hal.gate_low_polarity=active_low"});
    TEST_ASSERT_TRUE(pin_of(board, "PA8")->pull == nf::Pull::down);
    TEST_ASSERT_TRUE(pin_of(board, "PC13")->pull == nf::Pull::up);
}

const Lines ENABLES = {"hal.gate_low_pins=[]", R"(hal.gate_enable_pins=["PC13","PA12","PB15"])"};

// An enable is an output that is off, with its inactive level high; the driver makes the dead time.
TEST(enables_are_high_while_the_main_output_is_on_and_low_else)
{
    assert_header(ENABLES,
                  {"HAL_OUTPUTS (0x999UL)", "HAL_IDLE_LEVELS (0x0UL)", "HAL_DEAD_TIME_CODE (0U)"});
    TEST_ASSERT_TRUE(pin_of(resolved(ENABLES), "PC13")->pull == nf::Pull::down);
}

// RM0440 28.6.23: BKINE 1, BKINP 0x200; the pull is to the level at which nothing is wrong.
TEST(a_line_of_the_gate_driver_takes_the_place_of_the_comparators)
{
    for (const bool low : {false, true}) {
        Lines set = {"hal.break_pin=PB12", "board.trip_a=0"};
        set.push_back(fmt::format("hal.break_polarity={}", low ? "active_low" : "active_high"));
        const nf::G4Board board = resolved(set);
        TEST_ASSERT_TRUE(board.comparators.empty());
        TEST_ASSERT_TRUE(pin_of(board, "PB12")->pull == (low ? nf::Pull::up : nf::Pull::down));
        assert_header(set, {low ? "HAL_BREAK_SOURCES (TIM_AF1_BKINE | TIM_AF1_BKINP)"
                                : "HAL_BREAK_SOURCES (TIM_AF1_BKINE)"});
    }
}

// ---- inputs and sensors ----

TEST(a_board_without_inputs_has_none)
{
    const nf::G4Board board = resolved({});
    TEST_ASSERT_FALSE(board.throttle.has_value());
    TEST_ASSERT_EQUAL_INT(0, board.pulse_channel);
    TEST_ASSERT_EQUAL_INT(0, board.encoder_timer);
    TEST_ASSERT_EQUAL_INT(0, board.spi);
    assert_header({}, {"HAL_HAS_THROTTLE (false)", "HAL_HAS_PULSES (false)",
                       "HAL_HAS_BUTTON (false)", "HAL_SHAFT (BOARD_SHAFT_NONE)",
                       "#define HAL_PULSE_SETTINGS\n", "#define HAL_SHAFT_SETTINGS\n",
                       "HAL_AHB1 (RCC_AHB1ENR_CRC)", "HAL_ADC1_REGULAR_HELD (0xFFFFFFFFUL)"});
}

TEST(a_throttle_that_shares_the_converter_of_the_temperature_leaves_its_channel_unchecked)
{
    const nf::G4Board board = resolved({"hal.throttle_pin=PB12"});
    TEST_ASSERT_EQUAL_STRING("ADC1_IN11", shown(*board.throttle).c_str());
    assert_header({"hal.throttle_pin=PB12"},
                  {"HAL_HAS_THROTTLE (true)", "HAL_THROTTLE_CHANNEL (11U)",
                   "HAL_ADC1_REGULAR_HELD (~(0x1FUL << ADC_SQR1_SQ1_SHIFT))",
                   "HAL_ADC2_REGULAR_HELD (0xFFFFFFFFUL)"});
    assert_header({"hal.throttle_pin=PC4"},
                  {"HAL_ADC_THROTTLE (ADC2)", "HAL_ADC2_REGULAR (5U) /* hal.throttle_pin */",
                   "HAL_ADC1_REGULAR_HELD (0xFFFFFFFFUL)"});
}

// A pair of channels looks at the pin, whichever of them it is.
TEST(pulses_are_captured_by_the_pair_of_channels_of_their_pin)
{
    const struct {
        const char *pin;
        int channel;
        const char *mode;
    } rows[] = {{"PA15", 1, "TIM2 + TIM_CCMR1, ALL, TIM_CCMR_BOTH_OF_FIRST"},
                {"PB10", 3, "TIM2 + TIM_CCMR2, ALL, TIM_CCMR_BOTH_OF_FIRST"},
                {"PB11", 4, "TIM2 + TIM_CCMR2, ALL, TIM_CCMR_BOTH_OF_SECOND"}};
    for (const auto &row : rows) {
        const Lines set = {fmt::format("hal.pulse_pin={}", row.pin)};
        TEST_ASSERT_EQUAL_INT(row.channel, resolved(set).pulse_channel);
        TEST_ASSERT_TRUE(pin_of(resolved(set), row.pin)->pull == nf::Pull::down);
        assert_header(set,
                      {row.mode, "RCC_AHB1ENR_DMA1 | RCC_AHB1ENR_DMAMUX1", "| RCC_APB1ENR1_TIM2"});
    }
}

TEST(a_button_is_pulled_to_where_nobody_presses_it)
{
    for (const bool low : {false, true}) {
        const Lines set = {"hal.button_pin=PC10", fmt::format("hal.button_polarity={}",
                                                              low ? "active_low" : "active_high")};
        const auto board = resolved(set);
        const nf::G4Pin *const pin = pin_of(board, "PC10");
        TEST_ASSERT_TRUE(pin->mode == nf::PinMode::input);
        TEST_ASSERT_TRUE(pin->pull == (low ? nf::Pull::up : nf::Pull::down));
    }
}

const char *const HALL = R"(hal.hall_pins=["PB6","PB7","PB8"])";
const char *const ENCODER = R"(hal.encoder_pins=["PB6","PB7","PB8"])";

TEST(hall_sensors_are_read_at_their_pins)
{
    const Lines set = {R"(hal.hall_pins=["PB6","PB7","PC10"])"};
    TEST_ASSERT_TRUE(pin_of(resolved(set), "PB7")->mode == nf::PinMode::input);
    assert_header(set, {"HAL_SHAFT (BOARD_SHAFT_HALL)", "HAL_HALL_3_PORT (GPIOC)",
                        "HAL_HALL_AGE_Q24 (0U)", "#define HAL_SHAFT_SETTINGS\n"});
}

// 8500 counts of the timer are a tick.
TEST(channels_1_to_3_of_a_timer_take_the_time_of_hall_edges)
{
    for (const char *pins : {R"(["PB6","PB7","PB8"])", R"(["PB8","PB6","PB7"])"}) {
        const Lines set = {fmt::format("hal.hall_pins={}", pins)};
        TEST_ASSERT_EQUAL_INT(4, resolved(set).hall_timer);
        TEST_ASSERT_TRUE(pin_of(resolved(set), "PB7")->mode == nf::PinMode::alternate);
        assert_header(set, {"HAL_SHAFT_TIMER (TIM4)", "HAL_HALL_AGE_Q24 (1973U)",
                            "TIM4 + TIM_CR2, ALL, TIM_CR2_TI1S", "| RCC_APB1ENR1_TIM4"});
    }
}

// A pin that has no such channel, or an encoder elsewhere at the same timer.
TEST(hall_sensors_have_no_time_where_their_timer_cannot_take_it)
{
    TEST_ASSERT_EQUAL_INT(0, resolved({R"(hal.hall_pins=["PB6","PB7","PC10"])"}).hall_timer);
    TEST_ASSERT_EQUAL_INT(0, resolved({HALL, R"(hal.encoder_pins=["PA11","PB7"])"}).hall_timer);
    TEST_ASSERT_EQUAL_INT(4, resolved({HALL, ENCODER}).hall_timer);
}

TEST(an_encoder_has_the_timer_of_its_pins_and_may_lack_an_index)
{
    const nf::G4Board board = resolved({ENCODER});
    TEST_ASSERT_EQUAL_INT(4, board.encoder_timer);
    TEST_ASSERT_EQUAL_INT(3, board.index_channel);
    const nf::G4Board other =
        resolved({R"(hal.encoder_pins=["PA6","PA4"])", R"(hal.shunt_pins=["PA1","PA7","PB0"])"});
    TEST_ASSERT_EQUAL_INT(3, other.encoder_timer);
    TEST_ASSERT_EQUAL_INT(0, other.index_channel);
    assert_header({ENCODER}, {"HAL_SHAFT (BOARD_SHAFT_ENCODER)", "HAL_HAS_INDEX (true)",
                              "HAL_INDEX_AT (TIM_CCR3)", "| RCC_APB1ENR1_TIM4"});
}

TEST(one_connector_may_be_for_hall_sensors_and_for_an_encoder)
{
    const nf::G4Board board = resolved({HALL, ENCODER});
    TEST_ASSERT_TRUE(pin_of(board, "PB6")->mode == nf::PinMode::alternate);
    TEST_ASSERT_EQUAL_INT64(1,
                            std::count_if(board.pins.begin(), board.pins.end(),
                                          [](const nf::G4Pin &pin) { return pin.name == "PB6"; }));
}

TEST(a_drive_whose_angle_no_sensor_tells_is_refused)
{
    for (const char *source : {"both", "sensor"}) {
        assert_refused({fmt::format("drive.angle_source={}", source)},
                       fmt::format("drive.angle_source = \"{}\": has no sensor", source));
    }
}

TEST(an_absolute_encoder_has_the_spi_of_its_pins_and_starts_unselected)
{
    const Lines set = {R"(hal.spi_encoder_pins=["PB13","PB14","PA11","PB6"])",
                       "hal.temperature_pin=PB12"};
    const nf::G4Board board = resolved(set);
    TEST_ASSERT_EQUAL_INT(2, board.spi);
    TEST_ASSERT_TRUE(pin_of(board, "PB6")->high);
    TEST_ASSERT_TRUE(pin_of(board, "PB14")->pull == nf::Pull::up);
    assert_header(set, {"HAL_SHAFT (BOARD_SHAFT_ABSOLUTE)", "HAL_SPI_CS_BIT (6U)",
                        "| RCC_APB1ENR1_SPI2", "SPI2 + SPI_CR1, ALL, SPI_CR1_ENCODER"});
}

TEST(outputs_are_held_at_their_levels)
{
    const nf::G4Board board =
        resolved({R"(hal.high_pins=["PB5"])", R"(hal.low_pins=["PB6","PB7"])"});
    TEST_ASSERT_TRUE(pin_of(board, "PB5")->high);
    TEST_ASSERT_FALSE(pin_of(board, "PB6")->high);
    TEST_ASSERT_TRUE(pin_of(board, "PB7")->mode == nf::PinMode::output);
}

} // namespace

extern "C" void setUp()
{
}

extern "C" void tearDown()
{
}
