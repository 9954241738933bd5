/* SPDX-License-Identifier: MIT */
/*
 * Order of memory accesses between the background and an interrupt on the same core.
 *
 * `volatile` orders volatile accesses among themselves only: the compiler may move any other across them. An
 * interrupt on one core sees what the interrupted code has done so far in the order of its instructions, so the
 * order in which the compiler leaves them is all that counts. No instruction is made for it; against a second core
 * or a DMA it is of no use.
 */
#ifndef BARRIER_H
#define BARRIER_H

/*
 * No access to memory is moved across it by the compiler, in either direction. To be called by the background, in
 * front of what tells the interrupt that data are ready and behind what tells the background so; the interrupt itself
 * cannot be interrupted by the background and needs none. It is atomic_signal_fence() of C11, without <stdatomic.h>.
 */
static inline void barrier_compiler(void)
{
    __atomic_signal_fence(__ATOMIC_SEQ_CST);
}

#endif
