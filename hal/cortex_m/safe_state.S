/* SPDX-License-Identifier: MIT */
/*
 * The handler of every unexpected exception. It is in assembly because a compiled handler begins by
 * saving registers on the stack, and an exhausted stack is one of the causes that lead here.
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
