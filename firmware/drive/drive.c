/* SPDX-License-Identifier: MIT */
#include "drive.h"

#include "angle_sensor.h"
#include "config_check.h"
#include "drive_state.h"
#include "low_speed.h"
#include "monitor.h"
#include "vector_control.h"

#include <stddef.h>

#define ADC_MID_Q15 (16384)         /* I_b is twice the converter's full scale */
#define OFFSET_END (32768)          /* no sensor's zero is further away */
#define OFFSET_SUM_MAX (0x10000000) /* of 2^12 counts */

static void open_gates(drive_t *drive, drive_out_t *out)
{
    const uint32_t half = (uint32_t)drive->cfg->modulator.timer_counts / 2U;
    const uint16_t rest = (uint16_t)half;

    *out = (drive_out_t){.compare = {.phase = {rest, rest, rest}}, .gate_enable = false};
}

void drive_enter(drive_t *drive, drive_state_t state)
{
    drive->state = state;
    drive->limits = protection_limits(&drive->cfg->protection, drive_is_driving(state));
}

void drive_fail(drive_t *drive, fault_t fault)
{
    drive->fault = fault;
    drive->fault.tick = drive->tick;
    drive_enter(drive, DRIVE_STATE_FAULT);
}

static void enter_offset_cal(drive_t *drive)
{
    drive->offset_a = 0;
    drive->offset_b = 0;
    drive->offset_samples = 0U;
    drive_enter(drive, DRIVE_STATE_OFFSET_CAL);
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

/* An over-current at an end of the converter range is not a measured value: name the converter instead. */
static fault_id_t name_of(const drive_t *drive, const drive_in_t *in, fault_id_t id)
{
    const uint32_t shift = drive->cfg->sampling.current_shift;
    const bool saturated =
        protection_saturated(in->adc_ia, shift) || protection_saturated(in->adc_ib, shift);

    return ((id == FAULT_OVERCURRENT) && saturated) ? FAULT_ADC_SATURATED : id;
}

/* After a late tick no voltage acts in place of its demand. */
static void count_late(drive_t *drive)
{
    fault_t fault = {.id = FAULT_NONE};
    const fault_id_t id =
        supervision_count_late(&drive->supervision, &drive->cfg->supervision, &fault);

    drive->signals.ratio_ab = (ab_t){0, 0};
    if ((id != FAULT_NONE) && drive_is_driving(drive->state)) {
        drive_fail(drive, fault);
    }
}

/* Check the samples and latch the fault. */
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
        drive_fail(drive, protection_record(&drive->limits, &measured, name_of(drive, in, id)));
    }
}

/* Mean of 2^offset_log2 raw samples in Q15 of I_b. */
static int32_t mean_sample(const sampling_cfg_t *cfg, int32_t sum)
{
    const uint64_t scaled = (uint64_t)sum << cfg->current_shift;
    const uint64_t mean = scaled >> cfg->offset_log2;

    return (mean < (uint64_t)OFFSET_END) ? (int32_t)mean : OFFSET_END;
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
        drive_enter(drive, DRIVE_STATE_READY);
    } else {
        drive_fail(drive, fault);
    }
}

static void calibrate_step(drive_t *drive, const drive_in_t *in)
{
    drive->offset_a = fx_min(drive->offset_a + (int32_t)in->adc_ia, OFFSET_SUM_MAX);
    drive->offset_b = fx_min(drive->offset_b + (int32_t)in->adc_ib, OFFSET_SUM_MAX);
    drive->offset_samples++;
    if (drive->offset_samples == (1UL << drive->cfg->sampling.offset_log2)) {
        finish_calibration(drive);
    }
}

static bool wants_run(const drive_command_t *command)
{
    return (command->request & DRIVE_REQUEST_RUN) != 0U;
}

static bool has_sensor(const drive_t *drive)
{
    return drive->cfg->sampling.sensor_pole_pairs != 0U;
}

static void leave_ready(drive_t *drive)
{
    drive->attempts = 0U;
    supervision_reset(&drive->supervision);
    if (has_sensor(drive)) {
        angle_sensor_start(drive);
        drive_enter(drive, DRIVE_STATE_RUN);
    } else if (drive->cfg->startup.current_hold == 0) {
        vector_control_reset(drive);
        drive_enter(drive, DRIVE_STATE_RUN);
    } else {
        low_speed_start(drive);
    }
}

/* Changes of state without current: by the command, or at the end of the calibration. */
static void change_state(drive_t *drive, const drive_in_t *in)
{
    const bool run = wants_run(&in->command);
    const bool clear = (in->command.request & DRIVE_REQUEST_CLEAR) != 0U;

    switch (drive->state) {
    case DRIVE_STATE_READY:
        if (run) {
            leave_ready(drive);
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

/* Slow ticks to the end of the slow period after this one; 0 in its last. */
static uint32_t count_slow(drive_t *drive)
{
    const uint32_t left = drive->slow_count - 1U;

    drive->slow_count = (left == 0U) ? drive->cfg->slow_ticks : left;
    return left;
}

const char *drive_init(drive_t *drive, const drive_cfg_t *cfg)
{
    model_nominal_t nominal;
    const char *bad;

    *drive = (drive_t){.cfg = cfg};
    nominal = drive_nominal(drive);
    model_reset(&drive->model, &nominal);
    drive->slow_count = cfg->slow_ticks;
    drive_enter(drive, DRIVE_STATE_INIT);
    modulator_reset(&drive->modulator);
    derating_reset(&drive->derating, &cfg->derating);
    config_guard_reset(&drive->guard);
    bad = config_check(cfg);
    if ((bad == NULL) && (config_guard_crc(cfg) != cfg->crc)) {
        bad = "crc";
    }
    return bad;
}

/* The part of the slow period that belongs to this tick, in a state that controls a current. */
static void slow_step(drive_t *drive, const drive_in_t *in, uint32_t left)
{
    monitor_step(drive, in, left);
    if (drive->state == DRIVE_STATE_RUN) {
        vector_control_motion(drive, &in->command, left);
    } else if (drive_is_controlled(drive->state)) {
        low_speed_motion(drive, &in->command, left);
    } else {
        /* nothing moves */
    }
}

/* A tick that controls a current. When the state changes to one that does not, the gates open. */
static void control_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    const bool track = (drive->state == DRIVE_STATE_RUN) || low_speed_tracks(drive);

    vector_control_estimate(drive, track);
    if (drive->state != DRIVE_STATE_RUN) {
        low_speed_step(drive);
    }
    if (left < (uint32_t)SLOW_PARTS) {
        slow_step(drive, in, left);
    }
    if (drive_is_controlled(drive->state)) {
        vector_control_close(drive, track, out);
    } else {
        open_gates(drive, out);
    }
}

/* A tick without current control: idle, or flying start. */
static void idle_tick(drive_t *drive, const drive_in_t *in, uint32_t left, drive_out_t *out)
{
    open_gates(drive, out);
    if (drive->state == DRIVE_STATE_CATCH_SPIN) {
        low_speed_catch(drive, in, out);
    }
    if (left < (uint32_t)SLOW_PARTS) {
        monitor_step(drive, in, left);
    }
    out->gate_enable = out->gate_enable && drive_is_driving(drive->state);
}

void drive_step(drive_t *drive, const drive_in_t *in, drive_out_t *out)
{
    const uint32_t left = count_slow(drive);
    const bool controlled = drive_is_controlled(drive->state);

    convert_samples(drive, in);
    if (has_sensor(drive)) {
        angle_sensor_track(drive, in->angle);
    }
    if (!drive_is_driving(drive->state)) {
        change_state(drive, in);
    } else if (!wants_run(&in->command)) {
        drive_enter(drive, DRIVE_STATE_READY);
    } else {
        /* stay */
    }
    /* Check this before the currents: a fault of the currents that late ticks cause is to be reported as LATE. */
    if ((in->flags & DRIVE_FLAG_LATE) != 0U) {
        count_late(drive);
    }
    watch(drive, in);
    modulator_track_bus(&drive->modulator, &drive->cfg->modulator, drive->signals.bus);
    if (controlled && drive_is_controlled(drive->state)) {
        control_tick(drive, in, left, out);
    } else {
        idle_tick(drive, in, left, out);
    }
    drive->bus_before = drive->signals.bus;
    drive->tick++;
}
