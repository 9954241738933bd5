// SPDX-License-Identifier: MIT
#include "stages.h"

#include "vocabulary.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf::debug
{

namespace
{

const std::vector<Stage> STAGES = {
    {"raw ADC", {"in.adc_ia", "in.adc_ib", "in.adc_bus"}},
    {"angle sensor, speed and angle that follow it",
     {"in.angle", "drive.rotor.angle_sensor.speed", "angle_estimated_el_deg"},
     "cfg.sampling.sensor_pole_pairs"},
    {"per unit, offset removed", {"i_a_measured_a", "i_b_measured_a", "drive.bus"}},
    {"Clarke: stationary frame", {"i_alpha_a", "i_beta_a"}},
    {"Park: estimated rotor frame", {"i_d_measured_a", "i_q_measured_a"}},
    {"voltage of the last period", {"v_alpha_applied_v", "v_beta_applied_v"}},
    {"network (14)-(16): states and output",
     {"drive.rotor.observer.state.d", "drive.rotor.observer.state.q",
      "drive.rotor.observer.current.d", "drive.rotor.observer.current.q"}},
    {"error (17), and rotated by its static part",
     {"drive.rotor.observer.error.d", "drive.rotor.observer.error.q",
      "drive.rotor.observer.rotated_error.d", "drive.rotor.observer.rotated_error.q"}},
    {"training (18)-(21): gradient, weight change dW2/T",
     {"drive.rotor.observer.gradient", "weight_change_rpm"}},
    {"speed (22) and inner speed",
     {"drive.rotor.observer.speed", "drive.rotor.observer.speed_out"}},
    {"flying start: pulses of a short circuit, what they found",
     {"drive.start.flying_start.phase", "drive.start.flying_start.tick",
      "drive.start.flying_start.length", "drive.start.flying_start.gates",
      "drive.start.flying_start.first.alpha", "drive.start.flying_start.first.beta",
      "drive.start.flying_start.speed", "drive.start.flying_start.angle"},
     nullptr,
     true,
     {DRIVE_STATE_FLYING_START}},
    {"alignment: vector, means of voltage and current, what pulse and step made of the current",
     {"drive.start.align.phase", "drive.start.align.tick", "drive.start.align.current_ref",
      "drive.start.align.frame_speed", "drive.start.align.high.voltage",
      "drive.start.align.high.current", "drive.start.align.low.voltage",
      "drive.start.align.low.current", "drive.start.align.inductance.pulse.change.q",
      "drive.start.align.inductance.pulse.change.d", "drive.start.align.inductance.step.change.d"},
     nullptr,
     true,
     {DRIVE_STATE_ALIGN}},
    {"probe: ticks of its window, speed of the vector before damping, lag",
     {"drive.probe.tick", "drive.probe.own_speed", "drive.probe.lag_q15"},
     nullptr,
     true,
     {DRIVE_STATE_PROBE}},
    {"imposed current: its frame, the current in it, how well the rotor follows",
     {"drive.vector.position.turns_q32", "drive.vector.step", "i_d_vector_a", "i_q_vector_a",
      "drive.vector.current_mean.d", "drive.vector.current_mean.q", "drive.rotor.residual",
      "drive.start.lost_periods", "drive.start.handover_periods", "drive.start.attempts"},
     nullptr,
     true,
     {DRIVE_STATE_ALIGN, DRIVE_STATE_HOLD, DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER}},
    {"speed PI, in the last tick of a slow period: ticks to it, planned and ramped reference, "
     "integral, range",
     {"drive.slow_count", "drive.motion.speed_reference", "drive.motion.speed_loop.reference",
      "drive.motion.speed_loop.pi.integral_q26", "drive.motion.torque_range.lower",
      "drive.motion.torque_range.upper"},
     nullptr,
     true,
     {DRIVE_STATE_RUN}},
    {"low-pass of the torque current, in the same tick",
     {"drive.motion.torque_filter.smooth_q26"},
     "cfg.torque_filter.smooth_rate_q15",
     true,
     {DRIVE_STATE_RUN}},
    {"notch of the torque current, in the same tick: from where it counts, swing that it takes off",
     {"drive.motion.torque_filter.origin", "drive.motion.torque_filter.swing_q26.d",
      "drive.motion.torque_filter.swing_q26.q"},
     "cfg.torque_filter.notch_share_q15",
     true,
     {DRIVE_STATE_RUN}},
    {"references",
     {"speed_reference_rpm", "drive.control.current_ref.d", "drive.control.current_ref.q"},
     "drive.voltage_drive.active",
     false},
    {"model of the current loop, once a slow period: reactances; R.i* and EMF",
     {"drive.control.current_loop.reactance_q14.d", "drive.control.current_loop.reactance_q14.q",
      "drive.control.current_loop.constant.d", "drive.control.current_loop.constant.q"},
     "drive.voltage_drive.active",
     false},
    {"current loop: voltages",
     {"v_limit_v", "drive.control.voltage.d", "drive.control.voltage.q"},
     "drive.voltage_drive.active",
     false},
    {"speed loop: magnitude of the voltage",
     {"speed_reference_rpm", "v_limit_v", "drive.voltage_drive.magnitude"},
     "drive.voltage_drive.active"},
    {"phase compensator (40)-(43): lead, angle of the current, firing angle of the next tick",
     {"lead_el_deg", "drive.voltage_drive.compensator.current_angle",
      "drive.voltage_drive.compensator.angle"},
     "drive.voltage_drive.active"},
    {"voltage drive: voltages, mean of the current from which the virtual resistance counts",
     {"drive.control.voltage.d", "drive.control.voltage.q",
      "drive.voltage_drive.damping.mean_q30.d", "drive.voltage_drive.damping.mean_q30.q"},
     "drive.voltage_drive.active"},
    {"modulator: ratio of the bus, compare values",
     {"drive.control.ratio_next.alpha", "drive.control.ratio_next.beta", "out.compare.phase[0]",
      "out.compare.phase[1]", "out.compare.phase[2]", "out.gate_enable"}},
    {"rotor position (23) of the next tick", {"drive.rotor.position.turns_q32"}},
};

bool is_shown(const Stage &stage, const Tick &tick)
{
    const int64_t flag =
        stage.flag == nullptr ? 1 : raw_value(*find_signal(stage.flag), tick).value_or(1);
    const std::vector<drive_state_t> &states = stage.states;
    const bool here =
        states.empty() || std::count(states.begin(), states.end(), tick.sim->drive().state) != 0;
    return here && (flag != 0) == stage.shown_with;
}

} // namespace

const std::vector<Stage> &all_stages()
{
    return STAGES;
}

std::vector<const Stage *> stages_of(const Tick &tick)
{
    std::vector<const Stage *> shown;
    for (const Stage &stage : STAGES) {
        if (is_shown(stage, tick)) {
            shown.push_back(&stage);
        }
    }
    return shown;
}

std::string stages_text(const Tick &tick)
{
    std::string text;
    for (const Stage *const stage : stages_of(tick)) {
        text += fmt::format("{}\n", stage->title);
        for (const char *const name : stage->signals) {
            text += fmt::format("  {}\n", signal_line(named_signal(name), tick));
        }
    }
    return text;
}

} // namespace nf::debug
