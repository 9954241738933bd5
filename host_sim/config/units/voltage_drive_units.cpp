// SPDX-License-Identifier: MIT
#include "voltage_drive_units.h"

#include "numbers.h"
#include "phase_compensator_units.h"
#include "virtual_resistance_units.h"

#include <algorithm>
#include <cmath>

namespace nf
{

voltage_drive_cfg_t make_voltage_drive(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    const double base = 2 * b.speed_el_rad_s / b.voltage_v; // of the speed error, in U_b
    const char *const reason = "more is beyond the firmware's gains";
    voltage_drive_cfg_t c{};
    if (tuning.method != ControlMethod::voltage_phase) {
        return c;
    }
    const Source kp = {"voltage_loop.kp_v_s_per_rad", tuning.voltage_kp_v_s_per_rad};
    const Source ki = {"voltage_loop.ki_v_per_rad", tuning.voltage_ki_v_per_rad};
    const Mantissa p = normalise(tuning.voltage_kp_v_s_per_rad * base, 1, 30, kp, reason);
    const Mantissa i = normalise(std::ldexp(tuning.voltage_ki_v_per_rad * base * slow_period, 11),
                                 1, 30, ki, reason);
    c.enabled = 1;
    c.pi.kp = p.value;
    c.pi.kp_shift = p.shift;
    c.pi.ki = i.value;
    c.pi.ki_shift = i.shift;
    const double slowest_pct =
        std::max(tuning.voltage_speed_pct, ABOVE_HANDOVER * tuning.handover_speed_pct);
    require(slowest_pct / 100 * motor.rated_speed_rpm, 0, motor.max_speed_rpm,
            {"motor.rated_speed_rpm", motor.rated_speed_rpm},
            "the share voltage_loop.speed_min_pct of it is within motor.max_speed_rpm");
    keep(c.speed_min, b.step_from_rpm(slowest_pct / 100 * motor.rated_speed_rpm), 0, Q30 / 2);
    store(c.settle_periods, tuning.voltage_settle_s / slow_period, 1, 10000,
          {"voltage_loop.settle_s", tuning.voltage_settle_s}, "10000 periods of the speed loop");
    c.compensator = make_compensator(motor, tuning, b);
    c.damping = make_virtual_resistance(tuning, b);
    return c;
}

} // namespace nf
