/* SPDX-License-Identifier: MIT */
/*
 * drive_step() of drive.h: one control tick, from raw counts to compare values.
 *
 *     sample → attend → run | vector | probe | idle → compare
 *
 * The last function of this file is the tick; those before it are its parts, from the first to the
 * last.
 */
#include "attend.h"
#include "drive.h"
#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "instant.h"
#include "life.h"
#include "open_loop.h"
#include "probing.h"
#include "schedule.h"
#include "voltage_drive.h"

#define SLOW_MASK (0xFFU) /* of slow_count */

/*
 * A setting that has flipped below its range would leave slots out, the one that finds it among
 * them.
 */
static uint8_t slow_period(const drive_cfg_t *cfg)
{
    return (uint8_t)((cfg->slow_ticks < (uint32_t)SLOTS) ? (uint32_t)SLOTS : cfg->slow_ticks);
}

/*
 * Ticks left in the slow period after this one. On the last one slow_step() reloads the count: a
 * tick without a slot has nothing more to test.
 */
static uint32_t count_slow(drive_t *drive)
{
    const uint32_t left = (uint32_t)drive->slow_count - 1U;

    drive->slow_count = (uint8_t)(left & SLOW_MASK);
    return left;
}

/* The slot of the slow schedule that falls on this tick. */
TICK_APART static void slow_step(drive_t *drive, const drive_in_t *in, const instant_t *now,
                                 uint32_t left, bool moving)
{
    fault_t fault;

    if (left == 0U) {
        drive->slow_count = slow_period(drive->cfg);
    }
    fault_clear(&fault);
    life_follow_or_fail(drive, schedule_step(drive, in, now, (slot_t)left, moving, &fault), &fault,
                        &now->sample);
}

/* Only some ticks of a slow period have a slot. */
static void take_slot(drive_t *drive, const drive_in_t *in, const instant_t *now, uint32_t left,
                      bool moving)
{
    if (left < (uint32_t)SLOTS) {
        slow_step(drive, in, now, left, moving);
    }
}

static void open_gates(drive_t *drive, drive_out_t *out)
{
    const uint32_t half = (uint32_t)drive->cfg->modulator.timer_counts / 2U;
    const uint16_t rest = (uint16_t)half;

    *out = (drive_out_t){.compare = {.phase = {rest, rest, rest}}, .gate_enable = false};
}

/*
 * The output of a tick that drives nothing: the safe state. The compare values of the last tick act
 * for one period more. They are those of the control, or equal ones, which short the motor too.
 */
NEVER_INLINED static void rest(drive_t *drive, sample_t sample, drive_out_t *out)
{
    const safe_state_in_t measured = {
        .current = transforms_clarke(sample.phase_a, sample.phase_b),
        .bus = sample.bus,
        .bus_max = drive->limits.bus_max,
    };

    open_gates(drive, out);
    if (safe_state_step(&drive->safe_state, &drive->cfg->safe_state, &measured)) {
        *out = (drive_out_t){.compare = {.phase = {0U, 0U, 0U}}, .gate_enable = true};
    }
}

/*
 * The alignment measures inductances: the voltage changes as it says; the integrals of the loop do
 * not.
 */
static dq_t aligning_voltage(const drive_t *drive)
{
    const dq_t change = align_voltage(&drive->align, &drive->cfg->startup.align);

    return (dq_t){
        .d = fx_clamp(drive->voltage.d + change.d, -FX_Q15_MAX, FX_Q15_MAX),
        .q = fx_clamp(drive->voltage.q + change.q, -FX_Q15_MAX, FX_Q15_MAX),
    };
}

/* The voltage of a vector that is imposed. */
static dq_t imposed_voltage(drive_t *drive, const frame_t *frame, int32_t bus)
{
    const bool aligning = (drive->state == DRIVE_STATE_ALIGN) &&
                          align_holds_voltage(&drive->align, &drive->cfg->startup.align);

    return aligning ? aligning_voltage(drive) : frame_impose_current(drive, frame, bus);
}

/* The voltage to demand, Q15 of U_b. */
static dq_t control_voltage(drive_t *drive, const frame_t *frame, int32_t bus)
{
    dq_t voltage;

    if (frame->imposed) {
        voltage = imposed_voltage(drive, frame, bus);
    } else if (drive->voltage_drive.active) {
        voltage = voltage_drive_step(drive, frame->current, bus);
    } else {
        voltage = frame_control_current(drive, frame->loop, frame->current, bus);
    }
    return voltage;
}

/* Currents to compare values, and θ̂ of the next instant. */
static void control(drive_t *drive, const frame_t *frame, int32_t bus, bool trained,
                    drive_out_t *out)
{
    const dq_t voltage = control_voltage(drive, frame, bus);

    drive->voltage = voltage;
    frame_modulate(drive, frame, voltage, &out->compare);
    out->gate_enable = true;
    if (frame->imposed) {
        rotor_position_step(&drive->vector.position, drive->vector.step);
    }
    estimate_advance(drive, trained);
}

/*
 * The end of a tick whose parts may have changed the state. When no current is controlled now, the
 * safe state begins.
 */
static void act(drive_t *drive, const instant_t *now, bool trained, drive_out_t *out)
{
    if (drive_is_controlled(drive->state)) {
        const frame_t frame = (drive->state == DRIVE_STATE_RUN)
                                  ? frame_of_rotor(drive, now->along_rotor)
                                  : frame_of_vector(drive, now->along_vector);

        control(drive, &frame, now->sample.bus, trained, out);
    } else {
        rest(drive, now->sample, out);
    }
}

/*
 * The slow part of a tick has ended RUN. Only hand_back() goes on to an imposed current. It has
 * just set current_mean to the measured current in the frame of the vector.
 */
TICK_APART static void finish_left_run(drive_t *drive, instant_t now, drive_out_t *out)
{
    now.along_vector = drive->vector.current_mean;
    act(drive, &now, true, out);
}

TICK_WHOLE static void run_tick(drive_t *drive, const drive_in_t *in, sample_t sample,
                                uint32_t left, drive_out_t *out)
{
    const instant_t now = {.sample = sample,
                           .along_rotor = estimate_step(drive, sample, true),
                           .along_vector = {0, 0}};

    take_slot(drive, in, &now, left, true);
    if (drive->state == DRIVE_STATE_RUN) {
        const frame_t frame = frame_of_rotor(drive, now.along_rotor);

        control(drive, &frame, sample.bus, true, out);
    } else {
        finish_left_run(drive, now, out);
    }
}

/* A tick of ALIGN to HANDOVER: the current is that of an imposed vector. */
static void vector_tick(drive_t *drive, const drive_in_t *in, sample_t sample, uint32_t left,
                        drive_out_t *out)
{
    const bool trained = estimate_is_trained(drive);
    const dq_t along_rotor = estimate_step(drive, sample, trained);
    const instant_t now = {
        .sample = sample, .along_rotor = along_rotor, .along_vector = frame_measure(drive, sample)};
    fault_t fault;

    fault_clear(&fault);
    life_follow_or_fail(drive, open_loop_step(drive, &now, &fault), &fault, &sample);
    take_slot(drive, in, &now, left, true);
    act(drive, &now, trained, out);
}

/* A tick of PROBE. Its slow part may end it. */
static void probe_tick(drive_t *drive, const drive_in_t *in, sample_t sample, uint32_t left,
                       drive_out_t *out)
{
    const dq_t current = probing_step(drive, &in->command, sample, &out->compare);
    const instant_t now = {.sample = sample, .along_rotor = current, .along_vector = current};

    out->gate_enable = true;
    take_slot(drive, in, &now, left, false);
    if (drive->state != DRIVE_STATE_PROBE) {
        rest(drive, sample, out);
    }
}

/* A tick without current control: idle, or flying start. */
static void idle_tick(drive_t *drive, const drive_in_t *in, sample_t sample, uint32_t left,
                      drive_out_t *out)
{
    const instant_t now = {.sample = sample, .along_rotor = {0, 0}, .along_vector = {0, 0}};

    open_gates(drive, out);
    if (drive->state == DRIVE_STATE_FLYING_START) {
        fault_t fault;

        fault_clear(&fault);
        life_follow_or_fail(drive, open_loop_flying_start(drive, in, sample, out, &fault), &fault,
                            &sample);
    }
    take_slot(drive, in, &now, left, false);
    if (!drive_is_driving(drive->state)) {
        rest(drive, sample, out);
    }
}

/* A tick other than one of RUN. */
NEVER_INLINED static void other_tick(drive_t *drive, const drive_in_t *in, sample_t sample,
                                     uint32_t left, bool controlled, drive_out_t *out)
{
    if (!controlled) {
        idle_tick(drive, in, sample, left, out);
    } else if (drive->state == DRIVE_STATE_PROBE) {
        probe_tick(drive, in, sample, left, out);
    } else {
        vector_tick(drive, in, sample, left, out);
    }
}

void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    /*@ split drive->slow_count == 1; */
    const uint32_t left = count_slow(drive);
    const sample_t sample = instant_sample(drive, in);
    bool controlled = true;

    modulator_track_bus(&drive->modulator, modulator_bus_ahead(drive->bus, sample.bus));
    if (!attend_is_ordinary(drive, in, sample)) {
        controlled = attend_step(drive, in, sample);
    }
    if (controlled && (drive->state == DRIVE_STATE_RUN)) {
        run_tick(drive, in, sample, left, out);
    } else {
        other_tick(drive, in, sample, left, controlled, out);
    }
    drive->bus = sample.bus;
    drive->tick++;
}
