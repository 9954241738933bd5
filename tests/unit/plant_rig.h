/* SPDX-License-Identifier: MIT */
/* A coupled plant, period by period. */
#ifndef PLANT_RIG_H
#define PLANT_RIG_H

#include "plant.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

#define COUNTS 4250U
#define PERIOD_S 1.0e-4
#define BUS_V 310.0

static plant_t plant;
static plant_view_t view;
static plant_cfg_t wrong;

static inline void look(void)
{
    plant_view(&plant, &view);
}

static inline void start(const plant_cfg_t *cfg)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_init(&plant, cfg, &bad), bad);
    plant_set_gates(&plant, true);
    look();
}

static inline void write_compare(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t compare[PLANT_LEGS] = {a, b, c};

    plant_write_compare(&plant, compare);
}

static inline void run(int periods)
{
    for (int k = 0; k < periods; k++) {
        plant_step(&plant);
    }
    look();
}

/* A copy. The test then makes one of its fields wrong. */
static inline plant_cfg_t *copy_of(const plant_cfg_t *good)
{
    wrong = *good;
    return &wrong;
}

/* The init function refuses that copy and names the field. */
static inline void check_rejected(const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_init(&plant, &wrong, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

#endif
