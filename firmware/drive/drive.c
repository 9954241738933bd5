#include "drive.h"

#include <stddef.h>

#define ADC_MID_Q15 (16384) /* I_b is twice the converter's full scale */
#define Q16_TO_Q32 (65536)
#define SLOW_PARTS (5U) /* last ticks of a slow period that have work of their own */

static void open_gates(drive_t *drive, drive_out_t *out)
{
    const uint32_t half = (uint32_t)drive->cfg->modulator.timer_counts / 2U;
    const uint16_t rest = (uint16_t)half;

    *out = (drive_out_t){.compare = {.phase = {rest, rest, rest}}, .gate_enable = false};
}

static void enter(drive_t *drive, drive_state_t state)
{
    drive->state = state;
    drive->limits = protection_limits(&drive->cfg->protection, state == DRIVE_STATE_RUN);
}

static void enter_fault(drive_t *drive, fault_t fault)
{
    drive->fault = fault;
    drive->fault.tick = drive->tick;
    enter(drive, DRIVE_STATE_FAULT);
}

static void enter_offset_cal(drive_t *drive)
{
    drive->offset_a = 0;
    drive->offset_b = 0;
    drive->offset_samples = 0U;
    enter(drive, DRIVE_STATE_OFFSET_CAL);
}

/* The rotor is taken to be at rest at angle 0. */
static void reset_control(drive_t *drive)
{
    nn_observer_reset(&drive->observer, &drive->cfg->observer);
    rotor_position_reset(&drive->position, 0U);
    current_loop_reset(&drive->current_loop);
    speed_loop_reset(&drive->speed_loop, 0);
    position_loop_reset(&drive->position_loop, 0, 0);
    drive->speed_reference = 0;
    drive->ratio = (dq_t){0, 0};
    drive->ratio_acting = (dq_t){0, 0};
    drive->signals.current_ref_q = 0;
    drive->torque_range = (torque_range_t){-drive->derating.motoring, drive->derating.motoring};
    drive->slow_count = drive->cfg->slow_ticks;
    drive->mode = (uint8_t)DRIVE_MODE_SPEED;
    supervision_reset(&drive->supervision);
}

/* Raw counts to per unit. Before the calibration has ended the currents are meaningless. */
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

/* An over-current at an end of the converter is no measurement. */
static fault_id_t name_of(const drive_t *drive, const drive_in_t *in, fault_id_t id)
{
    const uint32_t shift = drive->cfg->sampling.current_shift;
    const bool saturated =
        protection_saturated(in->adc_ia, shift) || protection_saturated(in->adc_ib, shift);

    return ((id == FAULT_OVERCURRENT) && saturated) ? FAULT_ADC_SATURATED : id;
}

/* Latch what is wrong. */
static void watch(drive_t *drive, const drive_in_t *in)
{
    const protection_in_t measured = {
        .phase_a = drive->signals.phase_a,
        .phase_b = drive->signals.phase_b,
        .bus = drive->signals.bus,
        .break_input = (in->flags & DRIVE_FLAG_BREAK) != 0U,
    };
    const fault_id_t id = protection_check(&drive->limits, &measured);

    if ((id != FAULT_NONE) && (drive->state != DRIVE_STATE_FAULT)) {
        enter_fault(drive, protection_record(&drive->limits, &measured, name_of(drive, in, id)));
    }
    if ((in->flags & DRIVE_FLAG_LATE) != 0U) {
        drive->supervision.late++;
    }
}

/* Mean of 2^offset_log2 raw samples in Q15 of I_b. */
static int32_t mean_sample(const sampling_cfg_t *cfg, int32_t sum)
{
    const uint32_t scaled = (uint32_t)sum << cfg->current_shift;
    const uint32_t mean = scaled >> cfg->offset_log2;

    return (int32_t)mean;
}

static void finish_calibration(drive_t *drive)
{
    const sampling_cfg_t *const cfg = &drive->cfg->sampling;
    fault_t fault;

    drive->offset_a = mean_sample(cfg, drive->offset_a);
    drive->offset_b = mean_sample(cfg, drive->offset_b);
    fault = protection_check_offset(&drive->cfg->protection, drive->offset_a - ADC_MID_Q15,
                                    drive->offset_b - ADC_MID_Q15);
    if (fault.id == FAULT_NONE) {
        enter(drive, DRIVE_STATE_READY);
    } else {
        enter_fault(drive, fault);
    }
}

static void calibrate_step(drive_t *drive, const drive_in_t *in)
{
    drive->offset_a += (int32_t)in->adc_ia;
    drive->offset_b += (int32_t)in->adc_ib;
    drive->offset_samples++;
    if (drive->offset_samples == (1UL << drive->cfg->sampling.offset_log2)) {
        finish_calibration(drive);
    }
}

static bool wants_run(const drive_command_t *command)
{
    return (command->request & DRIVE_REQUEST_RUN) != 0U;
}

/* State changes other than out of RUN that the command asks for, or the end of the calibration. */
static void change_state(drive_t *drive, const drive_in_t *in)
{
    const bool run = wants_run(&in->command);
    const bool clear = (in->command.request & DRIVE_REQUEST_CLEAR) != 0U;

    switch (drive->state) {
    case DRIVE_STATE_READY:
        if (run) {
            reset_control(drive);
            enter(drive, DRIVE_STATE_RUN);
        }
        break;
    case DRIVE_STATE_OFFSET_CAL:
        calibrate_step(drive, in);
        break;
    case DRIVE_STATE_FAULT:
        if (clear && !run) {
            enter_offset_cal(drive);
        }
        break;
    default: /* INIT */
        enter_offset_cal(drive);
        break;
    }
}

/* The voltage that acted since the last instant: its duty ratio times the mean bus of that period. */
static dq_t applied_voltage(const drive_t *drive)
{
    const int32_t bus = fx_asr(drive->bus_before + drive->signals.bus, 1U);

    return (dq_t){
        .d = fx_asr(drive->ratio_acting.d * bus, 15U),
        .q = fx_asr(drive->ratio_acting.q * bus, 15U),
    };
}

/* Measured phase currents to the estimated frame, and the observer's tick. */
static void estimate(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;
    const sincos_t angle = trig_sincos(rotor_position_angle(&drive->position));

    s->current_ab = transforms_clarke(s->phase_a, s->phase_b);
    s->current = transforms_park(s->current_ab, angle);
    s->voltage_applied = applied_voltage(drive);
    nn_observer_step(&drive->observer, &drive->cfg->observer, s->current, s->voltage_applied);
    s->speed = fx_asr(drive->observer.speed, drive->cfg->speed_shift);
}

static void change_mode(drive_t *drive, uint8_t mode)
{
    drive->mode = mode;
    position_loop_reset(&drive->position_loop, drive->position.turns_q32,
                        drive->speed_loop.reference);
}

/* First half of the slow period: the speed reference. */
static void plan_speed(drive_t *drive, const drive_command_t *command)
{
    const drive_cfg_t *const cfg = drive->cfg;

    if (command->mode != drive->mode) {
        change_mode(drive, command->mode);
    }
    if (drive->mode == (uint8_t)DRIVE_MODE_POSITION) {
        drive->speed_reference = position_loop_step(&drive->position_loop, &cfg->position_loop,
                                                    (int64_t)command->target * Q16_TO_Q32,
                                                    drive->position.turns_q32, cfg->slow_ticks);
    } else {
        drive->speed_reference =
            speed_loop_ramp(&drive->speed_loop, &cfg->speed_loop, command->target);
    }
}

static fault_id_t check_current(drive_t *drive, fault_t *fault)
{
    const supervision_current_t measured = {
        .current = drive->signals.current,
        .reference = {.d = 0, .q = drive->signals.current_ref_q},
        .excused = fx_abs(drive->observer.speed) >= drive->cfg->supervision.stall_speed,
    };
    const supervision_cfg_t *const cfg = &drive->cfg->supervision;
    const fault_id_t id = supervision_check_current(&drive->supervision, cfg, &measured, fault);

    return (id != FAULT_NONE)
               ? id
               : supervision_check_observer(&drive->supervision, cfg, drive->observer.error, fault);
}

static fault_id_t check_phases(drive_t *drive, fault_t *fault)
{
    const uint64_t turns_q16 = (uint64_t)drive->position.turns_q32 >> 16U;
    const supervision_phases_t measured = {
        .a = drive->signals.phase_a,
        .b = drive->signals.phase_b,
        .turns_q16 = (int32_t)(uint32_t)(turns_q16 & 0xFFFFFFFFU),
        .speed = drive->observer.speed,
    };

    return supervision_check_phases(&drive->supervision, &drive->cfg->supervision, &measured,
                                    fault);
}

static fault_id_t check_speed(drive_t *drive, fault_t *fault)
{
    const int32_t torque = drive->signals.current_ref_q;
    const supervision_speed_t measured = {
        .speed = drive->observer.speed,
        .reference = drive->speed_loop.reference,
        .speed_limit = drive->cfg->observer.speed_limit,
        .current_ref = torque,
        .torque_at_limit =
            (torque >= drive->torque_range.upper) || (torque <= drive->torque_range.lower),
    };
    const supervision_cfg_t *const cfg = &drive->cfg->supervision;
    const fault_id_t id = supervision_check_late(&drive->supervision, cfg, fault);

    return (id != FAULT_NONE) ? id
                              : supervision_check_speed(&drive->supervision, cfg, &measured, fault);
}

/* One of the checks that take turns. Those of the loops need them closed. */
static fault_id_t check_next(drive_t *drive, uint16_t adc_temperature, fault_t *fault)
{
    const uint32_t step = drive->supervision.step;
    const bool running = drive->state == DRIVE_STATE_RUN;
    const dq_t current = running ? drive->signals.current : (dq_t){0, 0};
    fault_id_t id = FAULT_NONE;

    drive->supervision.step = (step + 1U) % SUPERVISION_STEPS;
    if (step == 0U) {
        id =
            derating_step(&drive->derating, &drive->cfg->derating, current, adc_temperature, fault);
    } else if (step == 1U) {
        id = config_guard_step(&drive->guard, drive->cfg, fault);
    } else if (!running) {
        /* gates are open */
    } else if (step == 2U) {
        id = check_current(drive, fault);
    } else {
        id = check_speed(drive, fault);
    }
    return id;
}

/* Once a slow period, in any state. A fault opens the gates in this tick. */
static void supervise(drive_t *drive, const drive_in_t *in)
{
    fault_t fault = {.id = FAULT_NONE};

    if ((check_next(drive, in->adc_temperature, &fault) != FAULT_NONE) &&
        (drive->state != DRIVE_STATE_FAULT)) {
        enter_fault(drive, fault);
    }
}

/* Once a slow period while running. */
static void supervise_phases(drive_t *drive)
{
    fault_t fault = {.id = FAULT_NONE};

    if ((check_phases(drive, &fault) != FAULT_NONE) && (drive->state != DRIVE_STATE_FAULT)) {
        enter_fault(drive, fault);
    }
}

/* The range of the torque current for the next demand. */
static void limit_torque(drive_t *drive)
{
    drive->torque_range = derating_range(&drive->derating, &drive->cfg->derating,
                                         drive->signals.bus, drive->observer.speed);
}

/* Second half of the motion loops: the torque current. */
static void demand_torque(drive_t *drive)
{
    drive->signals.current_ref_q =
        speed_loop_step(&drive->speed_loop, &drive->cfg->speed_loop, drive->speed_reference,
                        drive->observer.speed, drive->torque_range);
}

/* The slow period with open gates. */
static void idle_tick(drive_t *drive, const drive_in_t *in)
{
    drive->slow_count--;
    if (drive->slow_count == 0U) {
        drive->slow_count = drive->cfg->slow_ticks;
        supervise(drive, in);
    }
}

/* The end of the slow period; a short one has no tick for each part of its work. */
static void end_slow_period(drive_t *drive, const drive_in_t *in)
{
    drive->slow_count = drive->cfg->slow_ticks;
    if (drive->slow_count < SLOW_PARTS) {
        supervise(drive, in);
        supervise_phases(drive);
        limit_torque(drive);
    }
}

/* What the slow period does before the motion loops: parts 4 to 2 of five. */
static void watch_slowly(drive_t *drive, const drive_in_t *in, uint32_t part)
{
    if (drive->cfg->slow_ticks < SLOW_PARTS) {
        /* all at the end */
    } else if (part == 4U) {
        supervise_phases(drive);
    } else if (part == 3U) {
        supervise(drive, in);
    } else {
        limit_torque(drive);
    }
}

/*
 * The slow period ends with both parts of the supervision, the limits, planning and the speed PI, in a tick
 * each, so that the longest tick is shorter.
 */
static void control_motion(drive_t *drive, const drive_in_t *in)
{
    const uint32_t left = drive->slow_count - 1U;

    drive->slow_count = left;
    if (left >= SLOW_PARTS) {
        /* not yet */
    } else if (left == 0U) {
        demand_torque(drive);
        end_slow_period(drive, in);
    } else if (left == 1U) {
        plan_speed(drive, &in->command);
    } else {
        watch_slowly(drive, in, left);
    }
}

/* Currents to compare values. The vector is turned for the middle of the period in which it acts. */
static compare_t control_currents(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;
    const drive_cfg_t *const cfg = drive->cfg;
    const step_t step = drive->observer.speed_out;
    const dq_t reference = {.d = 0, .q = s->current_ref_q};
    const angle_t middle =
        rotor_position_angle(&drive->position) + (angle_t)step + (angle_t)fx_asr(step, 1U);

    s->voltage_limit = modulator_limit(&cfg->modulator, s->bus);
    s->voltage = current_loop_step(&drive->current_loop, &cfg->current_loop, reference, s->current,
                                   s->speed, s->voltage_limit);
    drive->ratio_acting.d = drive->ratio.d;
    drive->ratio_acting.q = drive->ratio.q;
    drive->ratio = modulator_ratio(&drive->modulator, s->voltage);
    s->ratio_ab = transforms_park_inverse(drive->ratio, trig_sincos(middle));
    return modulator_compare(&cfg->modulator, s->ratio_ab);
}

static void run_tick(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    estimate(drive);
    control_motion(drive, in);
    out->compare = control_currents(drive);
    out->gate_enable = true;
    rotor_position_step(&drive->position, drive->observer.speed_out);
}

const char *drive_init(drive_t *drive, const drive_cfg_t *cfg)
{
    const char *bad;

    *drive = (drive_t){.cfg = cfg};
    drive->slow_count = cfg->slow_ticks;
    enter(drive, DRIVE_STATE_INIT);
    modulator_reset(&drive->modulator);
    derating_reset(&drive->derating, &cfg->derating);
    config_guard_reset(&drive->guard);
    bad = params_check(cfg);
    if ((bad == NULL) && (config_guard_crc(cfg) != cfg->crc)) {
        bad = "crc";
    }
    return bad;
}

void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    convert_samples(drive, in);
    if (drive->state != DRIVE_STATE_RUN) {
        change_state(drive, in);
    } else if (!wants_run(&in->command)) {
        enter(drive, DRIVE_STATE_READY);
    } else {
        /* stay */
    }
    watch(drive, in);
    modulator_track_bus(&drive->modulator, &drive->cfg->modulator, drive->signals.bus);
    if (drive->state == DRIVE_STATE_RUN) {
        run_tick(drive, in, out);
    } else {
        idle_tick(drive, in);
    }
    if (drive->state != DRIVE_STATE_RUN) {
        open_gates(drive, out); /* the supervision may just have ended the run */
    }
    drive->bus_before = drive->signals.bus;
    drive->tick++;
}
