/* SPDX-License-Identifier: MIT */
#include "monitor.h"

#include "inlining.h"
#include "motor.h"
#include "state_guard.h"

#include "trig.h"

#define HALVES_OF_SWING (2U)
#define NEAR_SHIFT (4U) /* from 15/16 of its limit on the voltage counts as at the limit */

static fault_id_t check_phases(watch_t *watch, const drive_t *drive, const sample_t *sample,
                               fault_t *fault)
{
    const supervision_phases_t measured = {
        .a = sample->phase_a,
        .b = sample->phase_b,
        .turns_q16 = rotor_position_turns_q16(drive_frame_position(drive)),
        .speed = drive_speed(drive),
    };

    return supervision_check_phases(&watch->supervision, &drive->cfg->supervision, &measured,
                                    fault);
}

/* Returns the magnitude of the EMF at this speed, Q15 of U_b. */
static int32_t emf_at(const drive_t *drive, step_t speed)
{
    return motor_emf(&drive->motor, drive_speed_q15(drive, fx_abs(speed)));
}

/* The integrals of the current control are the voltage that the model does not explain. */
static fault_id_t check_imposed(watch_t *watch, const drive_t *drive, const sample_t *sample,
                                fault_t *fault)
{
    const sincos_t angle = trig_sincos(rotor_position_angle(&drive->vector.position));
    const supervision_imposed_t measured = {
        .a = sample->phase_a,
        .b = sample->phase_b,
        .expected = transforms_park_inverse(drive->control.current_ref, angle),
        .voltage = {.d = pi_output(&drive->control.current_loop.pi_d),
                    .q = pi_output(&drive->control.current_loop.pi_q)},
        .emf = emf_at(drive, drive->vector.step),
    };

    return supervision_check_imposed(&watch->supervision, &drive->cfg->supervision, &measured,
                                     fault);
}

/* Whether the rotor rests on the imposed current. */
static bool is_at_rest(const drive_t *drive)
{
    const bool aligned =
        (drive->state == DRIVE_STATE_ALIGN) && (drive->start.align.phase != ALIGN_PULL);

    return drive_is_held(drive) || aligned;
}

/*
 * Returns the current to compare with the reference. In RUN it is the measured current. An imposed
 * current is controlled softly, so a swinging rotor adds a current to it. An open wire takes away
 * half of the imposed current or all of it. So at rest the error counts half. Along the vector only
 * a current that is too small counts: an open wire never makes it larger, a swing may. While the
 * rotor is pulled in or turned, no error counts; then the check of the phases and the start-up find
 * the fault.
 */
static dq_t controlled_current(const drive_t *drive, const instant_t *now)
{
    dq_t current = drive->control.current_ref;

    if (drive->state == DRIVE_STATE_RUN) {
        current = now->along_rotor;
    } else if (is_at_rest(drive)) {
        current.d = fx_asr(current.d + fx_min(current.d, now->along_vector.d), 1U);
        current.q = fx_asr(current.q + now->along_vector.q, 1U);
    } else {
        /* the reference itself: no error */
    }
    return current;
}

/*
 * Whether the voltage is at its limit. It does not follow its demand then, so the integrals go to
 * their limits.
 */
static bool is_voltage_at_limit(const drive_t *drive, int32_t bus)
{
    const dq_t voltage = drive->control.voltage;
    const int32_t limit = modulator_limit(&drive->cfg->modulator, bus);
    const int32_t near = limit - fx_asr(limit, NEAR_SHIFT);

    return transforms_square(voltage) >= fx_unsigned(near * near);
}

/* Whether the motion oscillates. The oscillation check reports that. */
static bool is_swinging(const drive_t *drive)
{
    return (drive->cfg->oscillation.act != (uint32_t)OSCILLATION_ACT_NONE) &&
           (drive->watch.oscillation.halves >= HALVES_OF_SWING);
}

/* Fills in the values that explain or excuse a large voltage. */
RARE static void look_closer(const drive_t *drive, int32_t bus, supervision_voltage_t *measured)
{
    measured->emf = fx_max(emf_at(drive, drive->rotor.observer.speed),
                           emf_at(drive, drive->motion.speed_loop.reference));
    measured->off_reference =
        fx_abs(drive->rotor.observer.speed - drive->motion.speed_loop.reference);
    measured->excused = drive->voltage_drive.active || drive->motion.weakening.acts ||
                        is_swinging(drive) || is_voltage_at_limit(drive, bus);
}

static fault_id_t check_voltage(watch_t *watch, const drive_t *drive, int32_t bus, fault_t *fault)
{
    const supervision_cfg_t *const cfg = &drive->cfg->supervision;
    supervision_voltage_t measured = {
        .voltage = {.d = pi_output(&drive->control.current_loop.pi_d),
                    .q = pi_output(&drive->control.current_loop.pi_q)},
        .emf = 0,
        .off_reference = 0,
        .excused = false,
    };

    if (supervision_is_large(cfg, measured.voltage)) {
        look_closer(drive, bus, &measured);
    }
    return supervision_check_voltage(&watch->supervision, cfg, &measured, fault);
}

/*
 * Checks the flux only while model_track_flux() may correct it: flux correction is configured, and
 * the speed is at least flux_speed_min.
 */
static fault_id_t check_flux(watch_t *watch, const drive_t *drive, fault_t *fault)
{
    const model_cfg_t *const cfg = &drive->cfg->model;
    const bool corrected =
        (cfg->flux_limit_q14 > 0) && (fx_abs(drive->rotor.observer.speed) >= cfg->flux_speed_min);

    fault_id_t id = FAULT_NONE;

    if (corrected) {
        id = supervision_check_flux(&watch->supervision, &drive->cfg->supervision,
                                    drive->motor.model.flux_q30,
                                    emf_at(drive, drive->rotor.observer.speed), fault);
    }
    return id;
}

/*
 * Whether the residual shows a wrong angle. Hall sensors are half a sector off until two edges have
 * told the speed, so at low speed nothing follows from it.
 */
static bool shows_angle(const drive_t *drive)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const step_t low = fx_max(2 * cfg->observer.rho_speed_min, cfg->startup.handover_speed);
    const bool coarse = drive_is_sensed(drive) &&
                        (cfg->sensor.kind == (uint32_t)SENSOR_KIND_HALL) &&
                        (fx_abs(drive->rotor.observer.speed) < low);

    return (drive->state == DRIVE_STATE_RUN) && !coarse;
}

static fault_id_t check_current(watch_t *watch, const drive_t *drive, const instant_t *now,
                                fault_t *fault)
{
    const supervision_cfg_t *const cfg = &drive->cfg->supervision;
    const bool running = drive->state == DRIVE_STATE_RUN;
    const supervision_current_t measured = {
        .current = controlled_current(drive, now),
        .reference = drive_current_in_force(drive),
        .excused = running && (fx_abs(drive->rotor.observer.speed) >= cfg->stall_speed),
    };
    /*
     * The error along d is mostly an error of the flux, which the model corrects. Below RUN the
     * start-up checks the observer.
     */
    const dq_t residual = {.d = 0, .q = shows_angle(drive) ? drive->rotor.observer.error.q : 0};
    fault_id_t id = supervision_check_current(&watch->supervision, cfg, &measured, fault);

    if (id == FAULT_NONE) {
        id = supervision_check_observer(&watch->supervision, cfg, residual, fault);
    }
    if ((id == FAULT_NONE) && running) {
        id = check_voltage(watch, drive, now->sample.bus, fault);
    }
    return id;
}

/*
 * Whether the torque is at a limit because the speed loop needs it. A commanded torque does not
 * count, because a rotor may stand still with it.
 */
static bool is_at_limit(const drive_t *drive, int32_t torque)
{
    const bool asked =
        drive_torque_is_free(drive) && (drive->motion.torque_loop.end == (uint8_t)SPEED_END_NONE);
    const torque_range_t range = drive->motion.torque_range;

    return !asked && ((torque >= range.upper) || (torque <= range.lower));
}

static fault_id_t check_speed(watch_t *watch, const drive_t *drive, fault_t *fault)
{
    const supervision_cfg_t *const cfg = &drive->cfg->supervision;
    const int32_t torque = drive_current_in_force(drive).q;
    const supervision_speed_t measured = {
        .speed = drive->rotor.observer.speed,
        .reference = drive->motion.speed_loop.reference,
        .speed_limit = drive->motor.model.observer.speed_limit,
        .current_ref = torque,
        .torque_at_limit = is_at_limit(drive, torque),
    };

    return supervision_check_speed(&watch->supervision, cfg, &measured, fault);
}

/*
 * Returns the motion that the user asks for. In position control it is the speed of the profile,
 * because the speed reference also follows the measured position. In torque control it is the
 * torque reference, because the speed reference is the measured speed.
 */
static int32_t motion_asked(const drive_t *drive)
{
    int32_t asked = drive->motion.speed_loop.reference;

    if (drive->motion.mode == (uint8_t)DRIVE_MODE_POSITION) {
        asked = drive->motion.position_loop.profile_speed;
    } else if (drive_torque_is_free(drive)) {
        asked = drive->motion.torque_loop.reference_q28;
    } else {
        /* a speed */
    }
    return asked;
}

fault_id_t monitor_swing(watch_t *watch, const drive_t *drive, fault_t *fault)
{
    const oscillation_in_t measured = {
        .motion = motion_asked(drive),
        .current = drive_current_in_force(drive).q,
    };

    return oscillation_step(&watch->oscillation, &drive->cfg->oscillation, &measured, fault);
}

bool monitor_may_lower(const drive_t *drive)
{
    return (drive->cfg->oscillation.act == (uint32_t)OSCILLATION_ACT_LOWER) &&
           (drive->motion.speed_loop.halvings == 0U) && !drive->voltage_drive.active;
}

bool monitor_is_saturated(const drive_t *drive, const drive_in_t *in)
{
    const uint32_t shift = drive->cfg->sampling.current_shift;

    return protection_saturated(in->adc_ia, shift) || protection_saturated(in->adc_ib, shift);
}

/*
 * Returns the current that heats the winding while the drive controls no current: the current of a
 * shorted motor, or the current that a fast rotor drives through the diodes. If the converter is
 * saturated, a shorted motor counts as having the largest current. With open gates a saturated
 * converter means that the sensor is wrong, so the current counts as 0.
 */
RARE static dq_t uncontrolled_current(const drive_t *drive, const drive_in_t *in,
                                      const sample_t *sample)
{
    const ab_t measured = transforms_clarke(sample->phase_a, sample->phase_b);
    dq_t current = {0, 0};

    if (!monitor_is_saturated(drive, in)) {
        current = (dq_t){measured.alpha, measured.beta};
    } else if (safe_state_is_short(&drive->safe_state)) {
        current = (dq_t){FX_Q15_MAX, FX_Q15_MAX};
    } else {
        /* the sensor is wrong: assume no current */
    }
    return current;
}

/*
 * If the heat and its copy differ, a bit has flipped in one of them. The larger one is used, so
 * that the winding never counts as colder than it is.
 */
static fault_id_t check_heat(derating_t *derating, state_guard_t *guard, const drive_t *drive,
                             dq_t current, uint16_t adc_temperature, fault_t *fault)
{
    fault_id_t id = state_guard_check_heat(drive, fault);

    if (id == FAULT_NONE) {
        id = derating_step(derating, &drive->cfg->derating, current, adc_temperature, fault);
    } else {
        const int32_t hotter = fx_max(derating->heat_q24, guard->heat_q24);

        derating_warm(derating, fx_clamp(hotter, 0, DERATING_HEAT_MAX_Q24));
    }
    state_guard_keep_heat(guard, derating);
    return id;
}

/* Checks the configuration and the state for flipped bits; also counts the window of late ticks. */
static fault_id_t check_memory(drive_t *drive, fault_t *fault)
{
    fault_id_t id;

    supervision_forget_late(&drive->watch.supervision, &drive->cfg->supervision);
    id = config_guard_step(&drive->guard, drive->cfg, fault);
    if (id == FAULT_NONE) {
        id = state_guard_step(&drive->state_guard, &drive->motor, drive, fault);
    }
    return id;
}

fault_id_t monitor_next_check(drive_t *drive, const drive_in_t *in, const instant_t *now,
                              fault_t *fault)
{
    const uint32_t step = drive->watch.supervision.step;
    const bool controlled = drive_is_controlled(drive->state);
    const dq_t current =
        controlled ? now->along_rotor : uncontrolled_current(drive, in, &now->sample);
    fault_id_t id = FAULT_NONE;

    drive->watch.supervision.step = (step + 1U) % SUPERVISION_STEPS;
    if (step == 0U) {
        id = check_heat(&drive->derating, &drive->state_guard, drive, current, in->adc_temperature,
                        fault);
    } else if (step == 1U) {
        id = check_memory(drive, fault);
    } else if ((step == 2U) && controlled) {
        id = check_current(&drive->watch, drive, now, fault);
    } else if ((step > 2U) && (drive->state == DRIVE_STATE_RUN)) {
        id = check_speed(&drive->watch, drive, fault);
        if (id == FAULT_NONE) {
            id = check_flux(&drive->watch, drive, fault);
        }
    } else {
        /* this check does not apply in this state */
    }
    return id;
}

fault_id_t monitor_phases(watch_t *watch, const drive_t *drive, const sample_t *sample,
                          fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    if (drive_is_controlled(drive->state)) {
        id = check_phases(watch, drive, sample, fault);
    }
    if ((id == FAULT_NONE) && drive_is_imposed(drive->state)) {
        id = check_imposed(watch, drive, sample, fault);
    }
    return id;
}

torque_range_t monitor_derate(derating_t *derating, const drive_t *drive, int32_t bus)
{
    const derating_motion_t motion = {
        .bus = bus,
        .speed = drive_speed(drive),
        .voltage = drive_is_controlled(drive->state) ? drive->control.voltage : (dq_t){0, 0},
        .current_d = drive->control.current_ref.d,
    };

    return derating_range(derating, &drive->cfg->derating, &motion);
}

fault_id_t monitor_late(watch_t *watch, const drive_t *drive, fault_t *fault)
{
    return supervision_count_late(&watch->supervision, &drive->cfg->supervision, fault);
}

void monitor_reset(watch_t *watch)
{
    supervision_reset(&watch->supervision);
    oscillation_reset(&watch->oscillation);
}

void monitor_forget_imposed(watch_t *watch)
{
    supervision_forget_imposed(&watch->supervision);
}

void monitor_forget_flux(watch_t *watch)
{
    supervision_forget_flux(&watch->supervision);
}
