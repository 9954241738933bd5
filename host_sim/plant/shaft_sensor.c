/* SPDX-License-Identifier: MIT */
#include "shaft_sensor.h"

#include "check.h"
#include "rotation.h"

#include <math.h>

#define COUNTS_MIN 4U
#define COUNTS_MAX 65536U
#define POLE_PAIRS_MAX 50U
#define FRAME_COUNTS 16384.0
#define FRAME_MASK 0x3FFFU
#define PARITY_BIT 0x8000U
#define ALL_LEVELS 7U
#define TICK_Q8 256
#define BEGIN 51234 /* the counter's first number, as a timer has any when the firmware begins */

static bool has_rising_edges(const plant_shaft_cfg_t *cfg)
{
    bool good = cfg->edges_turns[PLANT_HALL_SECTORS - 1U] < cfg->edges_turns[0] + 1.0;
    for (unsigned k = 1; good && k < PLANT_HALL_SECTORS; k++) {
        good = cfg->edges_turns[k] > cfg->edges_turns[k - 1U];
    }
    return good;
}

static bool has_patterns(const plant_shaft_cfg_t *cfg)
{
    bool good = true;
    for (unsigned k = 0; k < PLANT_HALL_SECTORS; k++) {
        good = good && cfg->patterns[k] <= ALL_LEVELS;
    }
    return good;
}

bool plant_shaft_init(plant_shaft_t *shaft, const plant_shaft_cfg_t *cfg, const char **bad_field)
{
    const bool hall = cfg->kind == PLANT_SHAFT_HALL;
    const bool encoder = cfg->kind == PLANT_SHAFT_ENCODER;
    const plant_check_t checks[] = {
        {"shaft.counts", !encoder || (cfg->counts >= COUNTS_MIN && cfg->counts <= COUNTS_MAX)},
        {"shaft.zero_turns", isfinite(cfg->zero_turns)},
        {"shaft.pole_pairs", !hall || (cfg->pole_pairs >= 1U && cfg->pole_pairs <= POLE_PAIRS_MAX)},
        {"shaft.edges_turns", !hall || has_rising_edges(cfg)},
        {"shaft.patterns", !hall || has_patterns(cfg)},
    };
    *bad_field = plant_first_bad(checks, sizeof checks / sizeof checks[0]);
    *shaft = (plant_shaft_t){.cfg = *cfg};
    return *bad_field == NULL;
}

static double fraction(double turns)
{
    return turns - floor(turns);
}

static unsigned sector_at(const plant_shaft_cfg_t *cfg, double turns)
{
    const double angle = fraction(turns - cfg->edges_turns[0]);
    unsigned sector = 0;
    for (unsigned k = 1; k < PLANT_HALL_SECTORS; k++) {
        sector = angle >= cfg->edges_turns[k] - cfg->edges_turns[0] ? k : sector;
    }
    return sector;
}

/* Which part of the way since the last reading lies behind the edge that was passed last. */
static double share_since_edge(const plant_shaft_cfg_t *cfg, double from, double to)
{
    const unsigned sector = sector_at(cfg, to);
    const unsigned edge = to > from ? sector : (sector + 1U) % PLANT_HALL_SECTORS;
    const double way = to > from ? to - cfg->edges_turns[edge] : cfg->edges_turns[edge] - to;
    return fraction(way) / fabs(to - from);
}

static plant_shaft_reading_t sense_hall(plant_shaft_t *shaft, double turns)
{
    const plant_shaft_cfg_t *const cfg = &shaft->cfg;
    const uint16_t now = cfg->patterns[sector_at(cfg, turns)];
    unsigned age = shaft->age_q8 + (unsigned)TICK_Q8;
    if (shaft->begun && now != shaft->levels) {
        age = (unsigned)(share_since_edge(cfg, shaft->turns, turns) * TICK_Q8) + 1U;
    }
    shaft->age_q8 = (uint16_t)(age > UINT16_MAX ? UINT16_MAX : age);
    shaft->levels = now;
    shaft->turns = turns;
    return (plant_shaft_reading_t){.reading = now, .age_q8 = cfg->timed ? shaft->age_q8 : 0U};
}

/* Counts that are a whole number of turns from the index, between two others. */
static bool passes_index(int64_t from, int64_t to, int64_t counts, int64_t *at)
{
    const int64_t low = from < to ? from : to;
    const int64_t high = from < to ? to : from;
    *at = (int64_t)floor((double)high / (double)counts) * counts;
    return *at > low;
}

static plant_shaft_reading_t count(plant_shaft_t *shaft, double turns)
{
    const plant_shaft_cfg_t *const cfg = &shaft->cfg;
    const double way = (turns - cfg->zero_turns) * (cfg->reversed ? -1.0 : 1.0);
    const int64_t now = (int64_t)floor(way * cfg->counts);
    if (!shaft->begun) {
        shaft->begin = BEGIN - now;
        shaft->count = now;
    }
    int64_t at = 0;
    plant_shaft_reading_t reading = {.reading = (uint16_t)(now + shaft->begin)};
    reading.indexed = passes_index(shaft->count, now, (int64_t)cfg->counts, &at);
    if (reading.indexed) {
        shaft->index = (uint16_t)(at + shaft->begin);
    }
    reading.index = shaft->index;
    shaft->count = now;
    return reading;
}

static uint16_t frame(const plant_shaft_cfg_t *cfg, double turns)
{
    const double told = fraction((cfg->reversed ? -turns : turns) + cfg->zero_turns);
    unsigned bits = (unsigned)floor(told * FRAME_COUNTS + 0.5) & FRAME_MASK;
    unsigned odd = 0;
    for (unsigned rest = bits; rest != 0U; rest >>= 1U) {
        odd ^= rest & 1U;
    }
    return (uint16_t)(bits | (odd != 0U ? PARITY_BIT : 0U));
}

static plant_shaft_reading_t transfer(plant_shaft_t *shaft, double turns)
{
    const uint16_t now = frame(&shaft->cfg, turns);
    const plant_shaft_reading_t reading = {.reading = shaft->begun ? shaft->frame : now};
    shaft->frame = now;
    return reading;
}

plant_shaft_reading_t plant_shaft_read(plant_shaft_t *shaft, double angle_mech_rad)
{
    const double turns = angle_mech_rad / PLANT_TWO_PI;
    plant_shaft_reading_t reading = {.reading = 0};
    if (shaft->cfg.kind == PLANT_SHAFT_HALL) {
        reading = sense_hall(shaft, turns * shaft->cfg.pole_pairs);
    } else if (shaft->cfg.kind == PLANT_SHAFT_ENCODER) {
        reading = count(shaft, turns);
    } else if (shaft->cfg.kind == PLANT_SHAFT_ABSOLUTE) {
        reading = transfer(shaft, turns);
    } else {
        reading.reading = 0;
    }
    shaft->begun = true;
    return reading;
}
