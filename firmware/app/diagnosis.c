/* SPDX-License-Identifier: MIT */
#include "diagnosis.h"

#include "fault_text.h"

#include <stddef.h>

#define STEPS_IN_A_TURN (4294967296LL) /* 2^32 */
#define NEAR_SHARE (12) /* two frequencies count as equal if they differ by at most 1/12 */
#define SIX (6) /* in an electrical turn the three leg currents change their sign six times */
/*
 * The phase lag of the speed loop can cause a swing whose period is 6/8 to 12/8 of lag_periods_q4,
 * the period at which this phase lag is 180°.
 */
#define LAG_EIGHTHS (6U)
#define LAG_EIGHTHS_MOST (12U)
#define EIGHT (8U)
#define HALVES_SEEN (4U) /* 4 half-waves in a run are a sign of a swing, though not yet a fault */
/* The noise at rest is a sign if it is above 1/6 of the residual that a start allows. */
#define NOISE_SHARE (6)
/* A swing reaches the current limit if its amplitude is less than 1/16 below this limit. */
#define WHOLE_SHARE (16)
/*
 * The rotor does not follow the vector if the two speeds differ by more than 1/2 of the vector's
 * speed.
 */
#define FOLLOW_SHARE (2)

static uint32_t sign_if(fault_sign_t sign, bool is_there)
{
    return is_there ? ((uint32_t)1U << (uint32_t)sign) : 0U;
}

static bool was_running(const drive_t *drive)
{
    return drive->scene.state == DRIVE_STATE_RUN;
}

/*
 * Whether in RUN one of `limits` was in force and less than 3/4 of the motoring current was left.
 */
static bool is_derated_by(const drive_t *drive, uint32_t limits)
{
    const int32_t whole = drive->cfg->derating.current_max;

    return was_running(drive) && ((drive->scene.limits & limits) != 0U) &&
           (drive->scene.motoring < (whole - (whole / 4)));
}

/* Returns the frequency of the last swing in steps per tick; 0: no swing was found. */
static int64_t swing_step(const drive_t *drive)
{
    const int64_t ticks =
        2LL * (int64_t)drive->watch.oscillation.span * (int64_t)drive->cfg->slow_ticks;

    return (ticks == 0) ? 0
                        : ((STEPS_IN_A_TURN * (int64_t)drive->cfg->oscillation.halves_max) / ticks);
}

/* Whether `frequency` is about `times` · `turn`. Both are in steps per tick. */
static bool is_times(int64_t frequency, int64_t turn, int64_t times)
{
    const int64_t expected = turn * times;
    const int64_t off = (frequency > expected) ? (frequency - expected) : (expected - frequency);

    return (expected > 0) && ((NEAR_SHARE * off) <= expected);
}

/*
 * Period of the swing, and the period at which the speed loop has a phase lag of 180°, both in
 * sixteenths of a slow period.
 */
typedef struct {
    uint64_t swing_q4;
    uint64_t lag_q4;
} periods_t;

static periods_t periods_of(const drive_t *drive)
{
    const oscillation_cfg_t *const cfg = &drive->cfg->oscillation;

    return (periods_t){
        .swing_q4 = (32ULL * drive->watch.oscillation.span) / cfg->halves_max,
        .lag_q4 = cfg->lag_periods_q4,
    };
}

static bool is_faster_than_lag(const periods_t *periods)
{
    return (EIGHT * periods->swing_q4) < (LAG_EIGHTHS * periods->lag_q4);
}

static bool is_slower_than_lag(const periods_t *periods)
{
    return (EIGHT * periods->swing_q4) > (LAG_EIGHTHS_MOST * periods->lag_q4);
}

/* Whether the swing reaches the current limit. A loop that swings by itself does so. */
static bool swings_at_limit(const drive_t *drive)
{
    const int32_t whole = drive->cfg->derating.current_max;

    return drive->fault.value > (whole - (whole / WHOLE_SHARE));
}

/*
 * Returns the signs of a swing that something outside the speed loop forces. They follow from its
 * frequency. shaft: frequency of the shaft's turns; electric: frequency of the electrical turns.
 * With few pole pairs two causes have the same frequency.
 */
static uint32_t forced_signs(int64_t frequency, int64_t shaft, int64_t electric)
{
    /* a four-stroke engine or a belt forces a swing at half of the shaft's frequency */
    const bool turns = is_times(2 * frequency, shaft, 1) || is_times(frequency, shaft, 1) ||
                       is_times(frequency, shaft, 2) || is_times(frequency, shaft, 3);
    const bool electrical = is_times(frequency, electric, 1) || is_times(frequency, electric, 2);
    uint32_t signs;

    if (turns && electrical) {
        signs = sign_if(FAULT_SIGN_SHAFT_OR_ELECTRIC, true);
    } else {
        signs = sign_if(FAULT_SIGN_SHAFT, turns) | sign_if(FAULT_SIGN_ELECTRIC, electrical) |
                sign_if(FAULT_SIGN_SIX, is_times(frequency, electric, SIX));
    }
    return signs;
}

static uint32_t swing_signs(const drive_t *drive, uint32_t pole_pairs)
{
    const int64_t electric = (int64_t)fx_abs(drive->motion.speed_loop.reference);
    const periods_t periods = periods_of(drive);
    const bool fast = is_faster_than_lag(&periods);
    const bool lags = !fast && !is_slower_than_lag(&periods);
    const bool own = lags && swings_at_limit(drive);
    uint32_t signs = sign_if(FAULT_SIGN_LAG, lags);

    if (!fast && !own) { /* the loop does not follow a faster swing, so nothing has forced it */
        signs |= forced_signs(swing_step(drive), electric / (int64_t)pole_pairs, electric);
    }
    return signs;
}

/*
 * Returns the mean change of a current sensor from sample to sample at rest, Q15 of I_b. It is 1.13
 * times the rms value of the noise.
 */
static int32_t noise_at_rest(const drive_t *drive)
{
    const uint64_t samples = 2ULL * drive->sensors.sums.samples;
    const uint64_t sum = fx_unsigned(drive->sensors.sums.noise);
    uint64_t mean = 0U;

    if (samples > 0U) {
        mean = (sum << drive->cfg->sampling.current_shift) / samples;
    }
    return (int32_t)mean;
}

/*
 * Whether the noise at rest is large compared with the residual that a start allows (residual_max).
 */
static bool is_noisy_at_rest(const drive_t *drive)
{
    return (NOISE_SHARE * noise_at_rest(drive)) > drive->cfg->startup.residual_max;
}

/*
 * Whether the rotor did not follow the vector of a start. Then the observer finds no speed, or a
 * wrong one.
 */
static bool is_not_followed(const drive_t *drive)
{
    const step_t vector = drive->vector.step;
    const step_t slip = fx_abs(vector - drive->rotor.observer.speed);

    return drive_is_imposed(drive->scene.state) && ((FOLLOW_SHARE * slip) > fx_abs(vector));
}

/*
 * Whether the drive was braking: the braking torque was larger than ripple. If a high bus had
 * derated the braking torque, no braking torque is left to see. Then the drive was braking unless
 * the torque was clearly motoring.
 */
static bool brakes(const drive_t *drive)
{
    const fault_scene_t *const scene = &drive->scene;
    const int32_t onwards = (scene->speed < 0) ? -scene->torque : scene->torque;
    const int32_t ripple = drive->cfg->supervision.phase_range_min;
    const bool derated = (scene->limits & DERATING_BUS_HIGH) != 0U;

    return (onwards < -ripple) || (derated && (onwards < ripple));
}

static uint32_t scene_signs(const drive_t *drive)
{
    const fault_scene_t *const scene = &drive->scene;
    const bool turned = drive_is_imposed(scene->state) && (scene->state != DRIVE_STATE_ALIGN);
    const step_t handover = drive->cfg->startup.handover_speed;

    return sign_if(FAULT_SIGN_DERATED_BUS, is_derated_by(drive, DERATING_BUS_LOW)) |
           sign_if(
               FAULT_SIGN_DERATED_OTHER,
               is_derated_by(drive, DERATING_HEAT | DERATING_TEMPERATURE | DERATING_BUS_CURRENT)) |
           sign_if(FAULT_SIGN_SWING,
                   was_running(drive) && (drive->watch.oscillation.halves >= HALVES_SEEN)) |
           sign_if(FAULT_SIGN_PROBE, scene->state == DRIVE_STATE_PROBE) |
           sign_if(FAULT_SIGN_ALIGN, scene->state == DRIVE_STATE_ALIGN) |
           sign_if(FAULT_SIGN_START, turned) |
           sign_if(FAULT_SIGN_OPEN_GATES, !drive_is_controlled(scene->state)) |
           sign_if(FAULT_SIGN_RUN, was_running(drive)) | sign_if(FAULT_SIGN_BRAKES, brakes(drive)) |
           sign_if(FAULT_SIGN_SLOW, was_running(drive) && (fx_abs(scene->speed) < handover)) |
           sign_if(FAULT_SIGN_NOT_FOLLOWED, is_not_followed(drive));
}

/*
 * Whether one of the two measured phase currents has stayed constant in the present arc
 * (supervision.h), while the other has changed.
 */
static bool is_stuck(const drive_t *drive)
{
    const supervision_t *const seen = &drive->watch.supervision;
    int32_t least = 0;
    int32_t most = 0;

    for (uint32_t phase = 0U; phase < 2U; phase++) {
        const int32_t range = seen->highest[phase] - seen->lowest[phase];

        least = ((phase == 0U) || (range < least)) ? range : least;
        most = fx_max(most, range);
    }
    return (least <= 1) && (most > drive->cfg->supervision.phase_range_min);
}

/*
 * Whether a phase had no current in the tick of the fault, although the drive controlled the
 * current.
 */
static bool is_without_current(const drive_t *drive)
{
    const int32_t a = drive->scene.phase_a;
    const int32_t b = drive->scene.phase_b;
    const int32_t least = fx_min(fx_min(fx_abs(a), fx_abs(b)), fx_abs(a + b));

    return drive_is_controlled(drive->scene.state) &&
           (least <= drive->cfg->supervision.phase_zero_max);
}

static bool is_cold_end(const drive_t *drive)
{
    const derating_cfg_t *const cfg = &drive->cfg->derating;
    const bool below = drive->fault.value < cfg->temperature_lowest;
    const bool rises = cfg->temperature.gain > 0; /* the counts rise with the temperature */

    return below == rises;
}

static uint32_t measured_signs(const drive_t *drive)
{
    const fault_t *const fault = &drive->fault;
    const protection_cfg_t *const limits = &drive->cfg->protection;

    return sign_if(FAULT_SIGN_NOISE, is_noisy_at_rest(drive)) |
           sign_if(FAULT_SIGN_SENSED, drive_has_sensor(drive)) |
           sign_if(FAULT_SIGN_STUCK, is_stuck(drive)) |
           sign_if(FAULT_SIGN_NO_CURRENT, is_without_current(drive)) |
           sign_if(FAULT_SIGN_OPEN_WIRE, drive->watch.supervision.suspect.id == FAULT_LOST_PHASE) |
           sign_if(FAULT_SIGN_COLD, is_cold_end(drive)) |
           sign_if(FAULT_SIGN_GONE, fault->value < (limits->bus_min / 2)) |
           sign_if(FAULT_SIGN_LATE, drive->watch.supervision.late > 0U);
}

uint32_t diagnosis_signs(const drive_t *drive, uint32_t pole_pairs)
{
    return swing_signs(drive, pole_pairs) | scene_signs(drive) | measured_signs(drive);
}

const char *diagnosis_advice(const drive_t *drive, uint32_t pole_pairs)
{
    return fault_advice(drive->fault.id, diagnosis_signs(drive, pole_pairs));
}
