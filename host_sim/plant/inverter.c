/* SPDX-License-Identifier: MIT */
#include "inverter.h"

#include "check.h"

#define TIMER_COUNTS_MIN 2U
#define TIMER_COUNTS_MAX 65536U

/* Largest dead time, as a part of the period. */
#define DEAD_TIME_FRACTION_MAX 0.25

/* Entries of one leg's timeline: its state at the start and six changes. */
#define CHANGES_MAX 7

enum leg_state {
    LEG_LOW,
    LEG_HIGH,
    LEG_OPEN
};

typedef struct {
    unsigned count;
    double time_s[CHANGES_MAX];
    enum leg_state state[CHANGES_MAX];
    bool commanded;
    bool waiting;   /* a dead time runs */
    double ready_s; /* and ends here */
} timeline_t;

static const char *inverter_bad_field(const plant_inverter_cfg_t *cfg)
{
    const plant_check_t checks[] = {
        {"inverter.pwm_frequency_hz", plant_is_positive(cfg->pwm_frequency_hz)},
        {"inverter.timer_counts",
         cfg->timer_counts >= TIMER_COUNTS_MIN && cfg->timer_counts <= TIMER_COUNTS_MAX},
        {"inverter.dead_time_s",
         plant_is_not_negative(cfg->dead_time_s) &&
             cfg->dead_time_s * cfg->pwm_frequency_hz <= DEAD_TIME_FRACTION_MAX},
    };
    return plant_first_bad(checks, sizeof checks / sizeof checks[0]);
}

void plant_inverter_forget(plant_inverter_t *inverter)
{
    inverter->commanded = 0;
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        inverter->dead_left_s[leg] = 0.0;
    }
}

void plant_inverter_set_clock(plant_inverter_t *inverter, double ratio)
{
    inverter->period_s = inverter->configured_period_s / ratio;
    inverter->tick_s = inverter->period_s / (2.0 * (double)inverter->timer_counts);
    inverter->dead_time_s = inverter->configured_dead_time_s / ratio;
}

bool plant_inverter_init(plant_inverter_t *inverter, const plant_inverter_cfg_t *cfg,
                         const char **bad_field)
{
    *bad_field = inverter_bad_field(cfg);
    if (*bad_field != NULL) {
        return false;
    }
    inverter->configured_period_s = 1.0 / cfg->pwm_frequency_hz;
    inverter->configured_dead_time_s = cfg->dead_time_s;
    inverter->timer_counts = cfg->timer_counts;
    plant_inverter_set_clock(inverter, 1.0);
    plant_inverter_forget(inverter);
    return true;
}

/* Adds time to the last segment if nothing switches in between. */
static inline void append(plant_pattern_t *pattern, double duration_s, uint32_t high, uint32_t low)
{
    if (!(duration_s > 0.0)) {
        return;
    }
    plant_segment_t *last = &pattern->segment[pattern->count];
    if (pattern->count > 0U && last[-1].high == high && last[-1].low == low) {
        last[-1].duration_s += duration_s;
        return;
    }
    last->duration_s = duration_s;
    last->high = (uint8_t)high;
    last->low = (uint8_t)low;
    pattern->count++;
}

/* Legs in the order in which they rise: key = compare in the upper, mask in the lower bits. */
static inline void order(uint32_t *first, uint32_t *second)
{
    const uint32_t a = *first;
    const uint32_t b = *second;
    *first = (a > b) ? a : b;
    *second = (a > b) ? b : a;
}

static void pattern_ideal(plant_inverter_t *inverter, const uint32_t compare[PLANT_LEGS],
                          plant_pattern_t *pattern)
{
    uint32_t key[PLANT_LEGS];
    for (uint32_t leg = 0; leg < PLANT_LEGS; leg++) {
        key[leg] = (compare[leg] << 3U) | (1U << leg);
    }
    order(&key[0], &key[1]);
    order(&key[1], &key[2]);
    order(&key[0], &key[1]);

    const uint32_t first = key[0] & PLANT_ALL_LEGS;
    const uint32_t two = first | (key[1] & PLANT_ALL_LEGS);
    const double zero_s = inverter->tick_s * (double)(inverter->timer_counts - (key[0] >> 3U));
    const double one_s = inverter->tick_s * (double)((key[0] >> 3U) - (key[1] >> 3U));
    const double two_s = inverter->tick_s * (double)((key[1] >> 3U) - (key[2] >> 3U));
    append(pattern, zero_s, 0, PLANT_ALL_LEGS);
    append(pattern, one_s, first, PLANT_ALL_LEGS ^ first);
    append(pattern, two_s, two, PLANT_ALL_LEGS ^ two);
    append(pattern, 2.0 * inverter->tick_s * (double)(key[2] >> 3U), PLANT_ALL_LEGS, 0);
    append(pattern, two_s, two, PLANT_ALL_LEGS ^ two);
    append(pattern, one_s, first, PLANT_ALL_LEGS ^ first);
    append(pattern, zero_s, 0, PLANT_ALL_LEGS);
}

static void push(timeline_t *line, double time_s, enum leg_state state)
{
    line->time_s[line->count] = time_s;
    line->state[line->count] = state;
    line->count++;
}

static void close_switch_until(timeline_t *line, double time_s)
{
    if (line->waiting && line->ready_s <= time_s) {
        push(line, line->ready_s, line->commanded ? LEG_HIGH : LEG_LOW);
        line->waiting = false;
    }
}

static void edge(timeline_t *line, double time_s, bool commanded, double dead_time_s)
{
    if (commanded == line->commanded) {
        return;
    }
    close_switch_until(line, time_s);
    if (!line->waiting) {
        push(line, time_s, LEG_OPEN);
    }
    line->commanded = commanded;
    line->waiting = true;
    line->ready_s = time_s + dead_time_s;
}

static void leg_timeline(plant_inverter_t *inverter, uint32_t leg, uint32_t compare,
                         timeline_t *line)
{
    const uint32_t counts = inverter->timer_counts;
    const double dead_s = inverter->dead_time_s;
    line->count = 0;
    line->commanded = ((inverter->commanded >> leg) & 1U) != 0U;
    line->waiting = inverter->dead_left_s[leg] > 0.0;
    line->ready_s = inverter->dead_left_s[leg];
    push(line, 0.0, line->waiting ? LEG_OPEN : (line->commanded ? LEG_HIGH : LEG_LOW));

    edge(line, 0.0, compare == counts, dead_s);
    if (compare > 0U && compare < counts) {
        edge(line, inverter->tick_s * (double)(counts - compare), true, dead_s);
        edge(line, inverter->tick_s * (double)(counts + compare), false, dead_s);
    }
    close_switch_until(line, inverter->period_s);
    inverter->dead_left_s[leg] = line->waiting ? line->ready_s - inverter->period_s : 0.0;
    inverter->commanded &= ~(1U << leg);
    inverter->commanded |= (line->commanded ? 1U : 0U) << leg;
}

/* Merges the three timelines. */
static void pattern_dead_time(plant_inverter_t *inverter, const uint32_t compare[PLANT_LEGS],
                              plant_pattern_t *pattern)
{
    timeline_t line[PLANT_LEGS] = {0};
    unsigned next[PLANT_LEGS] = {1, 1, 1}; /* entry 0 is the state at time 0 */
    for (uint32_t leg = 0; leg < PLANT_LEGS; leg++) {
        leg_timeline(inverter, leg, compare[leg], &line[leg]);
    }
    double now_s = 0.0;
    while (now_s < inverter->period_s) {
        double end_s = inverter->period_s;
        uint32_t mask[3] = {0};
        for (uint32_t leg = 0; leg < PLANT_LEGS; leg++) {
            while (next[leg] < line[leg].count && line[leg].time_s[next[leg]] <= now_s) {
                next[leg]++;
            }
            mask[line[leg].state[next[leg] - 1U]] |= 1U << leg;
            if (next[leg] < line[leg].count && line[leg].time_s[next[leg]] < end_s) {
                end_s = line[leg].time_s[next[leg]];
            }
        }
        append(pattern, end_s - now_s, mask[LEG_HIGH], mask[LEG_LOW]);
        now_s = end_s;
    }
}

void plant_inverter_pattern(plant_inverter_t *inverter, const uint32_t compare[PLANT_LEGS],
                            plant_pattern_t *pattern)
{
    uint32_t clipped[PLANT_LEGS];
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        clipped[leg] =
            (compare[leg] < inverter->timer_counts) ? compare[leg] : inverter->timer_counts;
    }
    pattern->count = 0;
    if (inverter->dead_time_s > 0.0) {
        pattern_dead_time(inverter, clipped, pattern);
    } else {
        pattern_ideal(inverter, clipped, pattern);
    }
}

void plant_inverter_off(plant_inverter_t *inverter, plant_pattern_t *pattern)
{
    plant_inverter_forget(inverter);
    pattern->count = 0;
    append(pattern, inverter->period_s, 0, 0);
}
