// SPDX-License-Identifier: MIT
#include "per_unit.h"

#include "current_loop_units.h"
#include "current_reference_units.h"
#include "derating_units.h"
#include "hold_loop_units.h"
#include "input_units.h"
#include "link_units.h"
#include "model_units.h"
#include "modulator_units.h"
#include "motion_loop_units.h"
#include "motor_model.h"
#include "nn_observer_units.h"
#include "oscillation_units.h"
#include "protection_units.h"
#include "rules.h"
#include "run_units.h"
#include "safe_state_units.h"
#include "sampling_units.h"
#include "sensor_units.h"
#include "setting_error.h"
#include "startup_units.h"
#include "supervision_units.h"
#include "torque_filter_units.h"
#include "torque_loop_units.h"
#include "voltage_drive_units.h"
#include "weakening_units.h"

extern "C" {
#include "config_check.h"
#include "config_guard.h"
}

#include <stdexcept>

#include <fmt/format.h>

namespace nf
{
namespace
{

drive_cfg_t convert(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &tuning, const ModelScales &scales)
{
    const Bases b = make_bases(motor, board);
    const Model m = make_model(motor, scales);
    check_speed(motor, board, tuning, m, b);
    drive_cfg_t c{};
    c.sampling = make_sampling(motor, board, tuning);
    c.protection = make_protection(board, b);
    const double period_s = b.control_period_s * tuning.slow_ticks * SUPERVISION_STEPS;
    c.derating = make_derating(motor, board, period_s, b);
    c.supervision = make_supervision(motor, board, tuning, m, period_s, b);
    c.oscillation = make_oscillation(motor, tuning, b);
    c.observer = make_observer(motor, board, tuning, m, b);
    c.current_loop = make_current_loop(motor, tuning, m, b);
    c.speed_loop = make_speed_loop(motor, tuning, m, b);
    c.position_loop = make_position_loop(motor, tuning, b);
    c.modulator = make_modulator(board, tuning, scales, m, b);
    c.hold_loop = make_hold_loop(c.current_loop, motor, board, tuning, scales, m, b);
    c.startup = make_startup(motor, board, tuning, scales, m, b);
    c.current_reference = make_current_reference(motor, board, tuning, scales, m, b);
    c.run = make_run(tuning);
    c.model = make_model_cfg(motor, tuning, m, b);
    c.voltage_drive = make_voltage_drive(motor, tuning, b);
    c.torque_filter = make_torque_filter(tuning, b);
    c.torque_loop = make_torque_loop(motor, tuning, c.speed_loop, b);
    c.safe_state = make_safe_state(motor, board, b);
    c.link = make_link(tuning, b);
    c.console = make_console(tuning, b);
    c.input = make_input(tuning.input, b);
    c.sensor = make_sensor(motor, tuning, b);
    c.speed_shift = static_cast<uint32_t>(b.speed_shift);
    c.slow_ticks = static_cast<uint32_t>(tuning.slow_ticks);
    c.crc = config_guard_crc(&c);
    return c;
}

// Each round moves one end of one rule's range; a rule that is moved this often contradicts the
// others.
constexpr int RULE_ROUNDS = 64;
// A value that its limit was computed for is within it in spite of rounding.
constexpr double INWARDS = 1e-9;

// Moves the range of a rule whose value was refused; false where the value is written.
bool narrow(RuleRanges &ranges, const SettingError &error, const TuningSettings &as_written)
{
    if (rule_source(error.key, as_written) == nullptr) {
        return false;
    }
    RuleRange &range = ranges[error.key];
    if (error.limit.at_most) {
        range.most = error.limit.value * (1 - INWARDS);
    } else {
        range.least = error.limit.value * (1 + INWARDS);
    }
    return range.least <= range.most;
}

} // namespace

TuningSettings settled_tuning(const MotorSettings &motor, const BoardSettings &board,
                              const TuningSettings &as_written, const ModelScales &scales)
{
    RuleRanges ranges;
    for (int round = 0;; round++) {
        const TuningSettings tuning =
            for_sensor(by_rules(as_written, motor, board, scales, ranges));
        try {
            convert(motor, board, tuning, scales);
            return tuning;
        } catch (const SettingError &error) {
            if (round == RULE_ROUNDS || !narrow(ranges, error, as_written)) {
                throw;
            }
        }
    }
}

drive_cfg_t make_drive_cfg(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &as_written, const ModelScales &scales)
{
    const drive_cfg_t c =
        convert(motor, board, settled_tuning(motor, board, as_written, scales), scales);
    if (const char *bad = config_check(&c)) {
        throw std::logic_error(fmt::format("{} is outside its range", bad));
    }
    return c;
}

} // namespace nf
