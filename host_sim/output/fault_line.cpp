// SPDX-License-Identifier: MIT
#include "fault_line.h"

#include "numbers.h"
#include "temperature_sensor.h"

extern "C" {
#include "fault_text.h"
}

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double Q14 = 16384.0;

std::string quantity(fault_unit_t unit, int32_t value, const Bases &bases)
{
    switch (unit) {
    case FAULT_UNIT_CURRENT:
        return fmt::format("{:.4g} A", value / Q15 * bases.current_a);
    case FAULT_UNIT_VOLTAGE:
        return fmt::format("{:.4g} V", value / Q15 * bases.voltage_v);
    case FAULT_UNIT_SPEED:
        return fmt::format("{:.5g} rpm", bases.rpm_from_step(value));
    case FAULT_UNIT_HEAT:
        return fmt::format("{:.4g} %", value / Q14 * 100);
    case FAULT_UNIT_TEMPERATURE:
        return fmt::format("{} counts", value);
    case FAULT_UNIT_WORD:
        return fmt::format("0x{:08X}", static_cast<uint32_t>(value));
    case FAULT_UNIT_NONE:
        break;
    }
    return fmt::format("{}", value);
}

} // namespace

std::string fault_mark(const fault_t &fault, double time_s)
{
    return fmt::format("{}@{} ({:.6g} s)", fault_text(fault.id)->name, fault.tick, time_s);
}

std::string fault_measure(const FoundFault &fault, const Bases &bases, const BoardSettings *board)
{
    const fault_text_t &text = *fault_text(fault.id);
    if (text.unit == FAULT_UNIT_TEMPERATURE && board != nullptr) {
        return fmt::format("{}: {:.1f} °C, limit {:.1f} °C", text.name,
                           temperature_at(*board, fault.value),
                           temperature_at(*board, fault.limit));
    }
    return fmt::format("{}: {}{}, limit {}", text.name, quantity(text.unit, fault.value, bases),
                       fault.swing_hz ? fmt::format(" at {:.1f} Hz", *fault.swing_hz) : "",
                       quantity(text.unit, fault.limit, bases));
}

} // namespace nf
