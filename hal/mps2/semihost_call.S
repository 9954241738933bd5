/* SPDX-License-Identifier: MIT */
/*
 * The operations of semihosting. Each function gets its operation in r0 and up to three words of
 * the operation's block as further arguments. It puts the block on the stack. The host's answer
 * comes back in r0.
 */
    .syntax unified
    .thumb
    .section .text.semihost_call, "ax", %progbits

    .macro function name
    .global \name
    .type \name, %function
    .thumb_func
\name:
    .endm

    function semihost_call_open
    function semihost_call_read
    function semihost_call_write
    function semihost_call_close
    function semihost_call_exit
    push {r1, r2, r3, lr}
    mov r1, sp
    bkpt 0xAB
    add sp, #12
    pop {pc}

/* The text itself is the argument. */
    function semihost_call_print
    bkpt 0xAB
    bx lr
