/* SPDX-License-Identifier: MIT */
#include "identify_rest.h"

#include "identify_aim.h"

#include <stddef.h>

#define THIRD_TURN (0x55555555U)
#define HALF_TURN (0x80000000U)
#define ONE_Q16 (65536)
#define FASTEST (0x20000000) /* the vector is there in a few ticks */
#define QUARTERS (4)

/* ---- PULSE ---- */

#define PULSE_PATTERNS (16)
#define PULSE_TICKS_MOST (64)
/* An open phase leaves its own axis no current and the two others 3/4; saliency leaves one 0.4 of another at least. */
#define OPEN_SHARE (8)

static void aim_axis(identify_t *identify)
{
    const angle_t angle = identify->rest.axis * THIRD_TURN;

    *identify_aim_word(identify, PROBE_ANGLE) = fx_signed(angle);
}

static void aim_pulse(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;

    identify_aim_current(identify, 0);
    *identify_aim_word(identify, PROBE_RATE) = FASTEST;
    aim_axis(identify);
    *identify_aim_word(identify, PROBE_PULSE_D) = rest->pulse;
    *identify_aim_word(identify, PROBE_PULSE_TICKS) = rest->quarter;
    identify_aim_window(identify, "pulse", identify->ms_ticks,
                        QUARTERS * rest->quarter * PULSE_PATTERNS);
}

/* The current at the peak of the pulses that have ended. */
static void note_peak(identify_t *identify)
{
    const dq_t change = identify_aim_sums(identify)->change;
    const int32_t quarters = QUARTERS * PULSE_PATTERNS;

    identify->rest.peaks[identify->rest.axis] = (dq_t){change.d / quarters, change.q / quarters};
}

static int32_t largest_peak(const identify_rest_t *rest)
{
    return fx_max(fx_max(rest->peaks[0].d, rest->peaks[1].d), rest->peaks[2].d);
}

/* In any direction: exchanged wires turn the current away from the pulse. */
static int32_t largest_answer(const identify_rest_t *rest)
{
    int32_t largest = 0;

    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        largest = fx_max(largest, fx_max(fx_abs(rest->peaks[axis].d), fx_abs(rest->peaks[axis].q)));
    }
    return largest;
}

/* What the legs lose is the same in two pulses: it cancels in their difference. */
static void find_inductance(identify_rest_t *rest)
{
    const int64_t more = fx_max(largest_peak(rest) - rest->before, 1);
    const int64_t volts = ((int64_t)rest->pulse * (int64_t)rest->quarter) / 5;
    const int64_t ratio = (volts * 65536) / more;

    rest->inductance_q16 = identify_aim_bounded(ratio, 0, INT32_MAX);
    rest->along_q16 = rest->inductance_q16;
    rest->across_q16 = rest->inductance_q16;
    rest->across_volts = 0;
    rest->across_current = 0;
}

/* So large a current says which phases are connected, long before the drive misses one. */
static bool shows_current(const identify_t *identify)
{
    return largest_answer(&identify->rest) >= (identify_aim_continuous(identify) / 16);
}

/* In small steps once a current shows; twice as much before, first of the voltage, then of the time. */
static void enlarge_pulse(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const int32_t peak = largest_peak(rest);
    const int32_t most = fx_asr(identify->app->drive.signals.bus, 2U);
    const int32_t more = rest->pulse + (rest->pulse / 4);

    rest->before = peak;
    rest->fine = shows_current(identify) && (more <= most);
    if (rest->fine) {
        rest->pulse = more;
    } else if ((2 * rest->pulse) <= most) {
        rest->pulse *= 2;
    } else {
        rest->pulse = (rest->pulse * 5) / 8;
        rest->quarter *= 2;
    }
}

/*
 * Why the answers of the three axes are not those of a motor; NULL: they may be. One turned axis is no reason here: a phase that
 * stands out is judged by its resistance.
 */
static const char *find_wrong_phase(const identify_rest_t *rest)
{
    static const char *const open[IDENTIFY_AXES] = {"phase a is open", "phase b is open",
                                                    "phase c is open"};
    static const char *const crossed[IDENTIFY_AXES] = {
        "the wires or the current sensors of phases b and c are exchanged",
        "the wires or the current sensors of phases a and c are exchanged",
        "the wires or the current sensors of phases a and b are exchanged",
    };
    const int32_t least = largest_answer(rest) / OPEN_SHARE;
    const char *why = NULL;
    uint32_t turned = 0U;
    uint32_t straight = 0U;

    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        const dq_t peak = rest->peaks[axis];

        if ((fx_abs(peak.d) < least) && (fx_abs(peak.q) < least)) {
            why = open[axis];
        } else if (fx_abs(peak.q) > peak.d) {
            turned++;
        } else {
            straight = axis;
        }
    }
    /* An open phase turns the current of the others: where there is one, it is the reason. */
    if ((why == NULL) && (turned == IDENTIFY_AXES)) {
        why =
            "a current sensor is reversed, or the wires or the sensors of all three phases are exchanged";
    }
    if ((why == NULL) && (turned == 2U)) {
        why = crossed[straight];
    }
    return why;
}

/* All three axes have answered to pulses of this size. */
static bool judge_pulses(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const bool enough =
        rest->fine && (largest_peak(rest) >= (identify_aim_continuous(identify) / 4));
    const char *const why = shows_current(identify) ? find_wrong_phase(rest) : NULL;

    if (why != NULL) {
        identify_aim_refusal(identify, why);
    } else if (enough) {
        find_inductance(rest);
        identify_aim_phase(identify, IDENTIFY_CATCH);
    } else {
        enlarge_pulse(identify);
        if (rest->quarter > PULSE_TICKS_MOST) {
            identify_aim_refusal(identify, "no current flows: is the motor connected?");
        }
    }
    return identify->phase == IDENTIFY_PULSE;
}

bool identify_rest_plan_pulse(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    bool aims = true;

    if (identify->step == 0U) {
        rest->pulse = fx_max(fx_asr(identify->app->drive.signals.bus, 8U), 1);
        rest->quarter = 1;
    } else {
        note_peak(identify);
        rest->axis = (rest->axis + 1U) % IDENTIFY_AXES;
        aims = (rest->axis > 0U) || judge_pulses(identify);
    }
    if (aims) {
        aim_pulse(identify);
        identify->step++;
    }
    return aims;
}

/* ---- CATCH ---- */

#define CATCH_MOVES (10U)
#define CATCH_HALFWAY (2U)  /* the move in which the vector begins to turn */
#define CATCH_LOOKS (40U)   /* of 100 ms each: 4 s for a swing to calm down */
#define CATCH_RISE_MS (30)  /* each */
#define CATCH_TURN_MS (400) /* half a turn */
#define CATCH_LOOK_MS (100)
#define CALM_SHARE (16)
#define STEADY_LOOKS (5U)
#define NOISE_PEAK \
    (5) /* largest of some thousand samples, over the mean change from one to the next */

static step_t turn_rate(const identify_t *identify, int32_t half_turn_ms)
{
    return INT32_MAX / (half_turn_ms * identify->ms_ticks);
}

/*
 * |i_q| of a rotor that swings or slips, beyond what noise has for its largest sample. Windings that differ have a mean of
 * i_q, which stays for STEADY_LOOKS.
 */
static bool swings_no_more(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int32_t noise = fx_max(sums->noise_a, sums->noise_b) / identify->aim.ticks;
    const int32_t most = (identify_aim_asked_current(identify) / CALM_SHARE) + (NOISE_PEAK * noise);
    const int32_t mean = sums->current.q / identify->aim.ticks;
    const int32_t swing = sums->across - fx_abs(mean);

    if ((swing < most) && (fx_abs(mean - rest->mean_across) < (most / 2))) {
        rest->steady++;
    } else {
        rest->steady = 0U;
        rest->mean_across = mean;
    }
    return (sums->across < most) || (rest->steady >= STEADY_LOOKS);
}

static void refuse_restless(identify_t *identify)
{
    identify_aim_refusal(identify,
                         "the rotor does not come to rest on the current: does a load turn it?");
}

/*
 * A small current rises opposite to where the rotor is to be, the vector turns there in two quarters, and the rest of the
 * current follows. A rotor that falls into the field falls into a small one: its EMF drives no over-current.
 */
static void aim_catch(identify_t *identify)
{
    static const uint8_t eighths[CATCH_MOVES] = {1, 2, 2, 2, 3, 4, 5, 6, 7, 8};
    const uint32_t step = identify->step;
    const bool looks = step >= CATCH_MOVES;
    const int32_t share = looks ? 8 : (int32_t)eighths[step];
    angle_t angle = 0U;

    if (step < CATCH_HALFWAY) {
        angle = HALF_TURN;
    } else if (step == CATCH_HALFWAY) {
        angle = HALF_TURN / 2U;
    } else {
        /* where it is to be */
    }
    identify_aim_current(identify, (identify_aim_continuous(identify) * share) / 8);
    identify_aim_gains(identify, IDENTIFY_GAINS_SOFT);
    *identify_aim_word(identify, PROBE_RAMP) = FASTEST;
    *identify_aim_word(identify, PROBE_SPEED) = 0;
    if (step >= CATCH_HALFWAY) {
        *identify_aim_word(identify, PROBE_RATE) = turn_rate(identify, CATCH_TURN_MS);
    }
    *identify_aim_word(identify, PROBE_ANGLE) = fx_signed(angle);
    if (looks) {
        identify_aim_window(identify, "catch", 0, CATCH_LOOK_MS * identify->ms_ticks);
    } else {
        identify_aim_window(identify, "catch", CATCH_RISE_MS * identify->ms_ticks,
                            identify->ms_ticks);
    }
}

bool identify_rest_plan_catch(identify_t *identify)
{
    const bool looked = identify->step > CATCH_MOVES;

    if (looked && swings_no_more(identify)) {
        /* the second time it is for those who turn it */
        identify_aim_phase(identify,
                           (identify->turn.slower == 0U) ? IDENTIFY_STILL : IDENTIFY_SPIN);
    } else if (identify->step > (CATCH_MOVES + CATCH_LOOKS)) {
        refuse_restless(identify);
    } else {
        aim_catch(identify);
        identify->step++;
    }
    return identify->phase == IDENTIFY_CATCH;
}

/* ---- STILL ---- */

#define LEVELS (14U)
#define LEVEL_FOR_R (5U) /* with the first one it gives R: half of its current */
#define LEVEL_SETTLE_MS (20)
#define AXIS_SETTLE_MS (100) /* and then a look at least */
#define BURSTS (8U)
#define BURST_ROUNDS (2U)
#define BURST_TICKS (256)
#define UNLIKE_SHARE \
    (4) /* R of a phase may be 1/4 off that in the middle: mismatch of sensors, unlike wires */

int32_t identify_rest_largest(const identify_t *identify)
{
    const int32_t most = (identify->app->drive.cfg->derating.current_max * 9) / 10;

    return fx_min(most, 2 * identify_aim_continuous(identify));
}

/* Down, and up again in between: so a winding that gets warm shows. */
static void aim_level(identify_t *identify)
{
    static const uint8_t shares[LEVELS] = {255, 205, 164, 131, 105, 84,  67,
                                           54,  43,  34,  27,  54,  105, 205};
    const int32_t share = (int32_t)shares[identify->step];

    identify_aim_current(identify, (identify_rest_largest(identify) * share) / 256);
    identify_aim_window(identify, "still", LEVEL_SETTLE_MS * identify->ms_ticks,
                        IDENTIFY_AIM_WINDOW_MS * identify->ms_ticks);
}

typedef struct {
    uint8_t bias; /* in 1/16 of the continuous current */
    uint8_t along;
    uint8_t across;
} burst_t;

/*
 * Volt-ticks for pulses of so much current. Across, what the legs lose changes its sign with the current and is a large part
 * of a small pulse: the pulses before say what a current takes, and L what more of it takes.
 */
static int64_t volts_for(const identify_rest_t *rest, bool along, int64_t current)
{
    const int64_t more = current - (int64_t)rest->across_current;

    return along ? ((current * rest->along_q16) / ONE_Q16)
                 : (rest->across_volts + ((more * rest->across_q16) / ONE_Q16));
}

/*
 * Pulses of so much current, as short as the voltage allows: 3/8 of the bus. The sum of both is at most 7/8 of the largest
 * current: while the current control holds its voltage along the pulses, a ripple of the bus changes the mean current.
 */
static void aim_burst(identify_t *identify)
{
    static const burst_t bursts[BURSTS] = {{8, 3, 0}, {16, 6, 0}, {5, 4, 0},  {3, 2, 0},
                                           {2, 0, 6}, {2, 0, 11}, {2, 0, 16}, {8, 0, 14}};
    const identify_rest_t *const rest = &identify->rest;
    const burst_t *const burst = &bursts[(identify->step - LEVELS) % BURSTS];
    const bool along = burst->along > 0U;
    const int64_t current = ((int64_t)identify_aim_continuous(identify) *
                             ((int64_t)burst->along + (int64_t)burst->across)) /
                            16;
    const int64_t volts = volts_for(rest, along, current);
    const int32_t most = fx_max(fx_asr(identify->app->drive.signals.bus * 3, 3U), 1);
    const int64_t needed = 1 + (volts / most);
    const int32_t quarter = identify_aim_bounded(needed, 1, PULSE_TICKS_MOST);
    const int64_t each = volts / quarter;
    const int32_t patterns = fx_max(BURST_TICKS / (QUARTERS * quarter), 1);
    const int32_t most_bias = ((identify_rest_largest(identify) * 7) / 8) - (int32_t)current;
    const int32_t bias = (identify_aim_continuous(identify) * (int32_t)burst->bias) / 16;

    identify_aim_current(identify, along ? fx_max(fx_min(bias, most_bias), 0) : bias);
    *identify_aim_word(identify, along ? PROBE_PULSE_D : PROBE_PULSE_Q) =
        identify_aim_bounded(each, 0, most);
    *identify_aim_word(identify, PROBE_PULSE_TICKS) = quarter;
    identify_aim_window(identify, "burst", LEVEL_SETTLE_MS * identify->ms_ticks,
                        patterns * QUARTERS * quarter);
}

/* L across, of two pulses of unlike current. The smaller one may hardly overcome what the legs lose. */
static void note_across(identify_rest_t *rest, int32_t volts, int32_t current)
{
    const int32_t more = current - rest->across_current;

    if ((rest->across_current > 0) && (fx_abs(more) > (current / 8))) {
        const int64_t ratio = ((int64_t)(volts - rest->across_volts) * 65536) / more;

        rest->across_q16 = identify_aim_bounded(ratio, rest->inductance_q16 / 2, INT32_MAX);
    }
    rest->across_volts = volts;
    rest->across_current = current;
}

/* L of the pulses that have ended: it falls with the current. */
static void note_burst(identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int64_t ticks_q16 = (int64_t)identify->aim.ticks * 65536;
    const int32_t quarter = *identify_aim_word(identify, PROBE_PULSE_TICKS);
    const int32_t along = *identify_aim_word(identify, PROBE_PULSE_D);
    const int32_t across = *identify_aim_word(identify, PROBE_PULSE_Q);

    if ((along > 0) && (sums->change.d > 0)) {
        identify->rest.along_q16 =
            identify_aim_bounded((ticks_q16 * along) / sums->change.d, 0, INT32_MAX);
    }
    if ((across > 0) && (sums->change.q > 0)) {
        note_across(&identify->rest, across * quarter,
                    (sums->change.q / identify->aim.ticks) * quarter);
    }
}

static void note_level(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const int32_t ticks = identify->aim.ticks;
    const int32_t voltage = identify_aim_sums(identify)->voltage.d / ticks;
    const int32_t current = identify_aim_sums(identify)->current.d / ticks;

    if (identify->step == 1U) {
        rest->high_voltage = voltage;
        rest->high_current = current;
        if (current < ((identify_aim_asked_current(identify) * 7) / 8)) {
            identify_aim_refusal(identify, "the bus voltage is too low for the current");
        }
    } else if (identify->step == LEVEL_FOR_R) {
        const int32_t apart = fx_max(rest->high_current - current, 1);
        const int32_t found = (fx_max(rest->high_voltage - voltage, 0) * 8192) / apart;

        rest->resistance_q13[rest->axis] = fx_min(found, FX_Q15_MAX);
        rest->loss = fx_max(voltage - ((rest->resistance_q13[rest->axis] * current) / 8192), 0);
    } else {
        /* for the record only */
    }
}

static void note_still(identify_t *identify)
{
    if ((identify->step > 0U) && (identify->step <= LEVELS)) {
        note_level(identify);
    } else if (identify->step > LEVELS) {
        note_burst(identify);
    } else {
        /* the vector has come to this axis */
    }
}

/*
 * R of a phase, Q13. Along the axis of a phase flows its whole current, and half of it back through each other one:
 * R_axis = 2/3·R_phase + 1/6·(both others) = (R_phase + mean of the three axes)/2.
 */
static int32_t phase_resistance(const identify_rest_t *rest, uint32_t phase)
{
    const int32_t sum = rest->resistance_q13[0] + rest->resistance_q13[1] + rest->resistance_q13[2];

    return (2 * rest->resistance_q13[phase]) - (sum / 3);
}

/* Refuses a phase whose R is far from that in the middle. */
static bool are_alike(identify_t *identify)
{
    static const char *const names[IDENTIFY_AXES] = {"a", "b", "c"};
    uint32_t low = 0U;
    uint32_t high = 0U;
    int32_t r[IDENTIFY_AXES];
    int32_t middle;
    int32_t most;

    for (uint32_t phase = 0U; phase < IDENTIFY_AXES; phase++) {
        r[phase] = phase_resistance(&identify->rest, phase);
        low = (r[phase] < r[low]) ? phase : low;
        high = (r[phase] > r[high]) ? phase : high;
    }
    middle = (r[0] + r[1] + r[2]) - (r[low] + r[high]);
    most = (middle / UNLIKE_SHARE) + 1;
    if ((middle - r[low]) > most) {
        identify_aim_refusal_of(
            identify,
            "less than 3/4 of the resistance of the other phases, is the winding shorted: phase ",
            names[low]);
    } else if ((r[high] - middle) > most) {
        identify_aim_refusal_of(
            identify,
            "more than 5/4 of the resistance of the other phases, is a contact bad: phase ",
            names[high]);
    } else {
        /* three windings of a kind */
    }
    return identify->phase != IDENTIFY_ENDS;
}

/* The levels and pulses of an axis have ended. */
static bool leave_axis(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;

    if ((rest->axis + 1U) < IDENTIFY_AXES) {
        rest->axis++;
        rest->looks = 1U;
        identify->step = 0U;
        identify_aim_current(identify, identify_aim_continuous(identify));
        aim_axis(identify);
        identify_aim_window(identify, "catch", AXIS_SETTLE_MS * identify->ms_ticks,
                            CATCH_LOOK_MS * identify->ms_ticks);
    } else if (are_alike(identify)) {
        identify_aim_phase(identify, IDENTIFY_SPIN);
    } else {
        /* refused */
    }
    return identify->phase == IDENTIFY_STILL;
}

/* The vector has come to the next axis, and the rotor swings there for a while. */
static void look_again(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;

    if (swings_no_more(identify)) {
        rest->looks = 0U;
    } else if (rest->looks > CATCH_LOOKS) {
        refuse_restless(identify);
    } else {
        rest->looks++;
        identify_aim_window(identify, "catch", 0, CATCH_LOOK_MS * identify->ms_ticks);
    }
}

bool identify_rest_plan_still(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    bool aims = true;

    note_still(identify);
    if (rest->looks > 0U) {
        look_again(identify);
    }
    if (identify->phase == IDENTIFY_ENDS) {
        aims = false;
    } else if (rest->looks > 0U) {
        /* it is looked at once more */
    } else if (identify->step < LEVELS) {
        aim_level(identify);
        identify->step++;
    } else if (identify->step < (LEVELS + (BURST_ROUNDS * BURSTS))) {
        aim_burst(identify);
        identify->step++;
    } else {
        aims = leave_axis(identify);
    }
    return aims;
}
