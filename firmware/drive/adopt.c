/* SPDX-License-Identifier: MIT */
/* drive_change() of drive.h. */
#include "config_change.h"
#include "drive.h"
#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "life.h"
#include "monitor.h"
#include "motor.h"
#include "open_loop.h"
#include "run.h"
#include "schedule.h"
#include "state_guard.h"

#include <stddef.h>

/*
 * Takes over the configuration in each part of the state that holds copies, corrections or limits
 * of it.
 */
static void adopt_parts(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_cfg_t *const before = drive->cfg;
    const int32_t flux_q27 = drive->motor.model.observer.flux_q27;
    const int32_t saliency_q13 = drive->motor.model.observer.saliency_q13;

    drive->cfg = cfg;
    motor_change(&drive->motor, cfg);
    estimate_change(&drive->rotor, &drive->motor.model.observer, flux_q27, saliency_q13);
    modulator_change(&drive->modulator, &before->modulator, &cfg->modulator);
    derating_change(&drive->derating, &before->derating, &cfg->derating);
    state_guard_keep_heat(&drive->state_guard, &drive->derating);
    state_guard_keep_config(&drive->state_guard, cfg);
    state_guard_forget(&drive->state_guard);
    open_loop_change(&drive->start, drive);
    run_change(&drive->motion, drive, before);
    life_set_limits(drive);
    monitor_forget_flux(&drive->watch);
    config_guard_reset(&drive->guard);
}

/*
 * Takes over the configuration without a jump of the voltage: the integrals take up the difference
 * between the old model's voltage and the new one's.
 */
static void adopt_controlled(drive_t *drive, const drive_cfg_t *cfg)
{
    dq_t before;
    dq_t now;

    frame_plan(&drive->control, drive);
    before = frame_model_voltage(&drive->control);
    adopt_parts(drive, cfg);
    frame_plan(&drive->control, drive);
    now = frame_model_voltage(&drive->control);
    frame_take_over(&drive->control, (dq_t){before.d - now.d, before.q - now.q});
}

static void adopt(drive_t *drive, const drive_cfg_t *cfg)
{
    if ((drive->state == DRIVE_STATE_RUN) && drive->voltage_drive.active) {
        /*
         * End the voltage drive, because nothing limits its current. When its conditions hold
         * again, the drive changes back to it.
         */
        adopt_parts(drive, cfg);
        schedule_end_voltage_drive(drive);
    } else if ((drive->state == DRIVE_STATE_RUN) || drive_is_imposed(drive->state)) {
        adopt_controlled(drive, cfg);
    } else {
        adopt_parts(drive, cfg);
    }
}

/* A change is rare. Inlined into the tick, its code would take registers from a RUN tick. */
NEVER_INLINED void drive_change(drive_t *drive, const drive_cfg_t *cfg)
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
