/* SPDX-License-Identifier: MIT */
/*
 * USART2 with its FIFOs, polled by the background: board.baud bits a second, 8 data bits, no
 * parity, 1 stop bit. It goes through the ST-LINK of the board. Nothing here waits, and nothing
 * runs in an interrupt. hal_receive() and hal_send() are these two.
 */
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stdint.h>

void uart_init(void);

/*
 * The next received byte. False when there is none. Bytes with a line error are dropped by hardware
 * flags.
 */
bool uart_get(uint8_t *byte);

/* Take a byte for sending. False, and nothing done, while the FIFO is full. */
bool uart_put(uint8_t byte);

#endif
