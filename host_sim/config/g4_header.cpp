// SPDX-License-Identifier: MIT
#include "g4_header.h"

#include "g4_input_lines.h"
#include "g4_resolve.h"
#include "g4_text.h"

#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double HALF_CYCLE_NS = 1e9 / 85e6;  // of the converters' clock of 42.5 MHz
constexpr unsigned LONGEST_SAMPLING = 4;      // dividers of some kΩ with a capacitor
constexpr double CRYSTAL_CYCLES = 8 * 8 * 32; // of 8 captures, each at the 8th edge of 1/32
constexpr int STORE_PAGES = 2;
constexpr int BOX_PAGES = 6; // of the black box, before those of the store
constexpr int KEPT_PAGES = STORE_PAGES + BOX_PAGES;
constexpr int PAGE_KIB = 2;
constexpr int FLASH_AT = 0x08000000;
constexpr int CHANNELS_OF_SMPR1 = 10; // the rest is in SMPR2

// ---- chip and clock ----

std::string chip_lines(const G4Board &board)
{
    const G4Chip &chip = *board.chip;
    const int pages = chip.flash_kib / PAGE_KIB;
    const int bank_pages = chip.two_banks ? pages / 2 : pages; // the store is in the last one
    const int at = FLASH_AT + (chip.flash_kib - KEPT_PAGES * PAGE_KIB) * 1024;
    return g4_line("BOX", g4_hex(static_cast<unsigned long>(at)),
                   "the last eight pages of the flash: black box, store") +
           g4_line("BOX_PAGE", g4_unsigned(static_cast<unsigned>(bank_pages - KEPT_PAGES)),
                   "the first of them in its bank") +
           g4_line("STORE_BANK", chip.two_banks ? "FLASH_CR_BKER" : "0U", "that bank in FLASH_CR") +
           g4_line("FLASH_MODE", chip.two_banks ? "FLASH_OPTR_DBANK" : "0U",
                   "option bits that have to be set for such pages");
}

std::string clock_lines(const Config &config, const G4Board &board)
{
    const double hz = config.hal.crystal_hz;
    const bool crystal = hz > 0;
    const std::string pll = fmt::format("RCC_PLLCFGR_SRC_HSE | ({}UL << RCC_PLLCFGR_PLLM_SHIFT) | "
                                        "({}UL << RCC_PLLCFGR_PLLN_SHIFT) | RCC_PLLCFGR_REN",
                                        board.pll_divider - 1, board.pll_factor);
    const double span = crystal ? CRYSTAL_CYCLES * G4_OSCILLATOR_HZ / hz : 0;
    return g4_line("CRYSTAL_SPAN", g4_unsigned(static_cast<unsigned long>(std::round(span))),
                   "cycles of 16 MHz in 2048 of the crystal") +
           g4_line("PLL", crystal ? pll : "RCC_PLLCFGR_INSIDE", "RCC_PLLCFGR, for 170 MHz") +
           g4_line("CR", crystal ? "RCC_CR_INSIDE | RCC_CR_CRYSTAL" : "RCC_CR_INSIDE", "RCC_CR");
}

// ---- pins ----

const char *mode_name(PinMode mode)
{
    switch (mode) {
    case PinMode::input:
        return "GPIO_MODE_INPUT";
    case PinMode::output:
        return "GPIO_MODE_OUTPUT";
    case PinMode::alternate:
        return "GPIO_MODE_ALTERNATE";
    case PinMode::analog:
        break;
    }
    return "GPIO_MODE_ANALOG";
}

const char *pull_name(Pull pull)
{
    switch (pull) {
    case Pull::up:
        return "GPIO_PULL_UP";
    case Pull::down:
        return "GPIO_PULL_DOWN";
    case Pull::none:
        break;
    }
    return "GPIO_PULL_NONE";
}

std::string pin_lines(const G4Board &board)
{
    std::vector<std::string> rows;
    rows.reserve(board.pins.size());
    for (const G4Pin &pin : board.pins) {
        rows.push_back(fmt::format("{}U, {}U, {}, {}U, {}, {}, \"{}\" /* {} */", g4_port(pin.name),
                                   g4_number(pin.name), mode_name(pin.mode), pin.function,
                                   pull_name(pin.pull), g4_truth(pin.high), pin.name, pin.use));
    }
    return g4_rows("PINS", rows);
}

std::string light_lines(const Config &config)
{
    const std::string &pin = config.hal.led_pin;
    const unsigned long set = pin.empty() ? 0 : 1UL << g4_number(pin);
    const unsigned long reset = set << 16;
    const bool inverted = config.hal.led_polarity == Polarity::active_low;
    return g4_line("LED_PORT", pin.empty() ? "GPIOA" : fmt::format("GPIO{}", pin[1]),
                   pin.empty() ? "there is no LED" : "hal.led_pin") +
           g4_line("LED_ON", g4_hex(inverted ? reset : set), "of GPIO_BSRR") +
           g4_line("LED_OFF", g4_hex(inverted ? set : reset), "of GPIO_BSRR");
}

// ---- timer ----

bool has_enables(const HalSettings &hal)
{
    return !hal.gate_enable_pins.empty();
}

bool has_inverted_lows(const HalSettings &hal)
{
    return !has_enables(hal) && hal.gate_low_polarity == Polarity::active_low;
}

// TIM1_CCER. An enable line is an output CHxN that is off: it has its inactive level, which the
// polarity makes high, while the main output is on, and its idle level otherwise.
unsigned long outputs(const HalSettings &hal)
{
    const unsigned long high = hal.gate_high_polarity == Polarity::active_low ? 0x3 : 0x1;
    const unsigned long low = has_enables(hal) ? 0x8 : (has_inverted_lows(hal) ? 0xC : 0x4);
    return (high | low) * 0x111;
}

// TIM1_CR2, OIS: the levels at which the gates are off.
unsigned long idle_levels(const HalSettings &hal)
{
    const unsigned long high = hal.gate_high_polarity == Polarity::active_low ? 1UL << 8 : 0;
    return (high | (has_inverted_lows(hal) ? 1UL << 9 : 0)) * 0x15;
}

std::string timer_lines(const Config &config, const G4Board &board)
{
    const HalSettings &hal = config.hal;
    const double ticks = has_enables(hal) ? 0 : config.board.dead_time_s * G4_CLOCK_HZ;
    std::string text = g4_line("DEAD_TIME_CODE", g4_unsigned(g4_dead_time_code(ticks)),
                               has_enables(hal) ? "the driver makes it" : "board.dead_time_s") +
                       g4_line("OUTPUTS", g4_hex(outputs(hal)), "TIM1_CCER") +
                       g4_line("IDLE_LEVELS", g4_hex(idle_levels(hal)), "TIM1_CR2, gates off");
    const char *const phases[] = {"A", "B", "C"};
    for (std::size_t phase = 0; phase < board.channels.size(); phase++) {
        text += g4_line(fmt::format("CCR_{}", phases[phase]),
                        fmt::format("TIM1_CCR{}", board.channels[phase]), "TIM1's channel");
    }
    return text + g4_line("WAKE_US",
                          g4_unsigned(static_cast<unsigned long>(std::ceil(hal.driver_wake_us))),
                          "hal.driver_wake_us");
}

// ---- over-current ----

bool opens_below(const Config &config)
{
    return config.hal.break_polarity == Polarity::active_low;
}

std::string comparator_source(int number, bool low)
{
    return fmt::format("TIM_AF1_BKCMP{}E{}", number,
                       low ? fmt::format(" | TIM_AF1_BKCMP{}P", number) : "");
}

std::string break_sources(const Config &config, const G4Board &board)
{
    const bool low = opens_below(config);
    if (board.comparators.empty()) {
        return low ? "TIM_AF1_BKINE | TIM_AF1_BKINP" : "TIM_AF1_BKINE";
    }
    std::string sources;
    for (const G4Comparator &comparator : board.comparators) {
        sources += (sources.empty() ? "" : " | ") + comparator_source(comparator.number, low);
    }
    return sources;
}

// The comparators 1 and 3 look at the first channel of DAC3, 2 and 4 at the second.
std::string comparator_lines(const Config &config, const G4Board &board)
{
    const bool low = opens_below(config);
    const char *const phases[] = {"a", "b", "c"};
    std::vector<std::string> settings;
    std::vector<std::string> paths;
    for (std::size_t phase = 0; phase < board.comparators.size(); phase++) {
        const G4Comparator &comparator = board.comparators[phase];
        const std::string name = fmt::format("COMP{}_CSR", comparator.number);
        settings.push_back(
            g4_setting(name, "~COMP_CSR_VALUE",
                       fmt::format("COMPARATOR | ({}UL << COMP_CSR_INPSEL_SHIFT)", comparator.plus),
                       "SETTINGS_READ_ONLY"));
        paths.push_back(fmt::format("{}, {}, DAC3_DHR12R{}, "
                                    "\"the comparator of phase {} does not open the gates\"",
                                    name, comparator_source(comparator.number, low),
                                    comparator.number % 2 == 1 ? 1 : 2, phases[phase]));
    }
    return g4_rows("COMPARATORS", settings) + g4_rows("PATHS", paths) +
           g4_line("HAS_COMPARATORS", g4_truth(!paths.empty()),
                   "false: the line at hal.break_pin trips");
}

std::string trip_lines(const Config &config, const G4Board &board)
{
    const bool has_line = board.comparators.empty();
    std::vector<std::string> levels;
    if (!has_line) {
        for (const auto &[name, value] :
             {std::pair("DAC3_MCR", "DAC_MCR_INTERNAL"),
              std::pair("DAC3_DHR12R1", "HAL_TRIP_COUNT"),
              std::pair("DAC3_DHR12R2", "HAL_TRIP_COUNT"), std::pair("DAC3_CR", "DAC_CR_BOTH")}) {
            levels.push_back(g4_setting(name, "ALL", value, "SETTINGS_LEVEL"));
        }
    }
    return g4_line("BREAK_SOURCES", break_sources(config, board), "TIM1_AF1") +
           g4_rows("LEVELS", levels) + comparator_lines(config, board);
}

// ---- converters ----

unsigned log2_of(int power)
{
    unsigned log2 = 0;
    while ((power >> (log2 + 1)) != 0) {
        log2++;
    }
    return log2;
}

std::string amplifier_lines(const Config &config, const G4Board &board)
{
    std::vector<std::string> rows;
    rows.reserve(board.amplifiers.size());
    for (const G4Amplifier &amplifier : board.amplifiers) {
        rows.push_back(
            g4_setting(fmt::format("OPAMP{}_CSR", amplifier.number), "OPAMP_CSR_COUNTED",
                       fmt::format("AMPLIFIER | ({}UL << OPAMP_CSR_VPSEL_SHIFT){}", amplifier.plus,
                                   amplifier.internal ? " | OPAMP_CSR_INTEN" : ""),
                       "SETTINGS_AMPLIFIERS"));
    }
    const unsigned gain = config.hal.pga_gain > 1 ? log2_of(config.hal.pga_gain) - 1 : 0;
    return g4_line("AMPLIFIER_GAIN", g4_unsigned(gain), "OPAMP_CSR_PGA_GAIN: 0 is 2, 1 is 4, …") +
           g4_rows("AMPLIFIERS", rows);
}

using Times = std::map<int, unsigned>; // codes of the sampling times, by channel

// One table for both converters: the sampling time belongs to what is connected to the channel.
// Where their inputs differ, each has its own.
Times sampling_times(const Config &config, const G4Board &board, int converter)
{
    std::vector<std::pair<G4Input, unsigned>> inputs = {{board.bus, LONGEST_SAMPLING},
                                                        {board.temperature, LONGEST_SAMPLING}};
    if (board.throttle) {
        inputs.emplace_back(*board.throttle, LONGEST_SAMPLING);
    }
    for (const G4Input &current : board.currents) {
        inputs.emplace_back(current, g4_sampling_code(config.hal.adc_sampling_ns));
    }
    Times times;
    for (const bool own : {false, true}) {
        for (const auto &[input, code] : inputs) {
            if ((input.converter == converter) == own) {
                times[input.channel] = code;
            }
        }
    }
    return times;
}

// ADC_SMPR1 or ADC_SMPR2, which begins with the channel `first`.
unsigned long sampling_register(const Times &times, int first)
{
    unsigned long value = 0;
    for (const auto &[channel, code] : times) {
        if ((channel >= CHANNELS_OF_SMPR1) == (first >= CHANNELS_OF_SMPR1)) {
            value |= static_cast<unsigned long>(code) << (3 * (channel - first));
        }
    }
    return value;
}

std::string injected_sequence(const std::vector<int> &channels)
{
    std::string text =
        channels.size() == 2 ? "ADC_JSQR_TWO | ADC_JSQR_TRIGGER" : "ADC_JSQR_TRIGGER";
    for (std::size_t k = 0; k < channels.size(); k++) {
        text += fmt::format(" | ({}UL << ADC_JSQR_SQ{}_SHIFT)", channels[k], k + 1);
    }
    return text;
}

std::string one_converter(const Config &config, const G4Board &board, int converter)
{
    std::vector<int> channels;
    for (const G4Input &current : board.currents) {
        if (current.converter == converter) {
            channels.push_back(current.channel);
        }
    }
    if (board.bus.converter == converter) {
        channels.push_back(board.bus.channel);
    }
    const std::string name = fmt::format("ADC{}_", converter);
    const bool measures = board.temperature.converter == converter;
    const bool follows = board.throttle && board.throttle->converter == converter;
    const int regular = measures  ? board.temperature.channel
                        : follows ? board.throttle->channel
                                  : channels.front();
    const Times times = sampling_times(config, board, converter);
    return g4_line(name + "SMPR1", g4_hex(sampling_register(times, 0)), "sampling times") +
           g4_line(name + "SMPR2", g4_hex(sampling_register(times, CHANNELS_OF_SMPR1)),
                   "the same") +
           g4_line(name + "REGULAR", g4_unsigned(static_cast<unsigned>(regular)),
                   measures  ? "hal.temperature_pin"
                   : follows ? "hal.throttle_pin"
                             : "not used") +
           g4_line(name + "REGULAR_HELD",
                   measures && follows ? "~(0x1FUL << ADC_SQR1_SQ1_SHIFT)" : "0xFFFFFFFFUL",
                   "bits of ADC_SQR1 that stay") +
           g4_line(name + "JSQR", injected_sequence(channels), "the injected sequence");
}

// Phases a and b are the first of their sequences, bus and phase c the second.
std::string result(G4Input input, int place)
{
    return fmt::format("ADC{} + ADC_JDR{}", input.converter, place);
}

std::string converter_lines(const Config &config, const G4Board &board)
{
    const bool has_c = board.currents.size() == 3;
    return amplifier_lines(config, board) + one_converter(config, board, 1) +
           one_converter(config, board, 2) +
           g4_line("RESULT_A", result(board.currents[0], 1), "phase a") +
           g4_line("RESULT_B", result(board.currents[1], 1), "phase b, at the same instant") +
           g4_line("MEASURES_C", g4_truth(has_c), "board.current_sensors") +
           g4_line("RESULT_C", result(has_c ? board.currents[2] : board.currents[1], has_c ? 2 : 1),
                   "phase c") +
           g4_line("RESULT_BUS", result(board.bus, 2), "hal.bus_pin") +
           g4_line("ADC_LAST", fmt::format("ADC{}", board.bus.converter),
                   "its sequence is the longest one") +
           g4_line("ADC_TEMPERATURE", fmt::format("ADC{}", board.temperature.converter),
                   "hal.temperature_pin");
}

// ---- serial line ----

std::string serial_lines(const G4Board &board)
{
    const std::string name = fmt::format("USART{}", board.usart);
    return g4_line("USART", name, "hal.serial_pins") +
           fmt::format("#define HAL_USART_BRR_NAME \"{}_BRR\"\n", name);
}

// ---- clocks of the peripherals ----

std::string peripheral_lines(const G4Board &board)
{
    unsigned long ports = 0;
    for (const G4Pin &pin : board.pins) {
        ports |= 1UL << g4_port(pin.name);
    }
    const G4InputClocks inputs = g4_input_clocks(board);
    const bool on_second = board.usart == 1;
    const std::string usart =
        fmt::format(" | RCC_{}_USART{}", on_second ? "APB2ENR" : "APB1ENR1", board.usart);
    return g4_line("AHB1", "RCC_AHB1ENR_CRC" + inputs.ahb1, "clocks that RCC_AHB1ENR switches on") +
           g4_line("AHB2",
                   g4_hex(ports) + " | RCC_AHB2ENR_ADC12" +
                       (board.comparators.empty() ? "" : " | RCC_AHB2ENR_DAC3"),
                   "the same for RCC_AHB2ENR") +
           g4_line("APB1",
                   "RCC_APB1ENR1_RTCAPB | RCC_APB1ENR1_PWR" + (on_second ? "" : usart) +
                       inputs.apb1,
                   "the same for RCC_APB1ENR1") +
           g4_line("APB2",
                   "RCC_APB2ENR_SYSCFG | RCC_APB2ENR_TIM1 | RCC_APB2ENR_TIM16" +
                       (on_second ? usart : "") + inputs.apb2,
                   "the same for RCC_APB2ENR");
}

} // namespace

unsigned g4_dead_time_code(double ticks)
{
    const auto whole = static_cast<unsigned>(std::ceil(ticks * (1 - 1e-9)));
    if (whole <= 127) {
        return whole;
    }
    if (whole <= 254) {
        return 0x80 | ((whole + 1) / 2 - 64);
    }
    if (whole <= 504) {
        return 0xC0 | ((whole + 7) / 8 - 32);
    }
    return 0xE0 | ((whole + 15) / 16 - 32);
}

unsigned g4_sampling_code(double ns)
{
    constexpr double HALF_CYCLES[LONGEST_SAMPLING] = {5, 13, 25, 49};
    unsigned code = 0;
    while (code < LONGEST_SAMPLING && HALF_CYCLES[code] * HALF_CYCLE_NS < ns * (1 - 1e-9)) {
        code++;
    }
    return code;
}

std::string g4_memory(const Config &config)
{
    const G4Chip &chip = *resolve_g4_board(config).chip;
    return fmt::format("/* {}: nfconfig makes this file of the board file. */\n"
                       "MEMORY\n{{\n"
                       "    flash (rx) : ORIGIN = 0x08000000, LENGTH = {}K\n"
                       "    ram (rw) : ORIGIN = 0x20000000, LENGTH = {}K\n}}\n",
                       chip.name, chip.flash_kib - KEPT_PAGES * PAGE_KIB, chip.ram_kib);
}

std::string g4_header(const Config &config)
{
    const G4Board board = resolve_g4_board(config);
    return chip_lines(board) + clock_lines(config, board) + pin_lines(board) + light_lines(config) +
           timer_lines(config, board) + trip_lines(config, board) + converter_lines(config, board) +
           serial_lines(board) + g4_input_lines(config, board) + peripheral_lines(board);
}

} // namespace nf
