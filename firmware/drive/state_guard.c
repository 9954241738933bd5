/* SPDX-License-Identifier: MIT */
#include "state_guard.h"

#include "inlining.h"
#include "motor.h"
#include "transitions.h"

/* log2 of the slow periods in a supervision period, the time between two calls of look() */
#define PERIODS_LOG2 (2U)
/* largest current error of the observer, which corrects the flux, Q15 of I_b */
#define ERROR_MAX (8192)
#define IDENTIFIED (0x55AA0000UL)
/* more than any gain changes an integral in a tick, Q26 */
#define CHANGE_MAX (0x100000)
#define HALF_TURN_Q16 (32768U)
#define Q13_TO_Q17_LOG2 (4U)

_Static_assert((1U << PERIODS_LOG2) == SUPERVISION_STEPS, "a look in each supervision period");

RARE static fault_id_t found(uint32_t part, fault_t *fault)
{
    *fault = (fault_t){.id = FAULT_MEMORY, .value = fx_signed(part), .limit = 0};
    return FAULT_MEMORY;
}

/*
 * Returns the check word of the measured values. A flipped bit in one of them is a flipped bit in
 * the word. For a drive_t that is all zeros the word is not 0, so it differs from the kept one.
 */
static uint32_t word_of_measured(const drive_t *drive)
{
    const uint32_t word = fx_unsigned(drive->sensors.offset_a ^ ~drive->sensors.offset_b);

    return drive->motor.identified ? (word ^ IDENTIFIED) : word;
}

void state_guard_keep_measured(state_guard_t *guard, const drive_t *drive)
{
    guard->measured = word_of_measured(drive);
}

void state_guard_forget(state_guard_t *guard)
{
    guard->state = DRIVE_STATE_INIT;
}

void state_guard_keep_heat(state_guard_t *guard, const derating_t *derating)
{
    guard->heat_q24 = derating->heat_q24;
}

static uint32_t word_of_fade(const fade_t *fade)
{
    return fx_unsigned(fade->zero ^ fade->gain) ^ fade->shift;
}

static uint32_t word_of_derating(const derating_cfg_t *cfg)
{
    const int32_t ends = cfg->temperature_lowest ^ cfg->temperature_highest;
    const int32_t currents = cfg->current_max ^ cfg->current_continuous ^ cfg->bus_current_max;

    return word_of_fade(&cfg->temperature) ^ word_of_fade(&cfg->bus_low) ^
           fx_unsigned(ends ^ currents);
}

static uint32_t word_of_modulator(const modulator_cfg_t *cfg)
{
    return fx_unsigned(cfg->timer_counts ^ cfg->ratio_max_q15 ^ cfg->drop_q15 ^ cfg->ripple_q15 ^
                       cfg->edge_slope);
}

static uint32_t word_of_speed_loop(const speed_loop_cfg_t *cfg)
{
    return fx_unsigned(cfg->pi.kp ^ cfg->pi.ki) ^ cfg->pi.kp_shift ^ cfg->pi.ki_shift ^
           cfg->error_shift;
}

/*
 * Returns the check word of the settings in which a flipped bit makes speed or current wrong within
 * 100 ms.
 */
static uint32_t word_of_config(const drive_cfg_t *cfg)
{
    const uint32_t sampling =
        cfg->sampling.current_shift ^ cfg->sampling.bus_shift ^ cfg->sampling.sensor_pole_pairs;
    const int32_t filter = cfg->torque_filter.smooth_rate_q15 ^ cfg->torque_filter.notch_share_q15;
    const int32_t reference = cfg->current_reference.floor ^ cfg->current_reference.slope_down;
    const int32_t flux = cfg->observer.flux_q27 ^ cfg->current_loop.emf_q13;

    return cfg->speed_shift ^ cfg->slow_ticks ^ sampling ^ word_of_modulator(&cfg->modulator) ^
           word_of_derating(&cfg->derating) ^ word_of_speed_loop(&cfg->speed_loop) ^
           fx_unsigned(filter ^ reference ^ flux);
}

void state_guard_keep_config(state_guard_t *guard, const drive_cfg_t *cfg)
{
    guard->config = word_of_config(cfg);
}

static bool asks_speed(const drive_t *drive)
{
    return drive->motion.mode == (uint8_t)DRIVE_MODE_SPEED;
}

/* Whether the speed reference has changed no faster than its ramp. */
static bool is_ramp(const drive_t *drive)
{
    const step_t change = fx_abs(drive->motion.speed_loop.reference - drive->state_guard.reference);

    return !asks_speed(drive) || (fx_asr(change, PERIODS_LOG2) <= drive->cfg->speed_loop.ramp);
}

static bool is_drift(const drive_t *drive)
{
    const int32_t change = fx_abs(drive->motor.model.flux_q30 - drive->state_guard.flux_q30);

    return fx_asr(change, PERIODS_LOG2) <= (ERROR_MAX * drive->cfg->model.flux_rate);
}

/*
 * Whether the rotor can have moved so far since the last look. Any number of turns may be right, so
 * only the change is checked. In a supervision period a rotor moves at most half a turn further
 * than the sum of its speed and its speed reference at the last look leads it. The present speed
 * may be wrong by the same flipped bit, so it is not used.
 */
static bool is_way(const drive_t *drive)
{
    const state_guard_t *const guard = &drive->state_guard;
    const uint64_t before = ((uint64_t)guard->turns << 32U) | guard->turned;
    const uint64_t moved = fx_unsigned64(drive->rotor.position.turns_q32) - before;
    const uint64_t way = (fx_signed64(moved) < 0) ? (0U - moved) : moved;
    const uint32_t speed =
        fx_unsigned(fx_abs(guard->reference)) + fx_unsigned(fx_abs(guard->speed));
    const uint32_t ticks = drive->cfg->slow_ticks << PERIODS_LOG2;
    const uint32_t reach_q16 = ((speed >> 16U) * ticks) + HALF_TURN_Q16;
    const uint64_t reach_q32 = (uint64_t)reach_q16 << 16U;

    return way <= reach_q32;
}

static void keep_motion(state_guard_t *guard, const drive_t *drive)
{
    const uint64_t position = fx_unsigned64(drive->rotor.position.turns_q32);

    guard->turns = (uint32_t)(position >> 32U);
    guard->turned = rotor_position_angle(&drive->rotor.position);
    guard->speed = drive->rotor.observer.speed;
    guard->reference = drive->motion.speed_loop.reference;
}

static fault_id_t look_at_position(const drive_t *drive, fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    if (!position_loop_holds(&drive->motion.position_loop)) {
        id = found((uint32_t)STATE_GUARD_PROFILE, fault);
    } else if (!is_way(drive)) {
        id = found((uint32_t)STATE_GUARD_TURNS, fault);
    } else {
        /* the position is possible */
    }
    return id;
}

static bool asks_position(const drive_t *drive)
{
    return drive->motion.mode == (uint8_t)DRIVE_MODE_POSITION;
}

/* Checks the values that change only a little in RUN. */
static fault_id_t look_at_run(state_guard_t *guard, const drive_t *drive, fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    if (guard->state == DRIVE_STATE_RUN) {
        if (!is_ramp(drive)) {
            id = found((uint32_t)STATE_GUARD_REFERENCE, fault);
        } else if (!is_drift(drive)) {
            id = found((uint32_t)STATE_GUARD_FLUX, fault);
        } else if (!weakening_holds(&drive->motion.weakening)) {
            id = found((uint32_t)STATE_GUARD_WEAKENING, fault);
        } else if (asks_position(drive)) {
            id = look_at_position(drive, fault);
        } else {
            /* all values are possible */
        }
    }
    keep_motion(guard, drive);
    guard->flux_q30 = drive->motor.model.flux_q30;
    return id;
}

static bool is_integral(const drive_t *drive, const pi_cfg_t *cfg, int32_t now, int32_t before)
{
    const int32_t gain = fx_asr(FX_Q15_MAX * fx_abs(cfg->ki), cfg->ki_shift);
    const int32_t ticks = (int32_t)drive->cfg->slow_ticks;

    return fx_asr(fx_abs(now - before), PERIODS_LOG2) <= (fx_min(gain + 1, CHANGE_MAX) * ticks);
}

/*
 * Whether the integrals have changed by no more than their gains allow. Only at the voltage limit
 * an integral may change faster, and a rotor at rest in the field needs less voltage than that.
 */
static bool has_soft_integrals(const drive_t *drive)
{
    const current_loop_cfg_t *const loop = &drive->cfg->hold_loop;
    const state_guard_t *const guard = &drive->state_guard;

    return is_integral(drive, &loop->pi_d, drive->control.current_loop.pi_d.integral_q26,
                       guard->integral_d_q26) &&
           is_integral(drive, &loop->pi_q, drive->control.current_loop.pi_q.integral_q26,
                       guard->integral_q_q26);
}

/* Checks the angle of a resting vector, and the integrals, in HOLD. */
static fault_id_t look_at_rest(state_guard_t *guard, const drive_t *drive, fault_t *fault)
{
    const angle_t angle = rotor_position_angle(&drive->vector.position);
    fault_id_t id = FAULT_NONE;

    if (guard->state == DRIVE_STATE_HOLD) {
        if (angle != guard->angle) {
            id = found((uint32_t)STATE_GUARD_ANGLE, fault);
        } else if (!has_soft_integrals(drive)) {
            id = found((uint32_t)STATE_GUARD_INTEGRALS, fault);
        } else {
            /* all values are possible */
        }
    }
    guard->angle = angle;
    guard->integral_d_q26 = drive->control.current_loop.pi_d.integral_q26;
    guard->integral_q_q26 = drive->control.current_loop.pi_q.integral_q26;
    return id;
}

static fault_id_t look(state_guard_t *guard, const drive_t *drive, fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    if (word_of_measured(drive) != guard->measured) {
        id = found((uint32_t)STATE_GUARD_MEASURED, fault);
    } else if (drive->state == DRIVE_STATE_RUN) {
        id = look_at_run(guard, drive, fault);
    } else if (drive_is_held(drive)) {
        id = look_at_rest(guard, drive, fault);
    } else {
        /* nothing to check in these states */
    }
    guard->state = drive->state;
    return id;
}

static bool holds_limits(const drive_t *drive)
{
    const protection_limits_t due =
        protection_limits(&drive->cfg->protection, drive_is_driving(drive->state));

    return (drive->limits.current_max == due.current_max) &&
           (drive->limits.bus_max == due.bus_max) && (drive->limits.bus_min == due.bus_min);
}

/* Whether the learned J is within its limits. Both are ratios to the file's J. */
static bool has_inertia(const drive_t *drive)
{
    const speed_loop_cfg_t *const cfg = &drive->cfg->speed_loop;
    const int32_t ratio_q13 = fx_asr(drive->motion.speed_loop.inertia_q17, Q13_TO_Q17_LOG2);

    return (ratio_q13 >= cfg->inertia_least_q13) && (ratio_q13 <= cfg->inertia_most_q13);
}

static bool holds_choices(const drive_t *drive)
{
    const bool voltage = drive->voltage_drive.active && (drive->cfg->voltage_drive.enabled == 0U);

    return !voltage && has_inertia(drive) &&
           ((uint32_t)drive->start.align.phase <= (uint32_t)ALIGN_DONE) &&
           ((uint32_t)drive->start.flying_start.phase <= (uint32_t)FLYING_START_CHARGE) &&
           ((uint32_t)drive->safe_state.phase <= (uint32_t)SAFE_STATE_BROKEN) &&
           (drive->motion.speed_loop.halvings <= 1U);
}

/* A larger number of failed starts would have been a fault before. */
static bool holds_start(const drive_t *drive)
{
    return drive->start.attempts <= drive->cfg->startup.attempts;
}

static bool check_part(motor_t *motor, const drive_t *drive, uint32_t part)
{
    bool sound;

    if (part <= (uint32_t)STATE_GUARD_MODEL_FLUX) {
        sound = motor_check(motor, drive->cfg, (model_part_t)part);
    } else if (part == (uint32_t)STATE_GUARD_LIMITS) {
        sound = holds_limits(drive);
    } else if (part == (uint32_t)STATE_GUARD_CHOICES) {
        sound = holds_choices(drive);
    } else if (part == (uint32_t)STATE_GUARD_START) {
        sound = holds_start(drive);
    } else { /* CONFIG */
        sound = word_of_config(drive->cfg) == drive->state_guard.config;
    }
    return sound;
}

/*
 * Returns the fault of a part that does not hold: MEMORY, or CONFIGURATION for STATE_GUARD_CONFIG.
 */
RARE static fault_id_t found_part(const drive_t *drive, uint32_t part, fault_t *fault)
{
    fault_id_t id = found(part, fault);

    if (part == (uint32_t)STATE_GUARD_CONFIG) {
        id = FAULT_CONFIGURATION;
        *fault = (fault_t){.id = id,
                           .value = fx_signed(word_of_config(drive->cfg)),
                           .limit = fx_signed(drive->state_guard.config)};
    }
    return id;
}

fault_id_t state_guard_step(state_guard_t *guard, motor_t *motor, const drive_t *drive,
                            fault_t *fault)
{
    const uint32_t part = guard->at % (uint32_t)STATE_GUARD_PARTS;
    fault_id_t id = look(guard, drive, fault);

    guard->at = (part + 1U) % (uint32_t)STATE_GUARD_PARTS;
    if ((id == FAULT_NONE) && !check_part(motor, drive, part)) {
        id = found_part(drive, part, fault);
    }
    return id;
}

fault_id_t state_guard_check_state(const drive_t *drive, fault_t *fault)
{
    const uint32_t code = (uint32_t)STATE_GUARD_STATE + (uint32_t)drive->state;

    return transitions_is_state(drive->state) ? FAULT_NONE : found(code, fault);
}

fault_id_t state_guard_check_sensor(const drive_t *drive, fault_t *fault)
{
    const bool sound = angle_sensor_holds(&drive->rotor.angle_sensor);

    return sound ? FAULT_NONE : found((uint32_t)STATE_GUARD_TURNS, fault);
}

fault_id_t state_guard_check_heat(const drive_t *drive, fault_t *fault)
{
    const bool sound = drive->derating.heat_q24 == drive->state_guard.heat_q24;

    return sound ? FAULT_NONE : found((uint32_t)STATE_GUARD_HEAT, fault);
}

fault_id_t state_guard_check_vector(const drive_t *drive, fault_t *fault)
{
    const startup_cfg_t *const cfg = &drive->cfg->startup;
    const step_t step = drive->vector.step;
    const step_t change = fx_abs(drive->motion.speed_reference - step);
    const bool jumps = asks_speed(drive) && (change > cfg->ramp);
    const bool lost = drive->start.lost_periods > cfg->lost_periods;
    const bool measured = word_of_measured(drive) == drive->state_guard.measured;
    const bool sound = (step == drive->motion.speed_loop.reference) && measured && !jumps && !lost;

    return sound ? FAULT_NONE : found((uint32_t)STATE_GUARD_VECTOR, fault);
}
