/* SPDX-License-Identifier: MIT */
/*
 * The image for a board with an STM32G4: brings the chip up, then lets the control interrupt work
 * while the background serves the serial line, LED and watchdog, once a tick.
 */
#include "app.h"
#include "board.h"
#include "box.h"
#include "check.h"
#include "clock.h"
#include "cpu.h"
#include "drive_config.h"
#include "flash.h"
#include "guard.h"
#include "hal_config.h"
#include "hal_g4.h"
#include "image.h"
#include "inlining.h"
#include "kept_heat.h"
#include "led.h"
#include "link.h"
#include "pins.h"
#include "pwm.h"
#include "ram.h"
#include "reset.h"
#include "sensing.h"
#include "uart.h"
#include "vectors.h"

#include <stddef.h>

static app_t app;
static hal_t hardware;
static link_t serial;
static box_t box;
RAM_KEPT static recorder_t recorder;
RAM_KEPT static recorder_entry_t ring[RECORDER_SEGMENTS * DRIVE_RECORDER_ENTRIES];
RAM_KEPT static live_config_t live;
RAM_KEPT static fault_log_t faults;

/* The next start tells which exception it was. */
void board_safe_state(void)
{
    reg_clear(TIM1_BDTR, TIM_BDTR_MOE);
    reg_write(HAL_G4_EXCEPTION, reg_read(SCB_ICSR));
}

void ADC1_2_IRQHandler(void)
{
    control_isr(&app);
}

void NMI_Handler(void)
{
    const bool parity = reg_any(SYSCFG_CFGR2, SYSCFG_CFGR2_SPF); /* never forgiven */

    if (!parity && clock_has_lost_crystal()) {
        hal_g4_bar(&hardware, "the crystal has stopped");
        clock_do_without_crystal();
        guard_restart();
    } else if (parity || !flash_forgive()) {
        safe_state_handler();
    } else {
        /* a unit of the store that is not whole */
    }
}

/* The tick guard: no control tick for one and a half periods. */
void SysTick_Handler(void)
{
    hal_g4_tick_lost(&hardware);
}

/*
 * Checks the chip until the first fault. The consequences of that fault, such as the changed modes
 * of the pins, are not faults.
 */
static void check(uint32_t tick)
{
    const char *const why = (hardware.why_barred == NULL) ? check_step(tick) : NULL;

    if (why != NULL) {
        hal_g4_bar(&hardware, why);
    }
}

/* Never returns. After a lost tick the watchdog is not fed any more, and resets the chip. */
static void background(void)
{
    uint32_t fed = 0U;

    for (;;) {
        const uint32_t tick = hal_ticks(&hardware);

        if ((tick != fed) && !hardware.tick_lost) {
            guard_feed();
            fed = tick;
            led_show(app.drive.state, tick);
        }
        check(tick);
        recorder_service(&recorder, &app.drive);
        link_step(&serial);
        cpu_wait();
    }
}

static const char *bring_up(void)
{
    static shaft_decoder_t shaft;
    const char *why = hal_g4_init(&hardware);

    if (why == NULL) {
        why = app_init(&app, &hardware, &live.in_force->cfg);
    }
    if (why == NULL) {
        kept_heat_restore(&app);
        why = recorder_init(&recorder, ring, DRIVE_RECORDER_ENTRIES, BOARD_RECORDER_POST_TICKS);
        app_record(&app, &recorder);
        app_sense(&app, &shaft);
        ram_keep();
    }
    if (why == NULL) {
        why = hal_g4_start();
    }
    return why;
}

/*
 * The start has failed: the gates are open, and no control interrupt runs. The watchdog is fed, if
 * it runs, so that the console can say why.
 */
static void stay(const char *why)
{
    link_say(&serial, "cannot start:");
    link_say(&serial, why);
    for (;;) {
        guard_feed();
        link_step(&serial);
    }
}

/*
 * Says which protections are off that only a programming tool can switch on:
 * docs/board_bring_up.md.
 */
static void tell_options(void)
{
    const uint32_t options = reg_read(FLASH_OPTR);

    if ((options & FLASH_OPTR_BOR_LEV) != FLASH_OPTR_BOR_LEV_4) {
        link_say(&serial, "option bytes: no reset at 2.8 V of supply, set BOR_LEV = 4");
    }
    if ((options & FLASH_OPTR_SRAM_PE) != 0U) {
        link_say(&serial, "option bytes: no parity of the RAM, set SRAM_PE = 0");
    }
}

/* Says which configuration is in force, where it comes from, and what is wrong. */
static void greet(void)
{
    link_say(&serial, live.about.name);
    stored_config_tell(&serial.console.out, &live.stored);
    link_say(&serial, "");
    box_tell_start(&serial.console.out, &box);
    link_say(&serial, "");
    tell_options();
}

/* The log survives the test. Apart, so that it is not on the stack all the time. */
RARE static void test_kept(void)
{
    const fault_log_t log = faults;

    ram_test_kept();
    faults = log;
}

/*
 * Saves what the run before has left in the RAM, and then tests that part of the RAM. If something
 * in it leads the program astray, the watchdog makes the next start begin with an empty RAM.
 */
RARE static void rescue(const about_t *facts)
{
    recorder_place_t place = {.entries = ring, .segment_entries = DRIVE_RECORDER_ENTRIES};

    ram_forget();
    if (ram_is_kept()) {
        guard_watch_start();
    }
    box_init(&box, &app, &hardware, facts, &faults, !ram_is_kept());
    if (ram_is_kept()) {
        box_rescue(&box, &recorder, &place, &live);
        guard_feed();
    }
    test_kept();
}

static const about_t of_image = {DRIVE_ABOUT, .build = &build_id_note[BUILD_ID_FIRST_WORD]};

/* Returns why the drive cannot start. Apart, so that only its own calls have its variables. */
NEVER_INLINED static const char *start(const char *before)
{
    const char *why = before;

    live_config_init(&live, &app, &hardware, &of_image, &DRIVE_CONFIG);
    link_init(&serial, &live);
    box.about = &live.about;
    greet();
    if (why == NULL) {
        why = clock_crystal_fault();
    }
    if ((why == NULL) && ((reg_read(FLASH_OPTR) & HAL_FLASH_MODE) != HAL_FLASH_MODE)) {
        why = "option bytes: the flash has one bank, set DBANK = 1";
    }
    if ((why == NULL) && !image_is_whole()) {
        why = CHECK_IMAGE;
    }
    return (why == NULL) ? bring_up() : why;
}

int main(void)
{
    const char *why = NULL;

    reg_write(SCB_VTOR, SCB_VTOR_IMAGE);
    if (!clock_is_up()) {
        /* the baud rate is wrong then, so nobody can read this text */
        why = "the clock does not settle";
    }
    clock_peripherals();
    pins_init();
    uart_init();
    hal_g4_note_reset(&hardware);
    rescue(&of_image);
    if ((why == NULL) && (ram_fault != 0U)) {
        why = "the RAM does not hold what is written";
    }
    why = start(why);
    if (why != NULL) {
        stay((hardware.why_barred == NULL) ? why : hardware.why_barred);
    }
    background();
    return 0;
}
