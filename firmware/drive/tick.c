/* SPDX-License-Identifier: MIT */
/*
 * drive_step() of drive.h: one control tick, from raw counts to compare values.
 *
 *     sample → attend → run | vector | probe | idle → compare
 *
 * The last function of this file is the tick. The functions before it are its parts.
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
#include "vector.h"
#include "voltage_drive.h"

#define SLOW_MASK (0xFFU) /* all bits of drive_t.slow_count */

/*
 * Returns the length of a slow period in ticks, at least one tick per slot. If flipped bits make
 * the setting smaller, no slot is left out, not even CHECKS, which finds the flipped bits.
 */
static uint8_t slow_period(const drive_cfg_t *cfg)
{
    return (uint8_t)((cfg->slow_ticks < (uint32_t)SLOTS) ? (uint32_t)SLOTS : cfg->slow_ticks);
}

/*
 * Counts slow_count down. Returns the ticks left in the slow period after this one. slow_step()
 * reloads the count on the last tick, so a tick without a slot need not test for it.
 */
static uint32_t count_slow(uint8_t *slow_count)
{
    const uint32_t left = (uint32_t)*slow_count - 1U;

    *slow_count = (uint8_t)(left & SLOW_MASK);
    return left;
}

/*
 * Runs the slot of the slow schedule that falls on this tick. left: the number of that slot. What
 * follows from the event is done by the caller, so that the stack of both does not add up.
 */
NEVER_INLINED static drive_event_t slow_step(drive_t *drive, const drive_in_t *in,
                                             const instant_t *now, uint32_t left, bool moving,
                                             fault_t *fault)
{
    if (left == 0U) {
        drive->slow_count = slow_period(drive->cfg);
    }
    fault_clear(fault);
    return schedule_step(drive, in, now, (slot_t)left, moving, fault);
}

/* Only some ticks of a slow period have a slot. */
static void take_slot(drive_t *drive, const drive_in_t *in, const instant_t *now, uint32_t left,
                      bool moving)
{
    if (left < (uint32_t)SLOTS) {
        fault_t fault;
        const drive_event_t event = slow_step(drive, in, now, left, moving, &fault);

        life_follow_or_fail(drive, event, &fault, now);
    }
}

static void open_gates(const drive_t *drive, drive_out_t *out)
{
    const uint32_t half = (uint32_t)drive->cfg->modulator.timer_counts / 2U;
    const uint16_t rest = (uint16_t)half;

    *out = (drive_out_t){.compare = {.phase = {rest, rest, rest}}, .gate_enable = false};
}

/*
 * Sets the output of a tick that drives nothing: the safe state. When it begins to short the motor,
 * the gates are enabled at once, but the compare values of the last tick still act for one period.
 * They are the values of the control, or three equal ones, which short the motor too.
 */
NEVER_INLINED static void rest(safe_state_t *safe_state, const drive_t *drive, sample_t sample,
                               drive_out_t *out)
{
    const safe_state_in_t measured = {
        .current = transforms_clarke(sample.phase_a, sample.phase_b),
        .bus = sample.bus,
        .bus_max = drive->limits.bus_max,
    };

    open_gates(drive, out);
    if (safe_state_step(safe_state, &drive->cfg->safe_state, &measured)) {
        *out = (drive_out_t){.compare = {.phase = {0U, 0U, 0U}}, .gate_enable = true};
    }
}

/*
 * Returns the voltage while the alignment measures inductances: the voltage of the last tick plus
 * the change that the alignment asks for. The integrals of the current control stay as they are.
 */
static dq_t aligning_voltage(const drive_t *drive)
{
    const dq_t change = align_voltage(&drive->start.align, &drive->cfg->startup.align);

    return (dq_t){
        .d = fx_clamp(drive->control.voltage.d + change.d, -FX_Q15_MAX, FX_Q15_MAX),
        .q = fx_clamp(drive->control.voltage.q + change.q, -FX_Q15_MAX, FX_Q15_MAX),
    };
}

static dq_t imposed_voltage(control_t *control, const drive_t *drive, const frame_t *frame,
                            int32_t bus)
{
    const bool aligning = (drive->state == DRIVE_STATE_ALIGN) &&
                          align_holds_voltage(&drive->start.align, &drive->cfg->startup.align);

    return aligning ? aligning_voltage(drive) : frame_impose_current(control, drive, frame, bus);
}

/* Returns the voltage to demand, Q15 of U_b. */
static dq_t control_voltage(control_t *control, voltage_drive_t *vd, const drive_t *drive,
                            const frame_t *frame, int32_t bus)
{
    dq_t voltage;

    if (frame->imposed) {
        voltage = imposed_voltage(control, drive, frame, bus);
    } else if (drive->voltage_drive.active) {
        voltage = voltage_drive_step(vd, drive, frame->current, bus);
    } else {
        voltage = frame_control_current(control, drive, frame->loop, frame->current, bus);
    }
    return voltage;
}

/*
 * Computes the compare values from the currents, and θ̂ of the next instant. pulled: the vector
 * pulls θ̂.
 */
static void actuate(drive_t *drive, const frame_t *frame, int32_t bus, bool pulled,
                    drive_out_t *out)
{
    const dq_t voltage = control_voltage(&drive->control, &drive->voltage_drive, drive, frame, bus);

    frame_modulate(&drive->control, drive, frame, voltage, &out->compare);
    out->gate_enable = true;
    if (frame->imposed) {
        vector_advance(&drive->vector);
    }
    estimate_advance(&drive->rotor, drive, pulled);
}

/*
 * Ends a tick whose parts may have changed the state: controls the current in the frame of the
 * present state. If this state controls no current, sets the safe state instead.
 */
static void act(drive_t *drive, const instant_t *now, bool pulled, drive_out_t *out)
{
    if (drive_is_controlled(drive->state)) {
        const frame_t frame = (drive->state == DRIVE_STATE_RUN)
                                  ? frame_of_rotor(drive, now->along_rotor)
                                  : frame_of_vector(drive, now->along_vector);

        actuate(drive, &frame, now->sample.bus, pulled, out);
    } else {
        rest(&drive->safe_state, drive, now->sample, out);
    }
}

/*
 * The slow part of a tick has ended RUN. Only hand_back() goes on to an imposed current. It has
 * just set current_mean to the measured current in the frame of the vector.
 */
NEVER_INLINED static void finish_left_run(drive_t *drive, instant_t now, drive_out_t *out)
{
    now.along_vector = drive->vector.current_mean;
    act(drive, &now, false, out);
}

/*
 * A tick of RUN: observes the rotor and controls the current in its frame. The observer adapts ω̂
 * unless a sensor tells it. It is one piece of code, and what few ticks need stands apart. Without
 * these attributes the compiler changes its choice as the rest of the firmware grows. That costs 20
 * instructions on a Cortex-M4, and 24 on a Cortex-M0+.
 */
INLINES_ALL static void run_tick(drive_t *drive, const drive_in_t *in, sample_t sample,
                                 uint32_t left, drive_out_t *out)
{
    const instant_t now = {.sample = sample,
                           .along_rotor = estimate_step(&drive->rotor, drive, sample),
                           .along_vector = {0, 0}};

    if (!drive_is_sensed(drive)) {
        estimate_train(&drive->rotor, drive);
    }
    take_slot(drive, in, &now, left, true);
    if (drive->state == DRIVE_STATE_RUN) {
        const frame_t frame = frame_of_rotor(drive, now.along_rotor);

        actuate(drive, &frame, sample.bus, false, out);
    } else {
        finish_left_run(drive, now, out);
    }
}

/* Sets the imposed current of this tick. Returns the event that follows in ALIGN. */
static drive_event_t impose(start_t *start, control_t *control, const drive_t *drive,
                            dq_t along_vector, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->state == DRIVE_STATE_ALIGN) {
        event = open_loop_align(start, drive, along_vector, fault);
        frame_ask(control, (dq_t){.d = start->align.current_ref, .q = 0});
    } else {
        frame_ask_d(control, open_loop_current(drive));
    }
    return event;
}

/* A tick of ALIGN to HANDOVER, in which the drive imposes a current vector. */
static void vector_tick(drive_t *drive, const drive_in_t *in, sample_t sample, uint32_t left,
                        drive_out_t *out)
{
    const bool trained = estimate_is_trained(drive);
    const dq_t along_rotor = estimate_step(&drive->rotor, drive, sample);
    const instant_t now = {.sample = sample,
                           .along_rotor = along_rotor,
                           .along_vector = vector_measure(&drive->vector, sample)};
    drive_event_t event;
    fault_t fault;

    if (trained) {
        estimate_train(&drive->rotor, drive);
    } else {
        estimate_follow(&drive->rotor, drive);
    }
    fault_clear(&fault);
    event = impose(&drive->start, &drive->control, drive, now.along_vector, &fault);
    if (drive->state == DRIVE_STATE_ALIGN) {
        vector_move(&drive->vector, drive->start.align.frame_speed);
    }
    life_follow_or_fail(drive, event, &fault, &now);
    take_slot(drive, in, &now, left, true);
    act(drive, &now, !trained, out);
}

/* A tick of PROBE. The slot of this tick may end PROBE. */
static void probe_tick(drive_t *drive, const drive_in_t *in, sample_t sample, uint32_t left,
                       drive_out_t *out)
{
    const dq_t current = probing_step(drive, &in->command, sample, &out->compare);
    const instant_t now = {.sample = sample, .along_rotor = current, .along_vector = current};

    out->gate_enable = true;
    take_slot(drive, in, &now, left, false);
    if (drive->state != DRIVE_STATE_PROBE) {
        rest(&drive->safe_state, drive, sample, out);
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
        life_follow_or_fail(drive, open_loop_search(&drive->start, drive, in, sample, out, &fault),
                            &fault, &now);
    }
    take_slot(drive, in, &now, left, false);
    if (!drive_is_driving(drive->state)) {
        rest(&drive->safe_state, drive, sample, out);
    }
}

/*
 * A tick of another state than RUN, or without current control before attend_step() or after it.
 */
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
    const uint32_t left = count_slow(&drive->slow_count);
    const sample_t sample = instant_sample(drive, in);
    bool controlled = true;

    modulator_track_bus(&drive->modulator, modulator_bus_ahead(drive->bus, sample.bus));
    if (!attend_is_ordinary(drive, in, sample)) {
        controlled = attend_step(drive, in, sample);
    } else if (drive_has_sensor(drive)) {
        controlled = attend_sensor(drive, in, sample);
    } else {
        /* nothing asks for attention */
    }
    if (!controlled || (drive->state != DRIVE_STATE_RUN)) {
        other_tick(drive, in, sample, left, controlled, out);
    } else {
        run_tick(drive, in, sample, left, out);
    }
    drive->bus = sample.bus;
    drive->tick++;
}
