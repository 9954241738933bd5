/* SPDX-License-Identifier: MIT */
/*
 * USART2 with its FIFOs, polled by the background: board.baud bits per second, 8 data bits, no
 * parity, 1 stop bit. It goes through the ST-LINK of the board. Nothing here waits, and nothing
 * runs in an interrupt. hal_receive() and hal_send() call uart_get() and uart_put().
 */
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stdint.h>

void uart_init(void);

/*
 * Takes the next received byte. False when there is none, or when it has a framing error or noise:
 * that byte is dropped, and the next call goes on. Bytes that come while the FIFO is full are lost.
 */
bool uart_get(uint8_t *byte);

/* Takes a byte for sending. Returns false and does nothing while the FIFO is full. */
bool uart_put(uint8_t byte);

#endif
