/* SPDX-License-Identifier: MIT */
#include "life.h"

#include "calibration.h"
#include "config_check.h"
#include "drive.h"
#include "frame.h"
#include "inlining.h"
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
RARE static void leave(drive_t *drive, drive_state_t next)
{
    safe_state_leave(&drive->safe_state, &drive->cfg->safe_state, fastest_known(drive, next));
}

/*
 * RUN begins with a plan of its current control and with the torque that acts. So no slope from an
 * earlier change of the mode is left.
 */
static void begin_run(drive_t *drive)
{
    drive->motion.torque_loop.bridging = false;
    if (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) {
        torque_loop_start(&drive->motion.torque_loop, drive_flux(drive),
                          drive->control.current_ref.q);
    }
    torque_filter_start(&drive->motion.torque_filter, drive->control.current_ref.q);
    frame_plan_rotor(drive);
}

/* Sets the state. The protection limits of the new state apply from now on. */
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

void life_follow(drive_t *drive, drive_event_t event)
{
    enter(drive, transitions_next(drive->state, event));
}

void life_fail(drive_t *drive, const fault_t *fault, const sample_t *sample)
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
            .phase_a = sample->phase_a,
            .phase_b = sample->phase_b,
            .motoring = drive->derating.motoring,
        };
        life_follow(drive, DRIVE_EVENT_FAULT);
    }
}

RARE void life_react(drive_t *drive, drive_event_t event, const fault_t *fault,
                     const sample_t *sample)
{
    if (event == DRIVE_EVENT_FAULT) {
        life_fail(drive, fault, sample);
    } else {
        life_follow(drive, event);
    }
}

/*
 * Goes to INIT with this configuration. Nothing is known of the motor. Until the calibration the
 * zeros of the current sensors are nominal.
 */
static void initialise(drive_t *drive, const drive_cfg_t *cfg)
{
    model_nominal_t nominal;

    *drive = (drive_t){
        .cfg = cfg,
        .sensors = {.offset_a = CALIBRATION_NOMINAL_Q15, .offset_b = CALIBRATION_NOMINAL_Q15}};
    nominal = drive_nominal(drive);
    model_reset(&drive->motor.model, &nominal);
    speed_loop_init(&drive->motion.speed_loop);
    probe_reset(&drive->probe);
    supervision_forget_flux(&drive->watch.supervision);
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

void life_restart(drive_t *drive, const drive_cfg_t *cfg)
{
    const drive_state_t state = drive->state;
    const fault_t fault = drive->fault;
    const fault_scene_t scene = drive->scene;
    const uint32_t tick = drive->tick;
    const uint32_t left = drive->slow_count;
    derating_t heat = {.heat_q24 = drive->derating.heat_q24};
    const int32_t offset_a = drive->sensors.offset_a;
    const int32_t offset_b = drive->sensors.offset_b;
    safe_state_t safe_state;

    derating_change(&heat, &drive->cfg->derating, &cfg->derating);
    if (drive_is_driving(state)) {
        leave(drive, DRIVE_STATE_INIT);
    }
    safe_state = drive->safe_state;
    initialise(drive, cfg);
    drive->safe_state = safe_state;
    drive->sensors.offset_a = offset_a;
    drive->sensors.offset_b = offset_b;
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
