/* SPDX-License-Identifier: MIT */
#include "reset.h"

/*
 * Addresses and sizes that the reset handler needs to initialize the RAM (.data and .bss).
 * sections.ld fills in this structure.
 */
typedef struct {
    const uint32_t *data_load;
    uint32_t *data;
    uint32_t data_words;
    uint32_t *bss;
    uint32_t bss_words;
} startup_memory_t;

extern const startup_memory_t startup_memory;

void Reset_Handler(void)
{
    const startup_memory_t *const memory = &startup_memory;

    for (uint32_t k = 0U; k < memory->data_words; k++) {
        memory->data[k] = memory->data_load[k];
    }
    for (uint32_t k = 0U; k < memory->bss_words; k++) {
        memory->bss[k] = 0U;
    }
    (void)main();
    safe_state_handler();
}

/* Exceptions 1 to 15. ARMv6-M has fewer: the others are reserved there and never come. */
const vector_t core_vectors[CORE_VECTORS] __attribute__((section(".vectors.core"), used)) = {
    reset_entry,        NMI_Handler,        HardFault_Handler,  MemManage_Handler,
    BusFault_Handler,   UsageFault_Handler, safe_state_handler, safe_state_handler,
    safe_state_handler, safe_state_handler, SVC_Handler,        DebugMon_Handler,
    safe_state_handler, PendSV_Handler,     SysTick_Handler,
};
