/* SPDX-License-Identifier: MIT */
/*
 * The handler of everything that must not happen. In assembly, as a compiled one begins by saving
 * registers, and an exhausted stack is among the things that bring the core here.
 */
    .syntax unified
    .thumb
    .section .text.safe_state_handler, "ax", %progbits
    .global safe_state_handler
    .type safe_state_handler, %function
    .thumb_func
safe_state_handler:
    bl board_safe_state
stay:
    b stay
