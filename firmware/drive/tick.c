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
#include "life.h"
#include "open_loop.h"
#include "probing.h"
#include "schedule.h"
#include "voltage_drive.h"

#define SLOW_MASK (0xFFU) /* of slow_count */

/* Raw counts to per unit. The currents are not valid before the calibration has ended. */
static void convert_samples(drive_t *drive, const drive_in_t *in)
{
    const sampling_cfg_t *const cfg = &drive->cfg->sampling;
    drive_signals_t *const s = &drive->signals;
    const uint32_t a = (uint32_t)in->adc_ia << cfg->current_shift;
    const uint32_t b = (uint32_t)in->adc_ib << cfg->current_shift;
    const uint32_t bus = (uint32_t)in->adc_bus << cfg->bus_shift;

    s->phase_a = fx_sat15((int32_t)a - drive->offset_a);
    s->phase_b = fx_sat15((int32_t)b - drive->offset_b);
    s->bus = fx_usat15((int32_t)bus);
}

static void begin_tick(drive_t *drive, const drive_in_t *in)
{
    convert_samples(drive, in);
    modulator_track_bus(&drive->modulator,
                        modulator_bus_ahead(drive->bus_before, drive->signals.bus));
}

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
TICK_APART static void slow_step(drive_t *drive, const drive_in_t *in, uint32_t left, bool moving)
{
    fault_t fault;

    if (left == 0U) {
        drive->slow_count = slow_period(drive->cfg);
    }
    fault_clear(&fault);
    life_follow_or_fail(drive, schedule_step(drive, in, (slot_t)left, moving, &fault), &fault);
}

/* Few ticks have a slot. */
static void take_slot(drive_t *drive, const drive_in_t *in, uint32_t left, bool moving)
{
    if (left < (uint32_t)SLOTS) {
        slow_step(drive, in, left, moving);
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
NEVER_INLINED static void rest(drive_t *drive, drive_out_t *out)
{
    const drive_signals_t *const s = &drive->signals;
    const safe_state_in_t measured = {
        .current = transforms_clarke(s->phase_a, s->phase_b),
        .bus = s->bus,
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
static void give_voltage(drive_t *drive)
{
    const dq_t change = align_voltage(&drive->align, &drive->cfg->startup.align);
    dq_t *const voltage = &drive->signals.voltage;

    voltage->d = fx_clamp(voltage->d + change.d, -FX_Q15_MAX, FX_Q15_MAX);
    voltage->q = fx_clamp(voltage->q + change.q, -FX_Q15_MAX, FX_Q15_MAX);
}

/* Currents to compare values, and θ̂ of the next instant. */
static void control(drive_t *drive, const frame_t *frame, bool trained, drive_out_t *out)
{
    if (frame->imposed && (drive->state == DRIVE_STATE_ALIGN) &&
        align_holds_voltage(&drive->align, &drive->cfg->startup.align)) {
        give_voltage(drive);
    } else if (drive->voltage_drive.active) {
        voltage_drive_step(drive);
    } else {
        frame_control_current(drive, frame);
    }
    frame_modulate(drive, frame, &out->compare);
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
static void act(drive_t *drive, bool trained, drive_out_t *out)
{
    if (drive_is_controlled(drive->state)) {
        const frame_t frame =
            (drive->state == DRIVE_STATE_RUN) ? frame_of_rotor(drive) : frame_of_vector(drive);

        control(drive, &frame, trained, out);
    } else {
        rest(drive, out);
    }
}

/*
 * The parts of a tick of RUN. The compiler puts all that they call into them, less the branches for
 * other frames.
 */
INLINES_ALL static void estimate_rotor(drive_t *drive)
{
    estimate_step(drive, true);
}

INLINES_ALL static void control_rotor(drive_t *drive, drive_out_t *out)
{
    const frame_t frame = frame_of_rotor(drive);

    control(drive, &frame, true, out);
}

/* The slow part of a tick has ended RUN. */
TICK_APART static void finish_left_run(drive_t *drive, drive_out_t *out)
{
    act(drive, true, out);
}

TICK_WHOLE static void run_tick(drive_t *drive, const drive_in_t *in, uint32_t left,
                                drive_out_t *out)
{
    estimate_rotor(drive);
    take_slot(drive, in, left, true);
    if (drive->state == DRIVE_STATE_RUN) {
        control_rotor(drive, out);
    } else {
        finish_left_run(drive, out);
    }
}

/* A tick of ALIGN to HANDOVER: the current is that of an imposed vector. */
static void vector_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    const bool trained = estimate_is_trained(drive);
    fault_t fault;

    fault_clear(&fault);
    estimate_step(drive, trained);
    frame_measure(drive);
    life_follow_or_fail(drive, open_loop_step(drive, &fault), &fault);
    take_slot(drive, in, left, true);
    act(drive, trained, out);
}

/* A tick of PROBE. Its slow part may end it. */
static void probe_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    probing_step(drive, &in->command, &out->compare);
    out->gate_enable = true;
    take_slot(drive, in, left, false);
    if (drive->state != DRIVE_STATE_PROBE) {
        rest(drive, out);
    }
}

/* A tick without current control: idle, or flying start. */
static void idle_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    open_gates(drive, out);
    if (drive->state == DRIVE_STATE_FLYING_START) {
        fault_t fault;

        fault_clear(&fault);
        life_follow_or_fail(drive, open_loop_flying_start(drive, in, out, &fault), &fault);
    }
    take_slot(drive, in, left, false);
    if (!drive_is_driving(drive->state)) {
        rest(drive, out);
    }
}

/* A tick other than one of RUN. */
NEVER_INLINED static void other_tick(drive_t *drive, const drive_in_t *in, uint32_t left,
                                     bool controlled, drive_out_t *out)
{
    if (!controlled) {
        idle_tick(drive, in, left, out);
    } else if (drive->state == DRIVE_STATE_PROBE) {
        probe_tick(drive, in, left, out);
    } else {
        vector_tick(drive, in, left, out);
    }
}

static void end_tick(drive_t *drive)
{
    drive->bus_before = drive->signals.bus;
    drive->tick++;
}

void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    /*@ split drive->slow_count == 1; */
    const uint32_t left = count_slow(drive);
    bool controlled = true;

    begin_tick(drive, in);
    if (!attend_is_ordinary(drive, in)) {
        controlled = attend_step(drive, in);
    }
    if (controlled && (drive->state == DRIVE_STATE_RUN)) {
        run_tick(drive, in, left, out);
    } else {
        other_tick(drive, in, left, controlled, out);
    }
    end_tick(drive);
}
