/* SPDX-License-Identifier: MIT */
/*
 * A measured maximum against a derived bound, checked on both sides: above the bound something is
 * wrong, and far below it the bound (or the measurement) is.
 */
#ifndef FIGURE_H
#define FIGURE_H

#include "testing.h"

#include <stdio.h>

/* Passes when share·bound ≤ worst ≤ bound. Prints the figure in any case. */
static inline void figure_check(const char *what, double worst, double bound, double share)
{
    char text[200];

    (void)snprintf(text, sizeof text, "%.120s: at most %.5g, bound %.5g, at least %.3g of it", what,
                   worst, bound, share);
    (void)printf("%s\n", text);
    TEST_ASSERT_TRUE_MESSAGE((worst <= bound) && (worst >= (share * bound)), text);
}

#endif
