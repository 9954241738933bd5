/* SPDX-License-Identifier: MIT */
/*
 * Order of memory accesses between the background and an interrupt on the same core.
 *
 * `volatile` orders volatile accesses among themselves only; the compiler may move any other access
 * across them. An interrupt sees the accesses of the interrupted code in the order of its
 * instructions. So it is enough to keep the compiler from changing that order. The barrier
 * generates no instruction. It does not order accesses for a second core or a DMA.
 */
#ifndef BARRIER_H
#define BARRIER_H

/*
 * The compiler moves no memory access across this barrier, in either direction. The background
 * calls it before it tells the interrupt that data are ready, and after it has read that the
 * interrupt's data are ready. The interrupt needs no barrier, because the background cannot
 * interrupt it. The barrier is atomic_signal_fence() of C11, without <stdatomic.h>.
 */
static inline void barrier_compiler(void)
{
    __atomic_signal_fence(__ATOMIC_SEQ_CST);
}

#endif
