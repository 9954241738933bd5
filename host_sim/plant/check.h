/* SPDX-License-Identifier: MIT */
/* Range checks of the configuration structs. */
#ifndef PLANT_CHECK_H
#define PLANT_CHECK_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct {
    const char *field;
    bool good;
} plant_check_t;

static inline bool plant_is_positive(double x)
{
    return isfinite(x) && x > 0.0;
}

static inline bool plant_is_not_negative(double x)
{
    return isfinite(x) && x >= 0.0;
}

/* Name of the first field that is not good, NULL when all are. */
static inline const char *plant_first_bad(const plant_check_t *checks, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        if (!checks[k].good) {
            return checks[k].field;
        }
    }
    return NULL;
}

#endif
