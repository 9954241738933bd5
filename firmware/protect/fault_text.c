/* SPDX-License-Identifier: MIT */
#include "fault_text.h"

/* The length is the table's. */
const fault_text_t *fault_text(fault_id_t id) /* NOLINT(readability-function-size) */
{
    static const fault_text_t texts[FAULT_COUNT] = {
        [FAULT_NONE] = {"NONE", FAULT_UNIT_NONE, "no fault"},
        [FAULT_BREAK] = {"BREAK", FAULT_UNIT_CURRENT,
                         "short circuit, noise, or if little was measured a stuck current sensor; "
                         "check cable and insulation, then sensors"},
        [FAULT_OVERCURRENT] =
            {"OVERCURRENT", FAULT_UNIT_CURRENT,
             "load or ramp too hard, wire open, current sensor or motor file wrong, loop oscillates; "
             "check these and late ticks"},
        [FAULT_OVERVOLTAGE] = {"OVERVOLTAGE", FAULT_UNIT_VOLTAGE,
                               "energy of braking or supply too high; check the supply, then brake "
                               "slower or fit a brake resistor"},
        [FAULT_UNDERVOLTAGE] = {"UNDERVOLTAGE", FAULT_UNIT_VOLTAGE,
                                "supply off or too weak; check it at rest and under load"},
        [FAULT_CURRENT_OFFSET] =
            {"CURRENT_OFFSET", FAULT_UNIT_CURRENT,
             "motor was turning or sensor is faulty; let it stop, then measure "
             "the amplifier's output without current"},
        [FAULT_ADC_SATURATED] = {"ADC_SATURATED", FAULT_UNIT_CURRENT,
                                 "short circuit or broken sensor wire; check the motor cable, then "
                                 "the amplifier's output without current"},
        [FAULT_ADC_STUCK] =
            {"ADC_STUCK", FAULT_UNIT_CURRENT,
             "current sensor or its converter stands still; check amplifiers, then the converter's "
             "reference"},
        [FAULT_LOST_PHASE] = {"LOST_PHASE", FAULT_UNIT_CURRENT,
                              "motor wire open, switch or current sensor dead; measure the three "
                              "winding resistances at the terminals"},
        [FAULT_OVERLOAD] = {"OVERLOAD", FAULT_UNIT_HEAT,
                            "more than continuous current for too long; check the load, then "
                            "motor.continuous_current_a"},
        [FAULT_OVERTEMPERATURE] = {"OVERTEMPERATURE", FAULT_UNIT_TEMPERATURE,
                                   "power stage too hot or sensor open; check cooling, then the "
                                   "sensor's reading when cold"},
        [FAULT_OBSERVER_LOST] = {"OBSERVER_LOST", FAULT_UNIT_CURRENT,
                                 "wrong R, L or flux, too slow under load, or a motor wire open; "
                                 "check motor file, dead time, wires"},
        [FAULT_SPEED_IMPLAUSIBLE] =
            {"SPEED_IMPLAUSIBLE", FAULT_UNIT_SPEED,
             "rotor lost, or a motor wire open; check motor file and wires, then speed loop and "
             "inertia"},
        [FAULT_STALL] = {"STALL", FAULT_UNIT_SPEED,
                         "full torque does not move or brake the rotor; check for a blocked shaft, "
                         "then load and motor.max_current_a"},
        [FAULT_OVERSPEED] = {"OVERSPEED", FAULT_UNIT_SPEED,
                             "driven by the load, speed loop overshoots or a motor wire is open; "
                             "check both, lower speed_loop.bandwidth_hz"},
        [FAULT_LATE] = {"LATE", FAULT_UNIT_NONE,
                        "control interrupt held up; check longer interrupts above it, then lower "
                        "the PWM frequency"},
        [FAULT_CONFIGURATION] = {"CONFIGURATION", FAULT_UNIT_WORD,
                                 "configuration changed in memory; write the image again, if it "
                                 "returns replace the board"},
        [FAULT_STARTUP] = {"STARTUP", FAULT_UNIT_NONE,
                           "rotor did not follow the start; check load and phase order, then the "
                           "start current"},
        [FAULT_CURRENT_IMPLAUSIBLE] =
            {"CURRENT_IMPLAUSIBLE", FAULT_UNIT_VOLTAGE,
             "a current sensor does not tell what flows, or a motor wire is open; check sensors, "
             "then wires, then R"},
        [FAULT_OSCILLATION] = {"OSCILLATION", FAULT_UNIT_CURRENT,
                               "elastic shaft: set speed_loop.notch_hz to this frequency; loop too "
                               "fast: lower bandwidth_hz; dead time wrong: correct it"},
        [FAULT_TEMPERATURE_SENSOR] = {"TEMPERATURE_SENSOR", FAULT_UNIT_TEMPERATURE,
                                      "TODO; TODO"},
    };
    const unsigned int index = (unsigned int)id;

    return &texts[(index < (unsigned int)FAULT_COUNT) ? index : 0U];
}
