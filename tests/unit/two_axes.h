/* SPDX-License-Identifier: MIT */
/* Vectors in tests: seeded ones, and both parts compared at once. */
#ifndef TWO_AXES_H
#define TWO_AXES_H

#include "seeded.h"
#include "testing.h"
#include "transforms.h"

/* Both parts within ±limit. */
static inline dq_t seeded_dq(seeded_t *seed, int32_t limit)
{
    const int32_t d = seeded_in(seed, -limit, limit);

    return (dq_t){d, seeded_in(seed, -limit, limit)};
}

static inline ab_t seeded_ab(seeded_t *seed, int32_t limit)
{
    const dq_t v = seeded_dq(seed, limit);

    return (ab_t){v.d, v.q};
}

static inline void assert_dq(int32_t d, int32_t q, dq_t actual)
{
    TEST_ASSERT_EQUAL_INT32_MESSAGE(d, actual.d, "along d");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(q, actual.q, "along q");
}

#endif
