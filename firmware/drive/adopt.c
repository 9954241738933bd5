/* SPDX-License-Identifier: MIT */
/* drive_change() of drive.h. */
#include "config_change.h"
#include "drive.h"
#include "frame.h"
#include "inlining.h"
#include "life.h"
#include "run.h"
#include "state_guard.h"
#include "trig.h"
#include "voltage_drive.h"

#include <stddef.h>

/* Returns θ̂ at the instant of the last prediction. Since then θ̂ has advanced by one tick. */
static sincos_t angle_before(const drive_t *drive)
{
    const angle_t rotor = rotor_position_angle(&drive->rotor.position);

    return trig_sincos(rotor - fx_unsigned(drive->rotor.observer.speed_out));
}

static bool is_other_filter(const torque_filter_cfg_t *one, const torque_filter_cfg_t *other)
{
    return (one->smooth_rate_q15 != other->smooth_rate_q15) ||
           (one->notch_share_q15 != other->notch_share_q15) ||
           (one->notch_turn.sin != other->notch_turn.sin) ||
           (one->notch_turn.cos != other->notch_turn.cos);
}

/*
 * Takes over the configuration in each part of the state that holds copies, corrections or limits
 * of it.
 */
static void adopt_parts(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_cfg_t *const before = drive->cfg;
    const int32_t flux_q27 = drive->motor.model.observer.flux_q27;
    const int32_t saliency_q13 = drive->motor.model.observer.saliency_q13;
    model_nominal_t nominal;

    drive->cfg = cfg;
    nominal = drive_nominal(drive);
    model_change(&drive->motor.model, &cfg->model, &nominal);
    nn_observer_change(&drive->rotor.observer, &drive->motor.model.observer, flux_q27, saliency_q13,
                       angle_before(drive));
    modulator_change(&drive->modulator, &before->modulator, &cfg->modulator);
    derating_change(&drive->derating, &before->derating, &cfg->derating);
    state_guard_keep_heat(drive);
    state_guard_keep_config(drive);
    state_guard_forget(drive);
    if (drive->start.lost_periods > cfg->startup.lost_periods) {
        drive->start.lost_periods = cfg->startup.lost_periods;
    }
    if (drive->start.attempts > cfg->startup.attempts) {
        drive->start.attempts = cfg->startup.attempts;
    }
    speed_loop_change(&drive->motion.speed_loop, &cfg->speed_loop);
    if (is_other_filter(&before->torque_filter, &cfg->torque_filter)) {
        torque_filter_start(&drive->motion.torque_filter, drive->control.current_ref.q);
    }
    if (run_torque_is_free(drive)) {
        torque_loop_bridge(&drive->motion.torque_loop); /* the window of speeds may have new ends */
    }
    drive->limits = protection_limits(&cfg->protection, drive_is_driving(drive->state));
    supervision_forget_flux(&drive->watch.supervision);
    config_guard_reset(&drive->guard);
}

/*
 * If a measurement is under way, begins it again at the present vector: its pulses or times may
 * have changed.
 */
static void measure_again_with(drive_t *drive, const drive_cfg_t *cfg)
{
    align_t *const align = &drive->start.align;

    if (drive->state == DRIVE_STATE_FLYING_START) {
        flying_start_reset(&drive->start.flying_start);
    } else if ((drive->state == DRIVE_STATE_ALIGN) && (align->phase != ALIGN_PULL)) {
        align_reset_held(align, &cfg->startup.align, align->current_ref);
    } else {
        /* no measurement is under way */
    }
}

/*
 * Takes over the configuration without a jump of the voltage: the integrals take up the difference
 * between the old model's voltage and the new one's.
 */
static void adopt_controlled(drive_t *drive, const drive_cfg_t *cfg)
{
    const dq_t before = frame_model_voltage(drive);
    dq_t now;

    adopt_parts(drive, cfg);
    now = frame_model_voltage(drive);
    current_loop_take_over(&drive->control.current_loop,
                           (dq_t){before.d - now.d, before.q - now.q});
}

static void adopt(drive_t *drive, const drive_cfg_t *cfg)
{
    measure_again_with(drive, cfg);
    if ((drive->state == DRIVE_STATE_RUN) && drive->voltage_drive.active) {
        /*
         * End the voltage drive, because nothing limits its current. When its conditions hold
         * again, the drive changes back to it.
         */
        adopt_parts(drive, cfg);
        voltage_drive_end(drive);
    } else if ((drive->state == DRIVE_STATE_RUN) || drive_is_imposed(drive->state)) {
        adopt_controlled(drive, cfg);
    } else {
        adopt_parts(drive, cfg);
    }
}

/*
 * With INLINES_ALL this function has its own copy of each function that it calls. If it shared them
 * with the tick, the compiler would not inline them there. That would cost a RUN tick on a
 * Cortex-M4 7 instructions, and a tick at rest 20.
 */
INLINES_ALL NEVER_INLINED void drive_change(drive_t *drive, const drive_cfg_t *cfg)
{
    if (cfg->crc == drive->cfg->crc) {
        /*
         * it is the same configuration at another address, so a replay of the inputs sees no change
         */
        drive->cfg = cfg;
    } else if (config_change_refused(drive->cfg, cfg) == NULL) {
        adopt(drive, cfg);
    } else {
        life_restart(drive, cfg);
    }
}
