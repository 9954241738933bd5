/* SPDX-License-Identifier: MIT */
/*
 * What a sensor of the shaft reads, as the wires of a board have it.
 *
 *   Hall        three levels, bit 0 is sensor 1. Each of the six edges of an electrical turn has an
 *               angle of its own. If a timer measures it, the time since the last edge.
 *   encoder     a counter of 16 bits that begins at any number, and the counter at the last index.
 *               The index lies at one angle of the shaft, whichever way the shaft passes it.
 *   absolute    frames of 16 bits: angle in bits 13...0, error flag in bit 14, even parity in bit
 *               15. A frame is that of the tick before, as it takes a tick to transfer it.
 */
#ifndef PLANT_SHAFT_SENSOR_H
#define PLANT_SHAFT_SENSOR_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PLANT_HALL_SECTORS 6U

typedef enum {
    PLANT_SHAFT_NONE = 0,
    PLANT_SHAFT_HALL,
    PLANT_SHAFT_ENCODER,
    PLANT_SHAFT_ABSOLUTE
} plant_shaft_kind_t;

typedef struct {
    plant_shaft_kind_t kind;
    bool reversed;       /* encoder and absolute: it counts down forwards */
    uint32_t counts;     /* encoder: in a turn, 4 ... 65536 */
    double zero_turns;   /* absolute: reads this at angle 0; encoder: the index is there */
    unsigned pole_pairs; /* Hall: 1 ... 50 */
    /* Hall: electrical turns at which sector k begins, rising, the last less than the first + 1 */
    double edges_turns[PLANT_HALL_SECTORS];
    uint8_t patterns[PLANT_HALL_SECTORS]; /* Hall: levels in sector k, 0 ... 7 */
    bool timed;                           /* Hall: a timer measures the age of an edge */
} plant_shaft_cfg_t;

typedef struct {
    uint16_t reading;
    uint16_t index;  /* encoder: the counter at the last index */
    bool indexed;    /* encoder: an index has come since the last reading */
    uint16_t age_q8; /* Hall: time since the last edge, Q8 of a tick, 1 or more; 0: not timed */
} plant_shaft_reading_t;

typedef struct {
    plant_shaft_cfg_t cfg;
    int64_t count;  /* encoder: at the last reading, from the index */
    int64_t begin;  /* encoder: at the first reading */
    uint16_t frame; /* absolute: of the last reading */
    uint16_t index; /* encoder: the counter at the last index */
    double turns;   /* Hall: electrical, at the last reading */
    uint16_t levels;
    uint16_t age_q8; /* Hall: as of the reading, saturates */
    bool begun;
} plant_shaft_t;

/* Returns false and names the offending field in *bad_field when a value is out of range. */
bool plant_shaft_init(plant_shaft_t *shaft, const plant_shaft_cfg_t *cfg, const char **bad_field);

/* What it reads at an angle of the shaft, rad, multi-turn. Once a tick. */
plant_shaft_reading_t plant_shaft_read(plant_shaft_t *shaft, double angle_mech_rad);

#ifdef __cplusplus
}
#endif

#endif
