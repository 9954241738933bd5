/* SPDX-License-Identifier: MIT */
#include "identify.h"

#include "crc32.h"
#include "fault_text.h"
#include "identify_aim.h"
#include "identify_heat.h"
#include "identify_rest.h"
#include "identify_turn.h"
#include "probing.h"

#include <stddef.h>

#define MS_PS (1000000000U)
#define WINDOW_NUMBERS (0x7FFU)
#define CURRENT_ONE (32768) /* I_b in Q15 */
/*
 * a measurement is accepted if the mean change of a current sensor from sample to sample is at most
 * 1/16 of the continuous current
 */
#define NOISE_SHARE (16)
/* a longer move of the vector is given up; the longest ramp of the first attempt takes 3 s */
#define LONGEST_MOVE_MS (5000U)
#define HALL_MOVE_SHIFT (2U)
#define BRAKING_HELP \
    ": a supply that takes power back or a brake resistor helps, or a lower max_speed_rpm"
/* an identification that takes longer is ended; usually it takes 10 to 30 s, with its lines */
#define LONGEST_MS (120000U)

/* ---- the words of an experiment ---- */

static uint32_t ticks_passed(const identify_t *identify)
{
    return identify->app->drive.tick - identify->since;
}

static bool has_settled(const identify_t *identify)
{
    return ticks_passed(identify) >= fx_unsigned(identify->aim.settle);
}

static void wait_for(identify_t *identify, identify_wait_t wait)
{
    identify->wait = wait;
    identify->since = identify->app->drive.tick;
}

static void post(identify_t *identify, uint32_t which)
{
    const drive_command_t command = {
        .target = identify->aim.words[which],
        .mode = (uint8_t)(which + (uint32_t)PROBE_CURRENT),
        .request = DRIVE_REQUEST_PROBE,
    };

    command_mailbox_post(&identify->app->mailbox, &command);
    identify->in_force[which] = command.target;
}

/* Whether the word that was posted last has reached the drive. */
static bool word_is_taken(const identify_t *identify)
{
    const drive_command_t asked = command_mailbox_take(&identify->app->mailbox);
    const drive_command_t *const now = &identify->app->in.command;

    return (now->mode == asked.mode) && (now->target == asked.target) &&
           (now->request == asked.request);
}

/*
 * Posts the next word that is not in force yet, except the word of the window. Returns true if no
 * such word is left.
 */
static bool ask(identify_t *identify)
{
    bool complete = true;

    for (uint32_t k = 0U; (k < (IDENTIFY_WORDS - 1U)) && complete; k++) {
        if (identify->aim.words[k] != identify->in_force[k]) {
            post(identify, k);
            complete = false;
        }
    }
    return complete;
}

/*
 * Posts the word of the window. It contains the number of the window, so it differs from the words
 * of earlier windows.
 */
static void ask_for_window(identify_t *identify)
{
    const uint32_t number = identify->windows & WINDOW_NUMBERS;
    const uint32_t window = (number << PROBE_WINDOW_BITS) | fx_unsigned(identify->aim.ticks);

    identify->windows++;
    identify_aim_set(identify, PROBE_WINDOW, fx_signed(window));
    post(identify, IDENTIFY_WORDS - 1U);
}

static bool is_measured(const identify_t *identify)
{
    return word_is_taken(identify) &&
           probe_is_done(&identify->app->drive.probe, identify->in_force[IDENTIFY_WORDS - 1U]);
}

static bool has_arrived(const identify_t *identify)
{
    const drive_t *const drive = &identify->app->drive;
    const probe_t *const probe = &drive->probe;
    const bool turns = (probe->own_speed == probe->speed) && (probe->speed != 0);
    const bool rests =
        (probe->own_speed == 0) && (rotor_position_angle(&drive->vector.position) == probe->angle);

    return identify->aim.rushes || turns || rests;
}

/* ---- lines ---- */

static void add_word(text_t *text, int32_t value)
{
    text_add(text, " ");
    text_number(text, value, 0U);
}

static void add_words(text_t *text, dq_t value)
{
    add_word(text, value.d);
    add_word(text, value.q);
}

/* Adds ` #` and the CRC to a record. `text` contains only this record. */
static void end_record(identify_t *identify, text_t *text)
{
    identify->crc = text_crc(identify->crc, text->characters, text->length);
    text_add(text, " #");
    text_hex(text, ~identify->crc);
}

static void say_scales(identify_t *identify, text_t *text)
{
    const about_t *const about = identify->about;

    identify->crc = CRC32_START;
    text_add(text, "identify 2");
    add_word(text, (int32_t)about->rotation.tick_ps);
    add_word(text, (int32_t)about->current_full_scale_ua);
    add_word(text, (int32_t)about->bus_full_scale_uv);
    add_word(text, (int32_t)about->rotation.pole_pairs);
    add_word(text, (int32_t)identify->app->drive.cfg->speed_shift);
    end_record(identify, text);
    text_end_line(text);
}

static void add_survey(text_t *text, const hall_survey_t *survey)
{
    add_word(text, survey->start_q16);
    add_word(text, survey->turn_q16);
    for (uint32_t k = 0U; k < HALL_SURVEY_SIGNALS; k++) {
        add_words(text, survey->signals[k].middle);
        add_word(text, survey->signals[k].high);
    }
}

static void say_record(identify_t *identify, text_t *text)
{
    static const probe_word_t shown[] = {PROBE_CURRENT, PROBE_SPEED, PROBE_PULSE_D, PROBE_PULSE_Q,
                                         PROBE_PULSE_TICKS};
    const probe_sums_t *const sums = identify_aim_sums(identify);

    text_add(text, "= ");
    text_add(text, identify->aim.kind);
    add_word(text, (int32_t)identify->rest.axis);
    for (uint32_t k = 0U; k < (uint32_t)(sizeof(shown) / sizeof(shown[0])); k++) {
        add_word(text, identify->aim.words[(uint32_t)shown[k] - (uint32_t)PROBE_CURRENT]);
    }
    add_word(text, identify->aim.ticks);
    add_words(text, sums->voltage);
    add_words(text, sums->current);
    add_word(text, sums->bus);
    add_word(text, sums->noise_a);
    add_word(text, sums->noise_b);
    add_words(text, sums->change);
    add_word(text, sums->turn_q16);
    add_word(text, sums->across);
    add_word(text, sums->torque);
    if (identify->phase == IDENTIFY_HALL) {
        add_survey(text, &identify->app->shaft->survey);
    }
    end_record(identify, text);
    text_end_line(text);
}

static int32_t milliamperes(const identify_t *identify, int32_t current)
{
    return units_thousandths(current, CURRENT_ONE, 2U * identify->about->current_full_scale_ua);
}

static void add_amperes(text_t *text, int32_t current_ma)
{
    text_number(text, current_ma, 3U);
    text_add(text, " A");
}

static void say_end(identify_t *identify, text_t *text)
{
    if (identify->why == NULL) {
        text_add(text, "identify done");
        end_record(identify, text);
    } else {
        text_add(text, "identify refused: ");
        text_add(text, identify->why);
        text_add(text, identify->detail);
        if (identify->rest.lag) {
            text_add(text,
                     "; the current sensors follow late, as behind a low pass: pulses of twice the "
                     "time show much more current");
        }
    }
    if (identify->needed > 0) {
        /* rounded up, so that a name plate with this current is accepted */
        add_amperes(text, milliamperes(identify, identify->needed) + 1);
    }
}

/*
 * Adds the highest speed of the rotor: the highest speed of the vector, and a third more because
 * the rotor swings.
 */
static void add_highest_speed(const identify_t *identify, text_t *text, const char *before)
{
    const step_t speed = identify_turn_speed(identify);

    text_add(text, before);
    text_number(text, units_rpm(&identify->about->rotation, speed + (speed / 3)), 0U);
    text_add(text, " rpm");
}

/* Adds the line before a phase. It says how the shaft will move, with which current and speed. */
static void say_phase(identify_t *identify, text_t *text)
{
    const int32_t continuous = milliamperes(identify, identify_aim_continuous(identify));

    switch (identify->phase) {
    case IDENTIFY_PULSE:
        text_add(text, "pulses on each phase, the shaft hardly moves, up to ");
        add_amperes(text, continuous);
        add_highest_speed(identify, text, "; behind them it turns, up to ");
        break;
    case IDENTIFY_CATCH:
        text_add(text, "the shaft turns by up to one and a half electrical turns, with ");
        add_amperes(text, continuous);
        break;
    case IDENTIFY_STILL:
        text_add(text, "the shaft goes to three angles of an electrical turn, up to ");
        add_amperes(text, milliamperes(identify, identify_rest_largest(identify)));
        break;
    case IDENTIFY_SPIN:
        add_highest_speed(identify, text, "the shaft turns, up to ");
        text_add(text, ", with at most ");
        add_amperes(text, continuous);
        break;
    case IDENTIFY_RAMP:
        text_add(text, "between half of that speed and the whole");
        break;
    case IDENTIFY_COAST:
        text_add(text, "no current, the shaft coasts");
        break;
    case IDENTIFY_HALL:
        text_add(text, "the shaft turns backwards, then forwards");
        break;
    default: /* the end */
        say_end(identify, text);
        break;
    }
    text_end_line(text);
}

/* ---- the run of an experiment ---- */

static bool plan_in_phase(identify_t *identify)
{
    bool aims = true; /* true at the end: nothing is left to plan */

    switch (identify->phase) {
    case IDENTIFY_PULSE:
        aims = identify_rest_plan_pulse(identify);
        break;
    case IDENTIFY_CATCH:
        aims = identify_rest_plan_catch(identify);
        break;
    case IDENTIFY_STILL:
        aims = identify_rest_plan_still(identify);
        break;
    case IDENTIFY_SPIN:
        aims = identify_turn_plan_spin(identify);
        break;
    case IDENTIFY_RAMP:
        aims = identify_turn_plan_ramp(identify);
        break;
    case IDENTIFY_COAST:
        aims = identify_turn_plan_coast(identify);
        break;
    case IDENTIFY_HALL:
        aims = identify_turn_plan_hall(identify);
        break;
    default: /* nothing is planned at the end */
        break;
    }
    return aims;
}

static void plan_next(identify_t *identify)
{
    while (!plan_in_phase(identify)) {
        /* the phase has changed: its plan is next */
    }
    if (identify->aim.leads) {
        ask_for_window(identify);
        wait_for(identify, IDENTIFY_LEADING);
    } else {
        wait_for(identify, IDENTIFY_ASKING);
    }
}

/* Returns the largest accepted mean change of a sensor from sample to sample, Q15 of I_b. */
static int32_t noise_most(const identify_t *identify)
{
    return identify_aim_continuous(identify) / NOISE_SHARE;
}

/*
 * Whether the current sensors are too noisy. Only the first pulses on each axis are judged: later,
 * larger pulses and a turning vector change the current themselves.
 */
static bool is_noisy(const identify_t *identify)
{
    const probe_sums_t *const sums = identify_aim_sums(identify);
    const int32_t noise = fx_max(sums->noise_a, sums->noise_b) / identify->aim.ticks;

    return (identify->phase == IDENTIFY_PULSE) && (identify->step <= IDENTIFY_AXES) &&
           (noise > noise_most(identify));
}

static void end_experiment(identify_t *identify, text_t *text)
{
    say_record(identify, text);
    if (is_noisy(identify)) {
        identify_aim_refusal(
            identify, "the noise of the current sensors is too large for the continuous current");
    } else {
        plan_next(identify);
    }
}

/*
 * Call when the drive has taken all words of the experiment. Then waits for the end of the
 * measurement if its window has already begun (`leads`), otherwise for the vector's arrival.
 */
static void have_asked(identify_t *identify)
{
    wait_for(identify, identify->aim.leads ? IDENTIFY_MEASURING : IDENTIFY_MOVING);
}

/*
 * Returns the ticks after which a move of the vector is given up. The longest ramp belongs to SPIN:
 * it goes from 1/4 of the highest speed down to 1/16 of it. The ramps of each further attempt take
 * twice as long. A heavy rotor takes up to four times as long to turn back for the Hall sensors.
 */
static uint32_t longest_move(const identify_t *identify)
{
    const uint32_t ticks = LONGEST_MOVE_MS * fx_unsigned(identify->ms_ticks);

    return ticks << ((identify->phase == IDENTIFY_HALL) ? HALL_MOVE_SHIFT : identify->turn.slower);
}

/*
 * Gives up a move of the vector that takes too long. The rotor is lost, or braking has raised the
 * bus voltage and it does not fall.
 */
static void give_up_moving(identify_t *identify)
{
    if (identify->phase == IDENTIFY_HALL) {
        identify_aim_phase(identify, IDENTIFY_ENDS);
    } else if ((identify->phase == IDENTIFY_RAMP) && !probing_may_brake(&identify->app->drive)) {
        identify_aim_refusal(identify, "the bus stays too high for braking" BRAKING_HELP);
    } else {
        identify_turn_catch_again(identify);
    }
}

/*
 * Begins the survey of the Hall signals. It needs no word, so it ends before the window of as many
 * ticks.
 */
static void begin_survey(const identify_t *identify)
{
    if (identify->phase == IDENTIFY_HALL) {
        hall_survey_begin(&identify->app->shaft->survey, fx_unsigned(identify->aim.ticks));
    }
}

static void go_on(identify_t *identify, text_t *text)
{
    switch (identify->wait) {
    case IDENTIFY_LEADING:
        if (has_settled(identify)) {
            wait_for(identify, IDENTIFY_ASKING);
        }
        break;
    case IDENTIFY_ASKING:
        if (word_is_taken(identify) && ask(identify)) {
            have_asked(identify);
        }
        break;
    case IDENTIFY_MOVING:
        if ((ticks_passed(identify) > 2U) && has_arrived(identify)) {
            wait_for(identify, IDENTIFY_SETTLING);
        } else if (ticks_passed(identify) > longest_move(identify)) {
            give_up_moving(identify);
            plan_next(identify);
        } else {
            /* the vector still moves */
        }
        break;
    case IDENTIFY_SETTLING:
        if (has_settled(identify)) {
            ask_for_window(identify);
            begin_survey(identify);
            wait_for(identify, IDENTIFY_MEASURING);
        }
        break;
    default: /* MEASURING */
        if (is_measured(identify)) {
            end_experiment(identify, text);
        }
        break;
    }
}

void identify_init(identify_t *identify, app_t *app, const about_t *about)
{
    *identify = (identify_t){.app = app, .about = about};
}

/*
 * Begins an identification, from the words that probe_reset() sets. Withdraws a run that the drive
 * has not taken yet.
 */
static void begin_identifying(identify_t *identify)
{
    const uint32_t ticks = MS_PS / identify->about->rotation.tick_ps;
    const uint32_t pulse_ticks = (uint32_t)PROBE_PULSE_TICKS - (uint32_t)PROBE_CURRENT;
    const uint32_t emf = (uint32_t)PROBE_EMF - (uint32_t)PROBE_CURRENT;

    identify_init(identify, identify->app, identify->about);
    identify->before = command_mailbox_take(&identify->app->mailbox);
    identify->before.request = 0U;
    command_mailbox_post(&identify->app->mailbox, &identify->before);
    identify->began = identify->app->drive.tick;
    identify->ms_ticks = fx_max((int32_t)ticks, 1);
    identify->in_force[pulse_ticks] = 1;
    identify->in_force[emf] = 1;
    identify->aim.words[emf] = 1;
    identify_aim_phase(identify, IDENTIFY_BEGINS);
    (void)identify_aim_is_enough(
        identify,
        "the continuous current of the name plate is too small for this board's sensors, it takes at least ");
}

bool identify_is_busy(const identify_t *identify)
{
    return identify->phase != IDENTIFY_IDLE;
}

const char *identify_start(identify_t *identify)
{
    const char *why = NULL;

    if (identify_is_busy(identify)) {
        why = "it is under way";
    } else if (app_changes(identify->app)) {
        /* the identification takes its currents from the configuration */
        why = "the configuration changes in this moment; ask again";
    } else if (identify->about->is_example != 0U) {
        why = "the configuration has an example motor: name the one that is connected, by "
              "`identify PLATE.toml NEW.toml` of motorsim live";
    } else if (identify->app->drive.state != DRIVE_STATE_READY) {
        why = "the drive is not READY";
    } else {
        begin_identifying(identify);
    }
    return why;
}

/*
 * Puts the user's command, without its request, in place of a word of the probe. A request that has
 * come in the meantime stays in force.
 */
static void give_back(identify_t *identify)
{
    const drive_command_t now = command_mailbox_take(&identify->app->mailbox);

    if (now.mode >= (uint8_t)PROBE_CURRENT) {
        drive_command_t command = identify->before;

        command.request = (now.request == DRIVE_REQUEST_PROBE) ? 0U : now.request;
        command_mailbox_post(&identify->app->mailbox, &command);
    }
}

void identify_stop(identify_t *identify)
{
    if (identify_is_busy(identify)) {
        give_back(identify);
        identify->phase = IDENTIFY_IDLE;
    }
}

void identify_refuse(identify_t *identify, const char *why)
{
    if (identify_is_busy(identify) && (identify->phase != IDENTIFY_ENDS)) {
        identify_aim_refusal(identify, why);
        give_back(identify); /* now, because the last line may have to wait */
    }
}

/*
 * Writes the scales, plans the first experiment, and posts a first word, which brings the drive to
 * PROBE.
 */
static void start_probing(identify_t *identify, text_t *text)
{
    say_scales(identify, text);
    identify_aim_phase(identify, IDENTIFY_PULSE);
    plan_next(identify);
    post(identify, 0U);
}

/*
 * Returns the largest current that the experiment itself can cause, Q15 of I_b. A larger current is
 * driven by a turning rotor.
 */
static int32_t runaway_current(const identify_t *identify)
{
    const int32_t pulses = (identify_aim_continuous(identify) * 5) / 4;
    const int32_t fault = identify->app->drive.cfg->protection.current_max;
    const int32_t middle = (identify_rest_largest(identify) + fault) / 2;
    int32_t largest;

    switch (identify->phase) {
    case IDENTIFY_PULSE: /* nothing turns, and no current control acts */
        largest = fx_min(pulses, middle);
        break;
    case IDENTIFY_RAMP: /* a lost rotor is caught again */
    case IDENTIFY_COAST:
    case IDENTIFY_HALL:
        largest = fault;
        break;
    case IDENTIFY_CATCH:
        largest = ((identify->turn.slower > 0U) || identify->rest.tries) ? fault : middle;
        break;
    case IDENTIFY_SPIN:
        largest = identify_turn_seeks_speed(identify) ? middle : fault;
        break;
    default: /* STILL: a rotor falls into the field */
        largest = middle;
        break;
    }
    return largest;
}

static bool runs_away(const identify_t *identify)
{
    const dq_t current = probing_current(&identify->app->drive);

    return (identify->said != IDENTIFY_IDLE) &&
           (fx_max(fx_abs(current.d), fx_abs(current.q)) > runaway_current(identify));
}

static void refuse_runaway(identify_t *identify)
{
    const char *const why = identify->rest.lag
                                ? "more current flows than was asked for"
                                : "more current flows than was asked for: does a load turn the "
                                  "rotor, or do the current sensors follow late?";

    if (identify_turn_lacks_voltage(identify)) {
        identify_turn_refuse_voltage(identify);
    } else if (identify->turn.slower > 0U) {
        identify_turn_refuse_lost(identify);
    } else if (identify->phase == IDENTIFY_STILL) {
        identify_rest_refuse(identify, why);
    } else {
        identify_aim_refusal(identify, why);
    }
}

/* Writes the line of a new phase before anything else. */
static void say_or_go_on(identify_t *identify, text_t *text)
{
    if (identify->said != identify->phase) {
        identify->said = identify->phase;
        say_phase(identify, text);
        if (identify->phase == IDENTIFY_ENDS) {
            identify_stop(identify);
        }
    } else {
        go_on(identify, text);
    }
}

static void add_load(text_t *text, const char *before, int32_t heat_q24)
{
    text_add(text, before);
    text_number(text,
                (int32_t)((((int64_t)heat_q24 * 100) + (DERATING_HEAT_ONE_Q24 / 2)) /
                          DERATING_HEAT_ONE_Q24),
                0U);
    text_add(text, " %");
}

static void wait_for_cooling(identify_t *identify, text_t *text, int32_t most_q24)
{
    if (!identify->wait_is_said) {
        identify->wait_is_said = true;
        add_load(text, "the winding may be at ", identify->app->drive.derating.heat_q24);
        add_load(text, " of its continuous heat; waiting until it is at ", most_q24);
        text_end_line(text);
    }
}

static void begin_when_cool(identify_t *identify, text_t *text)
{
    const int32_t most_q24 = identify_heat_most_q24(identify);

    if (identify->app->drive.derating.heat_q24 <= most_q24) {
        start_probing(identify, text);
    } else {
        wait_for_cooling(identify, text, most_q24);
    }
}

static void take_turn(identify_t *identify, text_t *text)
{
    if (identify->phase == IDENTIFY_BEGINS) {
        begin_when_cool(identify, text);
    } else if ((identify->phase == IDENTIFY_ENDS) ||
               (identify->app->drive.state == DRIVE_STATE_PROBE)) {
        say_or_go_on(identify, text);
    } else {
        /* the drive is still READY: it has not taken the first word yet */
    }
}

/*
 * Whether the identification takes too long, whatever it waits for: the drive, a window, a rotor,
 * or a line that nobody reads.
 */
static bool lasts_too_long(const identify_t *identify)
{
    const uint32_t longest = LONGEST_MS * fx_unsigned(identify->ms_ticks);

    return (identify->app->drive.tick - identify->began) > longest;
}

/*
 * Ends the identification because of a fault. OVERVOLTAGE is due to braking if the rotor moves: a
 * rotor that is braked, swings in the field or is caught by it gives power back. If the rotor
 * rests, the bus is too high for another reason.
 */
static void refuse_fault(identify_t *identify, fault_id_t fault)
{
    const bool braking = (identify->phase == IDENTIFY_CATCH) ||
                         (identify->phase == IDENTIFY_SPIN) || (identify->phase == IDENTIFY_RAMP) ||
                         (identify->phase == IDENTIFY_COAST);

    identify_aim_refusal_of(identify, "the drive has a fault: ",
                            ((fault == FAULT_OVERVOLTAGE) && braking)
                                ? ("OVERVOLTAGE, by braking" BRAKING_HELP)
                                : fault_text(fault)->name);
}

/*
 * Ends the identification if a reason comes from outside. The line of the first phase is written in
 * PROBE, so from then on the drive has to be in PROBE.
 */
static void look_for_end(identify_t *identify)
{
    const drive_t *const drive = &identify->app->drive;

    if (drive->state == DRIVE_STATE_FAULT) {
        refuse_fault(identify, drive->fault.id);
    } else if ((identify->said != IDENTIFY_IDLE) && (drive->state != DRIVE_STATE_PROBE)) {
        identify_aim_refusal(identify, "another command has ended it");
    } else if (runs_away(identify)) {
        refuse_runaway(identify);
    } else if (lasts_too_long(identify)) {
        identify_aim_refusal(identify, "it has not ended within 2 minutes");
    } else {
        /* the identification goes on */
    }
}

void identify_step(identify_t *identify, text_t *text)
{
    if (identify_is_busy(identify)) {
        if (identify->phase != IDENTIFY_ENDS) {
            look_for_end(identify);
        }
        if (text->length == 0U) {
            take_turn(identify, text);
        }
        if (identify->phase == IDENTIFY_ENDS) {
            give_back(identify); /* at once, because the last line may have to wait */
        }
    }
}
