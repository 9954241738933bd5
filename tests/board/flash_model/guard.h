/* SPDX-License-Identifier: MIT */
/* In place of the binding's header of this name: test_flash.c has the functions. */
#ifndef GUARD_H
#define GUARD_H

#include <stdbool.h>

void guard_hold_ticks(void);
void guard_release_ticks(void);
bool guard_be_patient(void);
bool guard_be_strict(void);

#endif
