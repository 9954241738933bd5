/* SPDX-License-Identifier: MIT */
/*
 * The application shared by every target: one drive on one hardware binding.
 */
#ifndef APP_H
#define APP_H

#include "command_mailbox.h"
#include "current_sum.h"
#include "drive.h"
#include "hal.h"
#include "recorder.h"
#include "shaft_decoder.h"
#include "source.h"

#include <stdbool.h>

/* State of the background's check of the measurements, cross_check.h. */
typedef struct {
    uint32_t tick;       /* tick that was checked last */
    uint32_t begun;      /* tick in which the present window began */
    drive_state_t state; /* state of the drive in the tick that was checked last */
    current_sum_t sum;
} cross_check_t;

/* box.h */
struct box;

typedef struct {
    drive_t drive;
    command_mailbox_t mailbox; /* the background posts, the interrupt takes */
    hal_t *hal;
    drive_in_t in;          /* input frame of the last tick */
    drive_out_t out;        /* output frame of the last tick */
    recorder_t *recorder;   /* NULL: nothing is recorded */
    struct box *box;        /* NULL: there is no black box */
    shaft_decoder_t *shaft; /* NULL: the frames of the binding have the angle, if there is one */
    /*
     * a configuration that the background has posted and the interrupt has not taken yet; NULL:
     * there is none
     */
    const drive_cfg_t *volatile change;
    /* while `fails` is true the drive takes this in place of the user's command */
    drive_command_t failure;
    volatile bool fails; /* written by the background only */
    /* Background only: */
    cross_check_t check;
    uint32_t ticket; /* ticket that the next command of a PC has to carry, see commander.h */
    uint32_t upsets; /* events after which an input has to be seen at rest, see commander.h */
    source_t source; /* the source that has commanded last, see commander_source() */
    bool failed;     /* the drive was in FAULT at the last commander_step() */
    bool keeps_heat; /* kept_heat_restore() has run, so kept_heat_step() may keep the heat */
    bool unlocked;   /* the next configuration of a PC may protect less, see commander.h */
} app_t;

/*
 * Open the gates and bring the drive to INIT. Leaves `box` as it is. Call once, before the control
 * interrupt is enabled. Returns what drive_init returns: NULL, or the name of the configuration
 * field that is refused.
 */
const char *app_init(app_t *app, hal_t *hal, const drive_cfg_t *cfg);

/*
 * Decode the sensor of the shaft that the configuration names from now on. Call once, before the
 * control interrupt is enabled.
 */
void app_sense(app_t *app, shaft_decoder_t *shaft);

/* Record every tick from now on. Call once, before the control interrupt is enabled. */
void app_record(app_t *app, recorder_t *recorder);

/*
 * Post another configuration. The control interrupt takes it with the command, within a slow
 * period, as a whole and at one tick boundary, see drive_change(). A second post before the
 * interrupt has taken the first one replaces it. `cfg` must stay valid as long as it is used. The
 * configuration that was in force before must stay valid until app_changes() is false, and for the
 * recorder as long as recorder_change() says. Context: background.
 */
void app_change(app_t *app, const drive_cfg_t *cfg);

/* Returns true while the interrupt has not taken a posted configuration. Context: background. */
bool app_changes(const app_t *app);

/*
 * Tell the drive of a fault that the background has found. The drive latches it within a slow
 * period, in any state but FAULT, and opens the gates in that tick. Value and limit are clamped to
 * 0…65535. A recording shows the fault as a command. Context: background.
 */
void app_fail(app_t *app, const fault_t *fault);

/*
 * Forgets the failure of app_fail() once the drive is in FAULT. Call once per pass. Context:
 * background.
 */
void app_forget_failure(app_t *app);

/*
 * The control interrupt: takes the samples, steps the drive, applies and records the outputs. Call
 * once per PWM period; it must not interrupt itself.
 */
void control_isr(app_t *app);

#endif
