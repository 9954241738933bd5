/* SPDX-License-Identifier: MIT */
#include "drive.h"

#include "config_change.h"
#include "config_check.h"
#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "monitor.h"
#include "open_loop.h"
#include "probing.h"
#include "run.h"
#include "schedule.h"
#include "state_guard.h"
#include "straight.h"
#include "transitions.h"
#include "trig.h"
#include "voltage_drive.h"

#include <stddef.h>

#define ADC_MID_Q15 (16384)         /* I_b is twice the converter's full scale */
#define SLOW_MASK (0xFFU)           /* of slow_count */
#define OFFSET_END (32768)          /* no sensor's zero is further away */
#define OFFSET_SUM_MAX (0x10000000) /* of 2^12 counts */

/*
 * The largest speed that anything tells of, where the drive leaves for `next`. The estimate may be what has failed. Then the ramp is
 * where the rotor was to be. Torque control has no ramp, so behind a fault the rotor may be as fast as its window allows. PROBE has a
 * vector only. A flying start ends as it began, with open gates.
 */
static step_t fastest_known(const drive_t *drive, drive_state_t next)
{
    const torque_loop_cfg_t *const window = &drive->cfg->torque_loop;
    step_t speed = 0;

    if ((drive->state == DRIVE_STATE_RUN) && (next == DRIVE_STATE_FAULT) &&
        (drive->mode == (uint8_t)DRIVE_MODE_TORQUE)) {
        speed = fx_max(window->speed_forward, window->speed_backward);
    } else if (drive->state == DRIVE_STATE_PROBE) {
        speed = fx_abs(drive->vector.step);
    } else if (drive->state != DRIVE_STATE_FLYING_START) {
        speed = fx_max(fx_abs(drive->observer.speed), fx_abs(drive->speed_loop.reference));
    } else {
        /* nothing is known yet */
    }
    return speed;
}

/* Nothing is driven from this tick on: the gates open, or the motor is shorted where it is too fast for that. */
RARE static void leave(drive_t *drive, drive_state_t next)
{
    safe_state_leave(&drive->safe_state, &drive->cfg->safe_state, fastest_known(drive, next));
}

/* RUN begins with a plan of its current control, and with the torque that acts: no change of the mode is left to be bridged. */
static void begin_run(drive_t *drive)
{
    drive->torque_loop.bridging = false;
    if (drive->mode == (uint8_t)DRIVE_MODE_TORQUE) {
        torque_loop_start(&drive->torque_loop, drive_flux(drive), drive->signals.current_ref.q);
    }
    torque_filter_start(&drive->torque_filter, drive->signals.current_ref.q);
    frame_plan_rotor(drive);
}

/* The protection limits of the new state apply from now on. */
static void enter(drive_t *drive, drive_state_t state)
{
    if (drive_is_driving(drive->state) && !drive_is_driving(state)) {
        leave(drive, state);
    }
    if (drive->state != state) {
        state_guard_forget(drive);
    }
    drive->state = state;
    drive->limits = protection_limits(&drive->cfg->protection, drive_is_driving(state));
    if (state == DRIVE_STATE_RUN) {
        begin_run(drive);
    }
}

static void follow(drive_t *drive, drive_event_t event)
{
    enter(drive, transitions_next(drive->state, event));
}

/* A fault is latched: in FAULT another one changes nothing. */
static void fail(drive_t *drive, const fault_t *fault)
{
    if (drive->state != DRIVE_STATE_FAULT) {
        drive->fault.id = fault->id;
        drive->fault.value = fault->value;
        drive->fault.limit = fault->limit;
        drive->fault.tick = drive->tick;
        drive->scene = (fault_scene_t){
            .state = drive->state,
            .limits = drive->derating.flags,
            .speed = drive_speed(drive),
            .torque = drive_current_in_force(drive).q,
            .phase_a = drive->signals.phase_a,
            .phase_b = drive->signals.phase_b,
            .motoring = drive->derating.motoring,
        };
        follow(drive, DRIVE_EVENT_FAULT);
    }
}

RARE static void react(drive_t *drive, drive_event_t event, const fault_t *fault)
{
    if (event == DRIVE_EVENT_FAULT) {
        fail(drive, fault);
    } else {
        follow(drive, event);
    }
}

/* Act on the event of a part that can find a fault too. Most ticks have none. */
static void follow_or_fail(drive_t *drive, drive_event_t event, const fault_t *fault)
{
    if (event != DRIVE_EVENT_NONE) {
        react(drive, event, fault);
    }
}

static void open_gates(drive_t *drive, drive_out_t *out)
{
    const uint32_t half = (uint32_t)drive->cfg->modulator.timer_counts / 2U;
    const uint16_t rest = (uint16_t)half;

    *out = (drive_out_t){.compare = {.phase = {rest, rest, rest}}, .gate_enable = false};
}

/*
 * The output of a tick that drives nothing: the safe state. The compare values of the last tick act for one period more.
 * They are those of the control, or equal ones, which short the motor too.
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

/* After a late tick no voltage acts in place of its demand. */
static void count_late(drive_t *drive)
{
    fault_t fault = {.id = FAULT_NONE};
    const fault_id_t id =
        supervision_count_late(&drive->supervision, &drive->cfg->supervision, &fault);

    drive->signals.ratio_ab = (ab_t){0, 0};
    if ((id != FAULT_NONE) && drive_is_driving(drive->state)) {
        fail(drive, &fault);
    }
}

static protection_in_t measured_of(const drive_t *drive)
{
    return (protection_in_t){
        .phase_a = drive->signals.phase_a,
        .phase_b = drive->signals.phase_b,
        .bus = drive->signals.bus,
    };
}

/*
 * The samples of this tick against the limits of this state. When the sample of an over-current is at an end of the
 * converter range, the fault is ADC_SATURATED.
 */
static void watch(drive_t *drive, const drive_in_t *in)
{
    const protection_in_t measured = measured_of(drive);
    fault_t fault;
    const fault_id_t id = protection_check(&drive->limits, &measured, &fault);

    if (id != FAULT_NONE) {
        if ((id == FAULT_OVERCURRENT) && monitor_is_saturated(drive, in)) {
            fault.id = FAULT_ADC_SATURATED;
        }
        fail(drive, &fault);
    }
}

/* Mean of 2^offset_log2 raw samples in Q15 of I_b. */
static int32_t mean_sample(const sampling_cfg_t *cfg, int32_t sum)
{
    const uint64_t scaled = (uint64_t)sum << cfg->current_shift;
    const uint64_t mean = scaled >> cfg->offset_log2;

    return (mean < (uint64_t)OFFSET_END) ? (int32_t)mean : OFFSET_END;
}

static drive_event_t finish_calibration(drive_t *drive, fault_t *fault)
{
    const sampling_cfg_t *const cfg = &drive->cfg->sampling;
    fault_id_t id;

    drive->offset_a = mean_sample(cfg, drive->calibration.sum_a);
    drive->offset_b = mean_sample(cfg, drive->calibration.sum_b);
    state_guard_keep_measured(drive);
    id = protection_check_offset(&drive->cfg->protection, drive->offset_a - ADC_MID_Q15,
                                 drive->offset_b - ADC_MID_Q15, fault);
    return (id == FAULT_NONE) ? DRIVE_EVENT_CALIBRATED : DRIVE_EVENT_FAULT;
}

/* Without current nothing but noise changes a sample. */
static void count_noise(calibration_t *sums, const drive_in_t *in)
{
    const int32_t a = (int32_t)in->adc_ia - (int32_t)sums->before_a;
    const int32_t b = (int32_t)in->adc_ib - (int32_t)sums->before_b;

    if (sums->samples > 0U) {
        sums->noise = fx_min(sums->noise + fx_abs(a) + fx_abs(b), OFFSET_SUM_MAX);
    }
    sums->before_a = in->adc_ia;
    sums->before_b = in->adc_ib;
}

static drive_event_t calibrate_step(drive_t *drive, const drive_in_t *in, fault_t *fault)
{
    calibration_t *const sums = &drive->calibration;
    drive_event_t event = DRIVE_EVENT_NONE;

    sums->sum_a = fx_min(sums->sum_a + (int32_t)in->adc_ia, OFFSET_SUM_MAX);
    sums->sum_b = fx_min(sums->sum_b + (int32_t)in->adc_ib, OFFSET_SUM_MAX);
    count_noise(sums, in);
    sums->samples++;
    if (sums->samples == (1UL << drive->cfg->sampling.offset_log2)) {
        event = finish_calibration(drive, fault);
    }
    return event;
}

/* J was learned from the speed that the observer saw before the fault; R, L and φ were measured, or are bound to their files. */
static drive_event_t begin_calibration(drive_t *drive)
{
    drive->calibration = (calibration_t){.sum_a = 0};
    safe_state_reset(&drive->safe_state);
    speed_loop_init(&drive->speed_loop);
    return DRIVE_EVENT_CALIBRATE;
}

/* Nothing that supervision and monitor have seen counts from now on. */
static void forget_last_run(drive_t *drive)
{
    drive->attempts = 0U;
    supervision_reset(&drive->supervision);
    oscillation_reset(&drive->oscillation);
}

static drive_event_t start(drive_t *drive)
{
    drive_event_t event = DRIVE_EVENT_TRACKED;

    forget_last_run(drive);
    speed_loop_restore(&drive->speed_loop);
    if (drive_has_sensor(drive)) {
        run_reset_sensed(drive);
    } else if (drive->cfg->startup.current_hold == 0) {
        run_reset(drive);
    } else {
        event = open_loop_start(drive);
    }
    return event;
}

static drive_event_t obey_when_ready(drive_t *drive, uint8_t request)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if ((request & DRIVE_REQUEST_RUN) != 0U) {
        event = start(drive);
    } else if ((request & DRIVE_REQUEST_PROBE) != 0U) {
        forget_last_run(drive);
        event = probing_start(drive);
    } else {
        /* stay */
    }
    return event;
}

/* What the command asks for, and the calibration. */
static drive_event_t obey_at_rest(drive_t *drive, const drive_in_t *in, bool run, fault_t *fault)
{
    const bool clear = (in->command.request & DRIVE_REQUEST_CLEAR) != 0U;
    drive_event_t event;

    switch (drive->state) {
    case DRIVE_STATE_OFFSET_CAL:
        event = calibrate_step(drive, in, fault);
        break;
    case DRIVE_STATE_READY:
        event = obey_when_ready(drive, in->command.request);
        break;
    case DRIVE_STATE_FAULT:
        event = (clear && !run) ? begin_calibration(drive) : DRIVE_EVENT_NONE;
        break;
    default: /* INIT */
        event = begin_calibration(drive);
        break;
    }
    return event;
}

/* While the motor is shorted its current flows, and nothing begins. */
static void obey(drive_t *drive, const drive_in_t *in)
{
    const bool shorted = safe_state_is_short(&drive->safe_state);
    const bool driving = drive_is_driving(drive->state);
    const bool run = (in->command.request & DRIVE_REQUEST_RUN) != 0U;
    const uint8_t level =
        (drive->state == DRIVE_STATE_PROBE) ? DRIVE_REQUEST_PROBE : DRIVE_REQUEST_RUN;
    const bool goes_on = (in->command.request & level) != 0U;

    if (!driving && !shorted) {
        fault_t fault;

        fault_clear(&fault);
        follow_or_fail(drive, obey_at_rest(drive, in, run, &fault), &fault);
    } else if (driving && !goes_on) {
        follow(drive, DRIVE_EVENT_STOP);
    } else {
        /* go on */
    }
}

/* A setting that has flipped below its range would leave slots out, the one that finds it among them. */
static uint8_t slow_period(const drive_cfg_t *cfg)
{
    return (uint8_t)((cfg->slow_ticks < (uint32_t)SLOTS) ? (uint32_t)SLOTS : cfg->slow_ticks);
}

/*
 * Ticks left in the slow period after this one. On the last one slow_step() reloads the count: a tick without a slot has
 * nothing more to test.
 */
static uint32_t count_slow(drive_t *drive)
{
    const uint32_t left = (uint32_t)drive->slow_count - 1U;

    drive->slow_count = (uint8_t)(left & SLOW_MASK);
    return left;
}

/* In RUN, and nothing changes that: no sensor, no flag, the command is to run, and the samples are within their limits. */
static bool is_ordinary(const drive_t *drive, const drive_in_t *in)
{
    const uint32_t word = ((uint32_t)in->flags << 8U) | in->command.request;
    const protection_in_t measured = measured_of(drive);

    return (drive->state == DRIVE_STATE_RUN) && !drive_has_sensor(drive) &&
           (word == DRIVE_REQUEST_RUN) && protection_holds(&drive->limits, &measured);
}

/* A fault that only the background can find. What is no fault is none. */
static void fail_as_told(drive_t *drive, const drive_command_t *command)
{
    const uint32_t numbers = fx_unsigned(command->target);
    const uint32_t value = numbers & 0xFFFFU;
    const uint32_t limit = numbers >> 16U;

    if ((command->mode > (uint8_t)FAULT_NONE) && (command->mode < (uint8_t)FAULT_COUNT)) {
        const fault_t fault = {
            .id = (fault_id_t)command->mode, .value = (int32_t)value, .limit = (int32_t)limit};

        fail(drive, &fault);
    }
}

/* A bit of the state has flipped by itself. Nothing but FAULT follows. */
RARE static void reject_state(drive_t *drive)
{
    const uint32_t code = (uint32_t)STATE_GUARD_STATE + (uint32_t)drive->state;
    const fault_t fault = {.id = FAULT_MEMORY, .value = fx_signed(code), .limit = 0};

    fail(drive, &fault);
}

/* Sensor, command, flags and limits. Returns whether the current is controlled in this tick. */
static bool attend(drive_t *drive, const drive_in_t *in)
{
    const bool controlled = drive_is_controlled(drive->state);

    if (!transitions_is_state(drive->state)) {
        reject_state(drive);
    }
    if (drive_has_sensor(drive)) {
        estimate_sense(drive, in->angle);
    }
    if (in->command.request == DRIVE_REQUEST_FAIL) {
        fail_as_told(drive, &in->command);
    }
    obey(drive, in); /* with a fault that is none the request to run is gone all the same */
    if (((in->command.request & DRIVE_REQUEST_ZERO) != 0U) && drive_knows_rotor(drive)) {
        run_set_zero(drive);
    }
    /* Check this before the currents: a fault of the currents that late ticks cause is to be reported as LATE. */
    if ((in->flags & DRIVE_FLAG_LATE) != 0U) {
        count_late(drive);
    }
    if ((in->flags & DRIVE_FLAG_BREAK) != 0U) {
        const protection_in_t measured = measured_of(drive);
        const fault_t fault = protection_break(&measured);

        fail(drive, &fault);
        safe_state_break(&drive->safe_state);
    }
    watch(drive, in);
    return controlled && drive_is_controlled(drive->state);
}

/* INIT with this configuration. Nothing is known; until the calibration the current sensors have their nominal zero. */
static void initialise(drive_t *drive, const drive_cfg_t *cfg)
{
    model_nominal_t nominal;

    *drive = (drive_t){.cfg = cfg, .offset_a = ADC_MID_Q15, .offset_b = ADC_MID_Q15};
    nominal = drive_nominal(drive);
    model_reset(&drive->model, &nominal);
    speed_loop_init(&drive->speed_loop);
    probe_reset(&drive->probe);
    supervision_forget_flux(&drive->supervision);
    drive->slow_count = (uint8_t)cfg->slow_ticks;
    enter(drive, DRIVE_STATE_INIT);
    modulator_reset(&drive->modulator, &cfg->modulator);
    derating_reset(&drive->derating, &cfg->derating);
    config_guard_reset(&drive->guard);
    state_guard_keep_measured(drive);
    state_guard_keep_config(drive);
}

const char *drive_init(drive_t *drive, const drive_cfg_t *cfg)
{
    const char *bad;

    initialise(drive, cfg);
    bad = config_check(cfg);
    if ((bad == NULL) && (config_guard_crc(cfg) != cfg->crc)) {
        bad = "crc";
    }
    return bad;
}

void drive_warm(drive_t *drive, int32_t heat_q24)
{
    drive->derating.heat_q24 = heat_q24;
    state_guard_keep_heat(drive);
}

/*
 * Words of the state mean something else from now on, so the drive begins anew and calibrates. What remains is the clock, a
 * latched fault, and the heat of the same current. The slow period goes on: this tick has read its slow inputs.
 * A motor that is too fast for open gates is shorted first; the zeros of its current sensors hold in any scale.
 */
static void restart(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_state_t state = drive->state;
    const fault_t fault = drive->fault;
    const fault_scene_t scene = drive->scene;
    const uint32_t tick = drive->tick;
    const uint32_t left = drive->slow_count;
    derating_t heat = {.heat_q24 = drive->derating.heat_q24};
    const int32_t offset_a = drive->offset_a;
    const int32_t offset_b = drive->offset_b;
    safe_state_t safe_state;

    derating_change(&heat, &drive->cfg->derating, &cfg->derating);
    if (drive_is_driving(state)) {
        leave(drive, DRIVE_STATE_INIT);
    }
    safe_state = drive->safe_state;
    initialise(drive, cfg);
    drive->safe_state = safe_state;
    drive->offset_a = offset_a;
    drive->offset_b = offset_b;
    state_guard_keep_measured(drive);
    drive->fault = fault;
    drive->scene = scene;
    drive->tick = tick;
    drive->slow_count = (uint8_t)((left < cfg->slow_ticks) ? left : cfg->slow_ticks);
    drive->derating.heat_q24 = heat.heat_q24;
    state_guard_keep_heat(drive);
    if (state == DRIVE_STATE_FAULT) {
        enter(drive, DRIVE_STATE_FAULT);
    }
}

/* The instant of the last prediction: θ̂ has gone on since. */
static sincos_t angle_before(const drive_t *drive)
{
    const angle_t rotor = rotor_position_angle(&drive->position);

    return trig_sincos(rotor - fx_unsigned(drive->observer.speed_out));
}

static bool is_other_filter(const torque_filter_cfg_t *one, const torque_filter_cfg_t *other)
{
    return (one->smooth_rate_q15 != other->smooth_rate_q15) ||
           (one->notch_share_q15 != other->notch_share_q15) ||
           (one->notch_turn.sin != other->notch_turn.sin) ||
           (one->notch_turn.cos != other->notch_turn.cos);
}

/* Each part of the state that has copies, corrections or limits of the configuration. */
static void adopt_parts(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_cfg_t *const before = drive->cfg;
    const int32_t flux_q27 = drive->model.observer.flux_q27;
    const int32_t saliency_q13 = drive->model.observer.saliency_q13;
    model_nominal_t nominal;

    drive->cfg = cfg;
    nominal = drive_nominal(drive);
    model_change(&drive->model, &cfg->model, &nominal);
    nn_observer_change(&drive->observer, &drive->model.observer, flux_q27, saliency_q13,
                       angle_before(drive));
    modulator_change(&drive->modulator, &before->modulator, &cfg->modulator);
    derating_change(&drive->derating, &before->derating, &cfg->derating);
    state_guard_keep_heat(drive);
    state_guard_keep_config(drive);
    state_guard_forget(drive);
    if (drive->lost_periods > cfg->startup.lost_periods) {
        drive->lost_periods = cfg->startup.lost_periods;
    }
    if (drive->attempts > cfg->startup.attempts) {
        drive->attempts = cfg->startup.attempts;
    }
    speed_loop_change(&drive->speed_loop, &cfg->speed_loop);
    if (is_other_filter(&before->torque_filter, &cfg->torque_filter)) {
        torque_filter_start(&drive->torque_filter, drive->signals.current_ref.q);
    }
    if (run_torque_is_free(drive)) {
        torque_loop_bridge(&drive->torque_loop); /* the window may end elsewhere */
    }
    drive->limits = protection_limits(&cfg->protection, drive_is_driving(drive->state));
    supervision_forget_flux(&drive->supervision);
    config_guard_reset(&drive->guard);
}

/* A measurement whose pulses or times may be others now begins again, at the present vector. */
static void measure_again_with(drive_t *drive, const drive_cfg_t *cfg)
{
    align_t *const align = &drive->align;

    if (drive->state == DRIVE_STATE_FLYING_START) {
        flying_start_reset(&drive->flying_start);
    } else if ((drive->state == DRIVE_STATE_ALIGN) && (align->phase != ALIGN_PULL)) {
        align_reset_held(align, &cfg->startup.align, align->current_ref);
    } else {
        /* no measurement is under way */
    }
}

/* The voltage that the old model gave and the new one does not, or the other way round, goes to the integrals. */
static void adopt_controlled(drive_t *drive, const drive_cfg_t *cfg)
{
    const dq_t before = frame_model_voltage(drive);
    dq_t now;

    adopt_parts(drive, cfg);
    now = frame_model_voltage(drive);
    current_loop_take_over(&drive->current_loop, (dq_t){before.d - now.d, before.q - now.q});
}

static void adopt(drive_t *drive, const drive_cfg_t *cfg)
{
    measure_again_with(drive, cfg);
    if ((drive->state == DRIVE_STATE_RUN) && drive->voltage_drive.active) {
        /* Nothing limits the current there. It comes back by itself when all is calm. */
        adopt_parts(drive, cfg);
        voltage_drive_end(drive);
    } else if ((drive->state == DRIVE_STATE_RUN) || drive_is_imposed(drive->state)) {
        adopt_controlled(drive, cfg);
    } else {
        adopt_parts(drive, cfg);
    }
}

/*
 * All that it calls is a copy of its own. If the tick shared it, the compiler would not make it a part of the tick: 7
 * instructions of a RUN tick on a Cortex-M4, 20 of one at rest.
 */
INLINES_ALL NEVER_INLINED void drive_change(drive_t *drive, const drive_cfg_t *cfg)
{
    if (cfg->crc == drive->cfg->crc) {
        /* The same in another place: who follows the drive by its inputs sees no change. */
        drive->cfg = cfg;
    } else if (config_change_refused(drive->cfg, cfg) == NULL) {
        adopt(drive, cfg);
    } else {
        restart(drive, cfg);
    }
}

/* The slot of the slow schedule that falls on this tick. */
TICK_APART static void slow_step(drive_t *drive, const drive_in_t *in, uint32_t left, bool moving)
{
    fault_t fault;

    if (left == 0U) {
        drive->slow_count = slow_period(drive->cfg);
    }
    fault_clear(&fault);
    follow_or_fail(drive, schedule_step(drive, in, (slot_t)left, moving, &fault), &fault);
}

/* Few ticks have a slot. */
static void take_slot(drive_t *drive, const drive_in_t *in, uint32_t left, bool moving)
{
    if (left < (uint32_t)SLOTS) {
        slow_step(drive, in, left, moving);
    }
}

/* The alignment measures inductances: the voltage changes as it says; the integrals of the loop do not. */
static void give_voltage(drive_t *drive)
{
    const dq_t change = align_voltage(&drive->align, &drive->cfg->startup.align);
    dq_t *const voltage = &drive->signals.voltage;

    voltage->d = fx_clamp(voltage->d + change.d, -FX_Q15_MAX, FX_Q15_MAX);
    voltage->q = fx_clamp(voltage->q + change.q, -FX_Q15_MAX, FX_Q15_MAX);
}

/* Currents to compare values. */
static void control_current(drive_t *drive, compare_t *out)
{
    const frame_t frame =
        (drive->state == DRIVE_STATE_RUN) ? frame_of_rotor(drive) : frame_of_vector(drive);

    if ((drive->state == DRIVE_STATE_ALIGN) &&
        align_holds_voltage(&drive->align, &drive->cfg->startup.align)) {
        give_voltage(drive);
    } else if (drive->voltage_drive.active) {
        voltage_drive_step(drive);
    } else {
        frame_control_current(drive, &frame);
    }
    frame_modulate(drive, &frame, out);
}

/* The end of a tick that controls a current. When the state has changed to one that does not, the safe state begins. */
static void act(drive_t *drive, bool trained, drive_out_t *out)
{
    if (drive_is_controlled(drive->state)) {
        control_current(drive, &out->compare);
        out->gate_enable = true;
        if (drive->state != DRIVE_STATE_RUN) {
            rotor_position_step(&drive->vector.position, drive->vector.step);
        }
        estimate_advance(drive, trained);
    } else {
        rest(drive, out);
    }
}

/* The imposed current of this tick. */
static void control_vector(drive_t *drive)
{
    fault_t fault;

    fault_clear(&fault);
    frame_measure(drive);
    follow_or_fail(drive, open_loop_step(drive, &fault), &fault);
}

static void control_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    const bool trained = estimate_is_trained(drive);

    estimate_step(drive, trained);
    if (drive->state != DRIVE_STATE_RUN) {
        control_vector(drive);
    }
    take_slot(drive, in, left, true);
    act(drive, trained, out);
}

/* A tick without current control: idle, or flying start. */
static void idle_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    open_gates(drive, out);
    if (drive->state == DRIVE_STATE_FLYING_START) {
        fault_t fault;

        fault_clear(&fault);
        follow_or_fail(drive, open_loop_flying_start(drive, in, out, &fault), &fault);
    }
    take_slot(drive, in, left, false);
    if (!drive_is_driving(drive->state)) {
        rest(drive, out);
    }
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

static void begin_tick(drive_t *drive, const drive_in_t *in)
{
    convert_samples(drive, in);
    modulator_track_bus(&drive->modulator,
                        modulator_bus_ahead(drive->bus_before, drive->signals.bus));
}

static void end_tick(drive_t *drive)
{
    drive->bus_before = drive->signals.bus;
    drive->tick++;
}

static void general_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    const bool controlled = attend(drive, in);

    if (controlled && (drive->state == DRIVE_STATE_PROBE)) {
        probe_tick(drive, in, left, out);
    } else if (controlled) {
        control_tick(drive, in, left, out);
    } else {
        idle_tick(drive, in, left, out);
    }
}

/* The slow part of an ordinary tick has ended RUN. */
TICK_APART static void leave_straight(drive_t *drive, drive_out_t *out)
{
    act(drive, true, out);
}

/* An ordinary tick. Its slow part may end RUN; then the general way goes on. */
TICK_WHOLE static void straight_tick(drive_t *drive, const drive_in_t *in, uint32_t left,
                                     drive_out_t *out)
{
    straight_estimate(drive);
    take_slot(drive, in, left, true);
    if (drive->state == DRIVE_STATE_RUN) {
        straight_control(drive, out);
    } else {
        leave_straight(drive, out);
    }
}

void drive_step_general(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    const uint32_t left = count_slow(drive);

    begin_tick(drive, in);
    general_tick(drive, in, left, out);
    end_tick(drive);
}

void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    /*@ split drive->slow_count == 1; */
    const uint32_t left = count_slow(drive);

    begin_tick(drive, in);
    if (is_ordinary(drive, in)) {
        straight_tick(drive, in, left, out);
    } else {
        general_tick(drive, in, left, out);
    }
    end_tick(drive);
}
