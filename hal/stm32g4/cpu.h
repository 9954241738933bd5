/* SPDX-License-Identifier: MIT */
/*
 * An instruction for which C has no statement.
 */
#ifndef CPU_H
#define CPU_H

/*
 * Sleeps until the next exception has been served. It is in assembly, so it is also a barrier for
 * the compiler.
 */
void cpu_wait(void);

#endif
