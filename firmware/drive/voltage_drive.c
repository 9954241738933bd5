/* SPDX-License-Identifier: MIT */
#include "voltage_drive.h"

#include "trig.h"

#define QUARTER_TURN_STEP (0x40000000)
/* For the change to the voltage drive the speed error is at most 1/32 of the commanded speed. */
#define SPEED_SHIFT (5U)
/*
 * The voltage drive ends at 7/8 of brake_max, before the limit, because the angle of a small
 * voltage is rough.
 */
#define END_SHIFT (3U)
/* hysteresis of the limits between begin and end of the voltage drive: 1/4 of a limit */
#define HYSTERESIS_SHIFT (2U)

/* Returns the EMF at this speed, ω·φ, Q15 of U_b. */
static int32_t emf(const drive_t *drive, step_t speed)
{
    return fx_sat16(fx_asr(drive_speed_q15(drive, speed) * drive->motor.model.run_loop.emf_q13,
                           CURRENT_LOOP_GAIN_BITS));
}

/* Returns the speed error, reference − ω̂, Q15 of 2·Ω_b. */
static int32_t half_error(const drive_t *drive, step_t reference)
{
    return fx_sat16(
        fx_asr(reference - drive->rotor.observer.speed, drive->cfg->speed_loop.error_shift));
}

void voltage_drive_reset(voltage_drive_t *vd)
{
    *vd = (voltage_drive_t){.active = false};
}

dq_t voltage_drive_step(voltage_drive_t *vd, const drive_t *drive, dq_t current, int32_t bus)
{
    const dq_t damping = /* Q30 */
        virtual_resistance_step(&vd->damping, &drive->cfg->voltage_drive.damping, current);
    const int32_t limit = modulator_limit(&drive->cfg->modulator, bus);
    const int32_t room = fx_usat15(limit - fx_asr(fx_abs(damping.d) + fx_abs(damping.q), 15U));
    const int32_t magnitude = fx_clamp(vd->magnitude, -room, room);
    const int32_t lead =
        phase_compensator_step(&vd->compensator, &drive->cfg->voltage_drive.compensator, current,
                               rotor_position_angle(&drive->rotor.position),
                               drive->rotor.observer.speed_out, vd->magnitude >= 0);
    const sincos_t angle = trig_sincos(fx_unsigned(lead));

    return (dq_t){
        .d = fx_sat16(fx_asr(damping.d - (magnitude * angle.sin), 15U)),
        .q = fx_sat16(fx_asr(damping.q + (magnitude * angle.cos), 15U)),
    };
}

void voltage_drive_set_magnitude(voltage_drive_t *vd, const drive_t *drive, int32_t bus)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const step_t reference = drive->motion.speed_loop.reference;

    vd->magnitude = pi_step(&vd->pi, &cfg->voltage_drive.pi, half_error(drive, reference),
                            emf(drive, reference), modulator_limit(&cfg->modulator, bus));
}

/*
 * Returns the lead of this voltage in the direction in which it turns the rotor, 2^32 = one turn,
 * ±1/4 turn.
 */
static int32_t present_lead(dq_t voltage)
{
    const int32_t along = fx_abs(voltage.q);

    const angle_t lead = trig_atan2((int16_t)fx_sat16(-voltage.d), (int16_t)fx_sat16(along));

    return fx_clamp(fx_signed(lead), -QUARTER_TURN_STEP, QUARTER_TURN_STEP);
}

/*
 * Whether the voltage drive is enabled, the command is a speed, and both commanded and estimated
 * speed are at least speed_min.
 */
static bool is_wanted(const drive_t *drive, const drive_command_t *command, step_t speed_min)
{
    const bool asked =
        (drive->cfg->voltage_drive.enabled != 0U) && (command->mode == (uint8_t)DRIVE_MODE_SPEED);

    return asked && (fx_abs(drive->motion.speed_reference) >= speed_min) &&
           (fx_abs(drive->rotor.observer.speed) >= speed_min);
}

/* Whether the mean current is beyond the limits that current control would keep. */
static bool is_overloaded(const drive_t *drive)
{
    const torque_range_t range = drive->motion.torque_range;
    const dq_t i = virtual_resistance_mean(&drive->voltage_drive.damping);
    const int32_t square = (i.d * i.d) + (i.q * i.q);
    const int32_t length = (int32_t)trig_sqrt((uint32_t)square);

    return (i.q > range.upper) || (i.q < range.lower) ||
           (length > fx_max(range.upper, -range.lower));
}

/*
 * Whether the lead is near its limit towards braking, or the current is so small that the legs
 * switch near its zero crossing.
 */
static bool is_at_end(const drive_t *drive)
{
    const voltage_drive_cfg_t *const cfg = &drive->cfg->voltage_drive;
    const int32_t brake_max = cfg->compensator.brake_max;
    const int32_t floor = drive->cfg->current_reference.floor;
    const dq_t mean = virtual_resistance_mean(&drive->voltage_drive.damping);

    return (present_lead(drive->control.voltage) <= (fx_asr(brake_max, END_SHIFT) - brake_max)) ||
           (fx_abs(mean.q) < (floor - fx_asr(floor, HYSTERESIS_SHIFT)));
}

bool voltage_drive_count_end(voltage_drive_t *vd, const drive_t *drive,
                             const drive_command_t *command)
{
    const voltage_drive_cfg_t *const cfg = &drive->cfg->voltage_drive;
    const step_t leave = cfg->speed_min - fx_asr(cfg->speed_min, HYSTERESIS_SHIFT);

    vd->end_periods = is_at_end(drive) ? (vd->end_periods + 1U) : 0U;
    return !is_wanted(drive, command, leave) || is_overloaded(drive) ||
           (vd->end_periods >= cfg->settle_periods);
}

/*
 * Whether speed and currents have reached their references, and the lead is within the range of the
 * compensator.
 */
static bool is_calm(const drive_t *drive, step_t target, dq_t current, int32_t lead)
{
    const step_t speed_max = drive->cfg->speed_loop.speed_max;
    const step_t asked = fx_clamp(target, -speed_max, speed_max);
    const phase_compensator_cfg_t *const comp = &drive->cfg->voltage_drive.compensator;
    const int32_t brake = comp->brake_max - fx_asr(comp->brake_max, HYSTERESIS_SHIFT);

    return (fx_abs(asked - drive->rotor.observer.speed) <= fx_asr(fx_abs(asked), SPEED_SHIFT)) &&
           (drive->control.current_ref.d == 0) && (fx_abs(current.d) <= comp->current_min) &&
           (fx_abs(drive->control.current_ref.q - current.q) <= comp->current_min) &&
           (lead >= -brake) && (lead <= comp->lead_max);
}

/*
 * Returns the voltage that holds the reference: integrals plus model. The proportional part is left
 * out: in a single tick it is the converter's noise times the gain of the current loop, which is
 * more than R·i.
 */
static dq_t settled_voltage(const drive_t *drive)
{
    const current_loop_t *const loop = &drive->control.current_loop;
    const dq_t modelled = current_loop_model(loop, drive->control.current_ref);

    return (dq_t){
        .d = fx_sat16(modelled.d + pi_output(&loop->pi_d)),
        .q = fx_sat16(modelled.q + pi_output(&loop->pi_q)),
    };
}

bool voltage_drive_count_calm(voltage_drive_t *vd, const drive_t *drive,
                              const drive_command_t *command, dq_t current)
{
    const voltage_drive_cfg_t *const cfg = &drive->cfg->voltage_drive;
    const bool wanted = is_wanted(drive, command, cfg->speed_min);

    if (wanted && is_calm(drive, command->target, current, present_lead(settled_voltage(drive)))) {
        vd->calm_periods++;
    } else {
        vd->calm_periods = 0U;
    }
    return wanted && (vd->calm_periods >= cfg->settle_periods);
}

/*
 * The first output of the PI contains the proportional part of the speed error. So the integral
 * begins smaller by that part; otherwise the voltage would jump by more than R·i.
 */
void voltage_drive_begin(voltage_drive_t *vd, const drive_t *drive)
{
    const dq_t voltage = settled_voltage(drive);
    const int32_t length = fx_min((int32_t)trig_sqrt(transforms_square(voltage)), FX_Q15_MAX);
    const bool forwards = voltage.q >= 0;
    const int32_t magnitude = forwards ? length : -length;
    const int32_t lead = forwards ? present_lead(voltage) : -present_lead(voltage);
    const step_t reference = drive->motion.speed_loop.reference;
    const int32_t proportional =
        pi_sum(&drive->cfg->voltage_drive.pi, half_error(drive, reference), 0);
    const int32_t integral = magnitude - emf(drive, reference) - proportional;

    phase_compensator_start(&vd->compensator,
                            rotor_position_angle(&drive->rotor.position) + fx_unsigned(lead));
    pi_reset(&vd->pi, fx_sat16(integral));
    vd->magnitude = magnitude;
    virtual_resistance_start(&vd->damping, drive->control.current_ref);
    vd->end_periods = 0U;
    vd->active = true;
}
