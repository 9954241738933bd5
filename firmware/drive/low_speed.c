/* SPDX-License-Identifier: MIT */
#include "low_speed.h"

#include "drive_state.h"
#include "vector_control.h"

#define SIXTH_TURN (0x2AAAAAAAU)

void low_speed_start(drive_t *drive)
{
    vector_control_reset(drive);
    catch_spin_reset(&drive->catch_spin);
    drive_enter(drive, DRIVE_STATE_CATCH_SPIN);
}

static bool runs_backwards(const drive_command_t *command)
{
    return (command->mode != (uint8_t)DRIVE_MODE_POSITION) && (command->target < 0);
}

/* The start angle of the vector: from there its sweep ends at angle 0. */
static void start_alignment(drive_t *drive, const drive_command_t *command)
{
    const align_cfg_t *const cfg = &drive->cfg->startup.align;
    const bool backwards = runs_backwards(command);
    const angle_t sweep = (angle_t)cfg->sweep_speed * cfg->sweep_ticks;

    align_reset(&drive->align, backwards);
    rotor_position_reset(&drive->frame, 0U);
    drive->frame.turns_q32 -= (int64_t)sweep * (backwards ? -1 : 1);
    drive->position = drive->frame;
    nn_observer_start(&drive->observer, &drive->model.observer, 0, (dq_t){0, 0},
                      trig_sincos(rotor_position_angle(&drive->position)));
    drive_enter(drive, DRIVE_STATE_ALIGN);
}

/* The windings stay shorted, so the applied voltage is zero, until the first demand acts. */
static void start_turning(drive_t *drive)
{
    const catch_spin_t *const spin = &drive->catch_spin;
    const sincos_t angle = trig_sincos(spin->angle);

    rotor_position_reset(&drive->position, spin->angle);
    nn_observer_start(&drive->observer, &drive->model.observer, spin->speed,
                      transforms_park(drive->signals.current_ab, angle), angle);
    rotor_position_step(&drive->position, drive->observer.speed_out);
    speed_loop_reset(&drive->speed_loop, drive->observer.speed);
    drive->speed_reference = drive->observer.speed;
    drive_enter(drive, DRIVE_STATE_RUN);
}

/* A slower rotor is aligned instead. */
static bool is_fast(const drive_t *drive)
{
    return fx_abs(drive->catch_spin.speed) >= drive->cfg->startup.handover_speed;
}

void low_speed_catch(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    drive_signals_t *const s = &drive->signals;
    catch_spin_result_t result;

    s->current_ab = transforms_clarke(s->phase_a, s->phase_b);
    result = catch_spin_step(&drive->catch_spin, &drive->cfg->startup.catch_spin, s->current_ab);
    *out =
        (drive_out_t){.compare = {.phase = {0U, 0U, 0U}}, .gate_enable = drive->catch_spin.gates};
    if ((result == CATCH_SPIN_TURNING) && is_fast(drive)) {
        start_turning(drive);
    } else if (result == CATCH_SPIN_LIVE) {
        drive_fail(drive, (fault_t){.id = FAULT_ADC_STUCK,
                                    .value = fx_max(fx_abs(s->phase_a), fx_abs(s->phase_b)),
                                    .limit = fx_asr(drive->cfg->startup.catch_spin.current,
                                                    CATCH_SPIN_QUIET_LOG2)});
    } else if (result != CATCH_SPIN_BUSY) {
        out->gate_enable = false;
        start_alignment(drive, &in->command);
    } else {
        /* busy */
    }
}

static void finish_alignment(drive_t *drive)
{
    const align_cfg_t *const cfg = &drive->cfg->startup.align;
    const model_nominal_t nominal = drive_nominal(drive);
    const int32_t resistance = align_resistance_q13(&drive->align);
    const int32_t inductance = align_inductance_q14(&drive->align, cfg);

    if ((resistance > 0) && (inductance > 0)) {
        model_set(&drive->model, &drive->cfg->model, &nominal, resistance, inductance);
        nn_observer_start(&drive->observer, &drive->model.observer, 0, drive->signals.current,
                          trig_sincos(rotor_position_angle(&drive->position)));
    }
    drive->identified = true; /* what could not be told now will not be told by asking again */
    drive->frame_speed = 0;
    speed_loop_reset(&drive->speed_loop, 0);
    drive_enter(drive, DRIVE_STATE_HOLD);
}

static void align(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;

    align_step(&drive->align, &drive->cfg->startup.align, s->current_frame.d, s->voltage.d);
    s->current_ref = (dq_t){.d = drive->align.current_ref, .q = 0};
    drive->frame_speed = drive->align.frame_speed;
    if (drive->align.phase == ALIGN_DONE) {
        finish_alignment(drive);
    }
}

/* The imposed current. It is larger while the vector moves, because the rotor has to be accelerated too. */
static int32_t next_imposed_current(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const int32_t present = drive->signals.current_ref.d;
    const int32_t whole = (drive->speed_reference == 0) ? cfg->current_hold : cfg->current_move;
    const int32_t wanted = fx_min(whole, drive->derating.thermal);

    return fx_towards(present, wanted, cfg->current_slope);
}

/* The angle of the observer is near that of the vector, and its model explains the current. */
static bool has_found_rotor(const drive_t *drive)
{
    const angle_t load_angle =
        rotor_position_angle(&drive->frame) - rotor_position_angle(&drive->position);
    const bool near = (load_angle + SIXTH_TURN) < (2U * SIXTH_TURN);

    return near && (drive->residual < drive->cfg->startup.residual_max);
}

static void repeat_start(drive_t *drive)
{
    drive->attempts++;
    if (drive->attempts < drive->cfg->startup.attempts) {
        low_speed_start(drive);
    } else {
        drive_fail(drive, (fault_t){.id = FAULT_STARTUP,
                                    .value = drive->residual,
                                    .limit = drive->cfg->startup.residual_max});
    }
}

static void judge_handover(drive_t *drive)
{
    drive->handover_periods++;
    if (has_found_rotor(drive)) {
        vector_control_take_over(drive);
        drive->attempts = 0U;
        drive_enter(drive, DRIVE_STATE_RUN);
    } else if (drive->handover_periods >= drive->cfg->startup.handover_periods) {
        repeat_start(drive);
    } else {
        /* wait */
    }
}

/*
 * The back-EMF of a rotor that slips does not fit a model at standstill, nor one that follows it, and it persists. A swing
 * passes through zero. While the model follows the vector untrained, a load angle looks like an error, so there is no
 * check then.
 */
static bool has_lost_rotor(drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool judges = (drive->frame_speed == 0) || low_speed_tracks(drive);
    const bool wrong = judges && (drive->residual > cfg->residual_lost);

    drive->lost_periods = wrong ? (drive->lost_periods + 1U) : 0U;
    return drive->lost_periods >= cfg->lost_periods;
}

/* After a flying start R and L are not measured yet. The first standstill is used for that. */
static void hold(drive_t *drive)
{
    const bool at_rest = drive->state == DRIVE_STATE_HOLD;

    if (drive->identified || !at_rest) {
        drive_enter(drive, DRIVE_STATE_HOLD);
    } else {
        align_reset_held(&drive->align, &drive->cfg->startup.align, drive->signals.current_ref.d);
        drive_enter(drive, DRIVE_STATE_ALIGN);
    }
}

/* HOLD, IF_RAMP and HANDOVER by the speed of the vector. */
static void next_state(drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t speed = fx_abs(drive->frame_speed);

    if (has_lost_rotor(drive)) {
        repeat_start(drive);
    } else if (speed == 0) {
        hold(drive);
    } else if (speed < cfg->handover_speed) {
        drive_enter(drive, DRIVE_STATE_IF_RAMP);
    } else if (drive->state != DRIVE_STATE_HANDOVER) {
        drive->handover_periods = 0U;
        drive_enter(drive, DRIVE_STATE_HANDOVER);
    } else {
        judge_handover(drive);
    }
}

/* The vector does not wait for the rotor. The ramp leaves torque for load and inertia. */
static void plan(drive_t *drive, const drive_command_t *command)
{
    const step_t ramp = drive->cfg->startup.ramp;

    vector_control_plan(drive, command);
    if (drive->mode == (uint8_t)DRIVE_MODE_SPEED) {
        drive->speed_reference = fx_towards(drive->frame_speed, drive->speed_reference, ramp);
    }
}

void low_speed_step(drive_t *drive)
{
    if (drive->state == DRIVE_STATE_ALIGN) {
        align(drive);
    } else {
        drive->signals.current_ref.d = next_imposed_current(drive);
    }
}

static void drag(drive_t *drive, const drive_command_t *command, uint32_t left)
{
    if (left == (uint32_t)SLOW_PART_REFINE) {
        vector_control_refine(drive);
    } else if (left == (uint32_t)SLOW_PART_PLAN) {
        plan(drive, command);
    } else if (left == (uint32_t)SLOW_PART_SPEED) {
        drive->signals.current_ref.q =
            speed_loop_accelerate(&drive->speed_loop, &drive->cfg->speed_loop,
                                  drive->speed_reference, drive->torque_range);
        drive->frame_speed = drive->speed_loop.reference;
        next_state(drive);
    } else {
        /* the monitor's */
    }
}

void low_speed_motion(drive_t *drive, const drive_command_t *command, uint32_t left)
{
    if (drive->state != DRIVE_STATE_ALIGN) {
        drag(drive, command, left);
    }
}

bool low_speed_tracks(const drive_t *drive)
{
    return (drive->state != DRIVE_STATE_ALIGN) &&
           (fx_abs(drive->frame_speed) >= drive->cfg->startup.track_speed);
}
