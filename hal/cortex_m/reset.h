/* SPDX-License-Identifier: MIT */
/*
 * From reset to main() on any Cortex-M, and one handler for every unexpected exception.
 *
 * The vector table has two parts, which sections.ld puts one after the other: the core's own
 * entries are in reset.c; a target adds its interrupts as
 *
 *     const vector_t device_vectors[N] __attribute__((section(".vectors.device"), used)) = {...};
 *
 * with safe_state_handler for each interrupt that it does not use.
 */
#ifndef RESET_H
#define RESET_H

#include <stdint.h>

typedef void (*vector_t)(void);

/*
 * The image's GNU build-id as the linker writes it: four words of the note's header, then 20 bytes
 * of the id. `readelf -n` shows it.
 */
#define BUILD_ID_NOTE_WORDS (9U)
#define BUILD_ID_FIRST_WORD (4U)
extern const uint32_t build_id_note[BUILD_ID_NOTE_WORDS];

/* Exceptions 1 to 15; sections.ld puts the stack pointer before them. */
#define CORE_VECTORS (15U)
extern const vector_t core_vectors[CORE_VECTORS];

/*
 * Where the chip starts. By default sections.ld makes it the same as Reset_Handler. A target that
 * has something to do before defines it, and jumps to Reset_Handler at its end.
 */
void reset_entry(void);

/*
 * Brings up the memory (.data copied, .bss zero) and calls main(). Uses no variables but those on
 * the stack. If main() returns, it calls safe_state_handler().
 */
void Reset_Handler(void);

/*
 * Handler of every unexpected exception: opens the gates and never returns. The target decides what
 * happens next, for example a reset by its watchdog. Context: any exception.
 */
void safe_state_handler(void);

/* Exceptions of the core. By default sections.ld makes each the same as safe_state_handler. */
void NMI_Handler(void);
void HardFault_Handler(void);
void MemManage_Handler(void);
void BusFault_Handler(void);
void UsageFault_Handler(void);
void SVC_Handler(void);
void DebugMon_Handler(void);
void PendSV_Handler(void);
void SysTick_Handler(void);

/* Defined by each target; called when the memory is initialised. */
int main(void);

/*
 * Defined by each target: opens the gates in the shortest way. On a board with gates it must not
 * use the stack. It may rely on registers only, on no memory.
 */
void board_safe_state(void);

#endif
