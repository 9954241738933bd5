/* SPDX-License-Identifier: MIT */
/*
 * The store's two slots (hal.h): pages 62 and 63, the last 4 KiB of the flash, which the linker
 * script leaves free. RM0440 3.3; the data sheet DS12589 gives 10000 erases a page, 22 to 24.5 ms
 * an erase and 82 µs a double word.
 *
 * The flash has one bank: the core stands still while a page is erased or a double word is
 * programmed. Meanwhile no tick can come: the gates are opened first, the control interrupt is held
 * back and the tick guard rests; around an erase the watchdog waits 47 ms and more.
 *
 * A double word has 8 bits more, which correct one wrong bit and find two. Where a loss of power
 * has left more wrong, a read raises the NMI. Of a slot that only means that it is not whole; of
 * any other place it is an unexpected exception.
 */
#ifndef FLASH_H
#define FLASH_H

#include "hal.h"

#include <stdbool.h>

/*
 * Whether the NMI came of a unit that hal_store_read() is reading; then it is acknowledged, and
 * that call returns false. Context: the NMI, first.
 */
bool flash_forgive(void);

#endif
