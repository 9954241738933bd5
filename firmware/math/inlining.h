/* SPDX-License-Identifier: MIT */
/* What gcc and clang are told about inlining where their own choice makes a tick longer. */
#ifndef INLINING_H
#define INLINING_H

/* All that such a function calls becomes part of it. */
#define INLINES_ALL __attribute__((flatten))

/*
 * For what each tick goes through. The compiler inlines only so much into one program, and what is called seldom takes its
 * share: without this a call of follow_or_fail() costs up to 20 instructions of a tick.
 */
#define ALWAYS_INLINED __attribute__((always_inline))

/*
 * For what a start does once. As a part of the tick's functions it would take their registers: 4 % of a RUN tick on a
 * Cortex-M0+.
 */
#define NEVER_INLINED __attribute__((noinline))

/*
 * For what a user does now and then in the tick. The compiler leaves it and what it alone calls apart, and lays out the
 * rest as if it were not there.
 */
#define RARE __attribute__((noinline, cold))

#endif
