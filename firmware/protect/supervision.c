/* SPDX-License-Identifier: MIT */
#include "supervision.h"

/*
 * An arc is half an electrical turn: in it the current of each phase changes by at least the length
 * of the current vector.
 */
#define ARC_Q16 (32768)
#define ARC_SAMPLES_MIN (8U)
/*
 * A phase that is weak in this many arcs in a row is a fault. A load step can make one arc
 * lopsided, two at most.
 */
#define ARCS_MAX (3U)
#define WEAK_SHARE_LOG2 (3U) /* a phase is weak if its range is below 1/8 of the largest one */
#define ROOT_3_HALF_Q15 (28378)
#define NO_PHASE (SUPERVISION_PHASES)
/* φ̂ settles, and is compared with its mean, over 2^4 windows of the other means: about a second */
#define FLUX_TIME_SHIFT (4U)
#define EMF_SHARE_SHIFT (2U)
#define Q30_TO_Q14 (16U)
#define FLUX_OF_FILE_Q30 (0x40000000)

/* Clears word by word, because a library's memset takes five times as long. */
void supervision_forget_imposed(supervision_t *state)
{
    state->absent = NO_PHASE;
    state->absent_periods = 0U;
    state->unexplained = 0U;
}

void supervision_reset(supervision_t *state)
{
    state->step = 0U;
    state->late = 0U;
    state->late_periods = 0U;
    state->start_q16 = 0;
    state->samples = 0U;
    for (uint32_t phase = 0U; phase < SUPERVISION_PHASES; phase++) {
        state->lowest[phase] = 0;
        state->highest[phase] = 0;
    }
    state->weak = 0U;
    state->weak_arcs = 0U;
    state->suspect = (fault_t){.id = FAULT_NONE};
    supervision_forget_imposed(state);
    state->off_current = (dq_t){0, 0};
    state->off_reference = 0U;
    state->unmodelled = 0U;
    supervision_forget_flux(state);
    state->runaway = 0U;
    state->too_fast = 0U;
    state->stalled = 0U;
    state->onwards = 0;
    state->residual = 0;
}

/* Counts up while something is wrong and down while it is not; true when the count is above max. */
static bool lasts(uint32_t *count, bool wrong, uint32_t max)
{
    if (wrong) {
        *count += 1U;
    } else if (*count > 0U) {
        *count -= 1U;
    } else {
        /* nothing to forget */
    }
    return *count > max;
}

static void note_phase(supervision_t *state, uint32_t phase, int32_t current)
{
    const bool first = state->samples == 0U;

    if (first || (current < state->lowest[phase])) {
        state->lowest[phase] = current;
    }
    if (first || (current > state->highest[phase])) {
        state->highest[phase] = current;
    }
}

static int32_t range_of(const supervision_t *state, uint32_t phase)
{
    return state->highest[phase] - state->lowest[phase];
}

/*
 * Returns the fault of a weak phase. An open wire carries no current, a dead channel reads a
 * constant one. Phase c is not measured, so it has no channel that can be dead.
 */
static fault_t suspect(const supervision_t *state, const supervision_cfg_t *cfg, uint32_t weak,
                       int32_t current, int32_t limit)
{
    const bool at_zero = fx_abs(current) <= cfg->phase_zero_max;

    return (fault_t){
        .id = (at_zero || (weak == 2U)) ? FAULT_LOST_PHASE : FAULT_ADC_STUCK,
        .value = range_of(state, weak),
        .limit = limit,
    };
}

/* Ends an arc: finds the weak phase, and counts the arcs in a row in which it was weak. */
static fault_id_t compare_phases(supervision_t *state, const supervision_cfg_t *cfg,
                                 const int32_t current[SUPERVISION_PHASES], fault_t *fault)
{
    uint32_t weak = 0U;
    int32_t strongest = 0;
    fault_id_t id = FAULT_NONE;
    int32_t limit;

    for (uint32_t phase = 0U; phase < SUPERVISION_PHASES; phase++) {
        strongest = fx_max(strongest, range_of(state, phase));
        weak = (range_of(state, phase) < range_of(state, weak)) ? phase : weak;
    }
    limit = fx_asr(strongest, WEAK_SHARE_LOG2);
    if ((strongest <= cfg->phase_range_min) || (range_of(state, weak) >= limit)) {
        state->weak_arcs = 0U;
        state->suspect.id = FAULT_NONE;
    } else {
        state->weak_arcs = (weak == state->weak) ? (state->weak_arcs + 1U) : 1U;
        state->weak = weak;
        state->suspect = suspect(state, cfg, weak, current[weak], limit);
    }
    if (state->weak_arcs >= ARCS_MAX) {
        *fault = state->suspect;
        id = fault->id;
    }
    return id;
}

/* Returns the electrical turns since the start of this arc, Q16, wrapping. */
static int32_t turned_q16(const supervision_t *state, int32_t turns_q16)
{
    const uint32_t turned = fx_unsigned(turns_q16) - fx_unsigned(state->start_q16);

    return fx_signed(turned);
}

fault_id_t supervision_check_phases(supervision_t *state, const supervision_cfg_t *cfg,
                                    const supervision_phases_t *in, fault_t *fault)
{
    const int32_t current[SUPERVISION_PHASES] = {in->a, in->b, -in->a - in->b};
    fault_id_t id = FAULT_NONE;
    int32_t turned;

    if (state->samples == 0U) {
        state->start_q16 = in->turns_q16;
    }
    turned = turned_q16(state, in->turns_q16);
    for (uint32_t phase = 0U; phase < SUPERVISION_PHASES; phase++) {
        note_phase(state, phase, current[phase]);
    }
    state->samples++;
    if (fx_abs(in->speed) > cfg->phase_speed_max) {
        state->samples = 0U;
        state->weak_arcs = 0U;
        state->suspect.id = FAULT_NONE;
    } else if ((state->samples >= ARC_SAMPLES_MIN) &&
               ((turned >= ARC_Q16) || (turned <= -ARC_Q16))) {
        state->samples = 0U;
        id = compare_phases(state, cfg, current, fault);
    } else {
        /* the arc goes on */
    }
    return id;
}

typedef struct {
    uint32_t phase;  /* phase that should carry a current and does not; NO_PHASE: there is none */
    int32_t current; /* magnitude of the current measured in this phase */
} absent_t;

static absent_t absent_phase(const supervision_cfg_t *cfg, const supervision_imposed_t *in)
{
    const int32_t across = fx_asr(in->expected.beta * ROOT_3_HALF_Q15, 15U);
    const int32_t along = fx_asr(in->expected.alpha, 1U);
    const int32_t expected[SUPERVISION_PHASES] = {in->expected.alpha, across - along,
                                                  -across - along};
    const int32_t measured[SUPERVISION_PHASES] = {in->a, in->b, -in->a - in->b};
    absent_t absent = {.phase = NO_PHASE, .current = 0};

    for (uint32_t phase = 0U; phase < SUPERVISION_PHASES; phase++) {
        if ((fx_abs(measured[phase]) <= cfg->phase_zero_max) &&
            (fx_abs(expected[phase]) > cfg->phase_range_min)) {
            absent = (absent_t){.phase = phase, .current = fx_abs(measured[phase])};
        }
    }
    return absent;
}

fault_id_t supervision_check_imposed(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_imposed_t *in, fault_t *fault)
{
    const absent_t absent = absent_phase(cfg, in);
    const int32_t voltage = fx_max(fx_abs(in->voltage.d), fx_abs(in->voltage.q));
    const int32_t voltage_max = cfg->voltage_max + in->emf;
    const bool excess = lasts(&state->unexplained, voltage > voltage_max, cfg->swing_periods);
    fault_id_t id = FAULT_NONE;

    state->absent_periods = (absent.phase == state->absent) ? (state->absent_periods + 1U) : 0U;
    state->absent = absent.phase;
    if ((absent.phase != NO_PHASE) && (excess || (state->absent_periods > cfg->swing_periods))) {
        id = FAULT_LOST_PHASE;
        *fault = (fault_t){.id = id, .value = absent.current, .limit = cfg->phase_range_min};
    } else if (excess) {
        id = FAULT_CURRENT_IMPLAUSIBLE;
        *fault = (fault_t){.id = id, .value = voltage, .limit = voltage_max};
    } else {
        /* no fault */
    }
    return id;
}

/*
 * A weak phase in the last arc is the reason why the model fails, so its fault replaces this one.
 */
static fault_id_t cause_of(const supervision_t *state, fault_t *fault)
{
    if (state->suspect.id != FAULT_NONE) {
        *fault = state->suspect;
    }
    return fault->id;
}

bool supervision_is_large(const supervision_cfg_t *cfg, dq_t voltage)
{
    return fx_max(fx_abs(voltage.d), fx_abs(voltage.q)) > (2 * cfg->voltage_max);
}

fault_id_t supervision_check_voltage(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_voltage_t *in, fault_t *fault)
{
    const int32_t voltage = fx_max(fx_abs(in->voltage.d), fx_abs(in->voltage.q));
    const int32_t voltage_max = (2 * cfg->voltage_max) + fx_asr(in->emf, EMF_SHARE_SHIFT);
    const bool wrong =
        (voltage > voltage_max) && (in->off_reference < fx_asr(cfg->speed_error_max, 1U));
    fault_id_t id = FAULT_NONE;

    if (!in->excused && lasts(&state->unmodelled, wrong, ((uint32_t)1U << cfg->mean_shift) / 2U)) {
        *fault = (fault_t){.id = FAULT_CURRENT_IMPLAUSIBLE, .value = voltage, .limit = voltage_max};
        id = cause_of(state, fault);
    }
    return id;
}

void supervision_forget_flux(supervision_t *state)
{
    state->flux_q30 = FLUX_OF_FILE_Q30;
    state->flux_periods = 0U;
    state->flux_off = 0U;
}

/*
 * Returns the allowed change of the EMF: a share of the EMF, and a part for dead time and
 * resistance. In healthy drives whose files do not fit, changes of up to half of this limit were
 * measured.
 */
static int32_t emf_change_max(const supervision_cfg_t *cfg, int32_t emf)
{
    return fx_asr(emf, 4U) + fx_asr(emf, 6U) + fx_asr(cfg->voltage_max, 2U);
}

fault_id_t supervision_check_flux(supervision_t *state, const supervision_cfg_t *cfg,
                                  int32_t flux_q30, int32_t emf, fault_t *fault)
{
    const uint32_t shift = cfg->mean_shift + FLUX_TIME_SHIFT;
    const int32_t change_q14 = fx_asr(fx_abs(flux_q30 - state->flux_q30), Q30_TO_Q14);
    const int32_t change = fx_asr(change_q14 * emf, 14U);
    const int32_t change_max = emf_change_max(cfg, emf);
    fault_id_t id = FAULT_NONE;

    if (state->flux_periods < ((uint32_t)1U << shift)) {
        state->flux_periods++;
        state->flux_q30 = flux_q30;
    } else if (lasts(&state->flux_off, change > change_max,
                     (uint32_t)1U << (cfg->mean_shift / 2U))) {
        *fault = (fault_t){.id = FAULT_FLUX_IMPLAUSIBLE, .value = change, .limit = change_max};
        id = cause_of(state, fault);
    } else {
        state->flux_q30 = fx_approach(state->flux_q30, flux_q30, shift);
    }
    return id;
}

/* Adds a sample to a mean. Returns the mean before this sample. */
static int32_t average(int32_t *sum, int32_t sample, uint32_t shift)
{
    const int32_t before = *sum;
    int32_t mean;

    /*@ assert before < -0x48000000 || -0x48000000 <= before < 0 ||
               0 <= before <= 0x48000000 || before > 0x48000000; */
    mean = fx_asr(before, shift);
    *sum = before + (sample - mean);
    return mean;
}

fault_id_t supervision_check_current(supervision_t *state, const supervision_cfg_t *cfg,
                                     const supervision_current_t *in, fault_t *fault)
{
    const int32_t d = in->excused ? 0 : (in->reference.d - in->current.d);
    const int32_t q = in->excused ? 0 : (in->reference.q - in->current.q);
    const int32_t mean_d = average(&state->off_current.d, d, cfg->mean_shift);
    const int32_t mean_q = average(&state->off_current.q, q, cfg->mean_shift);
    const int32_t error = fx_max(fx_abs(mean_d), fx_abs(mean_q));
    fault_id_t id = FAULT_NONE;

    if (error > cfg->follow_error_max) {
        id = FAULT_LOST_PHASE;
        *fault = (fault_t){.id = id, .value = error, .limit = cfg->follow_error_max};
    }
    return id;
}

fault_id_t supervision_check_observer(supervision_t *state, const supervision_cfg_t *cfg,
                                      dq_t error, fault_t *fault)
{
    const int32_t larger = fx_max(fx_abs(error.d), fx_abs(error.q));
    const int32_t mean = average(&state->residual, larger, cfg->mean_shift);
    fault_id_t id = FAULT_NONE;

    if (mean > cfg->residual_max) {
        *fault = (fault_t){.id = FAULT_OBSERVER_LOST, .value = mean, .limit = cfg->residual_max};
        id = cause_of(state, fault);
    }
    return id;
}

/*
 * Whether the rotor has stalled. A rotor that turns against the torque is not stalled while the
 * torque brakes it: each time it has become slower by stall_speed, the count begins anew. The speed
 * is compared with the speed when this happened last, so ripple of the estimate does not count as
 * braking.
 */
static bool is_stalled(supervision_t *state, const supervision_cfg_t *cfg,
                       const supervision_speed_t *in)
{
    const step_t onwards = (in->current_ref < 0) ? -in->speed : in->speed;
    const bool stuck = in->torque_at_limit && (fx_abs(in->current_ref) >= cfg->stall_current) &&
                       (onwards < cfg->stall_speed);
    const bool against = state->onwards <= -cfg->stall_speed;
    const bool reversed = !against && (onwards <= -cfg->stall_speed);

    if ((state->stalled == 0U) || reversed) {
        state->onwards = onwards;
    } else if (against && ((onwards - state->onwards) >= cfg->stall_speed)) {
        state->onwards = onwards;
        state->stalled = 0U;
    } else {
        /* it stands, or it has not become slower by stall_speed */
    }
    return lasts(&state->stalled, stuck, cfg->stall_periods);
}

fault_id_t supervision_check_speed(supervision_t *state, const supervision_cfg_t *cfg,
                                   const supervision_speed_t *in, fault_t *fault)
{
    const int32_t speed = fx_abs(in->speed);
    const int32_t off = fx_abs(in->speed - in->reference);
    const bool off_reference = (off > cfg->speed_error_max) && !in->torque_at_limit;
    fault_t found = {.id = FAULT_NONE};

    if (lasts(&state->runaway, speed >= in->speed_limit, cfg->runaway_periods)) {
        found = (fault_t){FAULT_SPEED_IMPLAUSIBLE, speed, in->speed_limit, 0U};
    }
    if (lasts(&state->off_reference, off_reference, cfg->speed_error_periods)) {
        found = (fault_t){FAULT_SPEED_IMPLAUSIBLE, off, cfg->speed_error_max, 0U};
    }
    if (lasts(&state->too_fast, speed > cfg->overspeed, cfg->overspeed_periods)) {
        found = (fault_t){FAULT_OVERSPEED, speed, cfg->overspeed, 0U};
    }
    if (is_stalled(state, cfg, in)) {
        found = (fault_t){FAULT_STALL, speed, cfg->stall_speed, 0U};
    }
    if (found.id != FAULT_NONE) {
        *fault = found;
    }
    return found.id;
}

fault_id_t supervision_count_late(supervision_t *state, const supervision_cfg_t *cfg,
                                  fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    if (state->late <= cfg->late_max) { /* a larger count does not matter */
        state->late++;
    }
    if (state->late > cfg->late_max) {
        id = FAULT_LATE;
        *fault =
            (fault_t){.id = id, .value = (int32_t)state->late, .limit = (int32_t)cfg->late_max};
    }
    return id;
}

void supervision_forget_late(supervision_t *state, const supervision_cfg_t *cfg)
{
    state->late_periods++;
    if (state->late_periods >= cfg->late_window) {
        state->late_periods = 0U;
        state->late = 0U;
    }
}
