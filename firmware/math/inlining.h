/* SPDX-License-Identifier: MIT */
/*
 * Inlining attributes of gcc and clang, for places where the compiler's own choice makes a tick
 * longer.
 */
#ifndef INLINING_H
#define INLINING_H

/* The compiler inlines every function that such a function calls. */
#define INLINES_ALL __attribute__((flatten))

/*
 * For functions that few ticks call, such as the functions of a start. Inlined into the functions
 * of the tick, they would take registers from them, which costs 4 % of a RUN tick on a Cortex-M0+.
 */
#define NEVER_INLINED __attribute__((noinline))

/*
 * For functions of the tick that run only now and then, such as on a user's command or on a fault.
 * The compiler keeps such a function apart, together with the functions that only it calls, and
 * lays out the other code as if these functions did not exist.
 */
#define RARE __attribute__((noinline, cold))

#endif
