/* SPDX-License-Identifier: MIT */
#include "app.h"
#include "drive_config.h"
#include "hal_mine.h"
#include "units.h"

#include <stddef.h>

static const units_rotation_t ROTATION = {.pole_pairs = DRIVE_POLE_PAIRS, .tick_ps = DRIVE_TICK_PS};

static hal_t hardware;
static app_t app;

/* The interrupt at the end of the conversions of t_k. */
void mine_conversions_complete(void)
{
    control_isr(&app);
}

/* What the user wants, when the drive can have it. */
static void command(void)
{
    const drive_command_t run = {
        .target = units_step(&ROTATION, 1000),
        .mode = (uint8_t)DRIVE_MODE_SPEED,
        .request = DRIVE_REQUEST_RUN,
    };

    if (app.drive.state == DRIVE_STATE_READY) {
        command_mailbox_post(&app.mailbox, &run);
    }
}

int main(void)
{
    if (app_init(&app, &hardware, &DRIVE_CONFIG) == NULL) { /* else the name of a refused field */
        hal_mine_start(&hardware);
    }
    for (;;) {
        command();
        mine_wait();
    }
}
