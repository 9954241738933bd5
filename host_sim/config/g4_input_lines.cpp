// SPDX-License-Identifier: MIT
#include "g4_input_lines.h"

#include "acts.h"
#include "g4_family.h"
#include "g4_text.h"
#include "refusal.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr char PULSES_GROUP[] = "SETTINGS_PULSES";
constexpr char SHAFT_GROUP[] = "SETTINGS_SHAFT";

std::string count_of(int count)
{
    return g4_unsigned(static_cast<unsigned long>(count));
}

// The port of a pin, and its bit there. Without a pin they are not used.
std::string pin_lines(const std::string &name, const std::string &pin, const std::string &meaning)
{
    return g4_line(name + "_PORT", pin.empty() ? "GPIOA" : fmt::format("GPIO{}", pin[1]),
                   pin.empty() ? "not used" : meaning) +
           g4_line(name + "_BIT", count_of(pin.empty() ? 0 : g4_number(pin)), "of that port");
}

// ---- throttle and button ----

std::string throttle_lines(const G4Board &board)
{
    const bool has_one = board.throttle.has_value();
    const G4Input throttle = board.throttle.value_or(board.temperature);
    return g4_line("HAS_THROTTLE", g4_truth(has_one), "hal.throttle_pin") +
           g4_line("ADC_THROTTLE", fmt::format("ADC{}", throttle.converter),
                   has_one ? "its converter" : "not used") +
           g4_line("THROTTLE_CHANNEL", count_of(throttle.channel),
                   has_one ? "its channel" : "not used") +
           g4_line("TEMPERATURE_CHANNEL", count_of(board.temperature.channel),
                   "hal.temperature_pin");
}

std::string button_lines(const HalSettings &hal)
{
    return g4_line("HAS_BUTTON", g4_truth(!hal.button_pin.empty()), "hal.button_pin") +
           pin_lines("BUTTON", hal.button_pin, "the same") +
           g4_line("BUTTON_LOW", g4_truth(hal.button_polarity == Polarity::active_low),
                   "hal.button_polarity");
}

// ---- pulses ----

// The pair of channels that looks at the input: rising edges at the odd one, falling ones at the
// even one.
int rising_channel(int channel)
{
    return channel - (channel - 1) % 2;
}

// Its code in CCMR: the first channel has its own input, or that of the second one.
std::string capture_mode(int channel)
{
    return channel % 2 == 1 ? "TIM_CCMR_BOTH_OF_FIRST" : "TIM_CCMR_BOTH_OF_SECOND";
}

std::vector<std::string> pulse_rows(int channel)
{
    const int rise = rising_channel(channel);
    const int enable = 4 * (rise - 1);
    std::vector<std::string> rows;
    for (int k = 0; k < 2; k++) {
        rows.push_back(g4_setting(fmt::format("DMAMUX1_C{}CR", k), "ALL",
                                  fmt::format("DMAMUX_TIM2_CH{}", rise + k), PULSES_GROUP));
        rows.push_back(g4_setting(fmt::format("DMA1_CPAR{}", k + 1), "ALL",
                                  fmt::format("TIM2 + TIM_CCR{}", rise + k), PULSES_GROUP));
        rows.push_back(g4_setting(fmt::format("DMA1_CMAR{}", k + 1), "ALL",
                                  k == 0 ? "PULSES_OF_RISES" : "PULSES_OF_FALLS", PULSES_GROUP));
        rows.push_back(
            g4_setting(fmt::format("DMA1_CCR{}", k + 1), "ALL", "DMA_CCR_RING", PULSES_GROUP));
    }
    const auto add = [&](const std::string &offset, const std::string &value, const char *group) {
        rows.push_back(g4_setting_of("TIM2", offset, value, group));
    };
    add("TIM_PSC", "PULSES_PRESCALER", PULSES_GROUP);
    add("TIM_ARR", "ALL", PULSES_GROUP);
    add(fmt::format("TIM_CCMR{}", rise == 1 ? 1 : 2), capture_mode(channel), PULSES_GROUP);
    add("TIM_CCER", fmt::format("TIM_CCER_RISE_FALL << {}", enable), PULSES_GROUP);
    add("TIM_DIER", fmt::format("TIM_DIER_TWO << {}", rise - 1), PULSES_GROUP);
    add("TIM_CR1", "TIM_CR1_CEN", "SETTINGS_READ_ONLY");
    return rows;
}

std::string pulse_lines(const G4Board &board)
{
    const int channel = board.pulse_channel;
    const bool has_some = channel > 0;
    const int rise = has_some ? rising_channel(channel) : 1;
    return g4_line("HAS_PULSES", g4_truth(has_some), "hal.pulse_pin") +
           g4_line("PULSES_LOST", fmt::format("TIM_SR_TWO_LOST << {}", rise - 1),
                   has_some ? "an edge was not taken in time" : "not used") +
           g4_rows("PULSE_SETTINGS", has_some ? pulse_rows(channel) : std::vector<std::string>{});
}

// ---- sensor of the shaft ----

// A sensor that the drive uses has to have pins.
void need_pins(const Config &config, const char *kind, const char *key, std::size_t least)
{
    const HalSettings &hal = config.hal;
    const std::string name = key;
    const std::size_t pins = name == "hal.hall_pins"      ? hal.hall_pins.size()
                             : name == "hal.encoder_pins" ? hal.encoder_pins.size()
                                                          : hal.spi_encoder_pins.size();
    if (pins < least) {
        fail(config.origins.at("sensor.kind"), "sensor.kind", fmt::format("\"{}\"", kind),
             "has no pins on this board", fmt::format("a board with {} pins in {}", least, key));
    }
}

// A board knows no angle that no sensor tells it.
void need_sensor(const Config &config)
{
    if (has_ideal_sensor(config)) {
        fail(config.origins.at("drive.angle_source"), "drive.angle_source",
             has_both(config) ? "\"both\"" : "\"sensor\"", "has no sensor: sensor.kind is \"none\"",
             "\"observer\", or a sensor.kind that this board has pins for");
    }
}

// Where one connector is for several sensors, it is the one that the drive uses.
std::string sensor_of(const Config &config)
{
    const HalSettings &hal = config.hal;
    const SensorKind kind = has_angle_sensor(config) ? config.motor.sensor.kind : SensorKind::none;
    need_sensor(config);
    if (kind == SensorKind::hall) {
        need_pins(config, "hall", "hal.hall_pins", 3);
        return "BOARD_SHAFT_HALL";
    }
    if (kind == SensorKind::encoder || kind == SensorKind::encoder_index) {
        const bool index = kind == SensorKind::encoder_index;
        need_pins(config, index ? "encoder_index" : "encoder", "hal.encoder_pins", index ? 3 : 2);
        return "BOARD_SHAFT_ENCODER";
    }
    if (kind == SensorKind::absolute) {
        need_pins(config, "absolute", "hal.spi_encoder_pins", 4);
        return "BOARD_SHAFT_ABSOLUTE";
    }
    return !hal.spi_encoder_pins.empty() ? "BOARD_SHAFT_ABSOLUTE"
           : !hal.hall_pins.empty()      ? "BOARD_SHAFT_HALL"
           : !hal.encoder_pins.empty()   ? "BOARD_SHAFT_ENCODER"
                                         : "BOARD_SHAFT_NONE";
}

void add_encoder_rows(std::vector<std::string> &rows, const G4Board &board)
{
    const std::string timer = fmt::format("TIM{}", board.encoder_timer);
    const int index = board.index_channel;
    const auto add = [&](const std::string &offset, const std::string &value) {
        rows.push_back(g4_setting_of(timer, offset, value, SHAFT_GROUP));
    };
    add("TIM_CCMR1", "TIM_CCMR_ENCODER");
    if (index > 0) {
        add("TIM_CCMR2", fmt::format("TIM_CCMR_INDEX << {}", 8 * (index - 3)));
        add("TIM_CCER", fmt::format("TIM_CCER_CC1E << {}", 4 * (index - 1)));
    }
    add("TIM_SMCR", "TIM_SMCR_ENCODER_3");
    add("TIM_ARR", "0xFFFFU");
    add("TIM_CR1", "TIM_CR1_CEN");
}

// Counts of the timer in a control tick. It counts 16 bits.
struct HallClock {
    long divider;
    long counts;
};

HallClock hall_clock(const BoardSettings &board)
{
    const long all = std::lround(board.timer_clock_hz / board.pwm_frequency_hz);
    const long divider = all / 65536 + 1;
    return {divider, all / divider};
}

// Each edge of the three signals, which differ from their exclusive or's last level, sets the
// counter to 0.
void add_hall_rows(std::vector<std::string> &rows, const Config &config, int number)
{
    const std::string timer = fmt::format("TIM{}", number);
    const auto add = [&](const std::string &offset, const std::string &value) {
        rows.push_back(g4_setting_of(timer, offset, value, SHAFT_GROUP));
    };
    add("TIM_CR2", "TIM_CR2_TI1S");
    add("TIM_CCMR1", "TIM_CCMR_INDEX");
    add("TIM_SMCR", "TIM_SMCR_RESET_BY_EDGES");
    add("TIM_PSC", fmt::format("{}U", hall_clock(config.board).divider - 1));
    add("TIM_ARR", "0xFFFFU");
    add("TIM_CR1", "TIM_CR1_CEN");
}

std::string shaft_lines(const Config &config, const G4Board &board)
{
    const HalSettings &hal = config.hal;
    const int index = board.index_channel;
    std::vector<std::string> rows;
    const std::string sensor_name = sensor_of(config);
    const bool timed = board.hall_timer > 0 && sensor_name == "BOARD_SHAFT_HALL";
    const int timer = timed ? board.hall_timer : board.encoder_timer;
    std::string text = g4_line("SHAFT", sensor_name, "the sensor of the shaft");
    for (std::size_t sensor = 0; sensor < 3; sensor++) {
        text += pin_lines(fmt::format("HALL_{}", sensor + 1),
                          hal.hall_pins.empty() ? "" : hal.hall_pins[sensor], "hal.hall_pins");
    }
    if (timed) {
        add_hall_rows(rows, config, timer);
    } else if (timer > 0) {
        add_encoder_rows(rows, board);
    }
    if (board.spi > 0) {
        const std::string spi = fmt::format("SPI{}", board.spi);
        rows.push_back(g4_setting_of(spi, "SPI_CR2", "SPI_CR2_16_BITS", SHAFT_GROUP));
        rows.push_back(g4_setting_of(spi, "SPI_CR1", "SPI_CR1_ENCODER", SHAFT_GROUP));
    }
    return text +
           g4_line("SHAFT_TIMER", timer > 0 ? fmt::format("TIM{}", timer) : "TIM4",
                   "of the encoder or the Hall sensors") +
           g4_line("HALL_AGE_Q24",
                   timed ? fmt::format("{}U", 0x1000000 / hall_clock(config.board).counts) : "0U",
                   "ticks in a count of it; 0: no time of Hall edges") +
           g4_line("HAS_INDEX", g4_truth(index > 0), "its index") +
           g4_line("INDEX_SEEN", fmt::format("TIM_SR_CC1IF << {}", index > 0 ? index - 1 : 0),
                   "the index was captured") +
           g4_line("INDEX_AT", fmt::format("TIM_CCR{}", index > 0 ? index : 3),
                   "the count at the index") +
           g4_line("SPI", fmt::format("SPI{}", board.spi > 0 ? board.spi : 1),
                   "hal.spi_encoder_pins") +
           pin_lines("SPI_CS", board.spi > 0 ? hal.spi_encoder_pins[3] : "", "its chip select") +
           g4_rows("SHAFT_SETTINGS", rows);
}

} // namespace

std::string g4_input_lines(const Config &config, const G4Board &board)
{
    return throttle_lines(board) + button_lines(config.hal) + pulse_lines(board) +
           shaft_lines(config, board);
}

G4InputClocks g4_input_clocks(const G4Board &board)
{
    G4InputClocks clocks;
    if (board.pulse_channel > 0) {
        clocks.ahb1 = " | RCC_AHB1ENR_DMA1 | RCC_AHB1ENR_DMAMUX1";
        clocks.apb1 = " | RCC_APB1ENR1_TIM2";
    }
    if (board.hall_timer > 0 && board.hall_timer != board.encoder_timer) {
        clocks.apb1 += fmt::format(" | RCC_APB1ENR1_TIM{}", board.hall_timer);
    }
    if (board.encoder_timer > 0) {
        clocks.apb1 += fmt::format(" | RCC_APB1ENR1_TIM{}", board.encoder_timer);
    }
    if (board.spi == 1) {
        clocks.apb2 = " | RCC_APB2ENR_SPI1";
    } else if (board.spi > 1) {
        clocks.apb1 += fmt::format(" | RCC_APB1ENR1_SPI{}", board.spi);
    }
    return clocks;
}

} // namespace nf
