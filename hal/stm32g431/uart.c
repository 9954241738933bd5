/* SPDX-License-Identifier: MIT */
#include "uart.h"

#include "reg.h"
#include "settings.h"
#include "stm32g431.h"

void uart_init(void)
{
    settings_write(SETTINGS_LINE);
    reg_write(USART2_CR1, USART_CR1_FIFOEN | USART_CR1_TE | USART_CR1_RE | USART_CR1_UE);
}

/* The flags are cleared before the byte is read: afterwards they are those of the next one. */
bool uart_get(uint8_t *byte)
{
    const uint32_t flags = reg_read(USART2_ISR);
    const bool there = (flags & USART_ISR_RXFNE) != 0U;
    const bool whole = (flags & (USART_ISR_FE | USART_ISR_NE)) == 0U;

    /* An overrun flag that stays set would block the receiver. */
    if (!whole || ((flags & USART_ISR_ORE) != 0U)) {
        reg_write(USART2_ICR, USART_ICR_ERRORS);
    }
    if (there) {
        const uint32_t received = reg_read(USART2_RDR);

        if (whole) {
            *byte = (uint8_t)(received & 0xFFU);
        }
    }
    return there && whole;
}

bool uart_put(uint8_t byte)
{
    const bool room = reg_any(USART2_ISR, USART_ISR_TXFNF);

    if (room) {
        reg_write(USART2_TDR, byte);
    }
    return room;
}
