/* SPDX-License-Identifier: MIT */
/* cpu.h */
    .syntax unified
    .thumb

    .section .text.cpu_wait, "ax", %progbits
    .global cpu_wait
    .type cpu_wait, %function
cpu_wait:
    wfi
    bx lr
    .size cpu_wait, . - cpu_wait
