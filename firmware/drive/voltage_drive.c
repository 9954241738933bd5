#include "voltage_drive.h"

#include "drive_state.h"
#include "trig.h"

#define MEAN_SHIFT (5U) /* of the current's filter, in ticks */

/* ω·φ, Q15 of U_b. */
static int32_t emf(const drive_t *drive, step_t speed)
{
    const int32_t speed_q15 = fx_sat16(fx_asr(speed, drive->cfg->speed_shift));

    return fx_sat16(fx_asr(speed_q15 * drive->model.run_loop.emf_q13, 13U));
}

/* Go on from magnitude and lead, with the speed that is asked for. */
static void take_over(drive_t *drive, int32_t magnitude, angle_t lead)
{
    const step_t reference = drive->speed_loop.reference;

    phase_compensator_start(&drive->compensator, rotor_position_angle(&drive->position) + lead);
    speed_loop_start(&drive->speed_loop, reference, fx_sat16(magnitude - emf(drive, reference)));
    drive->voltage_magnitude = magnitude;
    drive->voltage_driven = true;
}

void voltage_drive_start(drive_t *drive)
{
    speed_loop_reset(&drive->speed_loop, drive->observer.speed);
    drive->speed_reference = drive->observer.speed;
    take_over(drive, emf(drive, drive->observer.speed), 0U);
}

void voltage_drive_step(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;
    const int32_t limit = modulator_limit(&drive->cfg->modulator, s->bus);
    const int32_t magnitude = fx_clamp(drive->voltage_magnitude, -limit, limit);
    const int32_t lead = phase_compensator_step(
        &drive->compensator, &drive->cfg->voltage_drive.compensator, s->current,
        rotor_position_angle(&drive->position), drive->observer.speed_out, magnitude >= 0);
    const sincos_t angle = trig_sincos((angle_t)lead);

    s->voltage_limit = limit;
    s->voltage.d = fx_asr(-magnitude * angle.sin, 15U);
    s->voltage.q = fx_asr(magnitude * angle.cos, 15U);
    s->current_ref.d += fx_asr(s->current.d - s->current_ref.d, MEAN_SHIFT);
    s->current_ref.q += fx_asr(s->current.q - s->current_ref.q, MEAN_SHIFT);
}

static bool is_position(const drive_command_t *command)
{
    return command->mode == (uint8_t)DRIVE_MODE_POSITION;
}

/* What the current loop's feed-forward will be with the current that flows. */
static dq_t modelled_voltage(const drive_t *drive)
{
    const current_loop_cfg_t *const loop = &drive->model.run_loop;
    const dq_t i = drive->signals.current_ref;
    const int32_t speed = drive->signals.speed;
    const int32_t reactance_d = fx_asr(speed * loop->reactance_d_q13, 13U);
    const int32_t reactance_q = fx_asr(speed * loop->reactance_q_q13, 13U);
    const dq_t drop = {fx_asr(i.d * loop->resistance_q13, 13U),
                       fx_asr(i.q * loop->resistance_q13, 13U)};

    return (dq_t){
        .d = drop.d - fx_asr(reactance_q * i.q, 15U),
        .q = drop.q + fx_asr(reactance_d * i.d, 15U) + emf(drive, drive->observer.speed),
    };
}

/*
 * Back to current control: its integrals are what the voltage has beyond the model, its torque current what flows. The
 * compensator has left no i_d, and there may be no start-up whose slope would take the rest away.
 */
static void return_to_current(drive_t *drive)
{
    drive_signals_t *const s = &drive->signals;
    const dq_t modelled = modelled_voltage(drive);

    pi_reset(&drive->current_loop.pi_d, fx_sat16(s->voltage.d - modelled.d));
    pi_reset(&drive->current_loop.pi_q, fx_sat16(s->voltage.q - modelled.q));
    s->current_ref.d = 0;
    speed_loop_start(&drive->speed_loop, drive->speed_loop.reference, s->current_ref.q);
    drive->voltage_driven = false;
}

static void set_magnitude(drive_t *drive)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const step_t speed_max = cfg->speed_loop.speed_max;
    const step_t reference = fx_clamp(drive->speed_reference, -speed_max, speed_max);
    const step_t error = reference - drive->observer.speed;

    drive->speed_loop.reference = reference;
    drive->voltage_magnitude = pi_step(&drive->speed_loop.pi, &cfg->voltage_drive.pi,
                                       fx_sat16(fx_asr(error, cfg->speed_loop.error_shift)),
                                       emf(drive, reference), drive->signals.voltage_limit);
}

void voltage_drive_motion(drive_t *drive, const drive_command_t *command, bool slow)
{
    if (slow || is_position(command)) {
        return_to_current(drive);
    } else {
        set_magnitude(drive);
    }
}

/* Where the present voltage lies: its lead, in the direction of rotation. */
static angle_t present_lead(dq_t voltage, bool forwards)
{
    const int32_t ahead = forwards ? -voltage.d : voltage.d;
    const int32_t along = forwards ? voltage.q : -voltage.q;

    return trig_atan2((int16_t)fx_sat16(ahead), (int16_t)fx_sat16(along));
}

void voltage_drive_offer(drive_t *drive, const drive_command_t *command, bool slow)
{
    const drive_cfg_t *const cfg = drive->cfg;
    const dq_t voltage = drive->signals.voltage;
    const bool forwards = voltage.q >= 0;
    const bool wanted = (cfg->voltage_drive.enabled != 0U) && !slow && !is_position(command);

    if (wanted && (fx_abs(drive->signals.current_ref.d) <= cfg->startup.current_floor)) {
        const int32_t square = (voltage.d * voltage.d) + (voltage.q * voltage.q);
        const int32_t magnitude = fx_min((int32_t)trig_sqrt((uint32_t)square), FX_Q15_MAX);

        take_over(drive, forwards ? magnitude : -magnitude, present_lead(voltage, forwards));
    }
}
