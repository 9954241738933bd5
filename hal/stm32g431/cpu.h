/* SPDX-License-Identifier: MIT */
/*
 * What C has no word for.
 */
#ifndef CPU_H
#define CPU_H

/*
 * Sleep until the next exception has been served. In assembly, thus a barrier for the compiler too.
 */
void cpu_wait(void);

#endif
