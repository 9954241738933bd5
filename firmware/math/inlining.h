/* SPDX-License-Identifier: MIT */
/* What gcc and clang are told about inlining where their own choice makes a tick longer. */
#ifndef INLINING_H
#define INLINING_H

/* All that such a function calls becomes part of it. */
#define INLINES_ALL __attribute__((flatten))

/*
 * For what a start does once. As a part of the tick's functions it would take their registers: 4 %
 * of a RUN tick on a Cortex-M0+.
 */
#define NEVER_INLINED __attribute__((noinline))

/*
 * For what a user does now and then in the tick. The compiler leaves it and what it alone calls
 * apart, and lays out the rest as if it were not there.
 */
#define RARE __attribute__((noinline, cold))

/*
 * The tick of RUN where the compiler has eight registers for it: it is made of all that it calls,
 * and what few ticks need stays apart. Left to itself, the compiler calls other parts of it as the
 * rest of the firmware grows. That costs a RUN tick 24 instructions on a Cortex-M0+. A Cortex-M4
 * would lose 12 by it.
 */
#if defined(__ARM_ARCH_6M__)
#define TICK_WHOLE INLINES_ALL
#define TICK_APART NEVER_INLINED
#else
#define TICK_WHOLE
#define TICK_APART
#endif

#endif
