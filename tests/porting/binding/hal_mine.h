/* SPDX-License-Identifier: MIT */
/*
 * A binding to a power stage that nobody has: one block of registers, which its timer and converters serve.
 */
#ifndef HAL_MINE_H
#define HAL_MINE_H

#include "hal.h"

#include <stdint.h>

#define MINE_BYTE (0x100U)       /* of the serial line's registers: there is one */
#define MINE_NO_CURRENTS (6144U) /* three times half of the converter's 4096 */

typedef struct {
    uint32_t current_a; /* of t_k, counts */
    uint32_t current_b;
    uint32_t bus;
    uint32_t temperature;
    uint32_t compare[3]; /* loaded at the sampling instant */
    uint32_t gates;      /* 1: they switch */
    uint32_t broken;     /* 1: the comparators have opened them */
    uint32_t run;        /* 1: the timer counts, and the interrupt comes */
    uint32_t received;   /* a byte that came in, with MINE_BYTE; 0: none, or it was read */
    uint32_t sent;       /* a byte to be sent, with MINE_BYTE; 0: there is room for one */
} mine_registers_t;

/* At an address that the linker script gives. */
extern volatile mine_registers_t mine_registers;

struct hal {
    uint32_t ticks; /* written by the control interrupt */
};

/* Lets the timer run. Once, after app_init(). */
void hal_mine_start(hal_t *hal);

/* The control interrupt: main.c. */
void mine_conversions_complete(void);

/* Until an interrupt has come. Context: background. */
void mine_wait(void);

#endif
