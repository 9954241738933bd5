/* SPDX-License-Identifier: MIT */
#include "hall.h"

#include "inlining.h"

#define PATTERN_BITS (3U)
#define PATTERN_MASK (7U)
#define HALF_TURN (0x80000000U)
#define NO_PATTERN (8U)
#define Q16_TO_Q32_SHIFT (16U)
#define UNLIKE_TICKS (4U)
#define TICKS_MAX (0x100000U)
#define SECTOR (0x2AAAAAABU)   /* 60° */
#define LOST_WAY (4U * SECTOR) /* without an edge */
/* A signal that stands still takes away one edge, so the illegal pattern comes at two sectors. */
#define DEAD_WAY ((5U * SECTOR) / 2U)
#define CLOSE (0x0AAAAAA9) /* 15° */
#define NEAR (0x20000000U) /* 45° */
/* Shares of the errors at an edge that are corrected, where its time is known and where it is not.
 */
#define TIMED_SHIFT (2U) /* all but a quarter of the angle's */
#define ANGLE_SHIFT (1U)
#define TIMED_SPEED_SHIFT (1U)
#define SPEED_SHIFT (2U)
#define STEADY_SHIFT (2U) /* the speed is steady if it has changed by less than a quarter */
#define REST_SHIFT (6U)
#define TURNED_SHIFT (4U)
#define HALF_SECTOR (0x15555555)
#define MEASURED_MAX (0x0FFFFFFFU)
#define SPEED_MAX (0x1FFFFFFF)
#define JITTER_TICKS (64U)
#define AGE_SHIFT (8U) /* ages are Q8 of a tick */
#define TICK_Q8 (256)
#define AGE_MEAN (128)      /* an edge lies half a tick before the tick that sees it, on average */
#define SHORT_TICKS (2048U) /* in less, the part of a tick matters */
#define SEEN_UNTIL (2U)

void hall_start(hall_t *hall)
{
    *hall = (hall_t){.seen = NO_PATTERN, .taken = NO_PATTERN};
}

static uint32_t hall_pattern_of(const hall_cfg_t *cfg, uint32_t sector)
{
    return (cfg->patterns >> (PATTERN_BITS * sector)) & PATTERN_MASK;
}

static uint32_t next_sector(uint32_t sector, uint32_t by)
{
    const uint32_t next = sector + by;

    return (next >= HALL_SECTORS) ? (next - HALL_SECTORS) : next;
}

bool hall_order_holds(uint32_t patterns)
{
    const hall_cfg_t cfg = {.patterns = patterns};
    uint32_t found = 0U;
    bool holds = true;

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        const uint32_t pattern = hall_pattern_of(&cfg, k);
        const uint32_t changed = pattern ^ hall_pattern_of(&cfg, next_sector(k, 1U));

        found |= (uint32_t)1U << pattern;
        holds = holds && ((changed == 1U) || (changed == 2U) || (changed == 4U));
    }
    return holds && (found == 0x7EU);
}

static bool fits(const hall_cfg_t *cfg, uint32_t sector, uint32_t pattern, uint32_t dead)
{
    return ((hall_pattern_of(cfg, sector) ^ pattern) & ~dead) == 0U;
}

/* Returns the sectors whose patterns are this one but for the dead signal. */
static hall_span_t span_of(const hall_cfg_t *cfg, uint32_t pattern, uint32_t dead)
{
    hall_span_t span = {0U, 0U};

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        if (fits(cfg, k, pattern, dead)) {
            const bool begins = !fits(cfg, next_sector(k, HALL_SECTORS - 1U), pattern, dead);

            span.first = begins ? (uint8_t)k : span.first;
            span.count++;
        }
    }
    return span;
}

static angle_t begin_of(const hall_cfg_t *cfg, uint32_t sector)
{
    return (angle_t)cfg->edges_q16[sector] << Q16_TO_Q32_SHIFT;
}

static angle_t hall_end_of(const hall_cfg_t *cfg, hall_span_t span)
{
    return begin_of(cfg, next_sector(span.first, span.count));
}

static angle_t middle_of(const hall_cfg_t *cfg, hall_span_t span)
{
    const angle_t begin = begin_of(cfg, span.first);

    return begin + ((hall_end_of(cfg, span) - begin) / 2U);
}

static angle_t width_of(const hall_cfg_t *cfg, hall_span_t span)
{
    return hall_end_of(cfg, span) - begin_of(cfg, span.first);
}

/* Returns the ticks in which a rotor with this pace goes at most so far. */
static uint32_t ticks_of(const hall_t *hall, angle_t way)
{
    const uint32_t pace = fx_unsigned(fx_abs(hall->pace));

    return (pace == 0U) ? UINT32_MAX : (way / pace);
}

/*
 * Decides how long the next edge may take. A slow rotor may take twice the time of its sector, a
 * fast one that of four sectors.
 */
static void expect_edge(hall_t *hall, const hall_cfg_t *cfg)
{
    const uint32_t width = width_of(cfg, hall->span);
    const uint32_t twice = (width < HALF_TURN) ? ((2U * width) + 1U) : UINT32_MAX;
    uint32_t patience;

    hall->fast = fx_abs(hall->pace) >= cfg->fast_speed;
    patience = ticks_of(hall, hall->fast ? LOST_WAY : twice);
    hall->patience = (patience < TICKS_MAX) ? patience : TICKS_MAX;
}

/* Begins the time since an edge, behind which the rotor has this pace. */
static void begin_time(hall_t *hall, const hall_cfg_t *cfg)
{
    hall->ticks = 0U;
    hall->edge_age_q8 = hall->seen_age_q8;
    expect_edge(hall, cfg);
}

/*
 * Returns the signal whose standing still explains an illegal pattern; 0: none. Without it the
 * rotor would be in one of three sectors, 120° apart. It is in the one to which its last speed has
 * brought it since the last edge. After a longer way than such a signal needs, a rotor that is not
 * fast may have stopped; and one that has turned back has no last speed.
 */
static uint32_t dead_signal(const hall_t *hall, const hall_cfg_t *cfg, uint32_t pattern)
{
    const angle_t expected = hall->edge + (fx_unsigned(hall->pace) * hall->ticks);
    const uint32_t farthest = hall->paced ? LOST_WAY : DEAD_WAY;
    uint32_t dead = 0U;

    for (uint32_t bit = 1U; bit <= 4U; bit *= 2U) {
        const angle_t middle = middle_of(cfg, span_of(cfg, pattern ^ bit, 0U));
        const bool near = ((expected - middle) + NEAR) < (2U * NEAR);

        dead = near ? bit : dead;
    }
    return ((hall->pace != 0) && (hall->ticks <= ticks_of(hall, farthest))) ? dead : 0U;
}

static void forget_pace(hall_t *hall)
{
    hall->speed = 0;
    hall->paced = false;
    hall->steady = false;
}

/* The pattern has changed to one that is no neighbour, or nothing was known before. */
static void place(hall_t *hall, const hall_cfg_t *cfg)
{
    hall->angle = middle_of(cfg, hall->span);
    hall->direction = 0;
    hall->turned = false;
    hall->pace = 0;
    forget_pace(hall);
    begin_time(hall, cfg);
}

/* Returns how far the rotor has gone on since the edge: the tick after the first one takes it. */
static step_t way_since(const hall_t *hall, step_t speed)
{
    return speed + (fx_asr(speed, AGE_SHIFT) * (step_t)hall->seen_age_q8);
}

/*
 * Returns the size of the mean speed from the edge before to this one. way: between them, which is
 * more than half a turn where a signal is left out of uneven sectors.
 */
static step_t speed_between(const hall_t *hall, angle_t way)
{
    const uint32_t shift = (hall->ticks < SHORT_TICKS) ? AGE_SHIFT : 0U;
    const int32_t part = (int32_t)hall->edge_age_q8 - (int32_t)hall->seen_age_q8;
    const int32_t time = fx_signed(hall->ticks << shift) + fx_asr(part, AGE_SHIFT - shift);
    const uint32_t pace = way / fx_unsigned(fx_max(time, 1));
    const uint32_t most = MEASURED_MAX >> shift;

    return fx_signed(((pace < most) ? pace : most) << shift);
}

/*
 * Returns the speed for the next sector. That of a slow rotor is extrapolated, as by an even
 * acceleration. That of a fast one, whose speed hardly changes from edge to edge, is a mean: it has
 * less of the jitter of a tick, or of what is not known of the edges' angles.
 */
static step_t speed_ahead(const hall_t *hall, step_t measured)
{
    const step_t before = hall->pace;
    step_t ahead;

    if (!hall->paced) {
        ahead = measured;
    } else if (!hall->fast && (hall->timed || (hall->ticks > JITTER_TICKS))) {
        const step_t most = fx_asr(fx_abs(measured), 1U);

        ahead = measured + fx_clamp(measured - before, -most, most);
    } else {
        const uint32_t shift = hall->timed ? TIMED_SPEED_SHIFT : SPEED_SHIFT;

        ahead = hall->speed + fx_asr(measured - hall->speed, shift);
    }
    return fx_clamp(ahead, -SPEED_MAX, SPEED_MAX);
}

/*
 * Whether the rotor has gone through the last two sectors with about the same speed, or is fast. A
 * slow one that does not may be anywhere soon: from rest the second sector takes 0.41 of the time
 * of the first.
 */
static bool is_steady(const hall_t *hall, step_t measured)
{
    const step_t before = hall->pace;

    return hall->fast ||
           (hall->paced && (fx_abs(measured - before) <= fx_asr(fx_abs(before), STEADY_SHIFT)));
}

/* Returns the share of the angle's error that an edge corrects. */
static int32_t corrected(const hall_t *hall, int32_t error)
{
    return hall->timed ? (error - fx_asr(error, TIMED_SHIFT)) : fx_asr(error, ANGLE_SHIFT);
}

/* Corrects angle and speed at an edge, from the way and the time since the edge before. */
static void hall_pace(hall_t *hall, angle_t edge)
{
    const bool forwards = hall->direction > 0;
    const angle_t way = forwards ? (edge - hall->edge) : (hall->edge - edge);
    const step_t size = speed_between(hall, way);
    const step_t measured = forwards ? size : -size;
    const step_t speed = speed_ahead(hall, measured);
    const angle_t now = edge + fx_unsigned(way_since(hall, speed));
    const int32_t error = fx_signed(now - hall->angle);
    const int32_t close = fx_clamp(error, -CLOSE, CLOSE);

    if (hall->paced && (error == close)) {
        hall->angle += fx_unsigned(corrected(hall, close));
    } else {
        hall->angle = now;
    }
    hall->steady = is_steady(hall, measured);
    hall->speed = speed;
    hall->pace = hall->fast ? speed : measured;
    hall->paced = true;
}

static bool is_illegal(uint32_t pattern)
{
    return (pattern == 0U) || (pattern == PATTERN_MASK);
}

/* The angle is not known any more; a legal pattern tells it again. */
static void lose(hall_t *hall)
{
    hall->known = false;
    hall->dead = 0U;
    hall->taken = NO_PATTERN;
    hall->seen = NO_PATTERN; /* no pattern tells it in this tick */
    hall->trouble = (uint8_t)SHAFT_TROUBLE_HALL_PATTERN;
}

/*
 * Two signals that stand still leave one edge, which the rotor seems to pass to and fro, and no
 * pattern is illegal once a signal is left out. So the angle is lost where a fast rotor seems to
 * turn back, or any rotor twice in a row while a signal is left out.
 */
static void hall_take_edge(hall_t *hall, const hall_cfg_t *cfg, angle_t edge, int8_t direction)
{
    const bool reversed = hall->direction == -direction;
    const bool second = reversed && (hall->fast || (hall->turned && (hall->dead != 0U)));

    if (hall->direction == direction) {
        hall_pace(hall, edge);
    } else {
        forget_pace(hall);
        hall->pace = 0;
        hall->angle = edge;
    }
    hall->turned = reversed;
    hall->edge = edge;
    hall->direction = direction;
    begin_time(hall, cfg);
    if (second) {
        lose(hall);
    }
}

/* Returns the direction of the edge to this span; 0: it is no neighbour. */
static int8_t direction_to(const hall_t *hall, hall_span_t span)
{
    const hall_span_t before = hall->span;
    int8_t direction = 0;

    if (next_sector(before.first, before.count) == span.first) {
        direction = 1;
    } else if (next_sector(span.first, span.count) == before.first) {
        direction = -1;
    } else {
        /* a jump */
    }
    return direction;
}

/*
 * Whether a rotor of this speed cannot be there yet: it has to go half of its sector to the next
 * edge, 3/4 if it is fast, a sector to turn back, and twice as much is given to a jump. So a signal
 * that begins to stand still makes no edge at once.
 */
static bool is_too_soon(const hall_t *hall, const hall_cfg_t *cfg, int8_t direction)
{
    uint32_t least = SECTOR;

    if (direction == 0) {
        least = 2U * SECTOR;
    } else if (direction == hall->direction) {
        const uint32_t half = width_of(cfg, hall->span) / 2U;

        least = hall->fast ? (half + (half / 2U)) : half;
    } else {
        /* it would have turned back */
    }
    return hall->known && hall->paced && hall->steady &&
           (hall->ticks <= ticks_of(hall, least - 1U));
}

/* A pattern has passed over a sector. If the speed has brought the rotor there, the angle goes on.
 */
static void take_jump(hall_t *hall, const hall_cfg_t *cfg)
{
    const angle_t inside = hall->angle - begin_of(cfg, hall->span.first);

    hall->trouble = (uint8_t)SHAFT_TROUBLE_HALL_JUMP;
    if (hall->paced && (inside < width_of(cfg, hall->span))) {
        hall->edge = hall->angle;
        begin_time(hall, cfg);
    } else {
        place(hall, cfg);
    }
}

/* A legal pattern counts. */
static void take_span(hall_t *hall, const hall_cfg_t *cfg, hall_span_t span, int8_t direction)
{
    const hall_span_t before = hall->span;

    hall->span = span;
    if (!hall->known) {
        place(hall, cfg);
        hall->known = true;
    } else if (direction > 0) {
        hall_take_edge(hall, cfg, begin_of(cfg, span.first), direction);
    } else if (direction < 0) {
        hall_take_edge(hall, cfg, begin_of(cfg, before.first), direction);
    } else {
        take_jump(hall, cfg);
    }
}

static void take_legal(hall_t *hall, const hall_cfg_t *cfg, uint32_t pattern, hall_span_t span)
{
    const int8_t direction = direction_to(hall, span);

    hall->unlike = 0U;
    if (hall->known && (span.first == hall->span.first)) {
        hall->taken = (uint8_t)pattern; /* only the signal that is left out has changed */
    } else if (!is_too_soon(hall, cfg, direction)) {
        hall->taken = (uint8_t)pattern;
        take_span(hall, cfg, span, direction);
    } else {
        /* not yet */
    }
}

/* An illegal pattern. It is bridged for some ticks; then a signal is left out, or the angle lost.
 */
RARE static void take_unlike(hall_t *hall, const hall_cfg_t *cfg, uint32_t pattern)
{
    hall->unlike++;
    if (hall->unlike >= UNLIKE_TICKS) {
        const uint32_t dead = hall->known ? dead_signal(hall, cfg, pattern) : 0U;

        hall->unlike = UNLIKE_TICKS;
        if (dead == 0U) {
            lose(hall);
        } else {
            hall->dead = (uint8_t)dead;
            hall->taken = (uint8_t)pattern;
            hall->span = span_of(cfg, pattern, dead);
            expect_edge(hall, cfg);
            hall->trouble = (uint8_t)SHAFT_TROUBLE_HALL_SIGNAL;
        }
    }
}

RARE static void take_pattern(hall_t *hall, const hall_cfg_t *cfg, uint32_t pattern)
{
    const hall_span_t span = span_of(cfg, pattern, hall->dead);

    if (span.count == 0U) {
        take_unlike(hall, cfg, pattern);
    } else {
        take_legal(hall, cfg, pattern, span);
    }
}

/*
 * Keeps the angle within the sector: a rotor that is slower than expected waits at its end. An edge
 * counts up to two ticks after the rotor has passed it, so the angle may go on for these.
 */
static void hall_stay(hall_t *hall, const hall_cfg_t *cfg)
{
    const angle_t late = fx_unsigned(fx_abs(hall->speed)) * SEEN_UNTIL;
    const angle_t begin = begin_of(cfg, hall->span.first) - late;
    const angle_t width = (hall_end_of(cfg, hall->span) - begin) + late;

    const angle_t inside = hall->angle - begin;

    if (inside > width) {
        hall->angle = ((inside - width) < (HALF_TURN - (width / 2U))) ? (begin + width) : begin;
    }
}

/*
 * Counts the ticks on. The edge that had to come has not, if the speed is known: a slow rotor has
 * stopped. But a pattern that is legal only without the signal that is left out may be that of an
 * open connector.
 */
RARE static void miss_edge(hall_t *hall)
{
    hall->patience = TICKS_MAX;
    if (hall->ticks < TICKS_MAX) {
        hall->ticks++;
    }
    if (!hall->known || !hall->paced) {
        /* none has to come */
    } else if (hall->fast || is_illegal(hall->taken)) {
        lose(hall);
    } else {
        forget_pace(hall);
    }
}

/* A tick at rest, or before the speed is known. */
static void go_to_middle(hall_t *hall, const hall_cfg_t *cfg)
{
    const int32_t way = fx_signed(middle_of(cfg, hall->span) - hall->angle);
    const step_t most = hall->turned ? fx_asr(cfg->fast_speed, TURNED_SHIFT) : HALF_SECTOR;

    hall->angle += fx_unsigned(fx_clamp(fx_asr(way, REST_SHIFT), -most, most));
}

static void hall_go_on(hall_t *hall, const hall_cfg_t *cfg)
{
    if (!hall->known || !hall->paced) {
        go_to_middle(hall, cfg);
    } else {
        hall->angle += fx_unsigned(hall->speed);
        if (!hall->fast) {
            hall_stay(hall, cfg);
        }
    }
    if (hall->ticks < hall->patience) {
        hall->ticks++;
    } else {
        miss_edge(hall);
    }
}

/* Another pattern than in the tick before: notes how long ago its edge was. */
RARE static void see_pattern(hall_t *hall, hall_reading_t reading)
{
    hall->seen = (uint8_t)reading.pattern;
    hall->timed = reading.age_q8 != 0U;
    hall->seen_age_q8 =
        (uint16_t)(hall->timed ? fx_min((int32_t)reading.age_q8, TICK_Q8) : AGE_MEAN);
}

bool hall_step(hall_t *hall, const hall_cfg_t *cfg, hall_reading_t reading)
{
    hall->trouble = (uint8_t)SHAFT_TROUBLE_NONE;
    hall_go_on(hall, cfg);
    if (reading.pattern != hall->seen) {
        see_pattern(hall, reading);
    } else if (reading.pattern != hall->taken) {
        take_pattern(hall, cfg, reading.pattern);
        hall->seen = (uint8_t)reading.pattern;
    } else {
        /* the same sector */
    }
    return hall->known;
}
