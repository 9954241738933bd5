/* SPDX-License-Identifier: MIT */
/*
 * A serial line with its baud rate, for hal_receive() and hal_send() of the simulated hardware: 10
 * bits per byte, and a receiver and a transmitter with FIFOs of 8 bytes.
 *
 * It works in steps of a PWM period. Bytes that the PC writes wait on its side until the line has
 * time for them. A byte that finds the receiver's FIFO full is lost, as on the board. While the
 * buffer on the PC's side is full, the bytes that the board sends are lost.
 *
 * Plain values without pointers. No function waits. Context: the one thread of the simulation.
 */
#ifndef HAL_HOST_LINE_H
#define HAL_HOST_LINE_H

#include <stdbool.h>
#include <stdint.h>

#define HAL_HOST_LINE_FIFO (8U)     /* bytes */
#define HAL_HOST_LINE_ROOM (65536U) /* bytes on the PC's side, each way */

typedef struct {
    uint8_t bytes[HAL_HOST_LINE_ROOM];
    uint32_t first;
    uint32_t count;
} hal_host_bytes_t;

typedef struct {
    uint8_t bytes[HAL_HOST_LINE_FIFO];
    uint32_t first;
    uint32_t count;
} hal_host_fifo_t;

typedef struct {
    uint64_t byte_ps; /* time of a byte */
    uint64_t tick_ps;
    uint64_t in_ps; /* time already spent on the next byte to the board */
    uint64_t out_ps;
    hal_host_bytes_t from_pc;
    hal_host_fifo_t received;
    hal_host_fifo_t sending;
    hal_host_bytes_t to_pc;
    uint32_t lost; /* lost bytes, in both directions */
} hal_host_line_t;

/* An empty line. baud: 1…4000000 bits per second; tick_ps: a PWM period, 1 or more. */
void hal_host_line_init(hal_host_line_t *line, uint32_t baud, uint64_t tick_ps);

/*
 * The PC's side of the line. Each function returns false and does nothing while there is no room,
 * or no byte.
 */
bool hal_host_line_write(hal_host_line_t *line, uint8_t byte);
bool hal_host_line_read(hal_host_line_t *line, uint8_t *byte);

/* The board's side. As hal_receive() and hal_send(). */
bool hal_host_line_receive(hal_host_line_t *line, uint8_t *byte);
bool hal_host_line_send(hal_host_line_t *line, uint8_t byte);

/* Lets one PWM period pass. */
void hal_host_line_step(hal_host_line_t *line);

#endif
