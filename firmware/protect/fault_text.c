/* SPDX-License-Identifier: MIT */
#include "fault_text.h"

#include <stddef.h>

#define OF(fault) (1UL << (uint32_t)FAULT_##fault)
/* A derated torque that is below the load ends in one of these. */
#define IN_RUN \
    (OF(OSCILLATION) | OF(OVERCURRENT) | OF(OVERSPEED) | OF(SPEED_IMPLAUSIBLE) | \
     OF(OBSERVER_LOST) | OF(STALL) | OF(LOST_PHASE))
#define ROWS (sizeof(advices) / sizeof(advices[0]))

/* The first row of a fault whose sign is there holds; the last one of each fault needs none. */
static const struct {
    uint32_t faults; /* bit k: of the fault k */
    fault_sign_t sign;
    const char *text;
} advices[] = {
    {IN_RUN, FAULT_SIGN_DERATED_BUS,
     "a low bus leaves less torque than the load takes: stronger supply or less load; then board.bus_low_v"},
    {IN_RUN, FAULT_SIGN_DERATED_OTHER,
     "torque is derated by heat or temperature below the load: less load or more cooling; then raise that limit"},
    {OF(OSCILLATION), FAULT_SIGN_ONCE_A_TURN,
     "load pulsates once a turn: raise supervision.oscillation_amplitude_pct; then lower the bandwidth"},
    {OF(OSCILLATION), FAULT_SIGN_SIX,
     "dead time wrong: correct board.dead_time_s; then lower speed_loop.bandwidth_hz"},
    {OF(OSCILLATION), FAULT_SIGN_ELECTRIC,
     "current sensors unlike in gain or zero: compare their amplifiers; then dead time, lower bandwidth_hz"},
    {OF(OSCILLATION), FAULT_SIGN_LAG,
     "loop too fast for lag or inertia: halve speed_loop.bandwidth_hz till it holds; then J of the rotor alone, notch_hz"},
    {OF(OSCILLATION), FAULT_SIGN_NONE,
     "elastic shaft: set speed_loop.notch_hz to this frequency; if it swings on, halve speed_loop.bandwidth_hz"},
    {OF(OVERCURRENT) | OF(CURRENT_IMPLAUSIBLE) | OF(STARTUP) | OF(OBSERVER_LOST), FAULT_SIGN_NOISE,
     "current sensors too noisy at rest: mend their filter or wiring; then motor file, wires, load"},
    {OF(BREAK), FAULT_SIGN_STUCK,
     "a current sensor stands still: check its amplifier and wires; then cable and insulation"},
    {OF(BREAK), FAULT_SIGN_NONE,
     "short circuit or noise: check cable and insulation; with little current measured, the current sensors"},
    {OF(OVERCURRENT), FAULT_SIGN_LATE,
     "late ticks: shorten interrupts above the control's; then look for load and wires"},
    {OF(OVERCURRENT) | OF(ADC_SATURATED), FAULT_SIGN_STUCK,
     "a current sensor or motor wire is off: check sensors, then the wires; then motor file"},
    {OF(OVERCURRENT), FAULT_SIGN_OPEN_WIRE,
     "motor wire open or a current sensor dead: measure the windings at the terminals; then sensors, motor file"},
    {OF(OVERCURRENT) | OF(OBSERVER_LOST) | OF(SPEED_IMPLAUSIBLE) | OF(OVERSPEED), FAULT_SIGN_SWING,
     "speed loop swings: halve speed_loop.bandwidth_hz, J no more than the rotor's; then current sensors, wires"},
    {OF(OVERCURRENT), FAULT_SIGN_PROBE,
     "plate says too much current or too little inductance: check both; then current sensors and wires"},
    {OF(OVERCURRENT), FAULT_SIGN_ALIGN,
     "dead time, R or L too large in the files: correct board.dead_time_s, motor file; then sensor gains, wires"},
    {OF(OVERCURRENT), FAULT_SIGN_START,
     "the load turns the rotor against the start: hold the shaft or take load off; then wires, current sensors"},
    {OF(OVERCURRENT), FAULT_SIGN_NO_CURRENT,
     "motor wire open or a current sensor dead: measure the windings at the terminals; then sensors, motor file"},
    {OF(OVERCURRENT), FAULT_SIGN_NONE,
     "load, ramp or J of the file too hard: halve ramp_rpm_s and bandwidth_hz; then wires, current sensors, L, flux"},
    {OF(OVERVOLTAGE), FAULT_SIGN_PROBE,
     "the measurement's ramps brake harder than the bus takes: fit a brake resistor; or lower motor.max_speed_rpm"},
    {OF(OVERVOLTAGE), FAULT_SIGN_OPEN_GATES,
     "supply too high, or a load spins the motor: measure the bus; then hold the shaft"},
    {OF(OVERVOLTAGE), FAULT_SIGN_BRAKES,
     "energy of braking: brake slower, set board.bus_regeneration_max_a, fit a brake resistor; then check the supply"},
    {OF(OVERVOLTAGE), FAULT_SIGN_NONE,
     "supply too high: measure it at rest; then brake slower or fit a brake resistor"},
    {OF(UNDERVOLTAGE), FAULT_SIGN_GONE,
     "supply is off or its wire is: check switch, fuse and plug; then its strength under load"},
    {OF(UNDERVOLTAGE), FAULT_SIGN_NONE,
     "supply too weak under load: stronger supply, or limit board.bus_current_max_a; then check its wires"},
    {OF(CURRENT_OFFSET), FAULT_SIGN_NOISE,
     "motor was turning, or noise: let it stop and clear; then measure the amplifiers without current"},
    {OF(CURRENT_OFFSET), FAULT_SIGN_NONE,
     "current sensor has a wrong zero: measure the amplifiers without current; then see that the motor rests"},
    {OF(ADC_SATURATED), FAULT_SIGN_NONE,
     "a current sensor's wire is off: measure the amplifier without current; then look for a short in the cable"},
    {OF(ADC_STUCK), FAULT_SIGN_NONE,
     "a current sensor stands still: check amplifiers; then the converter's reference, motor wires"},
    {OF(LOST_PHASE), FAULT_SIGN_NO_CURRENT,
     "motor wire open, switch or current sensor dead: measure the windings at the terminals; then the sensors"},
    {OF(LOST_PHASE), FAULT_SIGN_START,
     "the load turns the held rotor: hold the shaft or take load off; then motor wires and current sensors"},
    {OF(LOST_PHASE), FAULT_SIGN_NONE,
     "motor wire open, switch or current sensor dead: measure the windings at the terminals; then the sensors"},
    {OF(OVERLOAD), FAULT_SIGN_START,
     "start current above the continuous one: lower startup.current_pct; then motor.continuous_current_a"},
    {OF(OVERLOAD), FAULT_SIGN_NONE,
     "load above the continuous current for too long: lower it; then check motor.continuous_current_a"},
    {OF(OVERTEMPERATURE), FAULT_SIGN_NONE,
     "power stage too hot: more cooling or less load; then the sensor's reading when cold"},
    {OF(TEMPERATURE_SENSOR), FAULT_SIGN_COLD,
     "temperature sensor open: NTC off or its wire; then board.temperature_points_c, it reads colder than it can"},
    {OF(TEMPERATURE_SENSOR), FAULT_SIGN_NONE,
     "temperature sensor shorted: NTC or its wire; then board.temperature_points_c, it reads hotter than it can"},
    {OF(OBSERVER_LOST) | OF(SPEED_IMPLAUSIBLE) | OF(STALL), FAULT_SIGN_SENSED,
     "angle sensor off its zero or stuck: align it and check its wires; then R, L and flux"},
    {OF(OBSERVER_LOST) | OF(SPEED_IMPLAUSIBLE), FAULT_SIGN_OPEN_WIRE,
     "motor wire open: measure the windings at the terminals; then current sensors and motor file"},
    {OF(OBSERVER_LOST), FAULT_SIGN_SLOW,
     "too slow under this load: turn faster or take load off; then R, dead time and wires"},
    {OF(OBSERVER_LOST), FAULT_SIGN_NONE,
     "wrong R, L or flux: run identify and check the motor file; then dead time, current sensors, wires"},
    {OF(SPEED_IMPLAUSIBLE), FAULT_SIGN_NONE,
     "rotor lost: check load and motor file; then wires, current sensors, speed loop and inertia"},
    {OF(STALL), FAULT_SIGN_NONE,
     "shaft blocked or load too large: free it or take load off; then motor.max_current_a"},
    {OF(OVERSPEED), FAULT_SIGN_OPEN_GATES,
     "load spins the motor: brake or unload the shaft; then motor.max_speed_rpm"},
    {OF(OVERSPEED), FAULT_SIGN_BRAKES,
     "load drives the motor faster than it can brake: take load off; then board.bus_brake_v, motor wires, sensors"},
    {OF(OVERSPEED), FAULT_SIGN_NONE,
     "speed loop overshoots: lower speed_loop.bandwidth_hz or the ramp; then load, wires, current sensors"},
    {OF(LATE), FAULT_SIGN_NONE,
     "control interrupt held up: shorten interrupts above it; then lower the PWM frequency"},
    {OF(CONFIGURATION), FAULT_SIGN_NONE,
     "configuration changed in memory: write the image again; if it returns replace the board"},
    {OF(STARTUP), FAULT_SIGN_NOT_FOLLOWED,
     "rotor does not follow: free the shaft or lessen the load; then more startup.current_pct, slower ramp, L, wires"},
    {OF(STARTUP), FAULT_SIGN_NONE,
     "motor file does not fit: run identify, check R, L and flux; then load, phase order, dead time, wires"},
    {OF(CURRENT_IMPLAUSIBLE), FAULT_SIGN_STUCK,
     "a current sensor does not tell what flows: check its amplifier and wires; then dead time, R, motor wires"},
    {OF(CURRENT_IMPLAUSIBLE), FAULT_SIGN_NONE,
     "R or dead time of the files does not fit: correct both; then sensor gains, current sensors, motor wires"},
};

const fault_text_t *fault_text(fault_id_t id)
{
    static const fault_text_t texts[FAULT_COUNT] = {
        [FAULT_NONE] = {"NONE", FAULT_UNIT_NONE},
        [FAULT_BREAK] = {"BREAK", FAULT_UNIT_CURRENT},
        [FAULT_OVERCURRENT] = {"OVERCURRENT", FAULT_UNIT_CURRENT},
        [FAULT_OVERVOLTAGE] = {"OVERVOLTAGE", FAULT_UNIT_VOLTAGE},
        [FAULT_UNDERVOLTAGE] = {"UNDERVOLTAGE", FAULT_UNIT_VOLTAGE},
        [FAULT_CURRENT_OFFSET] = {"CURRENT_OFFSET", FAULT_UNIT_CURRENT},
        [FAULT_ADC_SATURATED] = {"ADC_SATURATED", FAULT_UNIT_CURRENT},
        [FAULT_ADC_STUCK] = {"ADC_STUCK", FAULT_UNIT_CURRENT},
        [FAULT_LOST_PHASE] = {"LOST_PHASE", FAULT_UNIT_CURRENT},
        [FAULT_OVERLOAD] = {"OVERLOAD", FAULT_UNIT_HEAT},
        [FAULT_OVERTEMPERATURE] = {"OVERTEMPERATURE", FAULT_UNIT_TEMPERATURE},
        [FAULT_OBSERVER_LOST] = {"OBSERVER_LOST", FAULT_UNIT_CURRENT},
        [FAULT_SPEED_IMPLAUSIBLE] = {"SPEED_IMPLAUSIBLE", FAULT_UNIT_SPEED},
        [FAULT_STALL] = {"STALL", FAULT_UNIT_SPEED},
        [FAULT_OVERSPEED] = {"OVERSPEED", FAULT_UNIT_SPEED},
        [FAULT_LATE] = {"LATE", FAULT_UNIT_NONE},
        [FAULT_CONFIGURATION] = {"CONFIGURATION", FAULT_UNIT_WORD},
        [FAULT_STARTUP] = {"STARTUP", FAULT_UNIT_CURRENT},
        [FAULT_CURRENT_IMPLAUSIBLE] = {"CURRENT_IMPLAUSIBLE", FAULT_UNIT_VOLTAGE},
        [FAULT_OSCILLATION] = {"OSCILLATION", FAULT_UNIT_CURRENT},
        [FAULT_TEMPERATURE_SENSOR] = {"TEMPERATURE_SENSOR", FAULT_UNIT_TEMPERATURE},
    };
    const unsigned int index = (unsigned int)id;

    return &texts[(index < (unsigned int)FAULT_COUNT) ? index : 0U];
}

const char *fault_advice(fault_id_t id, uint32_t signs)
{
    const uint32_t number = (uint32_t)id;
    const uint32_t fault = (number < (uint32_t)FAULT_COUNT) ? (1UL << number) : 0U;
    const uint32_t known = signs | (1UL << (uint32_t)FAULT_SIGN_NONE);
    const char *advice = NULL;

    for (uint32_t k = 0U; (k < ROWS) && (advice == NULL); k++) {
        if (((advices[k].faults & fault) != 0U) &&
            (((known >> (uint32_t)advices[k].sign) & 1U) != 0U)) {
            advice = advices[k].text;
        }
    }
    return (advice == NULL) ? "no fault" : advice;
}
