/* SPDX-License-Identifier: MIT */
#include "status.h"

#include "barrier.h"
#include "commander.h"
#include "diagnosis.h"
#include "fault_text.h"
#include "transitions.h"

#include <stddef.h>

#define Q14_ONE (16384)
#define Q15_ONE (32768)
#define Q32_TO_Q16_SHIFT (16U)
#define HEAT_BASE (1000000U)    /* base with which units_thousandths() gives tenths of a per cent */
#define CURRENT_BASE_RATIO (2U) /* I_b is twice the converter's full scale */

static void add_quantity(text_t *text, const char *name, int32_t value, uint32_t decimals)
{
    text_add(text, name);
    text_number(text, value, decimals);
}

static void add_rpm(text_t *text, const char *name, const about_t *about, step_t speed)
{
    add_quantity(text, name, units_rpm(&about->rotation, speed), 0U);
}

static void add_thousandths(text_t *text, const char *name, int32_t value, int32_t one,
                            uint32_t base_millionths)
{
    add_quantity(text, name, units_thousandths(value, one, base_millionths), 3U);
}

static void add_current(text_t *text, const char *name, const about_t *about, uint16_t count)
{
    const int32_t zero = (int32_t)about->current_zero_count;

    add_thousandths(text, name, (int32_t)count - zero, zero, about->current_full_scale_ua);
}

static void add_bus(text_t *text, const char *name, const about_t *about, int32_t bus_q15)
{
    add_thousandths(text, name, bus_q15, Q15_ONE, about->bus_full_scale_uv);
}

/* Returns the temperature in °C; 0 before the first tick, because nothing is measured yet. */
static int32_t celsius(const app_t *app, const hal_t *hal, const about_t *about)
{
    return (hal_ticks(hal) == 0U)
               ? 0
               : temperature_celsius(&about->temperature, app->in.adc_temperature);
}

/* Adds value or limit of a fault with its unit. */
static void add_measure(text_t *text, const char *name, const about_t *about, fault_unit_t unit,
                        int32_t value)
{
    const uint32_t current_ua = about->current_full_scale_ua * CURRENT_BASE_RATIO;

    switch (unit) {
    case FAULT_UNIT_CURRENT:
        add_thousandths(text, name, value, Q15_ONE, current_ua);
        text_add(text, " A");
        break;
    case FAULT_UNIT_VOLTAGE:
        add_bus(text, name, about, value);
        text_add(text, " V");
        break;
    case FAULT_UNIT_SPEED:
        add_rpm(text, name, about, value);
        text_add(text, " rpm");
        break;
    case FAULT_UNIT_HEAT:
        add_quantity(text, name, units_thousandths(value, Q14_ONE, HEAT_BASE), 1U);
        text_add(text, " %");
        break;
    case FAULT_UNIT_TEMPERATURE:
        add_quantity(text, name, temperature_celsius(&about->temperature, (uint16_t)value), 0U);
        text_add(text, " C");
        break;
    default: /* NONE, WORD */
        add_quantity(text, name, value, 0U);
        break;
    }
}

/* Adds the frequency of the last swing since the start. There must have been a swing. */
static void add_frequency(text_t *text, const char *name, const drive_t *drive,
                          const about_t *about)
{
    const uint32_t ticks = drive->watch.oscillation.span * drive->cfg->slow_ticks;
    const uint32_t halves = drive->cfg->oscillation.halves_max;

    add_quantity(text, name, units_decihertz(&about->rotation, halves, ticks), 1U);
    text_add(text, " Hz");
}

static bool is_swing(const drive_t *drive)
{
    return (drive->state == DRIVE_STATE_FAULT) && (drive->fault.id == FAULT_OSCILLATION);
}

void status_add_fault(text_t *text, const about_t *about, fault_id_t id, int32_t value,
                      int32_t limit)
{
    const fault_text_t *const words = fault_text(id);

    text_add(text, words->name);
    add_measure(text, " ", about, words->unit, value);
    add_measure(text, ", limit ", about, words->unit, limit);
}

static void add_fault(text_t *text, const drive_t *drive, const about_t *about)
{
    const fault_t *const fault = &drive->fault;
    const fault_text_t *const words = fault_text(fault->id);

    text_add(text, " by ");
    text_add(text, words->name);
    add_measure(text, " ", about, words->unit, fault->value);
    if (is_swing(drive)) {
        add_frequency(text, " at ", drive, about);
    }
    add_measure(text, ", limit ", about, words->unit, fault->limit);
    text_add(text, " (");
    text_add(text, diagnosis_advice(drive, about->rotation.pole_pairs));
    text_add(text, ")");
}

/*
 * Adds the frequency of a swing that was not a fault, and says if a swing has lowered the bandwidth
 * of the speed loop.
 */
static void add_swing(text_t *text, const drive_t *drive, const about_t *about)
{
    if ((drive->watch.oscillation.span != 0U) && !is_swing(drive)) {
        add_frequency(text, ", swing ", drive, about);
    }
    if (drive->motion.speed_loop.halvings != 0U) {
        text_add(text, ", half the speed bandwidth");
    }
}

static void add_state(text_t *text, const drive_t *drive, const about_t *about)
{
    static const char *const names[DRIVE_STATES + 1U] = {
        "INIT", "OFFSET_CAL", "READY",    "FLYING_START", "PROBE", "ALIGN",
        "HOLD", "IF_RAMP",    "HANDOVER", "RUN",          "FAULT", "?",
    };
    const drive_state_t state = drive->state;

    barrier_compiler(); /* the fault is read after the state */
    text_add(text, names[transitions_number(state)]);
    if (state == DRIVE_STATE_FAULT) {
        add_fault(text, drive, about);
    }
}

/* Says it if the motor is shorted because its rotor is too fast for open gates. */
static void add_short(text_t *text, const drive_t *drive)
{
    if (safe_state_is_short(&drive->safe_state)) {
        text_add(text, ", shorting the motor");
    }
}

/* Adds the reason why the gates stay open until a reset, if there is one. */
static void add_bar(text_t *text, const char *why)
{
    if (why != NULL) {
        text_add(text, ", until a reset: ");
        text_add(text, why);
    }
}

/* Adds the position of the rotor, if position control counts it, and the target position. */
static void add_position(text_t *text, const app_t *app, const about_t *about, bool known,
                         int32_t target)
{
    if (known && (app->drive.motion.mode == (uint8_t)DRIVE_MODE_POSITION)) {
        const uint64_t from_zero = fx_unsigned64(drive_position_from_zero_q32(&app->drive));
        const uint32_t turns_q16 = (uint32_t)((from_zero >> Q32_TO_Q16_SHIFT) & UINT32_MAX);

        add_quantity(text, ", turn ", units_hundredth_turns(&about->rotation, fx_signed(turns_q16)),
                     2U);
    }
    add_quantity(text, ", to turn ", units_hundredth_turns(&about->rotation, target), 2U);
}

static void add_torque(text_t *text, const app_t *app, const about_t *about, int32_t torque_q28)
{
    const int64_t base = units_torque_base(&about->rotation, about->current_full_scale_ua,
                                           about->bus_full_scale_uv, app->drive.cfg->speed_shift);

    add_quantity(text, ", torque ", units_torque(base, torque_q28), 6U);
    text_add(text, " N m");
}

/*
 * Adds the speed of the rotor. drive: NULL if the speed is unknown, so that no old number is shown.
 */
static void add_speed_now(text_t *text, const drive_t *drive, const about_t *about)
{
    if (drive != NULL) {
        add_rpm(text, ", speed ", about, drive_speed(drive));
    } else {
        text_add(text, ", speed unknown");
    }
}

/*
 * Adds speed and target. While the motor is measured, the target in force is a word of the probe,
 * so it is not shown.
 */
static void add_speed(text_t *text, const app_t *app, const about_t *about)
{
    const drive_command_t command = command_mailbox_take(&app->mailbox);
    const bool has_begun = app->drive.cfg != NULL; /* false if the configuration was refused */
    const bool known = has_begun && drive_knows_rotor(&app->drive);
    const char *const unit = known ? " rpm" : "";

    add_speed_now(text, known ? &app->drive : NULL, about);
    if (command.request == DRIVE_REQUEST_PROBE) {
        text_add(text, unit);
        text_add(text, ", measuring the motor");
    } else if (command.mode == (uint8_t)DRIVE_MODE_POSITION) {
        text_add(text, unit);
        add_position(text, app, about, known, command.target);
    } else if ((command.mode == (uint8_t)DRIVE_MODE_TORQUE) && has_begun) {
        text_add(text, unit);
        add_torque(text, app, about, command.target);
    } else {
        add_rpm(text, known ? " of " : ", asked ", about, command.target);
        text_add(text, " rpm");
    }
}

/* Says who commands the drive, if anybody does. */
static void add_source(text_t *text, const app_t *app)
{
    const source_t source = commander_source(app);

    if (source != SOURCE_NONE) {
        text_add(text, ", by ");
        text_add(text, source_name(source));
    }
}

/* Returns the trouble of a sensor that has one now, or has had one since the last start. */
static const char *trouble_of(const app_t *app)
{
    const shaft_decoder_t *const shaft = app->shaft;
    const bool unknown = (app->in.flags & DRIVE_FLAG_NO_ANGLE) != 0U;
    const char *trouble = NULL;

    if ((shaft != NULL) && (unknown || (shaft->troubles != shaft->before))) {
        trouble = shaft_trouble_text((shaft_trouble_t)shaft->trouble);
    } else if (app->drive.rotor.failed) {
        trouble = shaft_trouble_text(SHAFT_TROUBLE_TURNED);
    } else {
        /* there is none */
    }
    return trouble;
}

/* Says who tells the angle of a drive with a sensor, and what is wrong with the sensor. */
static void add_sensor(text_t *text, const app_t *app)
{
    const drive_t *const drive = &app->drive;

    if ((drive->cfg != NULL) && drive_has_sensor(drive)) {
        const char *const trouble = trouble_of(app);

        if (drive_is_sensed(drive)) {
            text_add(text, ", angle by sensor");
        } else if (drive->state == DRIVE_STATE_RUN) {
            text_add(text, ", angle by observer");
        } else {
            /* nobody tells it */
        }
        if (trouble != NULL) {
            text_add(text, ", sensor: ");
            text_add(text, trouble);
        }
    }
}

void status_add(text_t *text, const app_t *app, const hal_t *hal, const about_t *about)
{
    add_state(text, &app->drive, about);
    add_bar(text, hal_health(hal).why_barred);
    add_short(text, &app->drive);
    add_swing(text, &app->drive, about);
    add_speed(text, app, about);
    add_current(text, ", phases ", about, app->in.adc_ia);
    add_current(text, " ", about, app->in.adc_ib);
    add_current(text, " ", about, hal_health(hal).adc_ic);
    add_bus(text, " A, bus ", about, app->drive.bus);
    add_quantity(text, " V, ", celsius(app, hal, about), 0U);
    add_quantity(text, " C, late ", (int32_t)hal_health(hal).late_ticks, 0U);
    add_quantity(text, ", load ", (int32_t)hal_health(hal).load_pct, 0U);
    text_add(text, " %");
    add_sensor(text, app);
    add_source(text, app);
}
