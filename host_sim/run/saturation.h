/* SPDX-License-Identifier: MIT */
// Which of the drive's signals are at the end of their range, counted from outside: after each tick
// the values that the firmware keeps anyway are compared with the values that it clamps them to.
//
// Internal: a value that was clamped because its format ended, so that the arithmetic no longer
// does what the equations say. Limit: a value that a controller is meant to keep within (torque,
// voltage circle, duty); running into it is normal in a transient.
#pragma once

extern "C" {
#include "drive.h"
}

#include <array>
#include <cstddef>
#include <cstdint>

namespace nf
{

enum class Signal : std::size_t {
    phase_a, // measured current less its offset
    phase_b,
    bus,
    bus_reciprocal,
    network_alpha,
    network_beta,
    network_error_d,
    network_error_q,
    network_weight_step,
    network_speed, // ω̂
    integral_d,    // of the current loop
    integral_q,
    integral_speed, // of the speed loop
    speed_error,
    position_lag, // of the position loop
    torque,       // limits from here on: i_q* at an end of its range
    voltage,      // demand on the voltage circle
    ratio,        // demand over bus at its largest
    duty,         // a compare value at 0 or timer_counts
    count
};

constexpr std::size_t SIGNAL_COUNT = static_cast<std::size_t>(Signal::count);
constexpr std::size_t FIRST_LIMIT = static_cast<std::size_t>(Signal::torque);

const char *signal_name(std::size_t signal);

class Saturations
{
public:
    // A tick while the drive runs; `sample` is what it has measured.
    void add(const drive_t &drive, const sample_t &sample, const drive_out_t &out);

    // Ticks at the end of the range, by signal.
    const std::array<uint64_t, SIGNAL_COUNT> &ticks() const
    {
        return ticks_;
    }
    // Sum over the internal signals.
    uint64_t internal_count() const;

private:
    std::array<uint64_t, SIGNAL_COUNT> ticks_{};
};

} // namespace nf
