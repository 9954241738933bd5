#include "stages.h"

#include "vocabulary.h"

#include <vector>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

// In ticks of which kind.
enum class Shown {
    always,
    with_sensor,
    with_regulators,
    voltage_driven
};

struct Stage {
    const char *title;
    std::vector<const char *> signals;
    Shown shown = Shown::always;
};

const std::vector<Stage> &stages()
{
    static const std::vector<Stage> all = {
        {"raw ADC", {"in.adc_ia", "in.adc_ib", "in.adc_bus"}},
        {"angle sensor, speed and angle that follow it",
         {"in.angle", "drive.frame_speed", "angle_estimated_el_deg"},
         Shown::with_sensor},
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
         Shown::with_regulators},
        {"current loop: voltages",
         {"drive.signals.voltage_limit", "drive.signals.voltage.d", "drive.signals.voltage.q"},
         Shown::with_regulators},
        {"speed loop: magnitude of the voltage",
         {"speed_reference_rpm", "drive.signals.voltage_limit", "drive.voltage_magnitude"},
         Shown::voltage_driven},
        {"phase compensator (40)-(43): lead, angle of the current, firing angle of the next tick",
         {"lead_el_deg", "drive.compensator.current_angle", "drive.compensator.angle"},
         Shown::voltage_driven},
        {"voltage drive: voltages, mean of the current",
         {"drive.signals.voltage.d", "drive.signals.voltage.q", "drive.signals.current_ref.d",
          "drive.signals.current_ref.q"},
         Shown::voltage_driven},
        {"modulator: ratio of the bus, compare values",
         {"drive.signals.ratio_ab.alpha", "drive.signals.ratio_ab.beta", "out.compare.phase[0]",
          "out.compare.phase[1]", "out.compare.phase[2]", "out.gate_enable"}},
        {"rotor position (23) of the next tick", {"drive.position.turns_q32"}},
    };
    return all;
}

bool is_shown(const Stage &stage, const Simulation &sim)
{
    switch (stage.shown) {
    case Shown::with_sensor:
        return sim.cfg().sampling.sensor_pole_pairs != 0;
    case Shown::with_regulators:
        return !sim.drive().voltage_driven;
    case Shown::voltage_driven:
        return sim.drive().voltage_driven;
    case Shown::always:
        break;
    }
    return true;
}

} // namespace

std::string stages_text(const Tick &tick)
{
    std::string text;
    for (const Stage &stage : stages()) {
        if (!is_shown(stage, *tick.sim)) {
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
