/* SPDX-License-Identifier: MIT */
/*
 * The slots of flash (hal.h): the last two pages of 2 KiB of the flash are the store's, the six
 * pages before them the black box's. The linker script leaves them free. RM0440 3.3; the data sheet
 * DS12589 gives 10000 erases per page, 22 to 24.5 ms per erase and 82 µs per double word.
 *
 * An STM32G431 has one bank, so the core stands still while a page is erased or a double word is
 * programmed. No tick can run meanwhile. On an STM32G474, which has two banks, the
 * core could go on, but the binding does the same. So the gates are opened first, the control
 * interrupt is disabled and the tick guard is stopped; around an erase the watchdog waits for 47 ms
 * or more.
 *
 * A double word has 8 check bits, which correct one wrong bit and find two. If a loss of power has
 * left more than one bit wrong, a read raises the NMI. In a slot this only means that
 * the slot is incomplete; at any other address it is an unexpected exception.
 */
#ifndef FLASH_H
#define FLASH_H

#include "hal.h"

#include <stdbool.h>

/*
 * Whether the NMI was caused by a unit that hal_store_read() is reading. If so, acknowledges the
 * NMI, and hal_store_read() returns false. Context: handler of the NMI.
 */
bool flash_forgive(void);

#endif
