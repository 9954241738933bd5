/* SPDX-License-Identifier: MIT */
/*
 * The binding of hal.h to the board: one block of registers, which timer and converters serve. On
 * the chip the linker script says where it is; on the PC a program plays the board, for example
 * bench.c.
 */
#ifndef BOARD_H
#define BOARD_H

#include "hal.h"

#include <stdint.h>

#define BOARD_BYTE (0x100U)       /* of the serial line's registers: there is one */
#define BOARD_NO_CURRENTS (6144U) /* three times half of the converter's 4096 */

typedef struct {
    uint32_t current_a; /* of t_k, counts */
    uint32_t current_b;
    uint32_t bus;
    uint32_t temperature; /* of the power stage; 0 without a sensor */
    uint32_t compare[3];  /* loaded at the sampling instant */
    uint32_t gates;       /* 1: they switch */
    uint32_t broken;      /* 1: the comparators have opened them */
    uint32_t run;         /* 1: the timer counts, and the interrupt comes */
    uint32_t received;    /* a byte that came in, with BOARD_BYTE; 0: none, or it was read */
    uint32_t sent;        /* a byte to be sent, with BOARD_BYTE; 0: there is room for one */
} board_registers_t;

extern volatile board_registers_t board_registers;

struct hal {
    uint32_t ticks; /* written by the control interrupt */
};

/* Lets the timer run. Once, after app_init(). */
void board_start(hal_t *hal);

/* Until an interrupt has come. Context: background. */
void board_wait(void);

/* The control interrupt: main.c. */
void board_conversions_complete(void);

#endif
