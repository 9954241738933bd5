/* SPDX-License-Identifier: MIT */
/*
 * ram.h. The test overwrites the whole RAM, including the stack. So after clock_init() the code up
 * to Reset_Handler uses registers only.
 */
    .syntax unified
    .thumb

    .section .text.reset_entry, "ax", %progbits
    .global reset_entry
    .type reset_entry, %function
    .thumb_func
reset_entry:
    bl clock_init               /* makes the test ten times as fast */
    ldr r0, =_ram_start
    ldr r1, =_ram_end
    ldr r2, =0x55555555
    mvns r3, r2
    mov r4, r0
1:  str r2, [r4], #4            /* upwards: write */
    cmp r4, r1
    bne 1b
    mov r4, r0
2:  ldr r5, [r4]                /* upwards: read, write the opposite */
    cmp r5, r2
    bne 7f
    str r3, [r4], #4
    cmp r4, r1
    bne 2b
    mov r4, r0
3:  ldr r5, [r4]                /* upwards: read the opposite, write */
    cmp r5, r3
    bne 7f
    str r2, [r4], #4
    cmp r4, r1
    bne 3b
4:  ldr r5, [r4, #-4]!          /* downwards: read, write the opposite */
    cmp r5, r2
    bne 7f
    str r3, [r4]
    cmp r4, r0
    bne 4b
    mov r4, r1
5:  ldr r5, [r4, #-4]!          /* downwards: read the opposite, write */
    cmp r5, r3
    bne 7f
    str r2, [r4]
    cmp r4, r0
    bne 5b
6:  ldr r5, [r4]                /* upwards: read */
    cmp r5, r2
    bne 7f
    adds r4, #4
    cmp r4, r1
    bne 6b
    movs r4, #0                 /* nothing is wrong */
7:  ldr r0, =ram_fault
    str r4, [r0]
    b Reset_Handler
    .size reset_entry, . - reset_entry
