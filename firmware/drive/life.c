/* SPDX-License-Identifier: MIT */
#include "life.h"

#include "calibration.h"
#include "config_check.h"
#include "drive.h"
#include "entry.h"
#include "inlining.h"
#include "monitor.h"
#include "motor.h"
#include "run.h"
#include "state_guard.h"
#include "transitions.h"

#include <stddef.h>

/*
 * Returns an upper bound on the rotor's speed when driving stops; next: the state that follows. The
 * speed estimate may be wrong, because its failure may be the reason for the stop. So the bound is
 * the larger one of the estimate and the speed reference. Torque control has no ramp, so at a fault
 * the rotor may be as fast as the window of speeds allows. In PROBE only the vector's speed is
 * known. A flying start ends as it began, with open gates.
 */
static step_t fastest_known(const drive_t *drive, drive_state_t next)
{
    const torque_loop_cfg_t *const window = &drive->cfg->torque_loop;
    step_t speed = 0;

    if ((drive->state == DRIVE_STATE_RUN) && (next == DRIVE_STATE_FAULT) &&
        (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE)) {
        speed = fx_max(window->speed_forward, window->speed_backward);
    } else if (drive->state == DRIVE_STATE_PROBE) {
        speed = fx_abs(drive->vector.step);
    } else if (drive->state != DRIVE_STATE_FLYING_START) {
        speed =
            fx_max(fx_abs(drive->rotor.observer.speed), fx_abs(drive->motion.speed_loop.reference));
    } else {
        /* nothing is known yet */
    }
    return speed;
}

/*
 * Stops driving in this tick: opens the gates, or shorts the motor if the rotor is too fast for
 * open gates.
 */
RARE static void leave(safe_state_t *safe_state, const drive_t *drive, drive_state_t next)
{
    safe_state_leave(safe_state, &drive->cfg->safe_state, fastest_known(drive, next));
}

void life_set_limits(drive_t *drive)
{
    drive->limits = protection_limits(&drive->cfg->protection, drive_is_driving(drive->state));
}

/* Sets the state. The protection limits of the new state apply from now on. */
static void set_state(drive_t *drive, drive_state_t state)
{
    drive->state = state;
    life_set_limits(drive);
}

/* Changes the state. entry.c sets what the new state begins with. */
static void change_state(drive_t *drive, drive_state_t state)
{
    if (drive_is_driving(drive->state) && !drive_is_driving(state)) {
        leave(&drive->safe_state, drive, state);
    }
    if (drive->state != state) {
        state_guard_forget(&drive->state_guard);
    }
    set_state(drive, state);
}

void life_follow(drive_t *drive, drive_event_t event, const instant_t *now)
{
    const drive_state_t from = drive->state;

    change_state(drive, transitions_next(from, event));
    if (drive->state != from) {
        entry_begin(drive, from, now);
    }
}

void life_fail(drive_t *drive, const fault_t *fault, const instant_t *now)
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
            .phase_a = now->sample.phase_a,
            .phase_b = now->sample.phase_b,
            .motoring = drive->derating.motoring,
        };
        change_state(drive, transitions_next(drive->state, DRIVE_EVENT_FAULT)); /* nothing begins */
    }
}

RARE void life_react(drive_t *drive, drive_event_t event, const fault_t *fault,
                     const instant_t *now)
{
    if (event == DRIVE_EVENT_FAULT) {
        life_fail(drive, fault, now);
    } else {
        life_follow(drive, event, now);
    }
}

/*
 * Goes to INIT with this configuration. Nothing is known of the motor. Until the calibration the
 * zeros of the current sensors are nominal.
 */
static void initialise(drive_t *drive, const drive_cfg_t *cfg)
{
    *drive = (drive_t){
        .cfg = cfg,
        .sensors = {.offset_a = CALIBRATION_NOMINAL_Q15, .offset_b = CALIBRATION_NOMINAL_Q15},
        .slow_count = (uint8_t)cfg->slow_ticks,
    };
    motor_reset(&drive->motor, cfg);
    run_forget_inertia(&drive->motion);
    probe_reset(&drive->probe);
    monitor_forget_flux(&drive->watch);
    set_state(drive, DRIVE_STATE_INIT);
    modulator_reset(&drive->modulator, &cfg->modulator);
    derating_reset(&drive->derating, &cfg->derating);
    config_guard_reset(&drive->guard);
    state_guard_keep_measured(&drive->state_guard, drive);
    state_guard_keep_config(&drive->state_guard, cfg);
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
    derating_warm(&drive->derating, heat_q24);
    state_guard_keep_heat(&drive->state_guard, &drive->derating);
}

void life_restart(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_state_t state = drive->state;
    const fault_t fault = drive->fault;
    const fault_scene_t scene = drive->scene;
    const uint32_t tick = drive->tick;
    const uint32_t left = drive->slow_count;
    const sensors_t sensors = drive->sensors;
    derating_t heat = {.heat_q24 = drive->derating.heat_q24};
    safe_state_t safe_state;

    derating_change(&heat, &drive->cfg->derating, &cfg->derating);
    if (drive_is_driving(state)) {
        leave(&drive->safe_state, drive, DRIVE_STATE_INIT);
    }
    safe_state = drive->safe_state;
    initialise(drive, cfg);
    drive->safe_state = safe_state;
    calibration_keep(&drive->sensors, &sensors);
    state_guard_keep_measured(&drive->state_guard, drive);
    drive->fault = fault;
    drive->scene = scene;
    drive->tick = tick;
    drive->slow_count = (uint8_t)((left < cfg->slow_ticks) ? left : cfg->slow_ticks);
    drive_warm(drive, heat.heat_q24);
    if (state == DRIVE_STATE_FAULT) {
        set_state(drive, DRIVE_STATE_FAULT);
    }
}
