/* SPDX-License-Identifier: MIT */
#include "open_loop.h"

#include "estimate.h"
#include "inlining.h"

#define SIXTH_TURN (0x2AAAAAAAU)
/* At a hand-over the speeds of rotor and vector differ by less than 1/2 of the hand-over speed. */
#define SLIP_SHARE (2)
#define INVERSE_ROOT_3_Q15 (18918)
#define Q13_ONE (8192)
/* Failed starts are forgotten after this many times startup.lost_periods in RUN. */
#define HELD_LOST_TIMES (100U)

void open_loop_forget(start_t *start)
{
    start->attempts = 0U;
}

void open_loop_reset(start_t *start)
{
    *start = (start_t){.attempts = start->attempts};
    flying_start_reset(&start->flying_start);
}

void open_loop_change(start_t *start, const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;

    if (start->lost_periods > cfg->lost_periods) {
        start->lost_periods = cfg->lost_periods;
    }
    if (start->attempts > cfg->attempts) {
        start->attempts = cfg->attempts;
    }
    if (drive->state == DRIVE_STATE_FLYING_START) {
        flying_start_reset(&start->flying_start);
    } else if ((drive->state == DRIVE_STATE_ALIGN) && (start->align.phase != ALIGN_PULL)) {
        align_reset_held(&start->align, &cfg->align, start->align.current_ref);
    } else {
        /* no measurement is under way */
    }
}

bool open_loop_has_to_stand(const drive_t *drive)
{
    return (drive->start.attempts > 0U) && !drive->motor.identified;
}

static bool runs_backwards(const drive_command_t *command)
{
    return (command->mode != (uint8_t)DRIVE_MODE_POSITION) && (command->target < 0);
}

/*
 * Begins the alignment. Every other attempt sweeps in the other direction: a load that turned the
 * rotor against the vector then turns it with the vector.
 */
static drive_event_t begin_alignment(start_t *start, const drive_command_t *command)
{
    const bool reversed = (start->attempts & 1U) != 0U;

    align_reset(&start->align, runs_backwards(command) != reversed);
    return DRIVE_EVENT_STANDS;
}

/* Returns the speed above which the EMF between two phases is larger than the bus voltage. */
static step_t rectifying_speed(const drive_t *drive, int32_t bus)
{
    const int32_t phase = fx_asr(bus * INVERSE_ROOT_3_Q15, 15U);
    const int32_t speed_q15 = (phase * Q13_ONE) / fx_max(drive->motor.model.run_loop.emf_q13, 1);
    const uint32_t lift = (uint32_t)1U << drive->cfg->speed_shift;

    return fx_min(speed_q15, FX_Q15_MAX) * (int32_t)lift;
}

/*
 * Returns the fault that explains a current with open gates. There are two causes. The EMF of a
 * fast rotor is above the bus; then the current vector turns as fast as the rotor. Or a current
 * channel is stuck; then the vector stands still. A vector that turns faster than half of the limit
 * means a fast rotor.
 */
static fault_t live_fault(const drive_t *drive, sample_t sample)
{
    const step_t speed = fx_abs(drive->start.flying_start.speed);
    const step_t limit =
        fx_min(drive->cfg->speed_loop.speed_max, rectifying_speed(drive, sample.bus));
    fault_t fault = {.id = FAULT_OVERSPEED, .value = speed, .limit = limit};

    if (speed <= (limit / 2)) {
        fault = (fault_t){
            .id = FAULT_ADC_STUCK,
            .value = fx_max(fx_abs(sample.phase_a), fx_abs(sample.phase_b)),
            .limit = fx_asr(drive->cfg->startup.flying_start.current, FLYING_START_QUIET_LOG2),
        };
    }
    return fault;
}

/* Returns the event of a rotor that turns. */
static drive_event_t judge_turning(const drive_t *drive)
{
    const step_t speed = fx_abs(drive->start.flying_start.speed);
    const bool fast = speed >= drive->cfg->startup.handover_speed;

    return (fast && !open_loop_has_to_stand(drive)) ? DRIVE_EVENT_TRACKED : DRIVE_EVENT_DRAGGED;
}

drive_event_t open_loop_search(start_t *start, const drive_t *drive, const drive_in_t *in,
                               sample_t sample, drive_out_t *out, fault_t *fault)
{
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    const flying_start_result_t result =
        flying_start_step(&start->flying_start, &drive->cfg->startup.flying_start, current_ab);
    drive_event_t event = DRIVE_EVENT_NONE;

    *out =
        (drive_out_t){.compare = {.phase = {0U, 0U, 0U}}, .gate_enable = start->flying_start.gates};
    if (result == FLYING_START_TURNING) {
        event = judge_turning(drive);
    } else if (result == FLYING_START_LIVE) {
        event = DRIVE_EVENT_FAULT;
        *fault = live_fault(drive, sample);
    } else if (result != FLYING_START_BUSY) {
        out->gate_enable = false;
        event = begin_alignment(start, &in->command);
    } else {
        /* busy */
    }
    return event;
}

/*
 * Returns SEARCH to begin the start again, or FAULT after the last attempt. value: the current that
 * has exceeded its limit, Q15 of I_b.
 */
static drive_event_t repeat_start(start_t *start, const startup_cfg_t *cfg, int32_t value,
                                  int32_t limit, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_SEARCH;

    start->attempts++; /* what else the attempt has left, open_loop_reset() forgets */
    if (start->attempts >= cfg->attempts) {
        event = DRIVE_EVENT_FAULT;
        *fault = (fault_t){.id = FAULT_STARTUP, .value = value, .limit = limit};
    }
    return event;
}

/*
 * If the rotor is not at rest, begins the start again at once, because the load accelerates a
 * slipping rotor. A rotor that only swings costs an attempt too.
 */
static drive_event_t judge_rest(start_t *start, const startup_cfg_t *cfg, fault_t *fault)
{
    const align_t *const align = &start->align;
    drive_event_t event = DRIVE_EVENT_NONE;

    if (!align_is_at_rest(align, &cfg->align)) {
        event = repeat_start(start, cfg, align->swing, cfg->align.swing_max, fault);
    }
    return event;
}

/* The measurement is evaluated in one tick, and its result is used in the next one. */
drive_event_t open_loop_align(start_t *start, const drive_t *drive, dq_t current, fault_t *fault)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool done = start->align.phase == ALIGN_DONE;
    drive_event_t event = DRIVE_EVENT_NONE;

    align_step(&start->align, &cfg->align, current, drive->control.voltage.d);
    if (done) {
        event = DRIVE_EVENT_HELD;
    } else if (align_has_measured(&start->align)) {
        event = judge_rest(start, cfg, fault);
    } else {
        /* the alignment goes on */
    }
    return event;
}

int32_t open_loop_current(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const int32_t present = drive->control.current_ref.d;
    const int32_t whole =
        (drive->motion.speed_reference == 0) ? cfg->current_hold : cfg->current_move;
    const int32_t wanted = fx_min(whole, drive->derating.thermal);

    return fx_towards(present, wanted, cfg->current_slope);
}

angle_t open_loop_load_angle(const drive_t *drive)
{
    return rotor_position_angle(&drive->vector.position) -
           rotor_position_angle(&drive->rotor.position);
}

/*
 * Whether the observer has found the rotor: its angle and speed are near those of the vector, and
 * its model explains the current.
 */
static bool has_found_rotor(const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t slip = fx_abs(drive->vector.step - drive->rotor.observer.speed);
    const bool near = (open_loop_load_angle(drive) + SIXTH_TURN) < (2U * SIXTH_TURN);

    return near && (slip < (cfg->handover_speed / SLIP_SHARE)) &&
           (drive->rotor.residual < cfg->residual_max);
}

/*
 * Returns TRACKED when the observer takes over. While the vector turned slowly, the observer may
 * have learned a load angle. It has settle_periods to correct that.
 */
static drive_event_t judge_handover(start_t *start, const drive_t *drive, fault_t *fault)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool settled = start->handover_periods >= cfg->settle_periods;
    drive_event_t event = DRIVE_EVENT_NONE;

    start->handover_periods++;
    if (settled && has_found_rotor(drive)) {
        event = DRIVE_EVENT_TRACKED;
    } else if (start->handover_periods >= cfg->handover_periods) {
        event = repeat_start(start, cfg, drive->rotor.residual, cfg->residual_max, fault);
    } else {
        /* wait */
    }
    return event;
}

/*
 * Counts the slow periods in which the rotor slips. Returns whether they are so many that it counts
 * as lost. The EMF of a slipping rotor fits neither a model at standstill nor a model that is
 * trained, so the residual stays large. In each turn of the slip the EMF passes through zero twice,
 * so a period with a small residual only counts down by one. While the network follows the vector
 * untrained, a load angle looks like an error, so nothing is checked then.
 */
static bool count_lost(start_t *start, const drive_t *drive)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const bool judges = (drive->vector.step == 0) || estimate_is_trained(drive);
    const bool wrong = judges && (drive->rotor.residual > cfg->residual_lost);

    if (wrong) {
        start->lost_periods++;
    } else if (start->lost_periods > 0U) {
        start->lost_periods--;
    } else {
        /* nothing to count */
    }
    return start->lost_periods >= cfg->lost_periods;
}

/*
 * Returns the event of a vector at rest. After a flying start R and L have not been measured yet:
 * the first standstill is used for it.
 */
static drive_event_t hold(start_t *start, const drive_t *drive)
{
    const bool at_rest = drive->state == DRIVE_STATE_HOLD;
    drive_event_t event = DRIVE_EVENT_HELD;

    if (at_rest && !drive->motor.identified) {
        align_reset_held(&start->align, &drive->cfg->startup.align, drive->control.current_ref.d);
        event = DRIVE_EVENT_STANDS;
    }
    return event;
}

drive_event_t open_loop_judge(start_t *start, const drive_t *drive, fault_t *fault)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t speed = fx_abs(drive->vector.step);
    drive_event_t event;

    if (count_lost(start, drive)) {
        event = repeat_start(start, cfg, drive->rotor.residual, cfg->residual_lost, fault);
    } else if (speed == 0) {
        event = hold(start, drive);
    } else if ((speed < cfg->handover_speed) || open_loop_has_to_stand(drive)) {
        event = DRIVE_EVENT_DRAGGED;
    } else if (drive->state != DRIVE_STATE_HANDOVER) {
        start->handover_periods = 0U;
        event = DRIVE_EVENT_FAST;
    } else {
        event = judge_handover(start, drive, fault);
    }
    return event;
}

RARE static void count_held(start_t *start, const startup_cfg_t *cfg)
{
    start->held_periods++;
    if (start->held_periods >= (HELD_LOST_TIMES * cfg->lost_periods)) {
        start->attempts = 0U;
    }
}

void open_loop_count_run(start_t *start, const startup_cfg_t *cfg)
{
    if (start->attempts > 0U) {
        count_held(start, cfg);
    }
}
