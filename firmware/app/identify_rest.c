/* SPDX-License-Identifier: MIT */
#include "identify_rest.h"

#include "identify_aim.h"
#include "instant.h"
#include "trig.h"

#include <stddef.h>

#define THIRD_TURN (0x55555555U)
#define HALF_TURN (0x80000000U)
#define ONE_Q16 (65536)
/* rate or ramp with which the vector gets to its angle or speed in a few ticks */
#define FASTEST (0x20000000)
#define QUARTERS (4)

/* ---- PULSE ---- */

#define PULSE_PATTERNS (16)
#define PULSE_TICKS_MOST (64)
/*
 * A phase is open if its current is below 1/8 of the largest current. With an open phase, a pulse
 * on its axis causes no current, and pulses on the two other axes cause 3/4 of the usual current.
 * With saliency, the smallest current of the three axes is at least 0.4 of the largest.
 */
#define OPEN_SHARE (8)
/*
 * The current sensors follow late if pulses of twice the time with 5/8 of the voltage have more
 * than 13/8 of the current. Without a lag they have 5/4 of the current. Saturating iron alone
 * cannot cause 13/8.
 */
#define LAG_EIGHTHS (13)
/* peaks of at least 1/64 of the continuous current are above the converter's noise */
#define LAG_LEAST_SHARE (64)
#define TWO_PI_Q16 (411775)
#define TOO_SALIENT \
    "L_q is so much larger than L_d that only a current holds the rotor that is too small for this board's sensors, it takes at least "

static const char *const open_phases[IDENTIFY_AXES] = {"phase a is open", "phase b is open",
                                                       "phase c is open"};

static void aim_axis(identify_t *identify)
{
    const angle_t angle = identify->rest.axis * THIRD_TURN;

    identify_aim_set(identify, PROBE_ANGLE, fx_signed(angle));
}

static void aim_pulse(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;

    identify_aim_current(identify, 0);
    identify_aim_set(identify, PROBE_RATE, FASTEST);
    aim_axis(identify);
    identify_aim_set(identify, PROBE_PULSE_D, rest->pulse);
    identify_aim_set(identify, PROBE_PULSE_TICKS, rest->quarter);
    identify_aim_window(identify, "pulse", identify->ms_ticks,
                        QUARTERS * rest->quarter * PULSE_PATTERNS);
}

/* Notes the peak current of the pulses that have ended. */
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

/*
 * Returns the largest peak current in any direction, because exchanged wires turn the current away
 * from the pulse.
 */
static int32_t largest_answer(const identify_rest_t *rest)
{
    int32_t largest = 0;

    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        largest = fx_max(largest, fx_max(fx_abs(rest->peaks[axis].d), fx_abs(rest->peaks[axis].q)));
    }
    return largest;
}

/*
 * Computes L from the difference between two pulses: the voltage that the legs lose is the same in
 * both, so it cancels.
 */
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

/*
 * The currents of pulses on the three axes are m + b·cos(2·(angle − rotor)). Returns b, a measure
 * of how different they are. m + b is the current of a pulse along the flux, in proportion to
 * 1/L_d, and m − b the current of a pulse across it. The voltage that the legs lose is the same on
 * each axis, so it reduces m and b by the same share.
 */
static int32_t unlike_peaks(const identify_rest_t *rest)
{
    const int32_t ab = rest->peaks[0].d - rest->peaks[1].d;
    const int32_t bc = rest->peaks[1].d - rest->peaks[2].d;
    const int32_t ca = rest->peaks[2].d - rest->peaks[0].d;
    const int64_t squares =
        ((int64_t)ab * (int64_t)ab) + ((int64_t)bc * (int64_t)bc) + ((int64_t)ca * (int64_t)ca);
    const int64_t mean = (2 * squares) / 9;

    return (int32_t)trig_sqrt((uint32_t)mean);
}

/*
 * Returns half of φ/(L_q − L_d): a current of φ/(L_q − L_d) or more does not hold the rotor. L
 * comes from the axis with the largest peak current p, so L_d = L·p/(m + b), L_q = L·p/(m − b). φ
 * comes from the configuration; for a name plate it is the usual φ for its speed and the bus.
 * emf_q13 is Ω_b·φ/U_b, Ω_b is 2^(15 + shift) steps per tick, and a turn has 2^32 steps. So φ in
 * volt-ticks is emf·2^(4−shift)/2π.
 */
static int32_t find_stiff_current(const identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const drive_cfg_t *const cfg = identify->app->drive.cfg;
    const int64_t mean = (int64_t)rest->mean;
    const int64_t apart = (int64_t)rest->unlike;
    const int64_t product = (mean * mean) - (apart * apart);
    const uint64_t emf = (uint64_t)(uint32_t)cfg->current_loop.emf_q13;
    const uint64_t steps = emf << (34U - cfg->speed_shift);
    const int64_t volts = (int64_t)steps / TWO_PI_Q16;
    const int64_t answer = (2 * apart * (int64_t)largest_peak(rest)) + 1;
    int32_t stiff = 1;

    if (product > 0) {
        const int64_t difference_q16 = ((int64_t)rest->inductance_q16 * answer) / product;

        stiff = identify_aim_bounded((volts * ONE_Q16) / (difference_q16 + 1), 1, FX_Q15_MAX);
    }
    return stiff;
}

/*
 * Whether the pulses cause enough current to show which phases are connected. The drive itself
 * would find a lost phase much later.
 */
static bool shows_current(const identify_t *identify)
{
    return largest_answer(&identify->rest) >= (identify_aim_continuous(identify) / 16);
}

/*
 * Notes whether the current sensors follow late: low-pass filtered, a short pulse seems smaller
 * than a long one.
 */
static void note_lag(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const bool shows = rest->before >= (identify_aim_continuous(identify) / LAG_LEAST_SHARE);
    const bool more = (8 * largest_peak(rest)) > (LAG_EIGHTHS * rest->before);

    if (rest->longer && shows && more) {
        rest->lag = true;
    }
}

/*
 * Enlarges the pulses in small steps once they cause a visible current. Before that it doubles
 * them: first the voltage, then the time.
 */
static void enlarge_pulse(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const int32_t peak = largest_peak(rest);
    const int32_t most = fx_asr(identify->app->drive.bus, 2U);
    const int32_t more = rest->pulse + (rest->pulse / 4);

    rest->before = peak;
    rest->fine = shows_current(identify) && (more <= most);
    rest->longer = !rest->fine && ((2 * rest->pulse) > most);
    if (rest->fine) {
        rest->pulse = more;
    } else if (rest->longer) {
        rest->pulse = (rest->pulse * 5) / 8;
        rest->quarter *= 2;
    } else {
        rest->pulse *= 2;
    }
}

/*
 * Returns why the peak currents of the three axes cannot be those of a motor; NULL: they can. If
 * the current is turned on one axis only, this is not a reason here: STILL judges an unlike phase
 * by its resistance.
 */
static const char *find_wrong_phase(const identify_rest_t *rest)
{
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
            why = open_phases[axis];
        } else if (fx_abs(peak.q) > peak.d) {
            turned++;
        } else {
            straight = axis;
        }
    }
    /*
     * An open phase also turns the currents on the other axes. So if a phase is open, this is the
     * reason.
     */
    if ((why == NULL) && (turned == IDENTIFY_AXES)) {
        why =
            "a current sensor is reversed, or the wires or the sensors of all three phases are exchanged";
    }
    if ((why == NULL) && (turned == 2U)) {
        why = crossed[straight];
    }
    return why;
}

/* Judges the pulses of one size on all three axes. Returns whether PULSE goes on. */
static bool judge_pulses(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const bool enough =
        rest->fine && (largest_peak(rest) >= (identify_aim_continuous(identify) / 4));
    const char *const why = shows_current(identify) ? find_wrong_phase(rest) : NULL;

    note_lag(identify);
    if (why != NULL) {
        identify_aim_refusal(identify, why);
    } else if (enough) {
        find_inductance(rest);
        rest->unlike = unlike_peaks(rest);
        rest->mean = (rest->peaks[0].d + rest->peaks[1].d + rest->peaks[2].d) / 3;
        rest->stiff_current = find_stiff_current(identify);
        if (identify_aim_is_enough(identify, TOO_SALIENT)) {
            identify_aim_phase(identify, IDENTIFY_CATCH);
        }
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
        rest->pulse = fx_max(fx_asr(identify->app->drive.bus, 8U), 1);
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

#define CATCH_MOVES (10U)  /* steps of current and angle before the first look */
#define CATCH_HALFWAY (2U) /* the move in which the vector begins to turn */
/* largest number of looks of 100 ms each: a swing has 4 s to calm down */
#define CATCH_LOOKS (40U)
#define CATCH_RISE_MS (30)  /* settling time of each move */
#define CATCH_TURN_MS (400) /* time in which the vector turns by half a turn */
#define CATCH_LOOK_MS (100)
#define CALM_SHARE (16) /* a calm rotor has |i_q| below 1/16 of the current plus the noise */
#define TRY_MS (500)
#define TRY_PATTERNS (16)
#define TRY_DOUBT (3)
#define TRIES_MOST (4U) /* largest number of tries after which the current is lowered */
#define TRY_UNLIKE_SHARE (8)
#define STEADY_LOOKS (5U)
/* largest noise of some thousand samples, over the mean change from one sample to the next */
#define NOISE_PEAK (5)

static step_t turn_rate(const identify_t *identify, int32_t half_turn_ms)
{
    return INT32_MAX / (half_turn_ms * identify->ms_ticks);
}

/*
 * Whether the rotor has come to rest. If it swings or slips, |i_q| rises above the largest sample
 * of the noise. Unlike windings cause a constant i_q: if the mean of i_q stays the same for
 * STEADY_LOOKS looks, the rotor is at rest too.
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
 * Sets up the next move of the vector or, after the moves, the next window of 100 ms that shows
 * whether the rotor is at rest. First a small current rises at the angle opposite to the target
 * angle of the rotor. Then the vector turns to the target angle in two quarter turns. Then the
 * current rises to its full value. So the rotor falls into a weak field, and its EMF does not drive
 * an over-current.
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
        /* the target angle of the rotor */
    }
    identify_aim_current(identify, (identify_aim_continuous(identify) * share) / 8);
    identify_aim_gains(identify, IDENTIFY_GAINS_SOFT);
    identify_aim_set(identify, PROBE_RAMP, FASTEST);
    identify_aim_set(identify, PROBE_SPEED, 0);
    if (step >= CATCH_HALFWAY) {
        identify_aim_set(identify, PROBE_RATE, turn_rate(identify, CATCH_TURN_MS));
    }
    identify_aim_set(identify, PROBE_ANGLE, fx_signed(angle));
    if (looks) {
        identify_aim_window(identify, "catch", 0, CATCH_LOOK_MS * identify->ms_ticks);
    } else {
        identify_aim_window(identify, "catch", CATCH_RISE_MS * identify->ms_ticks,
                            identify->ms_ticks);
    }
}

/*
 * Whether a try is needed. φ of a name plate may be wrong by a factor. So a salient rotor is tried
 * with 1.5 times stiff_current: a rotor that this current does not hold turns away from the vector.
 * No try is needed if three times the current of the experiments would still hold the rotor, or if
 * L_q/L_d is below 9/7.
 */
static bool is_to_be_tried(const identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;

    return ((rest->stiff_current / TRY_DOUBT) < identify_rest_largest(identify)) &&
           ((TRY_UNLIKE_SHARE * rest->unlike) > rest->mean) && (identify->turn.slower == 0U);
}

static void aim_try(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const int32_t most = (identify->app->drive.cfg->derating.current_max * 7) / 8;
    const int32_t current = fx_min(rest->stiff_current + (rest->stiff_current / 2), most);
    const int32_t eighth = current / 8;
    const int64_t volts = ((int64_t)rest->inductance_q16 * (int64_t)eighth) / ONE_Q16;
    const int32_t limit = fx_max(fx_asr(identify->app->drive.bus, 2U), 1);
    const int32_t quarter = identify_aim_bounded(1 + (volts / limit), 1, PULSE_TICKS_MOST);

    identify_aim_current(identify, current);
    identify_aim_set(identify, PROBE_PULSE_D, identify_aim_bounded(volts / quarter, 0, limit));
    identify_aim_set(identify, PROBE_PULSE_TICKS, quarter);
    identify_aim_window(identify, "catch", TRY_MS * identify->ms_ticks,
                        TRY_PATTERNS * QUARTERS * quarter);
}

/*
 * Whether the rotor is off the vector by an angle δ of more than 15 degrees. A pulse along the
 * vector changes i_q by b·sin 2δ and i_d by m + b·cos 2δ.
 */
static bool lies_beside(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const dq_t change = identify_aim_sums(identify)->change;
    const int64_t across = (int64_t)fx_abs(change.q) * (int64_t)(rest->mean + rest->unlike);

    return (2 * across) > ((int64_t)fx_max(change.d, 0) * (int64_t)rest->unlike);
}

/*
 * Judges a try. A rotor that lies off the vector is caught again with 3/4 of the current; otherwise
 * STILL begins. If the rotor lies off the vector in every try, there is another cause, such as
 * unlike windings. STILL finds it, with the current that follows from the pulses. Returns whether
 * the rotor is caught again.
 */
static bool judge_try(identify_t *identify)
{
    identify_rest_t *const rest = &identify->rest;
    const bool beside = lies_beside(identify);
    bool again = false;

    rest->tries = false;
    if (beside && (rest->tried < TRIES_MOST)) {
        rest->tried++;
        rest->stiff_current = (rest->stiff_current * 3) / 4;
        identify->step = 0U;
        again = identify_aim_is_enough(identify, TOO_SALIENT);
    } else {
        if (beside) {
            rest->stiff_current = find_stiff_current(identify);
        }
        identify_aim_phase(identify, IDENTIFY_STILL);
    }
    return again;
}

static bool leave_catch(identify_t *identify)
{
    const bool tries = is_to_be_tried(identify);

    if (tries) {
        identify->rest.tries = true;
        aim_try(identify);
    } else {
        /* a rotor that was lost is caught again to go on with SPIN */
        identify_aim_phase(identify,
                           (identify->turn.slower == 0U) ? IDENTIFY_STILL : IDENTIFY_SPIN);
    }
    return tries;
}

bool identify_rest_plan_catch(identify_t *identify)
{
    const bool looked = identify->step > CATCH_MOVES;
    bool aims = true;

    if (identify->rest.tries && !judge_try(identify)) {
        aims = false;
    } else if (looked && (identify->step > 0U) && swings_no_more(identify)) {
        aims = leave_catch(identify);
    } else if (identify->step > (CATCH_MOVES + CATCH_LOOKS)) {
        refuse_restless(identify);
        aims = false;
    } else {
        aim_catch(identify);
        identify->step++;
    }
    return aims;
}

/* ---- STILL ---- */

#define LEVELS (14U)
/* R comes from the first level and this one, which has 0.41 of the first level's current */
#define LEVEL_FOR_R (5U)
/*
 * The rotor moves if the voltage of a level changes by more than 1/8 of R·i until the level comes
 * again. A winding that gets warm changes it by less. A phase is found unlike by more
 * (UNLIKE_SHARE).
 */
#define UNSTEADY_SHARE (8)
#define UNSTEADY_ONE (256)
/*
 * If a voltage is wrong by a share, R of a phase is wrong by at most 4 times this share. The two
 * levels for R are 0.59 of the current apart, so R of an axis is wrong by 1.7 times the share. R of
 * a phase is wrong by twice as much as R of an axis.
 */
#define UNSTEADY_TIMES (4)
#define TOO_HEAVY \
    "the rotor swings too slowly for this current: take inertia off, or allow more continuous current"
#define LEVEL_SETTLE_MS (20)
/* settling time after the vector has come to an axis; then follow one look or more */
#define AXIS_SETTLE_MS (100)
#define BURSTS (10U)
#define BURST_ROUNDS (2U)
#define BURST_TICKS (256) /* ticks of all pulse patterns of a burst, about */
/* R of a phase may differ by 1/4 from the middle R, because sensors or wires are not alike */
#define UNLIKE_SHARE (4)

int32_t identify_rest_largest(const identify_t *identify)
{
    const int32_t most = (identify->app->drive.cfg->derating.current_max * 9) / 10;

    const int32_t stiff = identify->rest.stiff_current;
    const int32_t held = (stiff > 0) ? fx_min(most, stiff) : most;

    return fx_min(held, 2 * identify_aim_continuous(identify));
}

/*
 * Returns the text that names an open phase; NULL: each phase has some current. Along the axis of
 * an open phase no current flows; along another axis it flows in the other two phases.
 */
static const char *find_open_phase(const identify_t *identify)
{
    const app_t *const app = identify->app;
    const sample_t sample = instant_sample(&app->drive, &app->in);
    const int32_t current[IDENTIFY_AXES] = {sample.phase_a, sample.phase_b,
                                            -sample.phase_a - sample.phase_b};
    const int32_t largest =
        fx_max(fx_max(fx_abs(current[0]), fx_abs(current[1])), fx_abs(current[2]));
    const char *open = NULL;

    if (largest < (identify_aim_asked_current(identify) / OPEN_SHARE)) {
        open = open_phases[identify->rest.axis];
    }
    for (uint32_t phase = 0U; (open == NULL) && (phase < IDENTIFY_AXES); phase++) {
        if (fx_abs(current[phase]) < (largest / OPEN_SHARE)) {
            open = open_phases[phase];
        }
    }
    return open;
}

void identify_rest_refuse(identify_t *identify, const char *why)
{
    const char *const open = find_open_phase(identify);

    identify_aim_refusal(identify, (open != NULL) ? open : why);
}

/*
 * Sets up the next level. The levels go down, and three of them come again on the way up: this
 * shows whether the winding gets warm.
 */
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
    uint8_t bias; /* imposed current, in 1/16 of the continuous current */
    uint8_t along;
    uint8_t across;
    bool slow; /* repeats the burst before with half of the voltage and twice as many ticks */
} burst_t;

/*
 * Returns the burst of a step. A slow burst has the same current as the burst before it, so the
 * iron is equally saturated in both. Along the imposed current, their difference shows sensors that
 * follow late. Across it, their difference shows the rotor's motion during the pulses.
 */
static const burst_t *burst_of(uint32_t step)
{
    static const burst_t bursts[BURSTS] = {{8, 3, 0, false},  {16, 6, 0, false}, {16, 6, 0, true},
                                           {5, 4, 0, false},  {3, 2, 0, false},  {2, 0, 6, false},
                                           {2, 0, 11, false}, {2, 0, 11, true},  {2, 0, 16, false},
                                           {8, 0, 14, false}};

    return &bursts[(step - LEVELS) % BURSTS];
}

/*
 * Returns the volt-ticks for pulses of this current. Across the imposed current, the voltage that
 * the legs lose changes its sign with the current and is a large part of a small pulse. So there
 * the result is the volt-ticks of the pulses before, plus L times the difference in current.
 */
static int64_t volts_for(const identify_rest_t *rest, bool along, int64_t current)
{
    const int64_t more = current - (int64_t)rest->across_current;

    return along ? ((current * rest->along_q16) / ONE_Q16)
                 : (rest->across_volts + ((more * rest->across_q16) / ONE_Q16));
}

static void aim_patterns(identify_t *identify, int32_t quarter)
{
    const int32_t patterns = fx_max(BURST_TICKS / (QUARTERS * quarter), 1);

    identify_aim_set(identify, PROBE_PULSE_TICKS, quarter);
    identify_aim_window(identify, "burst", LEVEL_SETTLE_MS * identify->ms_ticks,
                        patterns * QUARTERS * quarter);
}

/* Sets up the slow burst. If the pulses cannot be made longer, they are repeated as they are. */
static void aim_slow_burst(identify_t *identify)
{
    const int32_t quarter = 2 * identify_aim_word(identify, PROBE_PULSE_TICKS);

    if (quarter <= PULSE_TICKS_MOST) {
        identify_aim_set(identify, PROBE_PULSE_D, identify_aim_word(identify, PROBE_PULSE_D) / 2);
        identify_aim_set(identify, PROBE_PULSE_Q, identify_aim_word(identify, PROBE_PULSE_Q) / 2);
        aim_patterns(identify, quarter);
    }
}

/*
 * Sets up pulses that are as short as a voltage of 3/8 of the bus allows. If they lie along the
 * imposed current, pulses and imposed current together are at most 7/8 of the largest current: the
 * current control holds its voltage along the pulses, so ripple of the bus changes the mean
 * current.
 */
static void aim_fast_burst(identify_t *identify)
{
    const identify_rest_t *const rest = &identify->rest;
    const burst_t *const burst = burst_of(identify->step);
    const bool along = burst->along > 0U;
    const int64_t current = ((int64_t)identify_aim_continuous(identify) *
                             ((int64_t)burst->along + (int64_t)burst->across)) /
                            16;
    const int64_t volts = volts_for(rest, along, current);
    const int32_t most = fx_max(fx_asr(identify->app->drive.bus * 3, 3U), 1);
    const int64_t needed = 1 + (volts / most);
    const int32_t quarter = identify_aim_bounded(needed, 1, PULSE_TICKS_MOST);
    const int64_t each = volts / quarter;
    const int32_t most_bias = ((identify_rest_largest(identify) * 7) / 8) - (int32_t)current;
    const int32_t bias = (identify_aim_continuous(identify) * (int32_t)burst->bias) / 16;

    identify_aim_current(identify, along ? fx_max(fx_min(bias, most_bias), 0) : bias);
    identify_aim_set(identify, along ? PROBE_PULSE_D : PROBE_PULSE_Q,
                     identify_aim_bounded(each, 0, most));
    aim_patterns(identify, quarter);
}

static void aim_burst(identify_t *identify)
{
    if (burst_of(identify->step)->slow) {
        aim_slow_burst(identify);
    } else {
        aim_fast_burst(identify);
    }
}

/*
 * Notes L across the imposed current, from the difference between two pulses of unlike current. One
 * pulse alone is not enough, because a small one may hardly overcome the voltage that the legs
 * lose.
 */
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

/*
 * Notes L from the pulses that have ended, because L falls as the current rises. Slow bursts are
 * not noted, because no plan needs their L.
 */
static void note_burst(identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int64_t ticks_q16 = (int64_t)identify->aim.ticks * 65536;
    const int32_t quarter = identify_aim_word(identify, PROBE_PULSE_TICKS);
    const int32_t along = identify_aim_word(identify, PROBE_PULSE_D);
    const int32_t across = identify_aim_word(identify, PROBE_PULSE_Q);

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
            identify_rest_refuse(identify, "the bus voltage is too low for the current");
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

/*
 * Notes how much the voltage changes until a level comes again. A rotor that swings too slowly for
 * the looks induces such a change.
 */
static void note_twice(identify_t *identify)
{
    static const uint8_t pairs[IDENTIFY_TWICE][2] = {{2, 14}, {5, 13}, {8, 12}};
    identify_rest_t *const rest = &identify->rest;
    const int32_t voltage = identify_aim_sums(identify)->voltage.d / identify->aim.ticks;
    const int32_t current = identify_aim_sums(identify)->current.d / identify->aim.ticks;
    const int32_t resistive = (rest->resistance_q13[rest->axis] * current) / 8192;

    for (uint32_t k = 0U; k < IDENTIFY_TWICE; k++) {
        if (identify->step == (uint32_t)pairs[k][0]) {
            rest->first_voltage[k] = voltage;
        } else if (identify->step == (uint32_t)pairs[k][1]) {
            const int32_t apart = fx_abs(voltage - rest->first_voltage[k]);
            const int32_t share = (apart * UNSTEADY_ONE) / fx_max(resistive, 1);

            rest->unsteady = fx_max(rest->unsteady, fx_min(share, UNSTEADY_ONE));
        } else {
            /* another level */
        }
    }
}

static void note_still(identify_t *identify)
{
    if ((identify->step > 0U) && (identify->step <= LEVELS)) {
        note_level(identify);
        note_twice(identify);
    } else if ((identify->step > LEVELS) && !burst_of(identify->step - 1U)->slow) {
        note_burst(identify);
    } else {
        /* a look at the axis, or a slow burst */
    }
}

/*
 * Returns R of a phase, Q13 of U_b/I_b. On the axis of a phase the whole current flows through this
 * phase, and half of it back through each other phase: R_axis = 2/3·R_phase + 1/6·(both others) =
 * (R_phase + mean of the three axes)/2.
 */
static int32_t phase_resistance(const identify_rest_t *rest, uint32_t phase)
{
    const int32_t sum = rest->resistance_q13[0] + rest->resistance_q13[1] + rest->resistance_q13[2];

    return (2 * rest->resistance_q13[phase]) - (sum / 3);
}

/*
 * Whether the rotor moves enough during the levels to explain the difference `off` between R of a
 * phase and the middle R. A shorted phase moves the rotor too, but less.
 */
static bool is_by_motion(const identify_rest_t *rest, int32_t middle, int32_t off)
{
    const int32_t explained = (UNSTEADY_TIMES * rest->unsteady * middle) / UNSTEADY_ONE;

    return (rest->unsteady > (UNSTEADY_ONE / UNSTEADY_SHARE)) && (explained >= off);
}

/*
 * Returns whether the three phases are alike. If R of one is far from the middle R, ends the
 * identification.
 */
static bool are_alike(identify_t *identify)
{
    static const char *const names[IDENTIFY_AXES] = {"a", "b", "c"};
    uint32_t low = 0U;
    uint32_t high = 0U;
    int32_t r[IDENTIFY_AXES];
    int32_t middle;
    int32_t most;
    int32_t off;

    for (uint32_t phase = 0U; phase < IDENTIFY_AXES; phase++) {
        r[phase] = phase_resistance(&identify->rest, phase);
        low = (r[phase] < r[low]) ? phase : low;
        high = (r[phase] > r[high]) ? phase : high;
    }
    middle = (r[0] + r[1] + r[2]) - (r[low] + r[high]);
    most = (middle / UNLIKE_SHARE) + 1;
    off = fx_max(middle - r[low], r[high] - middle);
    if (off <= most) {
        /* the three phases are alike */
    } else if (is_by_motion(&identify->rest, middle, off)) {
        identify_rest_refuse(identify, TOO_HEAVY);
    } else if ((middle - r[low]) > most) {
        identify_aim_refusal_of(
            identify,
            "less than 3/4 of the resistance of the other phases, is the winding shorted: phase ",
            names[low]);
    } else {
        identify_aim_refusal_of(
            identify,
            "more than 5/4 of the resistance of the other phases, is a contact bad: phase ",
            names[high]);
    }
    return identify->phase != IDENTIFY_ENDS;
}

/*
 * Leaves an axis whose levels and pulses have ended. SPIN follows after the last axis. Returns
 * whether STILL goes on.
 */
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

/*
 * Judges a look on a new axis, where the rotor swings for a while, and sets up another look if
 * needed.
 */
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
        /* the rotor is looked at once more */
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
