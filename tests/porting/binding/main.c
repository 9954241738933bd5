/* SPDX-License-Identifier: MIT */
#include "app.h"
#include "console.h"
#include "drive_config.h"
#include "hal_mine.h"

#include <stddef.h>

static const about_t ABOUT = {DRIVE_ABOUT};

static hal_t hardware;
static app_t app;
static console_t console;

/* The interrupt at the end of the conversions of t_k. */
void mine_conversions_complete(void)
{
    control_isr(&app);
}

int main(void)
{
    const char *bad_field;

    console_init(&console, &app, &hardware, &ABOUT);
    console_say(&console, ABOUT.name);
    bad_field = app_init(&app, &hardware, &DRIVE_CONFIG);
    if (bad_field == NULL) {
        hal_mine_start(&hardware);
    } else {
        console_say(&console, bad_field);
    }
    for (;;) {
        console_step(&console);
        mine_wait();
    }
}
