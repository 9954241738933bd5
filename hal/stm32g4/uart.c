/* SPDX-License-Identifier: MIT */
#include "uart.h"

#include "hal_config.h"
#include "reg.h"
#include "settings.h"
#include "stm32g4.h"

void uart_init(void)
{
    settings_write(SETTINGS_LINE);
    reg_write(HAL_USART + USART_CR1, USART_CR1_FIFOEN | USART_CR1_TE | USART_CR1_RE | USART_CR1_UE);
}

/*
 * The flags are cleared before the byte is read: afterwards they are those of the next one. An
 * overrun flag that stays set would block the receiver.
 */
bool uart_get(uint8_t *byte)
{
    const uint32_t flags = reg_read(HAL_USART + USART_ISR);
    bool whole = false;

    if ((flags & USART_ISR_ORE) != 0U) {
        reg_write(HAL_USART + USART_ICR, USART_ICR_ERRORS);
    }
    if ((flags & USART_ISR_RXFNE) != 0U) {
        uint32_t received;

        whole = (flags & (USART_ISR_FE | USART_ISR_NE)) == 0U;
        if (!whole) {
            reg_write(HAL_USART + USART_ICR, USART_ICR_ERRORS);
        }
        received = reg_read(HAL_USART + USART_RDR);
        if (whole) {
            *byte = (uint8_t)(received & 0xFFU);
        }
    }
    return whole;
}

bool uart_put(uint8_t byte)
{
    const bool room = reg_any(HAL_USART + USART_ISR, USART_ISR_TXFNF);

    if (room) {
        reg_write(HAL_USART + USART_TDR, byte);
    }
    return room;
}
