/* SPDX-License-Identifier: MIT */
/*
 * The input that commands the drive without a PC: a throttle, which is a voltage, servo pulses or
 * DShot, and a button.
 *
 * Arming. A throttle that is high at power-up starts nothing. The input has to be seen at rest for
 * cfg->input.arm_ticks: its signal is there, without a bad reading, the throttle is within its dead
 * band, the button is released, and nothing runs. An enable may also be held, if it was pressed
 * after what has disarmed the input, or if the throttle has ended the run. Then it is armed, and a
 * throttle that is beyond the dead band for INPUT_SIGNAL_GOOD good readings starts the motor. It is
 * disarmed by each stop, fault, loss of the signal, by a change of the configuration while it does
 * not run the motor, by each command of console or link (commander.h), and by a bad reading.
 *
 * In command. The target follows the throttle (throttle.h). Back in the dead band the target
 * becomes 0; when the motor is slow the run ends, and the gates open. Without a signal the drive
 * ramps to a stop (source_guard.h). Console and link take over at any time (source.h).
 *
 * The button. With INPUT_BUTTON_ENABLE the motor starts and runs only while it is pressed; an armed
 * throttle that leaves its dead band without it is disarmed. With INPUT_BUTTON_START_STOP a press
 * starts and the next one stops; the throttle is the set point, so it may be anywhere while the
 * input is armed. A second press before the throttle has started the motor takes the first one
 * back. In both cases a release or a second press is a stop like any other: the gates
 * open, whoever runs the motor, and a measurement of the motor ends. A button that is pressed at
 * power-up counts once it has been
 * released. In FAULT a press clears the fault.
 *
 * Context: background.
 */
#ifndef INPUT_H
#define INPUT_H

#include "button.h"
#include "dshot.h"
#include "identify.h"
#include "input_signal.h"
#include "live_config.h"
#include "rc_pulse.h"
#include "source_guard.h"
#include "voltage_input.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    INPUT_WAITS = 0, /* has to be seen at rest */
    INPUT_ARMED,
    INPUT_RUNS, /* it has the drive */
    INPUT_ENDS  /* the signal is lost: the drive ramps to a stop */
} input_state_t;

typedef struct {
    uint32_t tick;      /* of the last pass */
    uint32_t rest;      /* tick since which the input is at rest */
    uint32_t upsets;    /* app->upsets that the input has seen */
    int32_t demand_q30; /* after the slope */
    int32_t share;      /* of the throttle beyond its dead band, Q15; 0: at rest */
    uint8_t state;      /* an input_state_t */
    uint8_t rested;     /* signal.count when the throttle was at rest last */
    uint8_t kind;       /* the input_kind_t that the readings are of */
    bool is_on;         /* the button lets the motor run */
    input_signal_t signal;
    rc_pulse_t rc;
    dshot_t dshot;
    voltage_input_t voltage;
    button_t button;
    source_guard_t guard;
} input_t;

void input_init(input_t *input);

/*
 * What a person should know of the input, as the end of a sentence; NULL: there is none. Constant
 * text.
 */
const char *input_text(const input_t *input);

/*
 * One pass. Returns the reason in the pass in which the drive begins to stop because the signal is
 * lost, else NULL. identify: a measurement of the motor, which no input may disturb.
 */
const char *input_step(input_t *input, const live_config_t *live, identify_t *identify,
                       uint32_t tick);

#endif
