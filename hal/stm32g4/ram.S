/* SPDX-License-Identifier: MIT */
/*
 * ram.h. The test at the reset overwrites the RAM, including the stack. So after ram_test_end() the
 * code up to Reset_Handler uses registers only.
 */
    .syntax unified
    .thumb

    .section .text.reset_entry, "ax", %progbits
    .global reset_entry
    .type reset_entry, %function
    .thumb_func
reset_entry:
    bl clock_init               /* makes the test ten times as fast */
    bl ram_test_end
    mov r8, r0
    mov r1, r0
    ldr r0, =_ram_start
    bl ram_test
    ldr r1, =ram_fault
    str r0, [r1]
    ldr r1, =ram_tested_end
    str r8, [r1]
    b Reset_Handler
    .size reset_entry, . - reset_entry

    .section .text.ram_test, "ax", %progbits
    .global ram_test
    .type ram_test, %function
    .thumb_func
ram_test:                       /* r0: first word, r1: the end; changes r0, r2, r3, r12 */
    ldr r2, =0x55555555
    mov r12, r0
1:  str r2, [r12], #4           /* upwards: write */
    cmp r12, r1
    bne 1b
    mov r12, r0
2:  ldr r3, [r12]               /* upwards: read, write the opposite */
    cmp r3, r2
    bne 7f
    mvns r3, r3
    str r3, [r12], #4
    cmp r12, r1
    bne 2b
    mov r12, r0
    mvns r2, r2
3:  ldr r3, [r12]               /* upwards: read the opposite, write */
    cmp r3, r2
    bne 7f
    mvns r3, r3
    str r3, [r12], #4
    cmp r12, r1
    bne 3b
    mvns r2, r2
4:  ldr r3, [r12, #-4]!         /* downwards: read, write the opposite */
    cmp r3, r2
    bne 7f
    mvns r3, r3
    str r3, [r12]
    cmp r12, r0
    bne 4b
    mov r12, r1
    mvns r2, r2
5:  ldr r3, [r12, #-4]!         /* downwards: read the opposite, write */
    cmp r3, r2
    bne 7f
    mvns r3, r3
    str r3, [r12]
    cmp r12, r0
    bne 5b
    mvns r2, r2
6:  ldr r3, [r12]               /* upwards: read */
    cmp r3, r2
    bne 7f
    adds r12, #4
    cmp r12, r1
    bne 6b
    mov r12, #0                 /* nothing is wrong */
7:  mov r0, r12
    bx lr
    .size ram_test, . - ram_test
