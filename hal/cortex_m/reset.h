/* SPDX-License-Identifier: MIT */
/*
 * From reset to main() on any Cortex-M, and one place where everything unexpected ends.
 *
 * The vector table has two parts, which sections.ld puts one behind the other: the core's own
 * entries are in reset.c; a target adds its interrupts as
 *
 *     const vector_t device_vectors[N] __attribute__((section(".vectors.device"), used)) = {...};
 *
 * with safe_state_handler for each that it does not use.
 */
#ifndef RESET_H
#define RESET_H

#include <stdint.h>

typedef void (*vector_t)(void);

/*
 * The image's GNU build-id as the linker writes it: four words of a note's header, then 20 bytes.
 * `readelf -n` shows them.
 */
#define BUILD_ID_NOTE_WORDS (9U)
#define BUILD_ID_FIRST_WORD (4U)
extern const uint32_t build_id_note[BUILD_ID_NOTE_WORDS];

/* Exceptions 1 to 15; sections.ld puts the stack pointer before them. */
#define CORE_VECTORS (15U)
extern const vector_t core_vectors[CORE_VECTORS];

/*
 * Where the chip starts: Reset_Handler, by sections.ld, if a target has nothing to do before. A
 * target that has ends by a jump to it.
 */
void reset_entry(void);

/*
 * Brings up the memory (.data copied, .bss zero) and calls main(). Runs on the stack alone. A
 * return of main() ends in safe_state_handler().
 */
void Reset_Handler(void);

/*
 * Handler of everything that must not happen: opens the gates and stays. What ends the stay is the
 * target's business, for example its watchdog. Context: any exception.
 */
void safe_state_handler(void);

/* Exceptions of the core: safe_state_handler, by sections.ld, if a target does not define them. */
void NMI_Handler(void);
void HardFault_Handler(void);
void MemManage_Handler(void);
void BusFault_Handler(void);
void UsageFault_Handler(void);
void SVC_Handler(void);
void DebugMon_Handler(void);
void PendSV_Handler(void);
void SysTick_Handler(void);

/* Defined by each target; called once the memory is as C wants it. */
int main(void);

/*
 * Defined by each target: gates open, by the shortest way, and without a stack if the board has
 * gates. No memory but registers may be relied on.
 */
void board_safe_state(void);

#endif
