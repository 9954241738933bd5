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
        torque_filter_start(&drive->torque_filter, drive->current_ref.q);
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

/*
 * The voltage that the old model gave and the new one does not, or the other way round, goes to the
 * integrals.
 */
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
 * All that it calls is a copy of its own. If the tick shared it, the compiler would not make it a
 * part of the tick: 7 instructions of a RUN tick on a Cortex-M4, 20 of one at rest.
 */
INLINES_ALL NEVER_INLINED void drive_change(drive_t *drive, const drive_cfg_t *cfg)
{
    if (cfg->crc == drive->cfg->crc) {
        /* The same in another place: who follows the drive by its inputs sees no change. */
        drive->cfg = cfg;
    } else if (config_change_refused(drive->cfg, cfg) == NULL) {
        adopt(drive, cfg);
    } else {
        life_restart(drive, cfg);
    }
}
