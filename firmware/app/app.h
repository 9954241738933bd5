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

#include <stdbool.h>

/* The background's cross-checks, cross_check.h. */
typedef struct {
    uint32_t tick;       /* of the last sample */
    uint32_t begun;      /* the tick in which this window has begun */
    drive_state_t state; /* at the last sample */
    current_sum_t sum;
} cross_check_t;

typedef struct {
    drive_t drive;
    command_mailbox_t mailbox; /* the background posts, the interrupt takes */
    hal_t *hal;
    drive_in_t in; /* the frames of the last tick, for traces and recordings */
    drive_out_t out;
    recorder_t *recorder; /* NULL: none */
    /*
     * a configuration that the background has posted and the interrupt has not taken yet; NULL:
     * none
     */
    const drive_cfg_t *volatile change;
    drive_command_t
        failure;         /* while it is told: the drive takes it in place of the user's command */
    volatile bool fails; /* written by the background only */
    /* Background only: */
    cross_check_t check;
    uint32_t ticket; /* of the next command of a PC, commander.h */
    bool failed;     /* as commander_step() has seen the drive last */
    bool keeps_heat; /* it was taken over from the last reset, kept_heat.h */
    bool unlocked;   /* the next configuration may protect less, commander.h */
} app_t;

/*
 * Open the gates and bring the drive to INIT. Call once, before the control interrupt is enabled.
 * Returns what drive_init returns: NULL, or the name of the configuration field that is refused.
 */
const char *app_init(app_t *app, hal_t *hal, const drive_cfg_t *cfg);

/* Record every tick from now on. Call once, before the control interrupt is enabled. */
void app_record(app_t *app, recorder_t *recorder);

/*
 * Post another configuration. The control interrupt takes it with the command, within a slow
 * period, as a whole and at one tick boundary: drive_change() says what that means. One that is
 * posted before it was taken is forgotten. `cfg` must outlive its use; what was in force before it
 * is needed until app_changes() is false, and by the recorder as long as recorder_change() says.
 * Context: background.
 */
void app_change(app_t *app, const drive_cfg_t *cfg);

/* Whether a configuration that was posted is still to be taken. Context: background. */
bool app_changes(const app_t *app);

/*
 * Tell the drive of a fault that the background has found. The drive latches it within a slow
 * period, in any state but FAULT, and opens the gates in that tick. Value and limit are clamped to
 * 0…65535. A recording has it as a command. Context: background.
 */
void app_fail(app_t *app, const fault_t *fault);

/* Once per pass: what was told is over once the drive is in FAULT. Context: background. */
void app_forget_failure(app_t *app);

/* The control interrupt: sample, step, apply, record. Call once a PWM period, never re-entered. */
void control_isr(app_t *app);

#endif
