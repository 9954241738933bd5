/* SPDX-License-Identifier: MIT */
#include "fault_text.h"

#include <stddef.h>

#define OF(number) ((uint32_t)1U << (uint32_t)(number))
/* faults that follow when derating leaves less torque than the load takes */
#define IN_RUN \
    (OF(FAULT_OSCILLATION) | OF(FAULT_OVERCURRENT) | OF(FAULT_OVERSPEED) | \
     OF(FAULT_SPEED_IMPLAUSIBLE) | OF(FAULT_OBSERVER_LOST) | OF(FAULT_STALL) | \
     OF(FAULT_LOST_PHASE))
#define ROWS (sizeof(advices) / sizeof(advices[0]))

/*
 * The advice of a fault is its first row whose sign is present. The last row of each fault needs no
 * sign.
 */
static const struct {
    uint32_t faults; /* bit k: the row is for the fault k */
    fault_sign_t sign;
    const char *text;
} advices[] = {
    {IN_RUN, FAULT_SIGN_DERATED_BUS,
     "a low bus leaves less torque than the load takes: stronger supply or less load; then board.bus_low_v"},
    {IN_RUN, FAULT_SIGN_DERATED_OTHER,
     "torque is derated by heat or temperature below the load: less load or more cooling; then raise that limit"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_SHAFT,
     "load pulsates with the turn: raise supervision.oscillation_amplitude_pct; then lower the bandwidth"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_SIX,
     "dead time wrong: correct board.dead_time_s; then lower speed_loop.bandwidth_hz"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_ELECTRIC,
     "current sensors unlike in gain or zero: compare their amplifiers; then dead time, lower bandwidth_hz"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_SHAFT_OR_ELECTRIC,
     "current sensors unlike, or the load pulsates: compare amplifiers; then raise supervision.oscillation_amplitude_pct"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_LAG,
     "loop too fast for lag or inertia: halve speed_loop.bandwidth_hz till it holds; then J of the rotor alone, notch_hz"},
    {OF(FAULT_OSCILLATION), FAULT_SIGN_NONE,
     "elastic shaft: set speed_loop.notch_hz to this frequency; if it swings on, halve speed_loop.bandwidth_hz"},
    {OF(FAULT_OVERCURRENT) | OF(FAULT_CURRENT_IMPLAUSIBLE) | OF(FAULT_STARTUP) |
         OF(FAULT_OBSERVER_LOST),
     FAULT_SIGN_NOISE,
     "current sensors too noisy at rest: mend their filter or wiring; then motor file, wires, load"},
    {OF(FAULT_BREAK), FAULT_SIGN_STUCK,
     "a current sensor stands still: check its amplifier and wires; then cable and insulation"},
    {OF(FAULT_BREAK), FAULT_SIGN_NONE,
     "short circuit or noise: check cable and insulation; with little current measured, the current sensors"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_LATE,
     "late ticks: shorten interrupts above the control's; then look for load and wires"},
    {OF(FAULT_OVERCURRENT) | OF(FAULT_ADC_SATURATED), FAULT_SIGN_STUCK,
     "a current sensor or motor wire is off: check sensors, then the wires; then motor file"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_OPEN_WIRE,
     "motor wire open or a current sensor dead: measure the windings at the terminals; then sensors, motor file"},
    {OF(FAULT_OVERCURRENT) | OF(FAULT_OBSERVER_LOST) | OF(FAULT_SPEED_IMPLAUSIBLE) |
         OF(FAULT_OVERSPEED),
     FAULT_SIGN_SWING,
     "speed loop swings: halve speed_loop.bandwidth_hz, J no more than the rotor's; then current sensors, wires"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_PROBE,
     "plate says too much current or too little inductance: check both; then current sensors and wires"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_ALIGN,
     "dead time, R or L too large in the files: correct board.dead_time_s, motor file; then sensor gains, wires"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_START,
     "the load turns the rotor against the start: hold the shaft or take load off; then wires, current sensors"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_NO_CURRENT,
     "motor wire open or a current sensor dead: measure the windings at the terminals; then sensors, motor file"},
    {OF(FAULT_OVERCURRENT), FAULT_SIGN_NONE,
     "load, ramp or J of the file too hard: halve ramp_rpm_s and bandwidth_hz; then wires, current sensors, L, flux"},
    {OF(FAULT_OVERVOLTAGE), FAULT_SIGN_PROBE,
     "the measurement's ramps brake harder than the bus takes: fit a brake resistor; or lower motor.max_speed_rpm"},
    {OF(FAULT_OVERVOLTAGE), FAULT_SIGN_OPEN_GATES,
     "supply too high, or a load spins the motor: measure the bus; then hold the shaft"},
    {OF(FAULT_OVERVOLTAGE), FAULT_SIGN_BRAKES,
     "energy of braking: brake slower, set board.bus_regeneration_max_a, fit a brake resistor; then check the supply"},
    {OF(FAULT_OVERVOLTAGE), FAULT_SIGN_NONE,
     "supply too high: measure it at rest; then brake slower or fit a brake resistor"},
    {OF(FAULT_UNDERVOLTAGE), FAULT_SIGN_GONE,
     "supply is off or its wire is: check switch, fuse and plug; then its strength under load"},
    {OF(FAULT_UNDERVOLTAGE), FAULT_SIGN_NONE,
     "supply too weak under load: stronger supply, or limit board.bus_current_max_a; then check its wires"},
    {OF(FAULT_CURRENT_OFFSET), FAULT_SIGN_NOISE,
     "motor was turning, or noise: let it stop and clear; then measure the amplifiers without current"},
    {OF(FAULT_CURRENT_OFFSET), FAULT_SIGN_NONE,
     "current sensor has a wrong zero: measure the amplifiers without current; then see that the motor rests"},
    {OF(FAULT_ADC_SATURATED), FAULT_SIGN_NONE,
     "a current sensor's wire is off: measure the amplifier without current; then look for a short in the cable"},
    {OF(FAULT_ADC_STUCK), FAULT_SIGN_NONE,
     "a current sensor stands still: check amplifiers; then the converter's reference, motor wires"},
    {OF(FAULT_LOST_PHASE), FAULT_SIGN_NO_CURRENT,
     "motor wire open, switch or current sensor dead: measure the windings at the terminals; then the sensors"},
    {OF(FAULT_LOST_PHASE), FAULT_SIGN_START,
     "the load turns the held rotor: hold the shaft or take load off; then motor wires and current sensors"},
    {OF(FAULT_LOST_PHASE), FAULT_SIGN_NONE,
     "motor wire open, switch or current sensor dead: measure the windings at the terminals; then the sensors"},
    {OF(FAULT_OVERLOAD), FAULT_SIGN_START,
     "start current above the continuous one: lower startup.current_pct; then motor.continuous_current_a"},
    {OF(FAULT_OVERLOAD), FAULT_SIGN_NONE,
     "load above the continuous current for too long: lower it; then check motor.continuous_current_a"},
    {OF(FAULT_OVERTEMPERATURE), FAULT_SIGN_NONE,
     "power stage too hot: more cooling or less load; then the sensor's reading when cold"},
    {OF(FAULT_TEMPERATURE_SENSOR), FAULT_SIGN_COLD,
     "temperature sensor open: NTC off or its wire; then board.temperature_points_c, it reads colder than it can"},
    {OF(FAULT_TEMPERATURE_SENSOR), FAULT_SIGN_NONE,
     "temperature sensor shorted: NTC or its wire; then board.temperature_points_c, it reads hotter than it can"},
    {OF(FAULT_OBSERVER_LOST) | OF(FAULT_SPEED_IMPLAUSIBLE) | OF(FAULT_STALL), FAULT_SIGN_SENSED,
     "angle sensor off its zero or stuck: align it and check its wires; then R, L and flux"},
    {OF(FAULT_OBSERVER_LOST) | OF(FAULT_SPEED_IMPLAUSIBLE), FAULT_SIGN_OPEN_WIRE,
     "motor wire open: measure the windings at the terminals; then current sensors and motor file"},
    {OF(FAULT_OBSERVER_LOST), FAULT_SIGN_SLOW,
     "too slow under this load: turn faster or take load off; then R, dead time and wires"},
    {OF(FAULT_OBSERVER_LOST), FAULT_SIGN_NONE,
     "wrong R, L or flux: run identify and check the motor file; then dead time, current sensors, wires"},
    {OF(FAULT_SPEED_IMPLAUSIBLE), FAULT_SIGN_NONE,
     "rotor lost: check load and motor file; then wires, current sensors, speed loop and inertia"},
    {OF(FAULT_STALL), FAULT_SIGN_NONE,
     "shaft blocked or load too large: free it or take load off; then motor.max_current_a"},
    {OF(FAULT_OVERSPEED), FAULT_SIGN_OPEN_GATES,
     "load spins the motor: brake or unload the shaft; then motor.max_speed_rpm"},
    {OF(FAULT_OVERSPEED), FAULT_SIGN_BRAKES,
     "load drives the motor faster than it can brake: take load off; then board.bus_brake_v, motor wires, sensors"},
    {OF(FAULT_OVERSPEED), FAULT_SIGN_NONE,
     "speed loop overshoots: lower speed_loop.bandwidth_hz or the ramp; then load, wires, current sensors"},
    {OF(FAULT_LATE), FAULT_SIGN_NONE,
     "control interrupt held up: shorten interrupts above it; then lower the PWM frequency"},
    {OF(FAULT_CONFIGURATION), FAULT_SIGN_NONE,
     "configuration changed in memory: write the image again; if it returns replace the board"},
    {OF(FAULT_MEMORY), FAULT_SIGN_NONE,
     "a bit of the memory has changed by itself: clear the fault; if it returns look for noise, replace the board"},
    {OF(FAULT_ANGLE_SENSOR), FAULT_SIGN_NONE,
     "sensor of the shaft tells no angle: check its wires and supply; then sensor.kind and its settings"},
    {OF(FAULT_STARTUP), FAULT_SIGN_NOT_FOLLOWED,
     "rotor does not follow: free the shaft or lessen the load; then more startup.current_pct, slower ramp, L, wires"},
    {OF(FAULT_STARTUP), FAULT_SIGN_NONE,
     "motor file does not fit: run identify, check R, L and flux; then load, phase order, dead time, wires"},
    {OF(FAULT_CURRENT_IMPLAUSIBLE), FAULT_SIGN_STUCK,
     "a current sensor does not tell what flows: check its amplifier and wires; then dead time, R, motor wires"},
    {OF(FAULT_CURRENT_SUM), FAULT_SIGN_NONE,
     "one of the three current sensors reads wrong: compare their amplifiers; then the leakage from motor to ground"},
    {OF(FAULT_FLUX_IMPLAUSIBLE), FAULT_SIGN_NONE,
     "bus sensor wrong: compare it with a meter; then the clock of the chip, current sensors, shorted turns"},
    {OF(FAULT_CURRENT_IMPLAUSIBLE), FAULT_SIGN_RUN,
     "a current sensor or a leg of the power stage is wrong: compare the amplifiers, then the gate drivers; then R, wires"},
    {OF(FAULT_CURRENT_IMPLAUSIBLE), FAULT_SIGN_NONE,
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
        [FAULT_CURRENT_SUM] = {"CURRENT_SUM", FAULT_UNIT_CURRENT},
        [FAULT_FLUX_IMPLAUSIBLE] = {"FLUX_IMPLAUSIBLE", FAULT_UNIT_VOLTAGE},
        [FAULT_MEMORY] = {"MEMORY", FAULT_UNIT_WORD},
        [FAULT_ANGLE_SENSOR] = {"ANGLE_SENSOR", FAULT_UNIT_NONE},
    };
    const unsigned int index = (unsigned int)id;

    return &texts[(index < (unsigned int)FAULT_COUNT) ? index : 0U];
}

/*
 * Returns the index of the first row that has one of the faults and one of the signs, or ROWS if
 * there is none.
 */
static uint32_t find_row(uint32_t faults, uint32_t signs)
{
    uint32_t k = 0U;

    while ((k < ROWS) &&
           (((advices[k].faults & faults) == 0U) || ((OF(advices[k].sign) & signs) == 0U))) {
        k++;
    }
    return k;
}

const char *fault_advice(fault_id_t id, uint32_t signs)
{
    const uint32_t number = (uint32_t)id;
    const uint32_t faults = (number < (uint32_t)FAULT_COUNT) ? OF(number) : 0U;
    const uint32_t row = find_row(faults, signs | OF(FAULT_SIGN_NONE));

    return (row < ROWS) ? advices[row].text : "no fault";
}
