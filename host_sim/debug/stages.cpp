#include "stages.h"

#include "vocabulary.h"

#include <fmt/format.h>

namespace nf::debug
{

const std::vector<Stage> &all_stages()
{
    static const std::vector<Stage> all = {
        {"raw ADC", {"in.adc_ia", "in.adc_ib", "in.adc_bus"}},
        {"angle sensor, speed and angle that follow it",
         {"in.angle", "drive.frame_speed", "angle_estimated_el_deg"},
         "cfg.sampling.sensor_pole_pairs"},
        {"per unit, offset removed",
         {"drive.signals.phase_a", "drive.signals.phase_b", "drive.signals.bus"}},
        {"Clarke: stationary frame",
         {"drive.signals.current_ab.alpha", "drive.signals.current_ab.beta"}},
        {"Park: estimated rotor frame", {"drive.signals.current.d", "drive.signals.current.q"}},
        {"voltage of the last period",
         {"drive.signals.voltage_applied.alpha", "drive.signals.voltage_applied.beta"}},
        {"network (14)-(16): states and output",
         {"drive.observer.state.d", "drive.observer.state.q", "drive.observer.current.d",
          "drive.observer.current.q"}},
        {"error (17), and turned by its static part",
         {"drive.observer.error.d", "drive.observer.error.q", "drive.observer.turned.d",
          "drive.observer.turned.q"}},
        {"training (18)-(21): descent, weight change dW2/T",
         {"drive.observer.descent", "weight_change_rpm"}},
        {"speed (22) and inner speed", {"drive.observer.speed", "drive.observer.speed_out"}},
        {"references",
         {"speed_reference_rpm", "drive.signals.current_ref.d", "drive.signals.current_ref.q"},
         "drive.voltage_driven",
         false},
        {"current loop: voltages",
         {"drive.signals.voltage_limit", "drive.signals.voltage.d", "drive.signals.voltage.q"},
         "drive.voltage_driven",
         false},
        {"speed loop: magnitude of the voltage",
         {"speed_reference_rpm", "drive.signals.voltage_limit", "drive.voltage_magnitude"},
         "drive.voltage_driven"},
        {"phase compensator (40)-(43): lead, angle of the current, firing angle of the next tick",
         {"lead_el_deg", "drive.compensator.current_angle", "drive.compensator.angle"},
         "drive.voltage_driven"},
        {"voltage drive: voltages, mean of the current",
         {"drive.signals.voltage.d", "drive.signals.voltage.q", "drive.signals.current_ref.d",
          "drive.signals.current_ref.q"},
         "drive.voltage_driven"},
        {"modulator: ratio of the bus, compare values",
         {"drive.signals.ratio_ab.alpha", "drive.signals.ratio_ab.beta", "out.compare.phase[0]",
          "out.compare.phase[1]", "out.compare.phase[2]", "out.gate_enable"}},
        {"rotor position (23) of the next tick", {"drive.position.turns_q32"}},
    };
    return all;
}

namespace
{

bool is_shown(const Stage &stage, const Tick &tick)
{
    const int64_t flag =
        stage.flag == nullptr ? 1 : raw_value(*find_signal(stage.flag), tick).value_or(1);
    return (flag != 0) == stage.shown_with;
}

} // namespace

std::string stages_text(const Tick &tick)
{
    std::string text;
    for (const Stage &stage : all_stages()) {
        if (!is_shown(stage, tick)) {
            continue;
        }
        text += fmt::format("{}\n", stage.title);
        for (const char *const name : stage.signals) {
            text += fmt::format("  {}\n", signal_line(named_signal(name), tick));
        }
    }
    return text;
}

} // namespace nf::debug
