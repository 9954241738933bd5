/* SPDX-License-Identifier: MIT */
#include "app.h"
#include "board.h"
#include "drive_config.h"
#include "link.h"

#include <stddef.h>

static const about_t ABOUT = {DRIVE_ABOUT};

static hal_t hardware;
static app_t app;
static live_config_t live;
static link_t serial;

/* The interrupt at the end of the conversions of t_k. */
void board_conversions_complete(void)
{
    control_isr(&app);
}

int main(void)
{
    const char *bad_field;

    live_config_init(&live, &app, &hardware, &ABOUT, &DRIVE_CONFIG);
    link_init(&serial, &live);
    link_say(&serial, live.about.name);
    bad_field = app_init(&app, &hardware, &live.in_force->cfg);
    if (bad_field == NULL) {
        board_start(&hardware);
    } else {
        link_say(&serial, bad_field);
    }
    for (;;) {
        link_step(&serial);
        board_wait();
    }
}
