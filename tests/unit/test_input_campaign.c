/* SPDX-License-Identifier: MIT */
/*
 * Random throttles: jitter, glitches, runts, open and shorted wires, a receiver that is switched
 * off, a throttle that is high at power-up, other sources, faults. An oracle that sees only what
 * the person does says whether a start was asked for.
 *
 * The oracle. Since power-up and since the last stop, fault or command of somebody else the person
 * has left the throttle at rest for the time of the arming, on a line that is whole or has gaps
 * shorter than the time-out, and then moves it. It knows nothing of readings, and of the firmware
 * only its times.
 */
#include "seeded.h"
#include "throttled_app.h"

#include <stdio.h>
#include <string.h>

/*
 * What lies between the person and the firmware, in ticks: the arming may end as much earlier or
 * later. Three servo pulses of 20 ms, by the median and the period that is under way; 70 ticks of
 * the low-pass of a voltage are less.
 */
#define LATENCY (600U)
/* A start needs eight readings, of 20 ms at most, and the latency. */
#define ANSWER (2400U)
/* From the loss of the line to open gates: its time-out, a ramp from full demand, the latency. */
#define ENDS (TIMEOUT + LATENCY + 500U)

typedef enum {
    LINE_WHOLE = 0,
    LINE_LOW,   /* open or shorted to ground, or a receiver that is off */
    LINE_HIGH,  /* shorted to the supply */
    LINE_NOISE, /* chatter of a contact, or pulses of any width at any time */
    LINES
} line_t;

/* What the person does, and what becomes of the line. */
static double wanted; /* share of the way, 0: at rest; never within the dead band's border */
static line_t line;

/* The oracle. */
static uint32_t rests;               /* ticks at rest on a whole line, undisturbed */
static bool may_start;               /* it was at rest for so long, and nothing has ended that */
static uint32_t moved;               /* ticks since which the throttle is away from its rest */
static uint32_t since_moved;         /* ticks since it was away last */
static uint32_t whole;               /* ticks since which the line is whole */
static uint32_t broken;              /* ticks since which the line is open or shorted */
static uint32_t starts[INPUT_KINDS]; /* of the input, over all runs */
static uint32_t unasked;             /* of these not asked for */
static uint32_t unended;             /* a lost line whose motor is still driven */
static uint32_t unstarted;           /* a start that was asked for and did not come */
static uint32_t fed;                 /* pulses */

static seeded_t seed;
static uint32_t next_pulse; /* time of the next servo pulse or frame */

static bool chance(uint32_t of)
{
    return seeded_in(&seed, 1, (int32_t)of) == 1;
}

static void send(uint32_t start, uint32_t width)
{
    hardware.pulses[hardware.pulse_end % EXAMPLE_PULSES] =
        (hal_pulse_t){.start = start, .width = width};
    hardware.pulse_end++;
    fed++;
}

/* ---- the line ---- */

static void feed_voltage(void)
{
    const double reading = 0.05 + (0.9 * wanted);
    int32_t count = (int32_t)(reading * 4096.0) + seeded_in(&seed, -10, 10);

    if ((line == LINE_LOW) || ((line == LINE_NOISE) && chance(3U))) {
        count = seeded_in(&seed, 0, 20);
    } else if (line == LINE_HIGH) {
        count = 4095;
    } else {
        /* whole, or the contact touches */
    }
    hardware.inputs.throttle = (uint16_t)count;
}

static void feed_noise(uint32_t most_width, uint32_t most_gap)
{
    while ((int32_t)(hardware.now - next_pulse) > 0) {
        const uint32_t width = (uint32_t)seeded_in(&seed, 1, (int32_t)most_width);

        send(next_pulse, width);
        next_pulse += width + (uint32_t)seeded_in(&seed, 1, (int32_t)most_gap);
        if ((hardware.pulse_end - hardware.pulse_first) > (EXAMPLE_PULSES / 2U)) {
            next_pulse = hardware.now + 1000U;
        }
    }
}

static void feed_servo(uint32_t period)
{
    const uint32_t width = (uint32_t)(10000.0 + (10000.0 * wanted));

    if (line == LINE_NOISE) {
        feed_noise(25000U, 250000U);
    } else if ((int32_t)(hardware.now - next_pulse) <= 0) {
        /* the pause */
    } else if (line == LINE_WHOLE) {
        if (chance(300U)) {
            send(next_pulse - 300U, (uint32_t)seeded_in(&seed, 1, 200)); /* a runt */
        }
        send(next_pulse, (uint32_t)((int32_t)width + seeded_in(&seed, -20, 20)));
        next_pulse += (uint32_t)((int32_t)period + seeded_in(&seed, -50, 50));
    } else {
        next_pulse += period;
    }
}

static void send_frame(uint32_t value)
{
    const uint32_t v = (value << 1U) | (chance(2U) ? 1U : 0U);
    uint32_t bits = (v << 4U) | ((v ^ (v >> 4U) ^ (v >> 8U)) & 15U);

    if (chance(3000U)) {
        bits ^= 1U << (uint32_t)seeded_in(&seed, 0, 15); /* a bit is misread */
    }
    for (uint32_t at = 0U; at < 16U; at++) {
        const bool one = ((bits >> (15U - at)) & 1U) != 0U;

        send(next_pulse + ((at * 100U) / 3U) + (uint32_t)seeded_in(&seed, 0, 1),
             one ? 25U : (uint32_t)seeded_in(&seed, 12, 13));
    }
}

static void feed_dshot(void)
{
    if (line == LINE_NOISE) {
        feed_noise(60U, 300U);
    } else if (((int32_t)(hardware.now - next_pulse) > 600) && (line == LINE_WHOLE)) {
        send_frame((wanted > 0.0) ? (uint32_t)(48.0 + (1999.0 * wanted))
                                  : (uint32_t)seeded_in(&seed, 0, 47));
        next_pulse += 10U * TICK_UNITS;
    } else if ((int32_t)(hardware.now - next_pulse) > 600) {
        next_pulse += 10U * TICK_UNITS;
    } else {
        /* the pause */
    }
}

static void feed(input_kind_t kind, uint32_t period)
{
    if (kind == INPUT_KIND_VOLTAGE) {
        feed_voltage();
    } else if (kind == INPUT_KIND_RC_PULSE) {
        feed_servo(period);
    } else {
        feed_dshot();
    }
}

/* ---- the oracle ---- */

static void disturb(void)
{
    rests = 0U;
    whole = 0U;
    may_start = false;
}

static void watch(void)
{
    broken = ((line == LINE_LOW) || (line == LINE_HIGH)) ? (broken + 1U) : 0U;

    const bool held = (broken > 0U) && (broken < TIMEOUT); /* a gap that is no loss yet */
    const bool still = ((line == LINE_WHOLE) || held) && (wanted <= 0.0);

    rests = (still && (commander_source(&app) == SOURCE_NONE)) ? (rests + 1U) : 0U;
    may_start =
        (may_start || ((rests + LATENCY) >= ARM)) && (commander_source(&app) != SOURCE_LINK);
    moved = (wanted > 0.0) ? (moved + 1U) : 0U;
    since_moved = (wanted > 0.0) ? 0U : (since_moved + 1U);
}

static void judge(source_t before, bool safely_armed)
{
    const source_t now = commander_source(&app);

    if ((now == SOURCE_INPUT) && (before != SOURCE_INPUT)) {
        starts[input.kind]++;
        unasked += (may_start && (since_moved <= LATENCY)) ? 0U : 1U;
    }
    if ((now != SOURCE_INPUT) && (before == SOURCE_INPUT)) {
        disturb(); /* a stop, whoever has stopped */
    }
    unended += ((now == SOURCE_INPUT) && (broken > ENDS)) ? 1U : 0U;
    unstarted += (safely_armed && (moved == ANSWER) && (now != SOURCE_INPUT)) ? 1U : 0U;
}

/* ---- one run ---- */

static void act_of_others(void)
{
    const int32_t which = seeded_in(&seed, 0, 3);

    if (which == 0) {
        (void)commander_set_speed(&app, SOURCE_LINK, 1000000);
        (void)commander_run(&app, SOURCE_LINK);
    } else if (which == 1) {
        commander_stop(&app, SOURCE_CONSOLE);
    } else if (which == 2) {
        app.drive.state = DRIVE_STATE_FAULT;
        commander_step(&app);
        (void)commander_clear(&app, SOURCE_CONSOLE);
    } else {
        commander_upset(&app);
    }
    disturb();
}

/* Returns the ticks of the next piece of what the person does. */
static uint32_t next_piece(void)
{
    wanted = chance(2U) ? 0.0 : (seeded_in(&seed, 80, 1000) / 1000.0);
    line = chance(4U) ? (line_t)seeded_in(&seed, 1, (int32_t)LINES - 1) : LINE_WHOLE;
    return (uint32_t)seeded_in(&seed, 50, (int32_t)(3U * ARM));
}

static void run_once(void)
{
    static const uint32_t periods[] = {200000U, 100000U, 25000U, 20500U};
    const input_kind_t kind = (input_kind_t)seeded_in(&seed, 1, 3);
    const uint32_t period = periods[seeded_in(&seed, 0, 3)];
    input_cfg_t settings = example_input_cfg();
    uint32_t left = 0U;

    settings.kind = (uint32_t)kind;
    if (kind == INPUT_KIND_RC_PULSE) {
        settings.least = 8000;
        settings.low = 10000;
        settings.high = 20000;
        settings.most = 22000;
    } else if (kind == INPUT_KIND_DSHOT) {
        settings.least = 0;
        settings.low = 0;
        settings.high = 2000;
        settings.most = 2000;
    } else {
        /* as in the example */
    }
    settings.middle = settings.low; /* one way */
    begin_with(&settings);
    hardware.now = seeded_u32(&seed);
    next_pulse = hardware.now + 1000U;
    disturb();
    for (uint32_t k = 0U; k < (20U * ARM); k++) {
        const source_t before = commander_source(&app);
        const bool armed_before =
            may_start && (moved == 0U) && (whole > (ARM + ANSWER)) && (rests >= whole);
        static bool safely_armed;

        if (left == 0U) {
            left = next_piece();
            safely_armed = armed_before && (line == LINE_WHOLE) && (wanted > 0.0) &&
                           (before == SOURCE_NONE) && (kind == INPUT_KIND_VOLTAGE);
        }
        left--;
        if (chance(20000U)) {
            act_of_others();
            safely_armed = false;
        }
        feed(kind, period);
        pass();
        watch();
        judge(before, safely_armed && (left > 0U));
    }
}

void setUp(void)
{
    seed = (seeded_t){90210U};
    memset(starts, 0, sizeof starts);
    unasked = 0U;
    unended = 0U;
    unstarted = 0U;
    fed = 0U;
}

TEST(test_of_random_throttles_none_starts_the_motor_that_nobody_asked)
{
    const unsigned runs = testing_runs(300U, 6000U);

    for (unsigned k = 0U; k < runs; k++) {
        run_once();
    }
    printf(
        "%u runs, %u pulses; %u, %u, %u starts by voltage, servo pulses, DShot: %u not asked for, "
        "%u asked for and missing, %u not ended\n",
        runs, fed, starts[INPUT_KIND_VOLTAGE], starts[INPUT_KIND_RC_PULSE],
        starts[INPUT_KIND_DSHOT], unasked, unstarted, unended);
    TEST_ASSERT_EQUAL_UINT32(0U, unasked);
    TEST_ASSERT_EQUAL_UINT32(0U, unstarted);
    TEST_ASSERT_EQUAL_UINT32(0U, unended);
    for (uint32_t kind = 1U; kind < (uint32_t)INPUT_KINDS; kind++) {
        TEST_ASSERT_GREATER_THAN_UINT32(runs / 10U, starts[kind]); /* it is no silence */
    }
}
